"""What the answers of several formulations share: body coordinates, the start, efforts."""

from __future__ import annotations

import math
from collections.abc import Iterable

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Effort
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim


def staying(question: Question) -> Solution:
    """The answer where the target is the start: the path of no length."""
    path = Path(question.scenario.start, [], [])
    return Solution(Claim.LOCAL, path=path, claimed_length=0.0, message="the target is the start")


def at_start(question: Question, tolerance: float = 0.0) -> Solution | None:
    """The answer where the target is within `tolerance` radii of the start; None elsewhere."""
    there = math.hypot(*question.scenario.local()) <= tolerance
    return staying(question) if there else None


def coordinate_rounding(scenario: Scenario) -> float:
    """The distance (radii) between start and target that the coordinates' rounding may fake."""
    return 2 * EPS * scenario.extent / scenario.radius


def in_world(scenario: Scenario, along: float, left: float) -> tuple[float, float]:
    """A vector, such as the duals of the end point, turned from body coordinates."""
    cos, sin = math.cos(scenario.heading), math.sin(scenario.heading)
    return along * cos - left * sin, along * sin + left * cos


def total(counts: Iterable[int | None]) -> int | None:
    """The sum, or None if an engine does not count."""
    known = list(counts)
    return None if None in known else sum(count for count in known if count is not None)


def summed(efforts: Iterable[Effort]) -> tuple[Effort, ...]:
    """Efforts by subproblem, in the order in which these were begun."""
    by_name: dict[str, list[Effort]] = {}
    for effort in efforts:
        by_name.setdefault(effort.subproblem, []).append(effort)
    return tuple(
        Effort(
            name,
            sum(effort.runs for effort in group),
            total(effort.evaluations for effort in group),
            sum(effort.seconds for effort in group),
        )
        for name, group in by_name.items()
    )

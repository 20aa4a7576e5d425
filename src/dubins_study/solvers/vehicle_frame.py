"""From the vehicle's frame, in which the methods work, back to the question."""

from __future__ import annotations

import math

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import Path
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
    """A vector, such as the duals of the end point, turned from the vehicle's frame."""
    cos, sin = math.cos(scenario.heading), math.sin(scenario.heading)
    return along * cos - left * sin, along * sin + left * cos

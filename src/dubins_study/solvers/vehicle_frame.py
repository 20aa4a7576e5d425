"""From the vehicle's frame, in which the methods work, back to the question."""

from __future__ import annotations

import math

from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.claim import Claim
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.vehicle_frame import EPS, Local


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


def unreachable(target: Local, branch: str) -> str | None:
    """Why no path of the branch's word ends at a target, or None.

    Turning left and then going straight never enters the left turning circle: its arc lies on
    the circle and its tangents outside. (Rates of one sign alone would: straight, then left.) What
    the coordinates' rounding hides counts as on the circle.

    Args:
        target: in the vehicle's frame.
        branch: `LS` or `RS`; any other ends everywhere as far as is known here.
    """
    if branch == "LS" and target.w > 0:
        return "the target is inside the left turning circle, which no LS path enters"
    if branch == "RS" and target.mirrored.w > 0:
        return "the target is inside the right turning circle, which no RS path enters"
    return None


def in_world(scenario: Scenario, along: float, left: float) -> tuple[float, float]:
    """A vector, such as the duals of the end point, turned from the vehicle's frame."""
    cos, sin = math.cos(scenario.heading), math.sin(scenario.heading)
    return along * cos - left * sin, along * sin + left * cos

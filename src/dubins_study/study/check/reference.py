"""The proven interval around the shortest length of any question, and a path of it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from copy import copy
from functools import lru_cache
from itertools import groupby
from typing import NamedTuple

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.check.pose_enclosure import enclose_pose
from dubins_study.study.closed_form.pose import pose_path
from dubins_study.study.closed_form.shortest import Shortest, margin, shortest, shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import SEARCH_S

ROUNDED = 8 * EPS  # relative error of two lengths that ought to be equal
# By how much the optimal length may change per shift of the target, at least: it does by 1 where
# the path ends straight, and more near a turning circle, where that changes within the shift.
STEEP = 10.0


class Reference(NamedTuple):
    """What an answer is compared with.

    Of a route the enclosure's one part is an interval that holds the shortest length; of one leg
    its parts hold the shortest lengths for all data within delta.
    """

    enclosure: Enclosure
    path: Path | None  # the shortest that is known; None where a branch has none
    at: tuple[float, ...]  # the arc lengths of its via points


def reference_of(scenario: Scenario, branch: str = "best", search_s: float = SEARCH_S) -> Reference:
    """The reference of a scenario's branch; nothing that a solver says enters.

    A search of the same route in this process, by whomever it was called, is not repeated.
    """
    if scenario.via:
        # routes alone need compiled code
        from dubins_study.study.route.shortest import known_route

        found = known_route(scenario, search_s)
        part = (found.low, found.high)
        return Reference(Enclosure(*part, False, (part,)), found.path, found.at)
    if scenario.final_heading is None:
        return Reference(enclose(scenario, branch), shortest_path(scenario, branch), ())
    end = Pose(scenario.target_x, scenario.target_y, scenario.final_heading)
    return _pose_reference(scenario.start, end, scenario.radius, branch)


@lru_cache(maxsize=4096)  # asked for when an answer is judged and when it is certified
def _pose_reference(start: Pose, end: Pose, radius: float, branch: str) -> Reference:
    """The reference of one leg with a final heading."""
    question = start, end, radius, branch
    return Reference(enclose_pose(*question), pose_path(*question), ())


def visited(scenario: Scenario, points: Iterable[tuple[float, float]], end: Pose) -> Scenario:
    """The scenario whose points are those that a path visits on its way to its end.

    Points that are one for a path are one point of that scenario.
    """
    way = [point for point, _ in groupby([scenario.start[:2], *points, end[:2]])]
    x, y = end[:2]
    return Scenario(
        *(*scenario.start, x, y, scenario.radius, scenario.speed),
        via=way[1:-1],
        final_heading=None if scenario.final_heading is None else end.heading,
    )


def free_leg_reference(
    scenario: Scenario,
    branch: str,
    optimum: Shortest | None,
    length: float,
    miss: float,
    end: Pose,
    gap: float,
) -> float | None:
    """The length that a path of one leg with a free final heading is compared with.

    None if no target within delta, or within its miss, has a path of the branch.

    Args:
        scenario, branch: the question.
        optimum: the shortest path of the branch, if there is one.
        length, miss: of the path, which arrives (length unit).
        end: of the path.
        gap: tolerance of the verdict.
    """
    reference = _relaxed_reference(scenario, branch, length, miss, (end.x, end.y), optimum)
    if reference is None:  # none where no target within delta has a path of the branch
        reference = enclose(scenario, branch).nearest(length)
    if reference is None:
        return None
    return _known_to_delta(scenario, branch, length, reference, gap)


def _relaxed_reference(
    scenario: Scenario,
    branch: str,
    length: float,
    miss: float,
    end: tuple[float, float],
    optimum: Shortest | None,
) -> float | None:
    """The length that an answer is compared with.

    That is the scenario's shortest length. Only a miss makes a shorter answer possible: such an
    answer is compared with the least shortest length over the targets within its miss. The length
    jumps only across the front half of a turning circle (docs/derivation.md, section 6), so that
    least length is met, up to the miss itself, at the path's end or at the nearest point of the
    circle. An answer that is shorter by no more than its miss explains has not used the jump.
    """
    bare = None if optimum is None else optimum.total * scenario.radius
    if bare is not None and length >= bare * (1.0 - ROUNDED):
        return bare
    at_end = _shortest_length(_moved(scenario, *end), branch)
    if optimum is not None and bare is not None:
        explained = bare - _steepness(optimum) * miss
        if length >= explained:
            jumps = at_end is None or at_end < explained
            return length if jumps or at_end is None else min(bare, at_end)
    lengths = [at_end]
    if margin(scenario) * scenario.radius <= miss:
        lengths.append(_shortest_length(_moved(scenario, *_onto_circle(scenario)), branch))
    return min((value for value in (bare, *lengths) if value is not None), default=None)


def _moved(scenario: Scenario, x: float, y: float) -> Scenario:
    """The scenario with another target, which may be beyond what a scenario may ask for."""
    moved = copy(scenario)
    object.__setattr__(moved, "target_x", x)
    object.__setattr__(moved, "target_y", y)
    return moved


def _steepness(optimum: Shortest) -> float:
    """How much a shortest length changes per shift of its target, with room for a small shift.

    The gradient's norm is 1 for words that end straight and 1 / |cos(a2 / 2)| for RL and LR
    (docs/derivation.md, section 9), which grows without bound toward the rear of a circle.
    """
    if optimum.word not in ("LR", "RL"):
        return STEEP
    return max(STEEP, 2.0 / max(abs(math.cos(optimum.segments.second / 2)), EPS))


def _shortest_length(scenario: Scenario, branch: str) -> float | None:
    optimum = shortest(scenario, branch)
    return None if optimum is None else optimum.total * scenario.radius


def _onto_circle(scenario: Scenario) -> tuple[float, float]:
    """The point of the nearer turning circle that is nearest to the target.

    Rounding moves it outwards only: next to the start delta is finer than this point's rounding.
    """
    _, Y = scenario.local()
    side = math.copysign(scenario.radius, Y)
    x = scenario.x - side * math.sin(scenario.heading)
    y = scenario.y + side * math.cos(scenario.heading)
    dx, dy = scenario.target_x - x, scenario.target_y - y
    stretch = scenario.radius * (1.0 + ROUNDED) / math.hypot(dx, dy)
    return x + dx * stretch, y + dy * stretch


def _known_to_delta(
    scenario: Scenario, branch: str, length: float, reference: float, gap: float
) -> float:
    """The reference that an answer is compared with, for data that are known to delta.

    Of a longer answer that is the longest shortest length, over targets within delta, that is not
    above the answer's length.
    """
    allowed = gap * max(reference, scenario.radius)
    if length - reference <= allowed:
        return reference
    nearest = enclose(scenario, branch).nearest(length, allowed)
    if nearest is None:
        return reference
    # what delta alone moves a length by is no reason for another reference
    matters = length - nearest <= allowed or nearest - reference > allowed
    return nearest if matters else reference

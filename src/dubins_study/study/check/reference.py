"""The proven interval around the shortest length of any question, and a path of it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from copy import copy
from functools import lru_cache
from itertools import groupby
from typing import NamedTuple

from dubins_study.study.body_coordinates import EPS, local
from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.check.pose_enclosure import enclose_pose
from dubins_study.study.closed_form.pose import pose_path
from dubins_study.study.closed_form.shortest import shortest, shortest_local, shortest_path
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
    final = None if scenario.final_heading is None else end.heading
    there = copy(scenario)  # the end may lie beyond what a scenario may ask for
    moved = {"target_x": end.x, "target_y": end.y, "via": tuple(way[1:-1]), "final_heading": final}
    for name, value in moved.items():
        object.__setattr__(there, name, value)
    return there


def free_leg_reference(
    scenario: Scenario,
    branch: str,
    shortest_length: float | None,
    length: float,
    end: Pose,
    gap: float,
) -> float | None:
    """The length that a path of one leg with a free final heading is compared with.

    That is the scenario's shortest length. Only a miss makes a shorter path possible: it is
    compared with the shortest to where it ends, so that missing buys nothing. That is no longer
    than the path itself, whatever side of a circle its end is rounded to. Where neither has a path
    of the branch, a point of a turning circle within the miss may. None if that is not so either.

    Args:
        scenario, branch: the question.
        shortest_length: of the branch, if it has a path (length unit).
        length, end: of the path, which arrives.
        gap: tolerance of the verdict.
    """
    radius, reference = scenario.radius, shortest_length
    if reference is None or length < reference * (1.0 - ROUNDED):
        there = shortest(visited(scenario, (), end), branch)
        if there is not None:
            reference = min(there.total * radius, length)
    if reference is None:
        target = local(scenario)
        off = 2.0 * math.hypot(end.x - scenario.target_x, end.y - scenario.target_y)
        there = shortest_local(target._replace(delta=target.delta + off / radius), branch)
        reference = None if there is None else there.total * radius
    return None if reference is None else _known_to_delta(scenario, branch, length, reference, gap)


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

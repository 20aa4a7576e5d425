"""The proven interval around the shortest length of any question, and a path of it."""

from __future__ import annotations

from functools import lru_cache
from time import perf_counter
from typing import NamedTuple

from dubins_study.study.check.enclosure import Enclosure, enclose, enclose_pose
from dubins_study.study.closed_form.pose import pose_path
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import DEFAULT, Tolerances

_SEARCH_SHARE = 0.8  # of the time that a check has left: what follows a search needs some too


class Reference(NamedTuple):
    """What an answer is compared with.

    Of a route the enclosure's one part is an interval that holds the shortest length; of one leg
    its parts hold the shortest lengths for all data within delta.
    """

    enclosure: Enclosure
    path: Path | None  # the shortest that is known; None where a branch has none
    at: tuple[float, ...]  # the arc lengths of its via points


def reference_of(
    scenario: Scenario, branch: str = "best", tolerances: Tolerances = DEFAULT
) -> Reference:
    """The reference of a scenario's branch; nothing that a solver says enters.

    A search of the same route in this process, by whomever it was called, is not repeated.
    """
    if scenario.via:
        # routes alone need compiled code
        from dubins_study.study.route.shortest import known_route

        left = min(tolerances.until - perf_counter(), tolerances.patience * tolerances.search_s)
        found = known_route(scenario, tolerances.search_s, max(_SEARCH_SHARE * left, 0.0))
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

"""Measure a path at the points of its scenario.

It also names the path's word, and says which claims about it are false.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check.visits import Visits, legs, off_heading, visits
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import HEADED, Tolerances, allowed_miss, arrives
from dubins_study.study.words import TURN, Claim, Order, Verdict

ROUNDED = 8 * EPS  # relative error of two lengths that ought to be equal
# Largest gap at which a longer path of another word counts as coarse. Near a circle's rear, words
# turn by nearly the same angle, and their lengths differ by more than a useful discretisation does.
COARSE = 0.05
# A run of arcs that turns by less than this (rad) is straight; a straight shorter than this share
# of the path is left out.
WORD = 1e-6
# A path cut into many steps has a step across the switch and a ripple after it, which fades within
# a few steps. Runs that turn by less than this (rad) have no letter. A path of up to three arcs is
# named without this limit.
DISCRETISED_WORD = 0.05
# rad; least difference between the net turns of two basins
_ANOTHER_TURN = 1.0


def visited(scenario: Scenario, visits: Visits, end: Pose) -> Scenario:
    """Scenario of the points that a path visits.

    If it has a target, that is the path's end. Points that the path visits at one place are one
    point of that scenario. A closed scenario still ends as it starts.
    """
    stops = []
    for i, pose in zip(visits.order, visits.poses, strict=True):
        stop = tuple(pose)
        if scenario.stops[i].heading is None:
            stop = stop[:2]
        stops.append(stop)
    begin = (scenario.x, scenario.y)
    moved: dict[str, Any] = {}
    if scenario.target is not None and not scenario.closed:
        moved = {"target_x": end.x, "target_y": end.y}
        if scenario.final_heading is not None:
            moved["final_heading"] = end.heading
        stops.append(end[:2])
    # stops that follow each other at one place are one; in a tour any stops at one place
    way = [next(same) for _, same in groupby([begin, *stops], key=itemgetter(0, 1))]
    if scenario.order is Order.FREE:
        way = list({stop[:2]: stop for stop in way}.values())
    via = way[1:]
    if "target_x" in moved:
        via = via[:-1]
    moved["via"] = tuple(via)
    if scenario.target is None and not moved["via"]:  # the path visits all points where it starts
        moved |= {"target_x": scenario.x, "target_y": scenario.y}
    changed = copy(scenario)  # the end may lie beyond what a scenario may ask for
    for name, value in moved.items():
        object.__setattr__(changed, name, value)
    return changed


def path_word_of(path: Path) -> str:
    """Word of a path that can be driven.

    The path may be cut into any number of arcs.
    """
    if path.lengths.size <= 3:
        return path.word(WORD)
    return path.word(DISCRETISED_WORD)


def is_wrong_basin(
    path: Path, word: str, gap: float, words: Sequence[str], turns: Sequence[float]
) -> bool:
    """Whether a longer path is another local optimum.

    `words` and `turns` (net, rad) are those of the shortest paths. Another optimum is of none of
    these words and longer by more than `COARSE`, or has another net turn.
    """
    another_word = gap > COARSE and word not in words
    turn = path.turn
    return another_word or all(abs(turn - best) > _ANOTHER_TURN for best in turns)


def curvature_excess(curvature: Sequence[float], branch: str) -> float:
    """Largest excess of curvatures over a branch's range.

    Curvatures and the excess are in units of 1 / radius. `best` allows [-1, 1]; `LS` [0, 1] and
    `RS` [-1, 0], since where the word exists no path of one-sided turning is shorter
    (docs/derivation.md, section 8); any other word allows only +1, 0 and -1 of its letters, in
    their order. Arcs of no length are left out of `curvature`.
    """
    if not curvature:
        return 0.0
    if not TURN.keys() >= set(branch):  # no word
        return max(0.0, max(map(abs, curvature)) - 1.0)
    if branch in ("LS", "RS"):
        # positive where the path turns to the side of the word's first letter
        first = [TURN[branch[0]] * u for u in curvature]
        return max(0.0, max(first) - 1.0, -min(first))
    # for each letter: least excess of the arcs so far, if it drives the last of them
    letters = [TURN[letter] for letter in branch]
    excess = [0.0] * len(letters)
    for u in curvature:
        before = math.inf
        for place, turn in enumerate(letters):
            before = min(before, excess[place])
            excess[place] = max(before, abs(u - turn))
    return min(excess)


class Seen(NamedTuple):
    """Measurements of a path at its scenario's points."""

    visits: Visits
    end: Pose
    miss: float  # the largest distance from a point, the target among them (length unit)
    turned: float  # the largest angle from a given heading at a point (rad)
    excess: float  # curvature beyond what the branch allows (1 / radius)
    arrives: bool  # at all points, and with the headings given there


def visits_of(scenario: Scenario, path: Path, allowed: float) -> Visits:
    """Earliest visit of each via point.

    Where the order is given, each visit comes after the one before.

    Args:
        allowed: how near the path has to come (length unit).
    """
    via = scenario.stops[: len(scenario.via)]
    return visits(
        path,
        via,
        radius=scenario.radius,
        allowed=allowed,
        any_order=scenario.order is Order.FREE,
    )


def seen_of(scenario: Scenario, path: Path, branch: str, tolerances: Tolerances) -> Seen:
    """Measure a path at the points of its scenario.

    The path is one that can be driven.
    """
    radius = scenario.radius
    extent = scenario.extent
    length = path.length
    end = path.end
    pieces = zip(path.curvatures.tolist(), path.lengths.tolist(), strict=True)
    excess = curvature_excess([k * radius for k, s in pieces if s > 0], branch)
    allowed = allowed_miss(tolerances.miss, radius, extent=extent, length=length)
    via_visits = visits_of(scenario, path, allowed)
    miss = via_visits.miss
    turned = via_visits.turned
    if scenario.target is not None:
        x, y = scenario.target
        miss = max(math.hypot(end.x - x, end.y - y), miss)
    final = scenario.final_heading
    if scenario.closed:
        final = path.start.heading
    turned = max(turned, off_heading(final, end.heading, driven=length / radius))
    near = arrives(miss, radius, extent=extent, length=length, allowed=tolerances.miss)
    return Seen(
        visits=via_visits,
        end=end,
        miss=miss,
        turned=turned,
        excess=excess,
        arrives=near and turned <= HEADED,
    )


def words_of(path: Path, at: Sequence[float], radius: float) -> str:
    """Words of a path's legs, with spaces between.

    The legs end at the arc lengths `at`.
    """
    return " ".join(map(path_word_of, legs(path, at, radius)))


_HONEST = {
    Claim.OPTIMAL: (Verdict.OPTIMAL, Verdict.UNDECIDED),
    Claim.LOCAL: (Verdict.OPTIMAL, Verdict.UNDECIDED, Verdict.LONGER),
    Claim.FEASIBLE: (Verdict.OPTIMAL, Verdict.UNDECIDED, Verdict.LONGER),
    Claim.INFEASIBLE: (Verdict.NONE_EXISTS,),
}


def is_false(claim: Claim, verdict: Verdict) -> bool:
    """Whether the claim is stronger than the verdict."""
    return claim in _HONEST and verdict not in _HONEST[claim]

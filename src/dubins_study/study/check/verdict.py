"""The check: a path judged from its controls alone, against the closed form."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from copy import copy
from functools import lru_cache
from itertools import groupby
from typing import Any, NamedTuple

from dubins_study.study.body_coordinates import EPS, local
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.reference import reference_of
from dubins_study.study.check.two_arcs import PATH_WORDS, WORD, path_word
from dubins_study.study.check.visits import Visits, legs, visits
from dubins_study.study.closed_form.shortest import (
    Shortest,
    margin_local,
    region_of,
    shortest,
    shortest_local,
)
from dubins_study.study.path import Path, drivable
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import DEFAULT, DRIVEN, HEADED, Tolerances, arrives
from dubins_study.study.words import TURN, Claim, Verdict

ROUNDED = 8 * EPS  # relative error of two lengths that ought to be equal
# By how much the optimal length may change per shift of the target, at least: it does by 1 where
# the path ends straight, and more near a turning circle, where that changes within the shift.
STEEP = 10.0
# A longer path of another word is coarse up to here; near a circle's rear, words turn by nearly the
# same angle and differ by more than any discretisation of use.
COARSE = 0.05
# A path cut into many steps has a step that straddles the switch and a ripple after it, which fades
# within a few steps; runs that turn by less than this (rad) name nothing. A path of up to three
# arcs is named as it is.
DISCRETISED_WORD = 0.05
# radians that a turn of another basin differs by, at least
_ANOTHER_TURN = 1.0


def judge(
    scenario: Scenario,
    path: Path | None,
    claim: Claim = Claim.NONE,
    branch: str = "best",
    tolerances: Tolerances = DEFAULT,
) -> Judgement:
    """Judge a path, or its absence, for a question.

    Nothing that the solver reports enters but its controls and, for `false_claim` and the
    verdict `none exists`, its claim.
    """
    free_leg = scenario.one_free_leg
    optimum, known = _closed_form(scenario, branch) if free_leg else (None, _NO_REGION)
    if path is None or not drivable(path):
        verdict = Verdict.NONE if path is None else Verdict.MISSES
        # a route and the best path always exist, and nothing has to be searched for
        denied = path is None and claim is Claim.INFEASIBLE and branch != "best"
        if denied and reference_of(scenario, branch).enclosure.absent:
            verdict = Verdict.NONE_EXISTS
        return Judgement(verdict=verdict, false_claim=is_false(claim, verdict), **known)
    seen = _seen(scenario, path, branch, tolerances)
    length, at = path.length, seen.visits.at
    word = path_word_of(path) if free_leg else words_of(path, at, scenario.radius)
    verdict = Verdict.MISSES
    if seen.arrives and seen.excess <= tolerances.curvature and path.start == scenario.start:
        if free_leg:
            verdict, found = _of_free_leg(scenario, path, branch, seen, word, tolerances, optimum)
        else:
            verdict, found = _of_visits(scenario, path, branch, seen, word, tolerances)
        known = known | found
    return Judgement(
        verdict=verdict,
        false_claim=is_false(claim, verdict),
        word=word,
        length=length,
        travel_time=length / scenario.speed,
        miss=seen.miss,
        visits=list(at) or None,
        curvature_excess=seen.excess,
        **known,
    )


_NO_REGION: dict[str, Any] = {"region": None, "margin": None}  # but of a leg to a free heading


@lru_cache(maxsize=16384)
def _closed_form(scenario: Scenario, branch: str) -> tuple[Shortest | None, dict[str, Any]]:
    """A question's shortest path, and the columns of a judgement that only the question decides.

    Many cells of a run ask the same question.
    """
    target = local(scenario)
    optimum = shortest_local(target, branch)
    return optimum, {
        "region": region_of(target.w, target.mirrored.w),
        "margin": margin_local(target.X, abs(target.Y)),
        "reference_word": None if optimum is None else optimum.word,
        "reference": None if optimum is None else optimum.total * scenario.radius,
    }


def _of_free_leg(
    scenario: Scenario,
    path: Path,
    branch: str,
    seen: _Seen,
    word: str,
    tolerances: Tolerances,
    optimum: Shortest | None,
) -> tuple[Verdict, dict[str, Any]]:
    """The verdict on a path of one leg that arrives with any heading, and its columns.

    It is compared with the scenario's shortest length. Only a miss makes a shorter path possible:
    it is compared with the shortest to where it ends, so that missing buys nothing. That is no
    longer than the path itself, whatever side of a circle its end is rounded to. Where neither has
    a path of the branch, a point of a turning circle within the miss may.
    """
    length, radius, end = path.length, scenario.radius, seen.end
    reference = None if optimum is None else optimum.total * radius
    if reference is None or length < reference * (1.0 - ROUNDED):
        there = shortest(visited(scenario, (), end), branch)
        if there is not None:
            reference = min(there.total * radius, length)
    if reference is None:
        target = local(scenario)
        off = 2.0 * math.hypot(end.x - scenario.target_x, end.y - scenario.target_y)
        there = shortest_local(target._replace(delta=target.delta + off / radius), branch)
        if there is None:
            return Verdict.MISSES, {}
        reference = there.total * radius
    reference = _known_to_delta(scenario, branch, length, reference, tolerances.gap)
    gap = (length - reference) / max(reference, radius)
    longer = gap > tolerances.gap
    return Verdict.LONGER if longer else Verdict.OPTIMAL, {
        "reference": reference,
        "gap": gap,
        "wrong_basin": longer and _is_wrong_basin(path, word, gap, *_basins(optimum)),
    }


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


def path_word_of(path: Path) -> str:
    """The word of a path that can be driven, however many arcs it is cut into."""
    arcs = list(zip(path.curvatures.tolist(), path.lengths.tolist(), strict=True))
    if len(arcs) > 2:
        return path.word(WORD if len(arcs) == 3 else DISCRETISED_WORD)
    first, second, *_ = (*arcs, _NO_ARC, _NO_ARC)
    return PATH_WORDS[path_word(*first, *second)]


_NO_ARC = (0.0, 0.0)


def _is_wrong_basin(
    path: Path, word: str, gap: float, words: Sequence[str], turns: Sequence[float]
) -> bool:
    """Whether a longer path is another local optimum than those of some words and net turns."""
    another_word, turn = gap > COARSE and word not in words, path.turn
    return another_word or all(abs(turn - best) > _ANOTHER_TURN for best in turns)


def _basins(optimum: Shortest | None) -> tuple[tuple[str, ...], tuple[float, ...]]:
    """Words and net turns (rad) of the shortest path, if any, and, of a tie, its mirror image."""
    if optimum is None:
        return (), ()
    lengths = [length for length in optimum.segments if length > 0]
    turn = sum(TURN[c] * length for c, length in zip(optimum.word, lengths, strict=True))
    return optimum.words, (turn, -turn)[: len(optimum.words)]


def curvature_excess(curvature: Sequence[float], branch: str) -> float:
    """Largest amount by which curvatures leave what a branch allows, in units of 1 / radius.

    `best` allows [-1, 1]; `LS` [0, 1] and `RS` [-1, 0], since where the word exists no path of
    one-sided turning is shorter (docs/derivation.md, section 8); any other word allows only +1, 0
    and -1 of its letters, in their order. Arcs of no length are left out of `curvature`.
    """
    if not curvature:
        return 0.0
    if branch == "best":
        return max(0.0, max(map(abs, curvature)) - 1.0)
    if branch in ("LS", "RS"):
        side = 1 if branch[0] == "L" else -1
        first = [side * u for u in curvature]
        return max(0.0, max(first) - 1.0, -min(first))
    # the least excess of the arcs up to here, the last of which is driven by each letter
    letters = [TURN[letter] for letter in branch]
    excess = [0.0] * len(letters)
    for u in curvature:
        before = math.inf
        for place, turn in enumerate(letters):
            before = min(before, excess[place])
            excess[place] = max(before, abs(u - turn))
    return min(excess)


class _Seen(NamedTuple):
    """What a path does at the points of its scenario."""

    visits: Visits
    end: Pose
    miss: float  # the largest distance from a point, the target among them (length unit)
    turned: float  # from the final heading, if that is given (rad)
    excess: float
    arrives: bool


def _seen(scenario: Scenario, path: Path, branch: str, tolerances: Tolerances) -> _Seen:
    radius, extent, length, end = scenario.radius, scenario.extent, path.length, path.end
    pieces = zip(path.curvatures.tolist(), path.lengths.tolist(), strict=True)
    excess = curvature_excess([k * radius for k, s in pieces if s > 0], branch)
    allowed = tolerances.miss * radius + DRIVEN * (extent + length)
    seen = visits(path, scenario.via, radius, allowed)
    miss = max(math.hypot(end.x - scenario.target_x, end.y - scenario.target_y), seen.miss)
    turned, blur = 0.0, 0.0
    if scenario.final_heading is not None:
        turned = abs(math.remainder(end.heading - scenario.final_heading, 2 * math.pi))
        blur = DRIVEN * (abs(end.heading) + abs(scenario.final_heading) + length / radius)
    there = arrives(miss, radius, extent, length, tolerances.miss)
    return _Seen(seen, end, miss, turned, excess, there and turned <= HEADED + blur)


def _of_visits(
    scenario: Scenario, path: Path, branch: str, seen: _Seen, word: str, tolerances: Tolerances
) -> tuple[Verdict, dict[str, Any]]:
    """The verdict on an arriving path of a route, or to a final heading, and its columns.

    It is compared with the scenario's reference. Only if it is shorter by more than what it misses
    its points by explains, it is compared with that of the points that it visits.

    One leg has a known set of lengths, for all data within delta, of which the nearest counts. Of a
    route the interval's lower end is the reference, so that the gap is proven.
    """
    radius, length, gap = scenario.radius, path.length, tolerances.gap
    best = reference_of(scenario, branch, tolerances)
    moved = STEEP * (scenario.legs * seen.miss + seen.turned * radius)
    if length < best.enclosure.low * (1.0 - ROUNDED) - moved:
        there = visited(scenario, seen.visits.points, seen.end)
        best = reference_of(there, branch, tolerances)
    if best.path is None or not best.enclosure.exists:
        return Verdict.MISSES, {}
    low = high = best.enclosure.low
    if scenario.via:
        high = best.enclosure.high
    elif (nearest := best.enclosure.nearest(length, gap * max(low, radius))) is not None:
        low = high = nearest
    above, reference_word = (length - low) / max(low, radius), words_of(best.path, best.at, radius)
    known = {"reference": low, "gap": above, "reference_word": reference_word}
    if above <= gap:
        return Verdict.OPTIMAL, known
    if (length - high) / max(high, radius) <= gap:
        return Verdict.UNDECIDED, known
    basin = (reference_word,), (best.path.turn,)
    return Verdict.LONGER, known | {"wrong_basin": _is_wrong_basin(path, word, above, *basin)}


def words_of(path: Path, at: Sequence[float], radius: float) -> str:
    """The words of a path's legs, which end at the arc lengths `at`, with spaces between."""
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


def miss_reason(
    scenario: Scenario, path: Path, branch: str, tolerances: Tolerances = DEFAULT
) -> str:
    """What keeps a path whose verdict is `misses` from answering its question."""
    if not drivable(path):
        return "the path has a number that is not finite, or a length below 0"
    if path.start != scenario.start:
        return "the path starts elsewhere"
    radius = scenario.radius
    seen = _seen(scenario, path, branch, tolerances)
    if seen.excess > tolerances.curvature:
        return f"the curvature is {seen.excess:.3g} / R beyond what the branch allows"
    if seen.miss > tolerances.miss * radius + DRIVEN * (scenario.extent + path.length):
        if seen.visits.miss == seen.miss:
            return f"the path passes {seen.miss / radius:.3g} R from a via point, in their order"
        return f"the path ends {seen.miss / radius:.3g} R from the target"
    if seen.turned > HEADED and not seen.arrives:
        return f"the path ends {seen.turned:.3g} rad from the final heading"
    return "the path is too long to be driven to within a radius, or the branch has none"

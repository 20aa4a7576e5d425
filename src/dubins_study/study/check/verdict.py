"""The check: a path judged from its controls alone, against the closed form."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import accumulate
from operator import mul
from typing import Any

from dubins_study.study.check.relaxation import relaxed_reference
from dubins_study.study.closed_form.shortest import (
    EPS,
    TURN,
    Shortest,
    local,
    margin_local,
    region_of,
    shortest_local,
)
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario


class Claim(StrEnum):
    """What a solver says of its answer, strongest first."""

    OPTIMAL = "optimal"
    LOCAL = "local"
    FEASIBLE = "feasible"
    INFEASIBLE = "infeasible"
    LIMIT = "limit"
    FAILED = "failed"
    NONE = "none"


class Verdict(StrEnum):
    """What the check finds."""

    OPTIMAL = "optimal"
    LONGER = "longer"
    MISSES = "misses"
    NONE = "none"
    NONE_EXISTS = "none exists"


@dataclass(frozen=True, slots=True)
class Tolerances:
    """When a path counts as arriving, as drivable and as optimal.

    Args:
        miss: largest distance to the target, in turning radii.
        curvature: largest curvature beyond what the branch allows, times the radius.
        gap: largest gap of an answer that is called optimal.
    """

    miss: float = 1e-6
    curvature: float = 1e-9
    gap: float = 1e-4


# A longer path of another word is coarse up to here; near a circle's rear, words turn by nearly the
# same angle and differ by more than any discretisation of use.
COARSE = 0.05
# A path of up to three arcs is named as it is. One cut into many steps has a step that straddles
# the switch and a ripple after it, which fades within a few steps; runs that turn by less than
# this (rad) name nothing.
WORD = 1e-6
DISCRETISED_WORD = 0.05


@dataclass(frozen=True, slots=True)
class Judgement:
    """What the check found. Lengths in the scenario's unit; None where there is nothing to say.

    `gap` is (length - reference) / max(reference, radius) and only stands for a path that
    arrives. `wrong_basin` is a longer path that turns by another angle than the shortest one
    (more than 1 rad apart), or is of another word and more than 5 % longer: another local
    optimum, not a coarse answer.
    """

    verdict: Verdict
    word: str | None
    reference_word: str | None
    length: float | None
    travel_time: float | None
    reference: float | None
    gap: float | None
    miss: float | None
    curvature_excess: float | None
    false_claim: bool
    wrong_basin: bool
    region: str
    margin: float


def judge(
    scenario: Scenario,
    path: Path | None,
    claim: Claim = Claim.NONE,
    branch: str = "best",
    tolerances: Tolerances = Tolerances(),
) -> Judgement:
    """Judge a path, or its absence, for a question.

    Nothing that the solver reports enters but its controls and, for `false_claim` and the
    verdict `none exists`, its claim.
    """
    target = local(scenario)
    optimum = shortest_local(target, branch)
    found: dict[str, Any] = dict.fromkeys(_ABSENT)
    found |= {
        "verdict": Verdict.MISSES,
        "reference_word": None if optimum is None else optimum.word,
        "reference": None if optimum is None else optimum.total * scenario.radius,
        "wrong_basin": False,
        "region": region_of(target.w, target.mirrored.w),
        "margin": margin_local(target.X, abs(target.Y)),
    }
    if path is None:
        agrees = claim is Claim.INFEASIBLE and optimum is None
        found["verdict"] = Verdict.NONE_EXISTS if agrees else Verdict.NONE
    elif drivable(path):
        found |= _judge_path(scenario, path, branch, optimum, tolerances)
    return Judgement(**found, false_claim=is_false(claim, found["verdict"]))


_ABSENT = ("word", "length", "travel_time", "gap", "miss", "curvature_excess")


def _judge_path(
    scenario: Scenario, path: Path, branch: str, optimum: Shortest | None, tolerances: Tolerances
) -> dict[str, Any]:
    """The fields of `Judgement` that a path decides."""
    radius = scenario.radius
    end = path.end
    miss = math.hypot(end.x - scenario.target_x, end.y - scenario.target_y)
    lengths = path.length.tolist()
    rates = [k * radius for k, s in zip(path.curvature.tolist(), lengths, strict=True) if s > 0]
    excess = curvature_excess(rates, branch)
    length = path.total_length
    # driven in floating point, a path of this size cannot be checked any closer
    rounding = 32 * EPS * (scenario.extent + length)
    driven: dict[str, Any] = {
        "word": path.word(WORD if len(lengths) <= 3 else DISCRETISED_WORD),
        "length": length,
        "travel_time": length / scenario.speed,
        "miss": miss,
        "curvature_excess": excess,
        "verdict": Verdict.MISSES,
    }
    arrives = miss <= tolerances.miss * radius + rounding and rounding <= radius
    if path.start != scenario.start or not arrives or not excess <= tolerances.curvature:
        return driven
    reference = relaxed_reference(scenario, branch, length, miss, (end.x, end.y), optimum)
    if reference is None:
        return driven  # the branch has no path, here or at the path's end
    gap = (length - reference) / max(reference, radius)
    longer = gap > tolerances.gap
    turns = () if optimum is None else _turns(optimum)
    return driven | {
        "verdict": Verdict.LONGER if longer else Verdict.OPTIMAL,
        "gap": gap,
        "reference": reference,
        "wrong_basin": longer
        and (
            all(abs(path.turn - turn) > 1.0 for turn in turns)
            or (gap > COARSE and optimum is not None and driven["word"] not in optimum.words)
        ),
    }


def _turns(optimum: Shortest) -> tuple[float, ...]:
    """Net turn (rad) of the shortest path and, of a tie, of its mirror image."""
    lengths = [length for length in optimum.segments if length > 0]
    turn = sum(TURN[c] * length for c, length in zip(optimum.word, lengths, strict=True))
    return (turn,) if len(optimum.words) == 1 else (turn, -turn)


def drivable(path: Path) -> bool:
    """Whether all numbers are finite, their sums too, and no length is negative."""
    curvatures, lengths = path.curvature.tolist(), path.length.tolist()
    turned = sum(map(mul, curvatures, lengths))
    sums = sum(curvatures), sum(lengths), turned, *path.start
    return all(map(math.isfinite, sums)) and min(lengths, default=0.0) >= 0


def curvature_excess(curvature: Sequence[float], branch: str) -> float:
    """Largest amount by which curvatures leave what a branch allows, in units of 1 / radius.

    `best` allows [-1, 1]; `LS` [0, 1] and `RS` [-1, 0], since where the word exists no path of
    one-sided turning is shorter (docs/derivation.md, section 8); `LR` and `RL` allow only +1 and
    -1, in that order.

    Args:
        curvature: of each arc, in units of 1 / radius, arcs of no length left out.
        branch: one of `study.closed_form.shortest.BRANCHES`.
    """
    if not curvature:
        return 0.0
    if branch == "best":
        return max(0.0, max(map(abs, curvature)) - 1.0)
    side = 1 if branch[0] == "L" else -1
    first = [side * u for u in curvature]
    if branch in ("LS", "RS"):
        return max(0.0, max(first) - 1.0, -min(first))
    before = list(accumulate((abs(u - 1) for u in first), max, initial=0.0))
    after = list(accumulate((abs(u + 1) for u in reversed(first)), max, initial=0.0))
    return min(map(max, before, reversed(after)))


_HONEST = {
    Claim.OPTIMAL: (Verdict.OPTIMAL,),
    Claim.LOCAL: (Verdict.OPTIMAL, Verdict.LONGER),
    Claim.FEASIBLE: (Verdict.OPTIMAL, Verdict.LONGER),
    Claim.INFEASIBLE: (Verdict.NONE_EXISTS,),
}


def is_false(claim: Claim, verdict: Verdict) -> bool:
    """Whether the claim is stronger than the verdict."""
    return claim in _HONEST and verdict not in _HONEST[claim]

"""The check: a path judged from its controls alone, against the closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np

from study.path import FloatArray, Path
from study.scenario import Scenario
from study.synthesis import EPS, TURN, Shortest, margin, region, shortest


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
ROUNDED = 8 * EPS  # relative error of two lengths that ought to be equal
# By how much the optimal length may change per shift of the target, at least: it does by 1 where
# the path ends straight, and more near a turning circle, where that changes within the shift.
STEEP = 10.0


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
    word_ref: str | None
    length: float | None
    time: float | None
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
    optimum = shortest(scenario, branch)
    found: dict[str, Any] = dict.fromkeys(_ABSENT)
    found |= {
        "verdict": Verdict.MISSES,
        "word_ref": None if optimum is None else optimum.word,
        "reference": None if optimum is None else optimum.total * scenario.radius,
        "wrong_basin": False,
        "region": region(scenario),
        "margin": margin(scenario),
    }
    if path is None:
        agrees = claim is Claim.INFEASIBLE and optimum is None
        found["verdict"] = Verdict.NONE_EXISTS if agrees else Verdict.NONE
    elif drivable(path):
        found |= _judge_path(scenario, path, branch, optimum, tolerances)
    return Judgement(**found, false_claim=is_false(claim, found["verdict"]))


_ABSENT = ("word", "length", "time", "gap", "miss", "curvature_excess")


def _judge_path(
    scenario: Scenario, path: Path, branch: str, optimum: Shortest | None, tolerances: Tolerances
) -> dict[str, Any]:
    """The fields of `Judgement` that a path decides."""
    radius = scenario.radius
    end = path.end
    miss = math.hypot(end.x - scenario.target_x, end.y - scenario.target_y)
    excess = curvature_excess(path.curvature[path.length > 0] * radius, branch)
    length = path.total_length
    # driven in floating point, a path of this size cannot be checked any closer
    rounding = 32 * EPS * (scenario.extent + length)
    driven: dict[str, Any] = {
        "word": path.word(WORD if path.length.size <= 3 else DISCRETISED_WORD),
        "length": length,
        "time": length / scenario.speed,
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
    if not path.length.size:
        return all(map(math.isfinite, path.start))
    with np.errstate(over="ignore", invalid="ignore"):
        sums = float(path.curvature.sum()), path.total_length, *path.start
        return all(map(math.isfinite, sums)) and bool(path.length.min() >= 0)


def curvature_excess(curvature: FloatArray, branch: str) -> float:
    """Largest amount by which curvatures leave what a branch allows, in units of 1 / radius.

    `best` allows [-1, 1]; `LS` [0, 1] and `RS` [-1, 0], since where the word exists no path of
    one-sided turning is shorter (docs/derivation.md, section 8); `LR` and `RL` allow only +1 and
    -1, in that order.

    Args:
        curvature: shape (n,), in units of 1 / radius, arcs of no length left out.
        branch: one of `study.synthesis.BRANCHES`.
    """
    if not curvature.size:
        return 0.0
    if branch == "best":
        return max(0.0, float(np.abs(curvature).max()) - 1.0)
    if branch in ("LS", "RS"):
        left = curvature if branch == "LS" else -curvature
        return max(0.0, float(left.max()) - 1.0, -float(left.min()))
    first = curvature if branch == "LR" else -curvature
    before = np.concatenate(([0.0], np.maximum.accumulate(np.abs(first - 1))))
    after = np.concatenate((np.maximum.accumulate(np.abs(first[::-1] + 1))[::-1], [0.0]))
    return float(np.maximum(before, after).min())


def relaxed_reference(
    scenario: Scenario,
    branch: str,
    length: float,
    miss: float,
    end: tuple[float, float],
    optimum: Shortest | None,
) -> float | None:
    """The length that an answer is compared with.

    The shortest length of the scenario; but an answer shorter than that, which only a miss makes
    possible, is compared with the least length over the ball of the miss that it made. The length
    jumps only across the front half of a turning circle (THEORY section 4), so the ball's least
    value is met, up to the miss itself, at the end point or at the nearest point of the circle.
    An answer that is shorter by no more than its miss explains has not made use of the jump.
    """
    bare = None if optimum is None else optimum.total * scenario.radius
    if bare is not None and length >= bare * (1.0 - ROUNDED):
        return bare
    at_end = _shortest_length(replace(scenario, target_x=end[0], target_y=end[1]), branch)
    if optimum is not None and bare is not None:
        explained = bare - _steepness(optimum) * miss
        if length >= explained:
            jumps = at_end is None or at_end < explained
            return length if jumps or at_end is None else min(bare, at_end)
    lengths = [at_end]
    if margin(scenario) * scenario.radius <= miss:
        x, y = _onto_circle(scenario)
        lengths.append(_shortest_length(replace(scenario, target_x=x, target_y=y), branch))
    return min((value for value in (bare, *lengths) if value is not None), default=None)


def _steepness(optimum: Shortest) -> float:
    """How much a shortest length changes per shift of its target, with room for a small shift.

    The gradient's norm is 1 for words that end straight and 1 / |cos(a2 / 2)| for RL and LR
    (docs/derivation.md, section 6), which grows without bound toward the rear of a circle.
    """
    if optimum.word not in ("LR", "RL"):
        return STEEP
    return max(STEEP, 2.0 / max(abs(math.cos(optimum.segments.second / 2)), EPS))


def _shortest_length(scenario: Scenario, branch: str) -> float | None:
    optimum = shortest(scenario, branch)
    return None if optimum is None else optimum.total * scenario.radius


def _onto_circle(scenario: Scenario) -> tuple[float, float]:
    """The point of the nearer turning circle that is nearest to the target."""
    _, Y = scenario.local()
    side = math.copysign(scenario.radius, Y)
    x = scenario.x - side * math.sin(scenario.heading)
    y = scenario.y + side * math.cos(scenario.heading)
    dx, dy = scenario.target_x - x, scenario.target_y - y
    stretch = scenario.radius / math.hypot(dx, dy)
    return x + dx * stretch, y + dy * stretch


_HONEST = {
    Claim.OPTIMAL: (Verdict.OPTIMAL,),
    Claim.LOCAL: (Verdict.OPTIMAL, Verdict.LONGER),
    Claim.FEASIBLE: (Verdict.OPTIMAL, Verdict.LONGER),
    Claim.INFEASIBLE: (Verdict.NONE_EXISTS,),
}


def is_false(claim: Claim, verdict: Verdict) -> bool:
    """Whether the claim is stronger than the verdict."""
    return claim in _HONEST and verdict not in _HONEST[claim]

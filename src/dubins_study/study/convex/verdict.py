"""The verdict on an answer to a frozen convex problem."""

from __future__ import annotations

from typing import Any

import numpy as np

from dubins_study.study.convex.digests import DIGESTS
from dubins_study.study.convex.problem import Point, Problem, read
from dubins_study.study.convex.proof import lower_bound, reference, residuals, upper_bound
from dubins_study.study.path import FloatArray
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.words import Claim, Proof, Verdict


def judge_convex(
    name: str, numbers: FloatArray | None, claim: Claim, tolerance: float
) -> tuple[Judgement, Certificate]:
    """Judge the numbers of a primal and dual point by the tolerance that was asked for.

    It misses if a constraint is violated by more. It is optimal if the feasible point made from it
    (`proof.upper_bound`) costs at most that more than the proven optimum, relative to the larger of
    1 and the optimum, and longer if it costs more for certain. A claim of an optimum is false if it
    is not optimal, and a residual or the gap of both objectives is beyond the tolerance as well.
    """
    low, high, verdict = None, None, Verdict.NONE
    shares: dict[str, Any] = {"region": None, "margin": None}
    if name in DIGESTS:
        low, high = reference(name)
        if numbers is not None and is_point(read(name), numbers):
            verdict, measured = _measured(name, read(name).split(numbers), tolerance)
            shares |= measured
    kept = max(shares.get(name, np.inf) for name in ("miss", "dual_residual", "duality_gap"))
    wrong = verdict is not Verdict.OPTIMAL and not kept <= tolerance
    false = claim is Claim.INFEASIBLE or (claim is Claim.OPTIMAL and wrong)
    proof = Proof.PROVED if verdict is Verdict.OPTIMAL else Proof.NONE
    return (
        Judgement(verdict=verdict, false_claim=false, reference=low, **shares),
        Certificate(proof=proof, reference_low=low, reference_high=high),
    )


def is_point(problem: Problem, numbers: FloatArray) -> bool:
    """Whether an array holds a primal and dual point of a problem, all of it finite."""
    return numbers.size == problem.numbers and bool(np.isfinite(numbers).all())


def _measured(name: str, point: Point, tolerance: float) -> tuple[Verdict, dict[str, float]]:
    problem, (low, high) = read(name), reference(name)
    primal, dual, gap = residuals(problem, point)
    value, scale = upper_bound(problem, point.x), max(1.0, abs(low))
    shares = {
        "miss": primal,
        "dual_residual": dual,
        "duality_gap": gap,
        "certified_gap": (value - lower_bound(problem, point)) / scale,
    }
    if not primal <= tolerance:
        return Verdict.MISSES, shares
    shares |= {"length": value, "gap": (value - low) / scale}
    if shares["gap"] <= tolerance:
        return Verdict.OPTIMAL, shares
    return (Verdict.LONGER if (value - high) / scale > tolerance else Verdict.UNDECIDED), shares

"""Prove bounds of a convex problem's optimum.

The bounds come from any primal and any dual point, and give the verdict. The upper bound is the
objective at the point moved into the feasible set. The lower bound is the Lagrangian's minimum over
the box of the variables. Both hold for every point, since they are evaluated in ball arithmetic
(Arb, through python-flint).
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from flint import arb, ctx
from scipy.sparse import csr_array

from dubins_study.study.arrays import FloatArray
from dubins_study.study.convex.problem import Point, Problem, listed, read
from dubins_study.study.rows.schema import Certificate, Judgement
from dubins_study.study.words import Claim, Proof, Verdict

_BITS = 106
_LEAST_STEP = 1e-14  # towards the interior; covers the rounding of the step itself
_STEPS = 12  # tries, each with a step ten times as large


class Residuals(NamedTuple):
    """Largest violations of a primal and dual point.

    `primal` is that of the constraints, `dual` that of stationarity and of the multipliers' signs.
    `gap` is the difference of both objectives.
    """

    primal: float
    dual: float
    gap: float


def residuals(problem: Problem, point: Point) -> Residuals:
    """Residuals of a point, and its objectives' difference.

    Residuals are in the largest norm, the difference is absolute. The definitions are those of the
    conditions of Karush, Kuhn and Tucker, unscaled.
    """
    x, y, z, w = point
    rows = problem.A @ x
    inside = problem.C @ x + problem.d
    beyond = (problem.l - rows, rows - problem.u, problem.lb - x, x - problem.ub)
    primal = max(_largest(each) for each in (*beyond, _outside(inside, problem.cones)))
    # a row without an end has no multiplier on that side
    wrong = np.where(np.isinf(problem.l), -y, 0.0), np.where(np.isinf(problem.u), y, 0.0)
    slope = problem.p * x + problem.q + problem.A.T @ y + z - problem.C.T @ w
    dual = max(_largest(each) for each in (np.abs(slope), *wrong, _outside(w, problem.cones)))
    ends = _paid(y, problem.l, problem.u) + _paid(z, problem.lb, problem.ub) + problem.d @ w
    return Residuals(primal, dual, abs(float(problem.p @ x**2 + problem.q @ x + ends)))


def _largest(values: FloatArray) -> float:
    return float(values.max(initial=0.0))


def _paid(multipliers: FloatArray, low: FloatArray, high: FloatArray) -> float:
    """Sum of multipliers times their ends.

    A positive multiplier belongs to the upper end, a negative one to the lower end. Infinite ends
    count as zero.
    """
    ends = np.where(multipliers > 0, high, low)
    return float(multipliers @ np.where(np.isinf(ends), 0.0, ends))


def _parts(cones: Any) -> list[slice]:
    """Places of each cone's numbers, from the cones' sizes."""
    ends = np.cumsum(cones).tolist()
    return [slice(end - size, end) for size, end in zip(cones.tolist(), ends, strict=True)]


def _outside(values: FloatArray, cones: Any) -> FloatArray:
    """Violation of each cone, negative inside.

    It is the norm of the other numbers less the first number.
    """
    blocks = [values[part] for part in _parts(cones)]
    return np.array([np.linalg.norm(block[1:]) - block[0] for block in blocks])


def upper_bound(problem: Problem, x: FloatArray) -> float:
    """Objective at a feasible point made from x.

    It is rounded up, and infinite if no such point was reached. x is cut off at its bounds and
    moved towards `interior` until rows, bounds and cones hold. Each equation has a variable of its
    own (`closing_columns`), which takes the value that closes it.
    """
    if not np.isfinite(x).all():
        return np.inf
    cut = _closed(problem, np.clip(x, problem.lb, problem.ub))
    inside = _closed(problem, problem.interior)
    step = _step(problem, cut, inside)
    for _ in range(_STEPS):
        value = _feasible_objective(problem, cut + step * (inside - cut))
        if value is not None:
            return value
        step = min(1.0, max(10 * step, _LEAST_STEP))
    return np.inf


def closing_columns(problem: Problem) -> dict[int, tuple[int, float]]:
    """Column that closes each equation, and its coefficient.

    The result is by row. The column's variable stands in no other row and costs nothing. An
    equation without such a column is left out.
    """
    columns = problem.A.tocsc()
    alone = np.flatnonzero((np.diff(columns.indptr) == 1) & (problem.p == 0) & (problem.q == 0))
    places = columns.indptr[alone]
    entries = zip(columns.indices[places], alone, columns.data[places], strict=True)
    return {int(row): (int(column), float(a)) for row, column, a in entries if problem.equal[row]}


def _closed(problem: Problem, x: FloatArray) -> FloatArray:
    """Copy of x that closes the equations.

    They hold up to rounding.
    """
    closing = closing_columns(problem)
    rows = list(closing)
    columns = [column for column, _ in closing.values()]
    factors = np.array([factor for _, factor in closing.values()])
    result = x.copy()
    result[columns] += (problem.u - problem.A @ x)[rows] / factors
    return result


def _step(problem: Problem, x: FloatArray, inside: FloatArray) -> float:
    """Least step from x towards a point inside.

    The step is a share of the way. After it all rows, bounds and cones hold, up to rounding.
    """
    rows = ~problem.equal

    def room(point: FloatArray) -> FloatArray:
        values = (problem.A @ point)[rows]
        cones = -_outside(problem.C @ point + problem.d, problem.cones)
        ends = values - problem.l[rows], problem.u[rows] - values
        return np.concatenate((*ends, point - problem.lb, problem.ub - point, cones))

    before = room(x)
    after = room(inside)
    # violated at x, and less at the other point
    short = before < np.minimum(after, 0.0)
    shares = before[short] / (before[short] - after[short])
    return float(np.max(shares, initial=0.0)) + _LEAST_STEP


def _feasible_objective(problem: Problem, x: FloatArray) -> float | None:
    """Objective of x with its equations closed.

    It is rounded up, and None if x may be infeasible. Rows are evaluated as balls; the numbers of x
    are exact.
    """
    with ctx.workprec(_BITS):
        point = [arb(value) for value in x.tolist()]
        values = _rows(problem.A, point)
        closing = closing_columns(problem)
        for row in np.flatnonzero(problem.equal).tolist():
            if row not in closing:
                return None
            column, factor = closing[row]
            point[column] += (arb(problem.u[row]) - values[row]) / arb(factor)
        ends = zip(problem.equal, problem.l, problem.u, values, strict=True)
        rows_hold = all(equal or _between(low, value, high) for equal, low, high, value in ends)
        bounds = zip(problem.lb, point, problem.ub, strict=True)
        if not (rows_hold and all(_between(low, value, high) for low, value, high in bounds)):
            return None
        total = _dot(problem.q, point) + _dot(problem.p, [value * value for value in point]) / 2
        inside = [
            value + arb(d) for value, d in zip(_rows(problem.C, point), problem.d, strict=True)
        ]
        return float(total.upper()) if _in_cones(inside, problem.cones) else None


def _between(low: float, value: Any, high: float) -> bool:
    """Whether a ball surely lies between two ends.

    Ends may be infinite.
    """
    return bool((low == -np.inf or value >= low) and (high == np.inf or value <= high))


def _in_cones(values: list[Any], cones: Any) -> bool:
    """Whether balls surely lie in their cones."""
    for part in _parts(cones):
        first, *others = values[part]
        if not (first >= 0 and first * first >= sum((v * v for v in others), arb(0))):
            return False
    return True


def lower_bound(problem: Problem, point: Point) -> float:
    """Lower bound of the optimum, from multipliers.

    It is rounded down, and holds for y and w of any point. Multipliers of the wrong sign count as
    zero, and those outside their cone are brought into it. The bounds of the variables stay
    constraints, so that z is not needed.
    """
    y = np.where(np.isinf(problem.l), np.maximum(point.y, 0.0), point.y)
    y = np.where(np.isinf(problem.u), np.minimum(y, 0.0), y)
    w = point.w.copy()
    for part in _parts(problem.cones):
        w[part.start] = max(w[part.start], float(np.linalg.norm(w[part][1:])) * (1 + 1e-12))
    if not (np.isfinite(y).all() and np.isfinite(w).all()):
        return -np.inf
    with ctx.workprec(_BITS):
        rows = [arb(value) for value in y]
        cones = [arb(value) for value in w]
        if not _in_cones(cones, problem.cones):
            return -np.inf
        ends = np.where(y > 0, problem.u, np.where(y < 0, problem.l, 0.0))
        total = -_dot(ends, rows) - _dot(problem.d, cones)
        pulls = _rows(csr_array(problem.A.T), rows)
        pushes = _rows(csr_array(problem.C.T), cones)
        columns = zip(problem.p, problem.q, problem.lb, problem.ub, pulls, pushes, strict=True)
        for p, q, low, high, pull, push in columns:
            total += _least(arb(p), arb(q) + pull - push, low=arb(low), high=arb(high))
        return float(total.lower())


def _least(p: Any, g: Any, low: Any, high: Any) -> Any:
    """Lower bound of a quadratic on an interval.

    It bounds p x^2 / 2 + g x over low <= x <= high.
    """
    # it only grows, it only falls, it has its vertex somewhere, or it is a line
    if p * low + g >= 0:
        return (p * low / 2 + g) * low
    if p * high + g <= 0:
        return (p * high / 2 + g) * high
    if p > 0:
        return -g * g / (2 * p)
    return min((g * low).lower(), (g * high).lower())


def _dot(numbers: FloatArray, values: list[Any]) -> Any:
    pairs = zip(numbers.tolist(), values, strict=True)
    return sum((arb(number) * value for number, value in pairs if number), arb(0))


def _rows(matrix: csr_array, values: list[Any]) -> list[Any]:
    """Product of a matrix and a vector of balls.

    The matrix holds doubles.
    """
    ends = matrix.indptr.tolist()
    columns = matrix.indices.tolist()
    data = matrix.data.tolist()
    return [
        sum((arb(data[place]) * values[columns[place]] for place in range(begin, end)), arb(0))
        for begin, end in pairwise(ends)
    ]


@lru_cache(maxsize=128)
def reference(name: str) -> tuple[float, float]:
    """Proven interval around a packaged problem's optimum."""
    problem = read(name)
    return lower_bound(problem, problem.witness), upper_bound(problem, problem.x)


def judge_convex(
    name: str, numbers: FloatArray | None, claim: Claim, tolerance: float
) -> tuple[Judgement, Certificate]:
    """Judge the numbers of a primal and dual point.

    The tolerance is the one that was asked for. The point misses if a constraint is violated by
    more. It is optimal if the feasible point made from it (`upper_bound`) costs at most that much
    more than the proven optimum, relative to the larger of 1 and the optimum. It is longer if that
    point surely costs more. A claim of an optimum is false if the point is not optimal, and a
    residual or the gap of both objectives is beyond the tolerance as well.
    """
    low = None
    high = None
    verdict = Verdict.NONE
    shares: dict[str, Any] = {}
    if name in listed():
        low, high = reference(name)
        problem = read(name)
        if numbers is not None and numbers.size == problem.numbers and np.isfinite(numbers).all():
            point = problem.split(numbers)
            verdict, shares = _measure(problem, point, tolerance, low=low, high=high)
    worst = max(shares.get(column, np.inf) for column in ("miss", "dual_residual", "duality_gap"))
    wrong = verdict is not Verdict.OPTIMAL and not worst <= tolerance
    false = claim is Claim.INFEASIBLE or (claim is Claim.OPTIMAL and wrong)
    proof = Proof.NONE
    if verdict is Verdict.OPTIMAL:
        proof = Proof.PROVED
    return (
        Judgement(verdict=verdict, false_claim=false, reference=low, **shares),
        Certificate(proof=proof, reference_low=low, reference_high=high),
    )


def _measure(
    problem: Problem, point: Point, tolerance: float, low: float, high: float
) -> tuple[Verdict, dict[str, float]]:
    """Verdict on a finite point, with columns.

    The columns `length` and `gap` are left out if the point misses.
    """
    primal, dual, gap = residuals(problem, point)
    value = upper_bound(problem, point.x)
    scale = max(1.0, abs(low))
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
    if (value - high) / scale > tolerance:
        return Verdict.LONGER, shares
    return Verdict.UNDECIDED, shares

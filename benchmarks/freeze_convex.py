"""Make the frozen problems: what successive convexification of a route's turn rates meets.

The route is driven in n steps of constant turn rate, the same number on each leg. Unknowns are the
changes z of the headings at the ends of the steps, and the relative changes t of the legs' lengths:

    minimise    sum_j t_j T_j / T + 1/2 sum_k c_k z_k^2 + penalty * miss
    subject to  |(z_k - z_{k-1}) / h_k + turn_k / h_k| <= 1 + t_j    the turn rates, exact
                |z_k| <= reach,  |t_j| <= stretch                    the trust region

where leg j ends at its point but for the linearised miss, counted in units of T: its coordinates'
sum by a pair of slacks each (QP), or its Euclidean length (SOCP, whose trust region is a ball for
each leg). `python -m benchmarks.freeze_convex` writes the files anew.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import fields, replace
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import block_diag, bmat, csr_array, diags_array, eye_array, hstack, vstack

from dubins_study.solvers.arcs import Elements, rollout
from dubins_study.solvers.convex.adapters import Ask, prepare
from dubins_study.study.arrays import FloatArray
from dubins_study.study.convex import digests, problem
from dubins_study.study.convex.problem import CSR, MATRICES, Point, Problem
from dubins_study.study.convex.proof import lower_bound, upper_bound
from dubins_study.study.words import Claim

SIZES = (50, 500, 5000)
_MARGIN, _CONE_MARGIN = 1e-3, 1e-6  # by which rows and cones hold at the interior
_PENALTY = 10.0  # of a sequence as long as it makes progress


class Case(NamedTuple):
    """A route in units of the radius, from (0, 0, 0), and where in its sequence it is frozen."""

    points: tuple[tuple[float, float], ...]
    steps: int  # QPs that are solved before
    penalty: float
    ease: float  # the share of the curvature that is kept
    reach: float  # rad, of the trust region
    ball: float  # root mean square of a leg's changes in its ball, as a share of the reach


# The first problem of a route with long legs; and one near the end of a sequence on short legs,
# with the largest penalty and the least curvature that `turn-rate-qp` uses.
CASES = {
    "well": Case(((6, 3), (9, -4), (15, -2), (18, 5), (25, 6)), 0, _PENALTY, 1.0, 1.0, 0.2),
    "bad": Case(((2, 1), (3.5, 2.5), (5.5, 2), (7, 0.5), (9, 1)), 3, 1e4, 1e-3, 0.1, 0.5),
}


class Iterate(NamedTuple):
    """Headings at the ends of the steps (n,), rad; lengths of the legs (m,), radii."""

    heading: FloatArray
    length: FloatArray


class Linear(NamedTuple):
    """A linearised route: gradients (2m, n) and (2m, m), what is missing (2m,), chords (2, n)."""

    by_heading: csr_array
    by_length: csr_array
    missing: FloatArray
    chords: FloatArray


def first_iterate(case: Case, n: int) -> Iterate:
    """Turn towards the next point as far as its bearing, then straight as far as it is away."""
    heading, headings, lengths = 0.0, [], []
    here = np.zeros(2)
    for point in case.points:
        away = np.array(point) - here
        turn = math.remainder(math.atan2(away[1], away[0]) - heading, 2 * math.pi)
        length = math.hypot(*away) + abs(turn)
        driven = length * np.arange(1, n // len(case.points) + 1) / (n // len(case.points))
        headings.append(heading + math.copysign(1, turn) * np.minimum(driven, abs(turn)))
        lengths.append(length)
        heading, here = heading + turn, np.array(point)
    return Iterate(np.concatenate(headings), np.array(lengths))


def linearised(case: Case, now: Iterate) -> Linear:
    """The legs' end points by the headings and the legs' lengths."""
    n, legs = now.heading.size, len(case.points)
    each = n // legs
    turns = np.diff(now.heading, prepend=0.0)
    rolled = rollout(Elements(turns, np.repeat(now.length / each, each)))
    ends = rolled.chords.reshape(2, legs, each).sum(axis=2).T
    # a chord depends on the headings at its step's end and at the end of the step before
    steps = np.arange(n)
    row = 2 * (steps // each) + np.arange(2)[:, None]
    values = np.hstack((rolled.by_after, rolled.by_before[:, 1:])).ravel()
    rows = np.hstack((row, row[:, 1:])).ravel()
    columns = np.tile(np.concatenate((steps, steps[:-1])), 2)
    return Linear(
        csr_array((values, (rows, columns)), shape=(2 * legs, n)),
        csr_array(block_diag(ends[:, :, None])),
        (np.diff(case.points, axis=0, prepend=[[0.0, 0.0]]) - ends).ravel(),
        rolled.chords,
    )


def subproblem(case: Case, now: Iterate, pulls: FloatArray, cone: bool) -> Problem:
    """The QP or SOCP at an iterate, without a witness; `pulls` (m, 2) are the ends' multipliers."""
    linear, reach = linearised(case, now), case.reach
    n, legs = now.heading.size, now.length.size
    each, total = n // legs, float(now.length.sum())
    along = np.maximum((np.repeat(pulls, each, axis=0) * linear.chords.T).sum(axis=1), 0.0) / total
    curvature = along / 2
    curvature[:-1] += along[1:] / 2
    curvature = np.maximum(curvature * case.ease, 1e-6 / n)
    stretch = min(reach, 0.5)
    step = np.repeat(now.length / each, each)
    rate = np.diff(now.heading, prepend=0.0) / step
    turn = diags_array([1 / step, -1 / step[1:]], offsets=[0, -1], shape=(n, n))
    own = block_diag([np.ones((each, 1))] * legs)
    rows = bmat([[turn, -own], [-turn, -own]])
    room = np.concatenate((1 - rate, 1 + rate))
    G, Q, r = linear.by_heading / total, linear.by_length / total, linear.missing / total
    box = case.ball * reach * math.sqrt(each) if cone else reach
    most = np.abs(r) + box * np.abs(G).sum(axis=1) + stretch * np.abs(Q).sum(axis=1) + 1
    slacks = legs if cone else 4 * legs
    highest = 2 * most.reshape(legs, 2).sum(axis=1) if cone else np.tile(most, 2)
    empty = csr_array((2 * n, slacks))
    A, low, high = hstack([rows, empty]), np.full(2 * n, -np.inf), room
    C, d, cones = csr_array((0, n + legs + slacks)), np.zeros(0), np.zeros(0, dtype=int)
    if cone:
        C, d = _cones(G, Q, r, legs, each, box)
        cones = np.concatenate((np.full(legs, 3), np.full(legs, each + 1)))
    else:
        pair = eye_array(2 * legs)
        A = vstack([A, hstack([G, Q, pair, -pair])])
        low, high = np.concatenate((low, r)), np.concatenate((high, r))
    return Problem(
        p=np.concatenate((curvature, np.zeros(legs + slacks))),
        q=np.concatenate((np.zeros(n), now.length / total, np.full(slacks, case.penalty))),
        A=_sorted(A),
        l=low,
        u=high,
        lb=np.concatenate((np.full(n, -box), np.full(legs, -stretch), np.zeros(slacks))),
        ub=np.concatenate((np.full(n, box), np.full(legs, stretch), highest)),
        C=_sorted(C),
        d=d,
        cones=cones,
        **dict.fromkeys(("interior", *Point._fields), np.zeros(0)),
    )


def _cones(G: Any, Q: Any, r: FloatArray, legs: int, each: int, radius: float) -> tuple[Any, Any]:
    """Rows of the misses' cones, then of the trust regions' balls."""
    n, blocks, ends = legs * each, [], []
    unit = eye_array(legs, format="csr")
    for leg in range(legs):
        two = slice(2 * leg, 2 * leg + 2)
        none = csr_array((1, n + legs))
        blocks.append(
            hstack(
                [
                    vstack([none, hstack([-G[two], -Q[two]])]),
                    vstack([unit[[leg]], csr_array((2, legs))]),
                ]
            )
        )
        ends.append(np.concatenate(([0.0], r[two])))
    all_of = eye_array(n, n + 2 * legs, format="csr")
    for leg in range(legs):
        blocks.append(vstack([csr_array((1, n + 2 * legs)), all_of[leg * each : (leg + 1) * each]]))
        ends.append(np.concatenate(([radius], np.zeros(each))))
    return vstack(blocks), np.concatenate(ends)


def _sorted(matrix: Any) -> csr_array:
    result = csr_array(matrix)
    result.sum_duplicates()
    result.eliminate_zeros()
    result.indices, result.indptr = result.indices.astype(np.int32), result.indptr.astype(np.int32)
    return result


def frozen(case: Case, n: int, cone: bool) -> Problem:
    """The problem that the sequence of a route meets after `case.steps` QPs, with a witness."""
    now, legs = first_iterate(case, n), len(case.points)
    away = np.diff(np.vstack((np.zeros(2), case.points)), axis=0)
    pulls = away / np.linalg.norm(away, axis=1)[:, None]
    early = case._replace(penalty=_PENALTY, ease=1.0, reach=1.0)
    for _ in range(case.steps):
        qp = subproblem(early, now, pulls, cone=False)
        point = prepare("piqp", "own", qp)(Ask(1e-9, 60.0)).point
        assert point is not None
        now = Iterate(now.heading + point.x[:n], now.length * (1 + point.x[n : n + legs]))
        pulls = -point.y[2 * n :].reshape(legs, 2)
    # the present path keeps the turn rates exactly, in floating point too
    step = np.repeat(now.length * legs / n, n // legs)
    turns = np.clip(np.diff(now.heading, prepend=0.0), -step, step)
    now = Iterate(np.cumsum(turns), now.length)
    qp = witnessed(subproblem(case, now, pulls, cone=False))
    if not cone:
        return qp
    # where the balls do not bind and nothing is missed, both have the same optimum
    bare, ends = subproblem(case, now, pulls, cone=True), qp.y[2 * n :].reshape(legs, 2)
    shared, slacks, m = n + legs, np.zeros(legs), 2 * n
    x, z = np.append(qp.x[:shared], slacks + 1e-16), np.append(qp.z[:shared], slacks)
    w = np.zeros(bare.d.size)
    w[: 3 * legs] = np.column_stack((np.full(legs, case.penalty), ends)).ravel()
    return witnessed(bare, Point(x, qp.y[:m], z, w))


def witnessed(bare: Problem, *points: Point) -> Problem:
    """The problem with a cheap interior, and the tightest interval of engines' and given points.

    The interior is the optimum of the problem whose rows and cones are tightened a little: on the
    way to it a point becomes feasible at about the least cost.
    """
    engines = ("clarabel", "ecos") if bare.cones.size else ("clarabel", "piqp")
    heads, rows = np.zeros(bare.d.size), ~bare.equal
    heads[np.cumsum(bare.cones) - bare.cones] = 1.0
    ends = {"l": bare.l + _MARGIN * rows, "u": bare.u - _MARGIN * rows}
    tight = replace(bare, **ends, d=bare.d - _CONE_MARGIN * heads)
    inner = prepare("clarabel", "own", tight)(Ask(1e-9, 60.0))
    assert inner.point is not None
    assert inner.claim is Claim.OPTIMAL
    asked = [
        prepare(engine, "own", bare)(Ask(tolerance, 60.0)).point
        for engine in engines
        for tolerance in (1e-9, 1e-10, 1e-11, 1e-12, 1e-13)
    ]
    best, high, low = (
        replace(bare, interior=np.clip(inner.point.x, bare.lb, bare.ub)),
        np.inf,
        -np.inf,
    )
    for point in (*points, *asked):
        if point is not None:
            if (value := upper_bound(best, point.x)) < high:
                high, best = value, replace(best, x=point.x)
            if (value := lower_bound(best, point)) > low:
                low, best = value, replace(best, y=point.y, z=point.z, w=point.w)
    return best


def trivial() -> Problem:
    """x^2 / 2 - x over [0, 1], with a row that does not bind: what any call takes."""
    one, none = np.ones(1), np.zeros(0)
    return Problem(
        *(one, -one, csr_array([[1.0]]), -2 * one, 2 * one, 0 * one, one, csr_array((0, 1))),
        *(none, np.zeros(0, dtype=int), 0.5 * one, one, 0 * one, 0 * one, none),
    )


def write(problem: Problem, file: FilePath) -> str:
    """Write a problem as a compressed .npz file, and return the SHA-256 of its bytes."""
    arrays: dict[str, Any] = {}
    for each in fields(problem):
        value = getattr(problem, each.name)
        if each.name in MATRICES:
            arrays |= {f"{each.name}_{part}": getattr(value, part) for part in CSR}
        else:
            arrays[each.name] = value
    np.savez_compressed(file, **arrays)
    return hashlib.sha256(file.read_bytes()).hexdigest()


def main() -> None:
    """Write all files and the module with their digests, and print the intervals."""
    folder = FilePath(problem.__file__).with_name("problems")
    made = {"trivial": trivial()}
    for cone in (False, True):
        for n in SIZES:
            for name, case in CASES.items():
                made[f"{'socp' if cone else 'qp'}-{n}-{name}"] = frozen(case, n, cone)
    lines = ['"""SHA-256 of the files of `problems`; written by `benchmarks.freeze_convex`."""', ""]
    lines.append("DIGESTS = {")
    for name, each in made.items():
        digest = write(each, folder / f"{name}.npz")
        lines.append(f'    "{name}": "{digest}",')
        low, high = lower_bound(each, each.witness), upper_bound(each, each.x)
        print(f"{name:16} [{low:.12g}, {high:.12g}]  width {high - low:.1e}")
    FilePath(digests.__file__).write_text("\n".join([*lines, "}", ""]), encoding="utf-8")


if __name__ == "__main__":
    main()

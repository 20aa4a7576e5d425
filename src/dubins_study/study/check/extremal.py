"""Check Pontryagin's conditions and the cut.

A path's controls alone decide. In the paper's convention (2.3)-(2.15), H = nu0 + nu1 cos theta +
nu2 sin theta + nu3 u is minimised and zero, with u the curvature in units of 1 / radius and
positions in radii. The paper leaves out nu0 >= 0, (nu0, nu) not all zero, and nu3 = 0 at the free
final heading. On an extremal all of

    H = 0 on every piece,    nu3 = 0 on every straight,    nu3 = 0 at the end

are linear in (nu0, nu1, nu2, nu3 at the end): nu3 = nu1 (y - y_end) - nu2 (x - x_end) + constant.
So the costates are the null vector of a small matrix. The distance of a path from being an extremal
is the distance of that matrix from having a null vector (docs/derivation.md, section 9). The words
S, C, CS and CC at full rate have their costates in closed form (`two_arcs.costates`), which is ten
times as quick.
"""

from __future__ import annotations

import math
from itertools import compress, pairwise
from operator import mul, or_
from typing import NamedTuple

import numpy as np

from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check.two_arcs import (
    ABNORMAL,
    NO_LENGTH,
    NO_TURN,
    RATE_TOLERANCE,
    Word,
    costates,
    cut_margin,
    nearest_rate,
    sign_margin,
)
from dubins_study.study.path import Path, corners, end_of
from dubins_study.study.scenario import Pose
from dubins_study.study.tolerances import ARRIVES, allowed_miss

_ORIGIN = Pose(0.0, 0.0, 0.0)
_NO_PIECE = (0.0, 0.0)
# coefficients of nu0, nu1, nu2 and of nu3 at the end
Row = tuple[float, float, float, float]


class Extremal(NamedTuple):
    """Findings of Pontryagin's conditions on a path.

    They are columns of `study.rows.schema.Certificate`. Residuals are for costates scaled to
    max(nu0, |(nu1, nu2)|) = 1, and nu3 is divided by the path's length in radii where that exceeds
    1, so that they are errors of angles.
    """

    costate_x: float  # nu1, nu2 at the end, in the world frame; nu0 = 1, or norm 1 if abnormal
    costate_y: float
    abnormal: bool  # nu0 = 0
    hamiltonian: float  # max |H| over the path
    sign_margin: float  # least -u nu3 over the turning pieces; below 0 a turn goes the wrong way
    transversality: float | None  # |nu3| at the end; None where a final heading is given
    pmp_residual: float  # worst of all violations, also those of nu3 = 0 on straights

    @property
    def nu(self) -> tuple[float, float]:
        return self.costate_x, self.costate_y


def measure(path: Path, radius: float, free: bool = True) -> tuple[Extremal | None, float | None]:
    """Costates of a one-leg path, and its cut margin.

    The path must be one that can be driven. `free` says whether the final heading is free. The cut
    margin says by how much (rad) a path stays clear of where another one becomes shorter. A path
    with a margin above zero is shortest to its own end point, and only such a path is
    (docs/derivation.md, section 10).

    The margin is None if the final heading is given, or if the path is no S, C, CS or CC at full
    rate, as every shortest path is. It is pi for a path without pieces. Both results are None for a
    path whose numbers overflow in units of the radius, which fits no scenario.
    """
    rates = [k * radius for k in path.curvatures.tolist()]
    lengths = [length / radius for length in path.lengths.tolist()]
    # overflows if any rate, length or turn does
    turns = sum(abs(u) * length + abs(u) for u, length in zip(rates, lengths, strict=True))
    if not math.isfinite(turns + sum(lengths)):
        return None, None
    driven = rates, lengths
    rates, lengths = pieces(rates, lengths)
    if not rates:
        if free:
            return None, math.pi
        return None, None
    word = _word(rates, lengths, free)
    if word is None and free:  # in a short path, a tiny turn may count as straight
        word = _word(*driven, free)
    if word is None:
        return extremal(path.start.heading, rates, lengths, free), None
    x, y, abnormal, H, margin = costates(path.start.heading, word)
    transversality = None
    cut = None
    if free:
        transversality = 0.0
        cut = cut_margin(word)
    best = Extremal(
        costate_x=x,
        costate_y=y,
        abnormal=abnormal,
        hamiltonian=H,
        sign_margin=margin,
        transversality=transversality,
        pmp_residual=max(H, -margin),
    )
    return best, cut


def _word(u: list[float], length: list[float], free: bool) -> Word | None:
    """Rates and lengths of a path's word.

    The word is S, C, CS or CC at full rate, or CSC or CCC if the heading is given. None if the
    pieces are another path.

    A word always has three pieces; one that it lacks has no length. S is (none, S, none), LS is
    (L, S, none). LR is (L, R, none) to a free heading and (L, none, R) to a given one, where the
    piece in the middle stands for a straight.
    """
    rates = [nearest_rate(k) for k in u]
    total = sum(length)
    off = [abs(k - rate) for k, rate in zip(u, rates, strict=True)]
    # distance of the end from the end of the path at full rates
    distance = sum(map(mul, off, length)) * total
    allowed = allowed_miss(ARRIVES, radius=1.0, extent=0.0, length=total)
    if max(off) > RATE_TOLERANCE or distance > allowed:
        return None
    arcs = list(zip(rates, length, strict=True))
    if arcs[0][0] == 0.0:
        arcs.insert(0, _NO_PIECE)
    if len(arcs) == 2 and arcs[1][0] != 0.0 and not free:
        arcs.insert(1, _NO_PIECE)
    first, second, third = (*arcs, _NO_PIECE, _NO_PIECE)[:3]
    if free:
        is_word = len(arcs) <= 2 and second[0] in (0.0, -first[0])
    else:
        three_arcs = first[0] == third[0] == -second[0]
        is_word = len(arcs) <= 3 and (second[0] == 0.0 or three_arcs)
    if not is_word:
        return None
    return first, second, third


def pieces(rate: list[float], length: list[float]) -> tuple[list[float], list[float]]:
    """Rates and lengths (radii) of the pieces that matter.

    Rates within `RATE_TOLERANCE` of +1, 0 or -1 become these numbers, and neighbours of one rate
    are joined. A piece that turns by less than `NO_TURN` is straight, and a straight shorter than
    `NO_LENGTH` is left out: solvers return such arcs where they mean none.

    Small things add up, and far away a small turn is a long way. If that merged path ends elsewhere
    or is shorter than the driven one by more than the check allows, it is another path. Then the
    driven one's own pieces are returned.
    """
    if _apart(rate, length):
        return rate, length
    driven = np.array([pair for pair in zip(rate, length, strict=True) if pair[1] != 0.0])
    u, scaled = driven.reshape(-1, 2).T
    merged = _merged(u, scaled)
    if _is_same(merged, (u, scaled)):
        u, scaled = merged
    return u.tolist(), scaled.tolist()


def _merged(rate: FloatArray, scaled: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rates and lengths of the merged path of `pieces`."""
    whole = np.clip(np.round(rate), -1, 1)
    u, length = _joined(np.where(np.abs(rate - whole) <= RATE_TOLERANCE, whole, rate), scaled)
    turns = np.abs(u) * length > NO_TURN
    if turns.all():
        return u, length
    mask = turns | (length > NO_LENGTH * min(1.0, float(length.sum())))
    return _joined(np.where(turns, u, 0.0)[mask], length[mask])


def _is_same(merged: tuple[FloatArray, FloatArray], driven: tuple[FloatArray, FloatArray]) -> bool:
    """Whether a merged path is the driven one.

    Their ends and their lengths are compared.
    """
    before = float(driven[1].sum())
    allowed = allowed_miss(ARRIVES, radius=1.0, extent=0.0, length=before)
    if not abs(before - float(merged[1].sum())) <= allowed:
        return False
    end = end_of(_ORIGIN, *merged)
    other = end_of(_ORIGIN, *driven)
    return math.dist(end[:2], other[:2]) <= allowed


def _apart(u: list[float], length: list[float]) -> bool:
    """Whether no pieces need to be merged.

    Every piece turns or is a straight that matters, and no neighbours are of one rate. That is true
    of most paths of few pieces, which then need no further work.
    """
    least = NO_LENGTH * min(1.0, sum(length))
    # first a test that a path cut into many steps fails at once
    return all(abs(a - b) > RATE_TOLERANCE for a, b in pairwise(u)) and all(
        (abs(k) > RATE_TOLERANCE and abs(k) * s > NO_TURN) or (k == 0 and s > least)
        for k, s in zip(u, length, strict=True)
    )


def _joined(u: FloatArray, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Merge neighbours whose rates are equal within `RATE_TOLERANCE`.

    A merged piece keeps its first rate and the sum of lengths.
    """
    if u.size < 2:
        return u, length
    first = np.concatenate(([0], 1 + np.flatnonzero(np.abs(u[1:] - u[:-1]) > RATE_TOLERANCE)))
    joined: FloatArray = np.add.reduceat(length, first)
    return u[first], joined


def extremal(heading: float, u: list[float], length: list[float], free: bool) -> Extremal | None:
    """Costates that fit a path best, with residuals.

    None where the conditions overflow. The path starts with a heading (rad) and has pieces of rates
    u and lengths (radii); `free` says whether its final heading is.
    """
    # in the frame of the start, where angles are small; the costates are turned back at the end
    path_conditions = conditions(u, length, _ORIGIN)
    if path_conditions is None:
        return None
    hamiltonian = path_conditions.hamiltonian
    straight = path_conditions.straight
    arcs = path_conditions.arcs
    rows = [*hamiltonian, *straight]
    if free:
        rows += path_conditions.ends
    # rows of zeros keep the matrix as high as it is wide
    matrix = np.array([*rows, *[(0.0,) * 4] * 3])
    # the vector of length 1 that violates the conditions least
    null_vector = np.linalg.svd(matrix, full_matrices=False)[2][-1].tolist()
    size = max(abs(null_vector[0]), math.hypot(null_vector[1], null_vector[2]))
    if not size > 0:
        # the path is so long that nu3 alone violates the conditions least; those are no costates
        return None
    null_vector = [c / size for c in null_vector]
    abnormal = abs(null_vector[0]) < ABNORMAL
    signs = [math.copysign(1.0, null_vector[0])]
    if abnormal:
        signs = [1.0, -1.0]
    signed = [[sign * c for c in null_vector] for sign in signs]
    margins = [sign_margin(one, arcs) for one in signed]
    margin = max(margins)
    best = signed[margins.index(margin)]
    H = largest(hamiltonian, best)
    nu0, nu1, nu2, nu3 = best
    transversality = None
    if free:
        transversality = abs(nu3) / path_conditions.stretch
    if not abnormal:
        nu1 /= nu0
        nu2 /= nu0
    c = math.cos(heading)
    s = math.sin(heading)
    return Extremal(
        costate_x=nu1 * c - nu2 * s,
        costate_y=nu1 * s + nu2 * c,
        abnormal=abnormal,
        hamiltonian=H,
        sign_margin=margin,
        transversality=transversality,
        pmp_residual=max(H, transversality or 0.0, largest(straight, best), -margin),
    )


class Conditions(NamedTuple):
    """Conditions on the costates of a path.

    They are linear in nu0, nu1, nu2 and nu3 at its end.
    """

    hamiltonian: list[Row]  # H on every piece
    straight: list[Row]  # nu3 at the ends of straights, divided by `stretch`
    arcs: list[tuple[float, float]]  # headings (rad) at the ends of the turns
    stretch: float  # the path's length, or 1 (radii)
    ends: list[Row]  # nu3 at a free end, and the condition that fixes the end of a single arc
    start: Row  # nu3 at the start


def conditions(u: list[float], length: list[float], start: Pose) -> Conditions | None:
    """Conditions of n pieces of rates u.

    None where they are lost in rounding or overflow.
    """
    driven = np.array(length)
    # a straight that bends has a condition in its middle too: nu3 may vanish at its two ends only
    halves = np.array([1 + (k != 0 and abs(k) < 1 - RATE_TOLERANCE) for k in u], np.intp)
    rates = np.repeat(u, halves)
    poses = corners(start, rates, np.repeat(driven / halves, halves)).tolist()
    stretch = max(1.0, float(driven.sum()))
    end_x, end_y, end = poses[-1]
    nu3 = [(0.0, y - end_y, end_x - x, 1.0) for x, y, _ in poses]
    pieces = rates.tolist()
    hamiltonian = [  # constant along a piece: one row for each
        (1.0, math.cos(theta) + k * along, math.sin(theta) + k * across, k)
        for k, (_, _, theta), (_, along, across, _) in zip(pieces, poses, nu3, strict=False)
    ]
    if stretch > 1 / EPS or not math.isfinite(sum(map(sum, hamiltonian))):
        return None
    straight = [abs(k) < 1 - RATE_TOLERANCE for k in pieces]
    touching = map(or_, [*straight, False], [False, *straight])
    still = [
        (0.0, along / stretch, across / stretch, 1.0 / stretch)
        for _, along, across, _ in compress(nu3, touching)
    ]
    turns = zip(pieces, poses, poses[1:], strict=False)
    arcs = [(a, b) for k, (_, _, a), (_, _, b) in turns if k != 0]
    ends = [nu3[-1]]
    if len(pieces) == 1 and not straight[0]:
        # a single arc has a family of costates; choose the one of a straight of no length after it
        ends.append((0.0, -math.sin(end), math.cos(end), 0.0))
    return Conditions(
        hamiltonian=hamiltonian,
        straight=still,
        arcs=arcs,
        stretch=stretch,
        ends=ends,
        start=nu3[0],
    )


def largest(rows: list[Row], nu: list[float]) -> float:
    """Worst violation of some conditions."""
    return max((abs(sum(map(mul, row, nu))) for row in rows), default=0.0)

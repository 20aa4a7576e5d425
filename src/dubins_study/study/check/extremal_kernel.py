"""Pontryagin's conditions and the cut over arrays: `study.check.extremal` for paths of two arcs.

The words S, C, CS and CC at full rate have their costates in closed form (THEORY section 6); that
they satisfy the conditions is still measured, from positions and headings. Other rows are left.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.check.extremal import ABNORMAL
from dubins_study.study.check.pieces import FULL_RATE
from dubins_study.study.check.verdict import WORD
from dubins_study.study.closed_form.kernel_compile import compiled, inlined
from dubins_study.study.path import FloatArray

_TURN = 2 * math.pi


@inlined
def _counts(u: float, length: float, total: float) -> bool:
    """Whether a piece matters, as in `pieces.pieces`."""
    return abs(u) * length > WORD or length > WORD * total


@inlined
def _least(nu0: float, rho: float, a: float, b: float) -> float:
    """Least nu0 + rho cos(theta) for theta between a and b, as in `extremal._sign_margin`."""
    low, high = min(a, b), max(a, b)
    if rho < 0.0:  # seen from where the cosine is least
        passed = math.floor(high / _TURN) > math.floor(low / _TURN)
        return nu0 + rho * (1.0 if passed else max(math.cos(a), math.cos(b)))
    passed = math.floor((high - math.pi) / _TURN) > math.floor((low - math.pi) / _TURN)
    return nu0 + rho * (-1.0 if passed else min(math.cos(a), math.cos(b)))


@inlined
def _moved(turn: float, length: float, heading: float) -> tuple[float, float]:
    """Displacement of a piece driven from a heading, in radii."""
    half = turn * length / 2
    chord = length * (math.sin(half) / half if half != 0.0 else 1.0)
    return chord * math.cos(heading + half), chord * math.sin(heading + half)


@inlined
def _row(
    turn1: float, first: float, turn2: float, second: float
) -> tuple[float, float, float, float, float, float]:
    """nu0, rho, phi, max |H|, sign margin and cut margin of a path, in the frame of its start.

    The first piece turns unless there is but one; the costates are (nu1, nu2) =
    rho (cos phi, sin phi), scaled to max(nu0, |rho|) = 1.
    """
    middle = turn1 * first
    end = middle + turn2 * second
    if turn2 != 0.0:  # CC: along or against the chord of the second arc
        half = math.cos(second / 2)
        nu0, rho, phi = abs(half), -math.copysign(1.0, half), middle + turn2 * second / 2
        longest = 2 * math.atan2(-math.sin(second), 2 - math.cos(second))
        cut = min(second - math.pi, _TURN - second, longest - first)
    else:  # CS: against the final heading
        nu0, rho, phi = 1.0, -1.0, end
        cut = math.pi if turn1 == 0.0 else _TURN - 2 * math.atan(second) - first
    x1, y1 = _moved(turn1, first, 0.0)
    x2, y2 = _moved(turn2, second, middle)
    nu1, nu2 = rho * math.cos(phi), rho * math.sin(phi)
    nu3 = nu2 * (x1 + x2) - nu1 * (y1 + y2)  # at the start, with nu3 = 0 at the end
    middle_nu3 = nu2 * x2 - nu1 * y2
    H1 = nu0 + nu1 + turn1 * nu3
    H2 = nu0 + rho * math.cos(middle - phi) + turn2 * middle_nu3
    margin1 = _least(nu0, rho, -phi, middle - phi) if turn1 != 0.0 else math.inf
    margin2 = _least(nu0, rho, middle - phi, end - phi) if turn2 != 0.0 else math.inf
    margin = min(margin1, margin2)
    on_straight = abs(middle_nu3) if turn2 == 0.0 else 0.0
    worst = max(max(abs(H1), abs(H2)), on_straight / max(1.0, first + second))
    return nu0, rho, phi, worst, 0.0 if margin == math.inf else margin, cut


@compiled
def extremal_rows(
    heading: FloatArray,
    radius: FloatArray,
    curvature: FloatArray,
    length: FloatArray,
    measured: FloatArray,
    abnormal: NDArray[np.bool_],
) -> NDArray[np.bool_]:
    """Fill `measured` and `abnormal`; returns which rows are left, shape (n,).

    Args:
        heading: start headings (rad), shape (n,).
        radius: turning radii (length unit), shape (n,).
        curvature: shape (2, n), 1 / length unit.
        length: shape (2, n), length unit.
        measured: shape (7, n), rows as `study.check.extremal.MEASURED`.
        abnormal: shape (n,).
    """
    n = heading.size
    left = np.zeros(n, np.bool_)
    for i in range(n):
        R = radius[i]
        u1, u2 = curvature[0, i] * R, curvature[1, i] * R
        l1, l2 = length[0, i] / R, length[1, i] / R
        kept1, kept2 = _counts(u1, l1, l1 + l2), _counts(u2, l2, l1 + l2)
        u1, u2 = u1 if abs(u1) * l1 > WORD else 0.0, u2 if abs(u2) * l2 > WORD else 0.0
        if not kept1:
            u1, l1 = u2, l2
        if not (kept1 and kept2):
            u2, l2 = 0.0, 0.0
        t1, t2 = np.rint(u1), np.rint(u2)
        full = abs(u1 - t1) <= FULL_RATE and abs(u2 - t2) <= FULL_RATE
        full = full and abs(t1) <= 1.0 and abs(t2) <= 1.0
        # S alone, C alone, CS, or CC with a change of side
        word = (t2 == 0.0 and (t1 != 0.0 or l2 == 0.0)) or t1 * t2 == -1.0
        if not (full and word and (kept1 or kept2)):
            left[i] = True
            continue
        nu0, rho, phi, H, margin, cut = _row(t1, l1, t2, l2)
        abnormal[i] = nu0 < ABNORMAL
        scale = rho if abnormal[i] else rho / nu0
        # turned by the heading on its own: added to one of many turns, phi loses its digits
        c, s = math.cos(heading[i]), math.sin(heading[i])
        measured[0, i] = scale * (c * math.cos(phi) - s * math.sin(phi))
        measured[1, i] = scale * (s * math.cos(phi) + c * math.sin(phi))
        measured[2, i] = H
        measured[3, i] = margin
        measured[4, i] = 0.0
        measured[5, i] = max(H, -margin)
        measured[6, i] = cut
    return left

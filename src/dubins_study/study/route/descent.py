"""Shorten a route by local search.

Its length is the upper bound of the certified search. Newton's method on the tridiagonal Hessian is
used where no word changes, finer and finer grids where one does. Everything is in units of the
turning radius.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import BoolArray, FloatArray
from dubins_study.study.closed_form.kernel_compile import compiled
from dubins_study.study.closed_form.pose import pose_curvatures, pose_gradient
from dubins_study.study.route.effort import Effort
from dubins_study.study.route.heading_grids import shorten, shortest_leg
from dubins_study.study.route.leg_bound import WordArray

_FINE = 1e-6  # rad, of grids
_FINEST = 1e-13
_LARGEST_STEP = 0.3  # rad, of Newton's method
_BESIDE_ARC = 1e-6  # rad; more than the square root of the rounding of a leg's data


@compiled
def route_length(legs: FloatArray, headings: FloatArray) -> float:
    """Length of the route with these headings."""
    total = 0.0
    for i in range(legs.shape[0]):
        total += shortest_leg(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])[0]
    return total


@compiled
def route_words(legs: FloatArray, headings: FloatArray) -> tuple[WordArray, FloatArray]:
    """Words of the legs, and their segments (radii).

    Shapes (n,) and (n, 3). Words are places in `pose.WORDS6`.
    """
    n = legs.shape[0]
    words = np.empty(n, np.int8)
    segments = np.empty((n, 3))
    for i in range(n):
        _, words[i], t, p, q = shortest_leg(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
        segments[i, 0] = t
        segments[i, 1] = p
        segments[i, 2] = q
    return words, segments


@compiled
def newton(legs: FloatArray, headings: FloatArray, free: BoolArray) -> bool:
    """Move free headings by Newton's method, in place.

    Returns whether they came to rest at a local minimum. If not, they may have moved all the same.
    """
    n = legs.shape[0]
    slope = np.empty(n + 1)
    diagonal = np.empty(n + 1)
    beside = np.empty(n + 1)
    for _ in range(40):
        slope[:] = 0.0
        diagonal[:] = 0.0
        beside[:] = 0.0
        for i in range(n):
            if not (free[i] or free[i + 1]):
                continue
            _, word, t, p, q = shortest_leg(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
            if not (p > 1e-9):
                return False
            d1, d2 = pose_gradient(word, t, p, q)
            d11, d12, d22 = pose_curvatures(word, t, p, q)
            slope[i] += d1
            slope[i + 1] += d2
            diagonal[i] += d11
            diagonal[i + 1] += d22
            beside[i] = d12
        for i in range(n + 1):
            if not free[i]:
                slope[i] = 0.0
                diagonal[i] = 1.0
                beside[i] = 0.0
                if i > 0:
                    beside[i - 1] = 0.0
        # at a straight's free end the length is like a cubic at its minimum: a step goes halfway
        if np.abs(slope).max() < 1e-13:
            return True
        # elimination without pivoting: the matrix is positive definite if all pivots are positive
        for i in range(n + 1):
            if i > 0:
                factor = beside[i - 1] / diagonal[i - 1]
                diagonal[i] -= factor * beside[i - 1]
                slope[i] -= factor * slope[i - 1]
            if not (diagonal[i] > 1e-9):
                return False
        longest = 0.0
        for i in range(n, -1, -1):
            if i < n:
                slope[i] -= beside[i] * slope[i + 1]
            slope[i] /= diagonal[i]
            longest = max(longest, abs(slope[i]))
        headings -= slope * min(1.0, _LARGEST_STEP / max(longest, _LARGEST_STEP))
        if longest < 1e-12:
            return True
    return False


def _on_arcs(headings: FloatArray, arc_ends: Sequence[FloatArray]) -> tuple[FloatArray, BoolArray]:
    """Headings moved onto nearby arcs.

    Returns a moved copy, and a mask of the headings that are not on an arc. A heading so near
    to that of an arc's end differs from it by rounding only.
    """
    moved = headings.copy()
    off_arcs = np.ones(headings.size, np.bool_)
    for i, ends in enumerate(arc_ends):
        for end in ends:
            away = math.remainder(headings[i] - end, TWO_PI)
            if abs(away) < _BESIDE_ARC:
                moved[i] -= away
                off_arcs[i] = False
    return moved, off_arcs


def downhill(
    legs: FloatArray,
    headings: FloatArray,
    free: BoolArray,
    arc_ends: Sequence[FloatArray],
    width: float,
    best: float,
    effort: Effort,
) -> FloatArray:
    """Headings of the shortest route downhill from one.

    If the route is unlikely to become shorter than `best`, it is improved on a coarse grid only.

    Args:
        legs: from each point to the next, shape (n, 2).
        headings: at the points, shape (n + 1,); varied where `free`.
        arc_ends: headings at each point to which a single arc leads from one that is given.
        width: distance of the first grid's headings (rad).
        best: length of a route that is known.
        effort: where that is spent, the route is as short as it has come until then.
    """
    smooth = headings.copy()
    gridded = headings.copy()
    rests = newton(legs, smooth, free)
    smooth, _ = _on_arcs(smooth, arc_ends)
    if rests and (np.hypot(*legs.T) >= 4.0).all():  # nothing jumps: a grid finds nothing better
        return smooth
    movable = free
    before = np.zeros(0, np.bool_)
    # a heading that has come to an arc stays there: it is not movable in the next pass
    while not np.array_equal(movable, before):
        before = movable
        shorten(legs, gridded, before, (width, _FINE), effort)
        gridded, off_arcs = _on_arcs(gridded, arc_ends)
        movable = free & off_arcs
    if route_length(legs, gridded) < best + 2.0 * _FINE * len(legs):
        shorten(legs, gridded, movable, (_FINE, _FINEST), effort)
        # lengths determine headings only to the square root of their rounding
        words, segments = route_words(legs, gridded)
        inner = np.where(words[:, None] < 4, segments[:, 1:2], segments).min(axis=1) > _FINE
        movable[:-1] &= inner
        movable[1:] &= inner
        polished = gridded.copy()
        if newton(legs, polished, movable) and np.allclose(polished, gridded, rtol=0, atol=_FINE):
            gridded = polished
    if rests and route_length(legs, smooth) < route_length(legs, gridded):
        return smooth
    return gridded

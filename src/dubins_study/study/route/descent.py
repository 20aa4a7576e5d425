"""A short route by local search: the upper bound of the certified search.

A dynamic program over a few headings a point, its grid made finer about the best ones, finds a
route; Newton's method on the tridiagonal Hessian ends it where no word changes. Everything is in
units of the turning radius.
"""

from __future__ import annotations

import math

import numpy as np

from dubins_study.study.closed_form import pose
from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.leg_bound import WordArray
from dubins_study.study.route.leg_words import shortest_word

_gradient = separate(pose.pose_gradient)

_FINEST = 1e-13  # rad, of the grid about the best headings
_ROUGH = 1e-3  # rad; below it Newton's method is tried
_GRID = 13  # headings a point
_LARGEST_STEP = 0.05  # rad, of Newton's method


@compiled
def leg_table(
    x: float, y: float, first: FloatArray, last: FloatArray
) -> tuple[FloatArray, WordArray]:
    """Lengths and words of a leg for all pairs of headings, of shape (first, last)."""
    lengths, words = np.empty((first.size, last.size)), np.empty((first.size, last.size), np.int8)
    for i in range(first.size):
        for j in range(last.size):
            lengths[i, j], words[i, j], _, _, _ = shortest_word(x, y, first[i], last[j])
    return lengths, words


@compiled
def leg_lengths(
    x: float, y: float, first: FloatArray, last: FloatArray
) -> FloatArray:
    """Lengths of a leg for pairs of headings."""
    lengths = np.empty(first.size)
    for i in range(first.size):
        lengths[i] = shortest_word(x, y, first[i], last[i])[0]
    return lengths


@separate
def _grid_step(
    legs: FloatArray, headings: FloatArray, free: BoolArray, width: float
) -> bool:
    """Move to the best of `_GRID` headings a point, `width` apart; whether any has changed."""
    n, centre = legs.shape[0], _GRID // 2
    cost, back = np.full(_GRID, math.inf), np.empty((n, _GRID), np.int64)
    for j in range(_GRID):
        if free[0] or j == centre:
            cost[j] = 0.0
    for i in range(n):
        following = np.full(_GRID, math.inf)
        for k in range(_GRID):
            if k != centre and not free[i + 1]:
                continue
            b = headings[i + 1] + (k - centre) * width
            for j in range(_GRID):
                if not (cost[j] < math.inf):
                    continue
                a = headings[i] + (j - centre) * width
                length = shortest_word(legs[i, 0], legs[i, 1], a, b)[0]
                # the middle wins where lengths are equal, so that the search comes to rest
                total = cost[j] + length + (0.0 if j == centre else 1e-14)
                if total < following[k]:
                    following[k], back[i, k] = total, j
        cost = following
    k, moved = centre, False
    for j in range(_GRID):
        if cost[j] < cost[k]:
            k = j
    for i in range(n, -1, -1):
        moved |= k != centre
        headings[i] += (k - centre) * width
        if i > 0:
            k = back[i - 1, k]
    return moved


@separate
def route_length(legs: FloatArray, headings: FloatArray) -> float:
    """The length of the route with these headings."""
    total = 0.0
    for i in range(legs.shape[0]):
        total += shortest_word(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])[0]
    return total


@separate
def _curvatures(word: int, t: float, p: float, q: float) -> tuple[float, float, float]:
    """Second derivatives of a word's length by its headings: 11, 12, 22."""
    if word < 4:
        a, c = math.sin(t), math.sin(q)
        return a * (1.0 + a / p), a * c / p, c * (1.0 + c / p)
    psi = 0.5 * p
    sine, rho = math.sin(psi), -1.0 / math.cos(psi)
    u, v = psi - t, q - psi
    w1, w2, z1, z2 = math.sin(u), -math.sin(v), math.cos(u), -math.cos(v)
    across, along = 0.25 * rho / sine, 0.25 * sine * rho**3
    return (
        rho * math.sin(u) - across * w1 * w1 - along * z1 * z1,
        -across * w1 * w2 - along * z1 * z2,
        -rho * math.sin(v) - across * w2 * w2 - along * z2 * z2,
    )


@separate
def _newton(
    legs: FloatArray, headings: FloatArray, free: BoolArray
) -> bool:
    """Newton's method; False where the Hessian is not positive definite or a step is long."""
    n = legs.shape[0]
    slope, diagonal, beside = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    for _ in range(12):
        slope[:], diagonal[:], beside[:] = 0.0, 0.0, 0.0
        for i in range(n):
            length, word, t, p, q = shortest_word(
                legs[i, 0], legs[i, 1], headings[i], headings[i + 1]
            )
            if not (p > 1e-9):
                return False
            d1, d2 = _gradient(word, t, p, q)
            d11, d12, d22 = _curvatures(word, t, p, q)
            slope[i] += d1
            slope[i + 1] += d2
            diagonal[i] += d11
            diagonal[i + 1] += d22
            beside[i] = d12
        for i in range(n + 1):
            if not free[i]:
                slope[i], diagonal[i], beside[i] = 0.0, 1.0, 0.0
                if i > 0:
                    beside[i - 1] = 0.0
        # elimination without pivots: the matrix is positive definite where all of them are
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
        if not (longest < _LARGEST_STEP):
            return False
        headings -= slope
        if longest < 1e-12:
            return True
    return True


@compiled
def descend(
    legs: FloatArray, headings: FloatArray, free: BoolArray, width: float
) -> float:
    """Shorten a route in place, and return its length.

    Args:
        legs: from each point to the next, shape (n, 2).
        headings: at the points, shape (n + 1,); changed where `free`.
        width: distance of the first grid's headings (rad).
    """
    best = route_length(legs, headings)
    trial = headings.copy()
    tried = 0
    while width > _FINEST:
        if width < _ROUGH and tried < 3:
            tried += 1
            trial[:] = headings
            if _newton(legs, trial, free):
                length = route_length(legs, trial)
                if length <= best + 1e-14 * (1.0 + best):
                    if length < best:
                        best = length
                        headings[:] = trial
                    return best
        moves = 0
        while moves < 8 and _grid_step(legs, headings, free, width):
            moves += 1
        width *= 0.5
    return route_length(legs, headings)


@compiled
def route_words(legs: FloatArray, headings: FloatArray) -> tuple[WordArray, FloatArray]:
    """The word of each leg, shape (n,), and its segments, shape (n, 3)."""
    n = legs.shape[0]
    words, segments = np.empty(n, np.int8), np.empty((n, 3))
    for i in range(n):
        _, words[i], t, p, q = shortest_word(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
        segments[i, 0], segments[i, 1], segments[i, 2] = t, p, q
    return words, segments

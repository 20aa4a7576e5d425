"""A short route by local search: the upper bound of the certified search.

A dynamic program over a few headings a point, its grid made finer about the best ones, finds a
route; Newton's method on the tridiagonal Hessian ends it where no word changes. Everything is in
units of the turning radius.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dubins_study.study.closed_form import pose
from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.leg_bound import WordArray
from dubins_study.study.route.leg_words import (
    between,
    nearest_segments,
    shortest_word,
)

_gradient = separate(pose.pose_gradient)

_GRID = 13  # headings a point
_FINE, _FINEST = 1e-4, 1e-13  # rad, of grids
_NEAR = (0.4, 0.1, 0.01, 1e-3)  # radii; a straight below it may be one that vanishes
_SHORT = (0.0, 0.03, 0.3)  # rad; so may an arc
_LARGEST_STEP = 0.3  # rad, of Newton's method


@compiled
def leg_table(
    leg: FloatArray, first: FloatArray, last: FloatArray, live: BoolArray
) -> tuple[FloatArray, WordArray]:
    """Lengths and words of a leg for all live pairs of headings, of shape (first, last)."""
    lengths, words = np.full(live.shape, math.inf), np.zeros(live.shape, np.int8)
    for i in range(first.size):
        for j in range(last.size):
            if live[i, j]:
                lengths[i, j], words[i, j], _, _, _ = shortest_word(
                    leg[0], leg[1], first[i], last[j]
                )
    return lengths, words


@separate
def _grid_step(legs: FloatArray, headings: FloatArray, free: BoolArray, width: float) -> bool:
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


@compiled
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


@compiled
def newton(legs: FloatArray, headings: FloatArray, free: BoolArray) -> bool:
    """Newton's method from headings, in place; whether it came to rest at a local minimum."""
    n = legs.shape[0]
    slope, diagonal, beside = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    for _ in range(40):
        slope[:], diagonal[:], beside[:] = 0.0, 0.0, 0.0
        for i in range(n):
            _, word, t, p, q = shortest_word(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
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
        # a straight's free end is reached like a cubic's minimum: by halves
        if np.abs(slope).max() < 1e-13:
            return True
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
        headings -= slope * min(1.0, _LARGEST_STEP / max(longest, _LARGEST_STEP))
        if longest < 1e-12:
            return True
    return False


@compiled
def descend(
    legs: FloatArray, headings: FloatArray, free: BoolArray, width: float, finest: float
) -> None:
    """Shorten a route in place, on grids about its headings.

    Args:
        legs: from each point to the next, shape (n, 2).
        headings: at the points, shape (n + 1,); changed where `free`.
        width, finest: distance of the first and of the last grid's headings (rad).
    """
    while width > finest:
        moves = 0
        while moves < 8 and _grid_step(legs, headings, free, width):
            moves += 1
        width *= 0.5


@compiled
def route_words(legs: FloatArray, headings: FloatArray) -> tuple[WordArray, FloatArray]:
    """The word of each leg, shape (n,), and its segments, shape (n, 3)."""
    n = legs.shape[0]
    words, segments = np.empty(n, np.int8), np.empty((n, 3))
    for i in range(n):
        _, words[i], t, p, q = shortest_word(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
        segments[i, 0], segments[i, 1], segments[i, 2] = t, p, q
    return words, segments


@separate
def _touching(
    x: float, y: float, t1: float, t2: float, s: float
) -> tuple[float, float, float, float, float, float, float, float, float, float, float]:
    """Two arcs, the first one's turn s: derivatives of their length, and of |C2 - C1|^2 - 4.

    Of the length pi + 2 s chi - s (t1 + t2), chi the direction from centre to centre, as it goes on
    where they are not 2 apart: derivatives 1, 2, 11, 12, 22; then the condition's value and those.
    """
    dx, dy = between(x, y, s, -s, t1, t2)
    square = dx * dx + dy * dy
    # derivatives of (dx, dy) by t1 are s e(t1), by t2 s e(t2); second ones s n(t1), s n(t2)
    e1x, e1y, e2x, e2y = s * math.cos(t1), s * math.sin(t1), s * math.cos(t2), s * math.sin(t2)
    along1, along2 = dx * e1x + dy * e1y, dx * e2x + dy * e2y
    across1, across2 = dx * e1y - dy * e1x, dx * e2y - dy * e2x
    between_arcs = math.cos(t1 - t2)
    # the second derivative by t1 is (-e1y, e1x): its parts along and across are -across1, along1
    chi1, chi2 = across1 / square, across2 / square
    chi11 = (along1 - 2.0 * chi1 * along1) / square
    chi22 = (along2 - 2.0 * chi2 * along2) / square
    chi12 = -(chi1 * along2 + chi2 * along1) / square
    return (
        2.0 * s * chi1 - s,
        2.0 * s * chi2 - s,
        2.0 * s * chi11,
        2.0 * s * chi12,
        2.0 * s * chi22,
        square - 4.0,
        2.0 * along1,
        2.0 * along2,
        2.0 * (1.0 - across1),
        2.0 * between_arcs,
        2.0 * (1.0 - across2),
    )


@compiled
def leg_models(
    legs: FloatArray, headings: FloatArray, words: WordArray, edges: FloatArray
) -> FloatArray:
    """The eleven numbers of `_touching` for each leg; zeros for the condition where it has none."""
    models = np.zeros((words.size, 11))
    for i in range(words.size):
        x, y, t1, t2 = legs[i, 0], legs[i, 1], headings[i], headings[i + 1]
        if edges[i] != 0.0:
            models[i] = np.array(_touching(x, y, t1, t2, edges[i]))
        else:
            t, p, q = nearest_segments(x, y, t1, t2, words[i])
            models[i, 0], models[i, 1] = _gradient(words[i], t, p, q)
            models[i, 2], models[i, 3], models[i, 4] = _curvatures(words[i], t, p, q)
    return models


def settle(
    legs: FloatArray, headings: FloatArray, free: BoolArray, words: WordArray, edges: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """A stationary route whose legs at an edge stay there, by Newton's method; None if it fails.

    Args:
        free: headings that are varied; those of a leg that is one arc are not.
        edges: for each leg the first turn of the two arcs that it is to be, or 0.

    Returns the headings, and at each point the slope of the potential for which both legs are flat
    there: the derivative of the leg before it, with its condition's multiplier; NaN where unknown.
    """
    headings, n = headings.copy(), words.size
    at = np.flatnonzero(edges)
    size = n + 1 + at.size
    tau = np.zeros(n)
    moving = free[:-1] | free[1:]
    fixed, i, rows = np.flatnonzero(~free), np.arange(n), n + 1 + np.arange(at.size)
    idle = rows[~moving[at]]
    for _ in range(20):
        models = leg_models(legs, headings, words, edges)
        models[~moving] = 0.0  # nothing is asked of a leg between headings that are given
        if not np.isfinite(models).all():
            return None
        matrix, right = np.zeros((size, size)), np.zeros(size)
        hessian = models[:, 2:5] + tau[:, None] * models[:, 8:11]
        np.add.at(matrix, (i, i), hessian[:, 0])
        np.add.at(matrix, (i + 1, i + 1), hessian[:, 2])
        matrix[i, i + 1] = matrix[i + 1, i] = hessian[:, 1]
        np.add.at(right, i, models[:, 0])
        np.add.at(right, i + 1, models[:, 1])
        matrix[rows, at] = matrix[at, rows] = models[at, 6]
        matrix[rows, at + 1] = matrix[at + 1, rows] = models[at, 7]
        right[rows] = models[at, 5]
        for given in (fixed, idle):
            matrix[given], matrix[:, given], right[given] = 0.0, 0.0, 0.0
            matrix[given, given] = 1.0
        try:
            step = np.linalg.solve(matrix, right)
        except np.linalg.LinAlgError:
            return None
        tau[at] = -step[n + 1 :]
        longest = float(np.abs(step[: n + 1]).max())
        if not longest < 1.0:
            return None
        headings -= step[: n + 1] * min(1.0, 0.1 / max(longest, 1e-300))
        if longest < 1e-14:
            break
    slopes = np.full(n + 1, math.nan)
    slopes[:-1] = np.where(moving, -models[:, 0] - tau * models[:, 6], math.nan)
    behind = np.where(moving, models[:, 1] + tau * models[:, 7], math.nan)
    slopes[1:] = np.where(np.isnan(behind), slopes[1:], behind)
    return headings, slopes


def _edges(words: WordArray, segments: FloatArray, near: float) -> FloatArray:
    """For each leg that is nearly two arcs the turn of the first, else 0."""
    turn = np.where((words == 2) | (words == 5), 1.0, -1.0)
    first, middle, last = segments.T
    edges = np.where(((words == 2) | (words == 3)) & (middle < near), turn, 0.0)
    edges = np.where((words >= 4) & (first < near), -turn, edges)
    return np.where((words >= 4) & (last < near), turn, edges)


def _single_arcs(
    legs: FloatArray,
    headings: FloatArray,
    free: BoolArray,
    words: WordArray,
    segments: FloatArray,
    near: float,
    short: float,
) -> tuple[FloatArray, BoolArray]:
    """Headings with which legs that are nearly one arc are one, and which are free then.

    A straight below `near` and an arc below `short` are taken to vanish.
    """
    headings, free = headings.copy(), free.copy()
    for i, (word, (t, p, q)) in enumerate(zip(words, segments, strict=True)):
        distance = math.hypot(*legs[i])
        first = 1.0 if word in (0, 2, 5) else -1.0
        if word < 2 and p < near:
            s, arc = first, t + q
        elif word in (2, 3) and p < near and min(t, q) < short:
            s, arc = (first, t) if q < t else (-first, q)
        elif word >= 4 and t < short and q < short:
            s, arc = -first, p
        else:
            continue
        if distance > 2.0:
            continue
        half = math.asin(0.5 * distance)
        half = half if arc < math.pi else math.pi - half
        chord = math.atan2(legs[i, 1], legs[i, 0])
        for at, heading in ((i, chord - s * half), (i + 1, chord + s * half)):
            if free[at]:
                headings[at] = heading
                free[at] = False
    return headings, free


@compiled
def leg_slopes(legs: FloatArray, headings: FloatArray) -> FloatArray:
    """Derivatives of the leg before each point by the heading there; 0 at the first point."""
    slopes = np.zeros(headings.size)
    for i in range(legs.shape[0]):
        _, word, t, p, q = shortest_word(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
        _, slopes[i + 1] = _gradient(word, t, p, q)
    return slopes


@compiled
def route_nearly(legs: FloatArray, headings: FloatArray, words: WordArray) -> FloatArray:
    """Segments of words that exist or nearly do, shape (n, 3)."""
    segments = np.empty((words.size, 3))
    for i in range(words.size):
        segments[i] = np.array(
            nearest_segments(legs[i, 0], legs[i, 1], headings[i], headings[i + 1], words[i])
        )
    return segments


def descents(
    legs: FloatArray, headings: FloatArray, words: WordArray, free: BoolArray, width: float
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Routes downhill from one, each with the slopes of the potential at its points (NaN: unknown).

    Args:
        legs: from each point to the next, shape (n, 2).
        headings: at the points, shape (n + 1,); varied where `free`.
        words: of each leg, which need not quite exist.
        width: distance of the first grid's headings (rad).
    """
    smooth = headings.copy()
    if newton(legs, smooth, free):
        yield smooth, leg_slopes(legs, smooth)
        if (np.hypot(*legs.T) >= 4.0).all():  # nothing jumps: a grid finds nothing better
            return
    yield from _settled(legs, headings, free, words, route_nearly(legs, headings, words))
    unknown = np.full(headings.size, math.nan)
    headings = headings.copy()
    descend(legs, headings, free, width, _FINE)
    yield headings, unknown
    settled = list(_settled(legs, headings, free, *route_words(legs, headings)))
    yield from settled
    if not settled:
        descend(legs, headings, free, _FINE, _FINEST)
        yield headings, unknown


def _settled(
    legs: FloatArray,
    headings: FloatArray,
    free: BoolArray,
    words: WordArray,
    segments: FloatArray,
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """`settle` for every choice of segments that may be meant to vanish."""
    attempts: set[bytes] = set()
    for near in _NEAR:
        edges = _edges(words, segments, near)
        for short in _SHORT:
            start, moving = _single_arcs(legs, headings, free, words, segments, near, short)
            attempt = edges.tobytes() + moving.tobytes()
            if attempt not in attempts:
                attempts.add(attempt)
                result = settle(legs, start, moving, words, edges)
                if result is not None:
                    yield result

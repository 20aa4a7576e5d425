"""A short route by local search: the upper bound of the certified search.

A dynamic program over a few headings a point, of a grid and of edges where a leg loses a segment,
is done again and again on finer grids about the best ones. Newton's method on the tridiagonal
Hessian ends it where no word changes, or with multipliers on the edges where it rests. Everything
is in units of the turning radius.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.closed_form.pose import (
    pose_curvatures,
    pose_delta,
    pose_gradient,
    pose_shortest,
)
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.leg_bound import WordArray
from dubins_study.study.route.leg_words import between, nearest_segments, principal

_PI, _TWO_PI = math.pi, 2 * math.pi
_GRID, _MOST = 2, 24  # headings on each side of a point's; and at most in all, with edges
_ALL, _MOST_OF_ALL = 48, 112  # headings of the whole circle; and at most in all, with edges
_FINER = 0.5  # of one grid's width to the next
_REACH = 3.0  # grid widths; edges farther from a heading wait for a wider grid
_FINE, _FINEST = 1e-6, 1e-13  # rad, of grids
_NEAR = (1e-3, 0.1)  # radii; a straight below it may be one that vanishes
_SHORT = (1e-3, 0.1)  # rad; so may an arc
_LARGEST_STEP = 0.3  # rad, of Newton's method


@separate
def _shortest(x: float, y: float, a: float, b: float) -> tuple[float, int, float, float, float]:
    """Length, word and segments of a leg, whose data are rounded: on an edge it has both words."""
    size = abs(x) + abs(y)
    return pose_shortest(x, y, a, b, pose_delta(size, size))


@compiled
def leg_table(
    leg: FloatArray, first: FloatArray, last: FloatArray, live: BoolArray
) -> tuple[FloatArray, WordArray]:
    """Lengths and words of a leg for all live pairs of headings, of shape (first, last)."""
    lengths, words = np.full(live.shape, math.inf), np.zeros(live.shape, np.int8)
    for i in range(first.size):
        for j in range(last.size):
            if live[i, j]:
                lengths[i, j], words[i, j], _, _, _ = _shortest(leg[0], leg[1], first[i], last[j])
    return lengths, words


@separate
def _touching_headings(x: float, y: float, heading: float, back: bool, found: FloatArray) -> int:
    """Headings at the other end of a leg for which two arcs are a path of it; how many there are.

    Args:
        x, y: the leg's end, seen from its start.
        heading: at its start, or at its end if `back`.
        found: written, shape (4,).
    """
    if back:  # driven backwards the leg is one too
        x, y, heading = -x, -y, heading + _PI
    n = 0
    for turn in (1.0, -1.0):
        dx, dy = x + turn * math.sin(heading), y - turn * math.cos(heading)
        d = math.hypot(dx, dy)
        if not 1.0 <= d <= 3.0:
            continue
        way = math.atan2(dy, dx)
        off = math.acos(min(1.0, (3.0 - d * d) / (2.0 * d)))
        for side in (off, -off):  # from the end to the second circle's centre
            found[n] = way + side + turn * 0.5 * _PI + (_PI if back else 0.0)
            n += 1
    return n


@separate
def _arc_headings(x: float, y: float, end: bool, found: FloatArray) -> int:
    """Headings at one end of a leg, its start or its `end`, for which it is one arc."""
    d = math.hypot(x, y)
    if d > 2.0:
        return 0
    chord, short = math.atan2(y, x), math.asin(0.5 * d)
    for k in range(4):
        half = short if k < 2 else _PI - short
        found[k] = chord + (half if (k % 2 == 0) == end else -half)
    return 4


@separate
def _add(headings: FloatArray, n: int, others: FloatArray, m: int, reach: float) -> int:
    """Add those of m headings that are within reach of the first to the n that are there."""
    for k in range(m):
        off = principal(others[k] - headings[0])
        if n < headings.size and abs(off) <= reach:
            headings[n] = headings[0] + off
            n += 1
    return n


@separate
def _step(
    legs: FloatArray, headings: FloatArray, free: BoolArray, width: float, back: bool, wide: bool
) -> bool:
    """Move to the best chain of some headings a point; whether any has changed.

    They are those of a grid, and those of edges: where a leg is one arc, or two arcs from one of
    the headings at the point before (after it, if `back`), so that a chain of edges is followed.
    `wide` is about the whole circle: from given headings and single arcs alone.
    """
    grid, most, reach = _GRID, _MOST, _REACH * width
    if wide:
        grid, most, reach = _ALL // 2, _MOST_OF_ALL, _PI
    n = legs.shape[0]
    tried, sizes = np.empty((n + 1, most)), np.empty(n + 1, np.int64)
    found = np.empty(4)
    for place in range(n + 1):
        i = n - place if back else place
        some = tried[i]
        some[0], size = headings[i], 1
        if free[i]:
            for k in range(1, grid + 1):
                some[size], some[size + 1] = headings[i] + k * width, headings[i] - k * width
                size += 2
            for leg in range(max(i - 1, 0), min(i + 1, n)):
                m = _arc_headings(legs[leg, 0], legs[leg, 1], leg < i, found)
                size = _add(some, size, found, m, reach)
            if place > 0:
                leg, other = (i, i + 1) if back else (i - 1, i - 1)
                for k in range(1 + 2 * grid if wide and free[other] else 0, sizes[other]):
                    m = _touching_headings(legs[leg, 0], legs[leg, 1], tried[other, k], back, found)
                    size = _add(some, size, found, m, reach)
        sizes[i] = size
    cost, before = np.zeros(most), np.empty((n, most), np.int64)
    for i in range(n):
        following = np.full(most, math.inf)
        for k in range(sizes[i + 1]):
            for j in range(sizes[i]):
                length = _shortest(legs[i, 0], legs[i, 1], tried[i, j], tried[i + 1, k])[0]
                # where lengths are equal nothing moves, so that the search comes to rest
                total = cost[j] + length + (0.0 if j == 0 else 1e-14)
                if total < following[k]:
                    following[k], before[i, k] = total, j
        cost = following
    k, moved = 0, False
    for j in range(sizes[n]):
        if cost[j] < cost[k]:
            k = j
    for i in range(n, -1, -1):
        moved |= k != 0
        headings[i] = tried[i, k]
        if i > 0:
            k = before[i - 1, k]
    return moved


@compiled
def route_length(legs: FloatArray, headings: FloatArray) -> float:
    """The length of the route with these headings."""
    total = 0.0
    for i in range(legs.shape[0]):
        total += _shortest(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])[0]
    return total


@compiled
def newton(legs: FloatArray, headings: FloatArray, free: BoolArray) -> bool:
    """Newton's method from headings, in place; whether it came to rest at a local minimum."""
    n = legs.shape[0]
    slope, diagonal, beside = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    for _ in range(40):
        slope[:], diagonal[:], beside[:] = 0.0, 0.0, 0.0
        for i in range(n):
            _, word, t, p, q = _shortest(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
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
    """Shorten a route in place, on grids about its headings and along the edges near them.

    Args:
        legs: from each point to the next, shape (n, 2).
        headings: at the points, shape (n + 1,); changed where `free`.
        width, finest: distance of the first and of the last grid's headings (rad).
    """
    while width > finest:
        moves = 0
        while moves < 8 and (
            _step(legs, headings, free, width, False, False)
            | _step(legs, headings, free, width, True, False)
        ):
            moves += 1
        width *= _FINER


@compiled
def survey(legs: FloatArray, headings: FloatArray, free: BoolArray) -> None:
    """Set free headings to the best chain of a grid of the whole circle and of many edges."""
    for back in (False, True):
        _step(legs, headings, free, _TWO_PI / _ALL, back, True)


@compiled
def route_words(legs: FloatArray, headings: FloatArray) -> tuple[WordArray, FloatArray]:
    """The word of each leg, shape (n,), and its segments, shape (n, 3)."""
    n = legs.shape[0]
    words, segments = np.empty(n, np.int8), np.empty((n, 3))
    for i in range(n):
        _, words[i], t, p, q = _shortest(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
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
            models[i, 0], models[i, 1] = pose_gradient(words[i], t, p, q)
            models[i, 2], models[i, 3], models[i, 4] = pose_curvatures(words[i], t, p, q)
    return models


def settle(
    legs: FloatArray,
    headings: FloatArray,
    free: BoolArray,
    words: WordArray,
    edges: FloatArray,
    arcs: BoolArray,
) -> tuple[FloatArray, FloatArray] | None:
    """A stationary route whose legs at an edge stay there, by Newton's method; None if it fails.

    Args:
        free: headings that are varied; those of a leg that is one arc are not.
        edges: for each leg the first turn of the two arcs that it is to be, or 0.
        arcs: legs that are one arc, which fixes both their headings.

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
    known = ~arcs & (moving | (edges == 0.0))
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
    models = leg_models(legs, headings, words, edges)
    slopes = np.full(n + 1, math.nan)
    slopes[:-1] = np.where(known, -models[:, 0] - tau * models[:, 6], math.nan)
    behind = np.where(known, models[:, 1] + tau * models[:, 7], math.nan)
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
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Headings with which legs that are nearly one arc are one, which are free, and these legs.

    A straight below `near` and an arc below `short` are taken to vanish.
    """
    headings, free, arcs = headings.copy(), free.copy(), np.zeros(words.size, np.bool_)
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
        arcs[i] = True
        for at, heading in ((i, chord - s * half), (i + 1, chord + s * half)):
            if free[at]:
                headings[at] = heading
                free[at] = False
    return headings, free, arcs


@compiled
def leg_slopes(legs: FloatArray, headings: FloatArray) -> FloatArray:
    """Derivatives of the leg before each point by the heading there; 0 at the first point."""
    slopes = np.zeros(headings.size)
    for i in range(legs.shape[0]):
        _, word, t, p, q = _shortest(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
        _, slopes[i + 1] = pose_gradient(word, t, p, q)
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
    best, settled = route_length(legs, headings), math.inf
    for result in _settled(legs, headings, free, *route_words(legs, headings)):
        settled = min(settled, route_length(legs, result[0]))
        yield result
    if settled > best:
        descend(legs, headings, free, width, _FINEST)
        yield headings, unknown
        yield from _settled(legs, headings, free, *route_words(legs, headings))


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
            start, moving, arcs = _single_arcs(legs, headings, free, words, segments, near, short)
            attempt = edges.tobytes() + moving.tobytes()
            if attempt not in attempts:
                attempts.add(attempt)
                result = settle(legs, start, moving, words, edges, arcs)
                if result is not None:
                    yield result

"""A short route by local search: the upper bound of the certified search.

Newton's method on the tridiagonal Hessian where no word changes; grids of headings, and Newton's
method with multipliers on the edges where the route rests. Everything is in units of the turning
radius.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dubins_study.study.closed_form.kernel_compile import compiled
from dubins_study.study.closed_form.pose import pose_curvatures, pose_gradient
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.effort import Effort
from dubins_study.study.route.heading_grids import shorten, shortest_leg
from dubins_study.study.route.leg_bound import WordArray
from dubins_study.study.route.leg_words import nearest_segments
from dubins_study.study.route.settle import settled_routes

_FINE, _FINEST = 1e-6, 1e-13  # rad, of grids
_LARGEST_STEP = 0.3  # rad, of Newton's method


@compiled
def route_length(legs: FloatArray, headings: FloatArray) -> float:
    """The length of the route with these headings."""
    total = 0.0
    for i in range(legs.shape[0]):
        total += shortest_leg(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])[0]
    return total


@compiled
def route_words(legs: FloatArray, headings: FloatArray) -> tuple[WordArray, FloatArray]:
    """The word of each leg, shape (n,), and its segments, shape (n, 3)."""
    n = legs.shape[0]
    words, segments = np.empty(n, np.int8), np.empty((n, 3))
    for i in range(n):
        _, words[i], t, p, q = shortest_leg(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
        segments[i, 0], segments[i, 1], segments[i, 2] = t, p, q
    return words, segments


@compiled
def route_nearly(legs: FloatArray, headings: FloatArray, words: WordArray) -> FloatArray:
    """Segments of words that exist or nearly do, shape (n, 3)."""
    segments = np.empty((words.size, 3))
    for i in range(words.size):
        segments[i] = np.array(
            nearest_segments(legs[i, 0], legs[i, 1], headings[i], headings[i + 1], words[i])
        )
    return segments


@compiled
def leg_slopes(legs: FloatArray, headings: FloatArray) -> FloatArray:
    """Derivatives of the leg before each point by the heading there; 0 at the first point."""
    slopes = np.zeros(headings.size)
    for i in range(legs.shape[0]):
        _, word, t, p, q = shortest_leg(legs[i, 0], legs[i, 1], headings[i], headings[i + 1])
        _, slopes[i + 1] = pose_gradient(word, t, p, q)
    return slopes


@compiled
def newton(legs: FloatArray, headings: FloatArray, free: BoolArray) -> bool:
    """Newton's method from headings, in place; whether it came to rest at a local minimum."""
    n = legs.shape[0]
    slope, diagonal, beside = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    for _ in range(40):
        slope[:], diagonal[:], beside[:] = 0.0, 0.0, 0.0
        for i in range(n):
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


def descents(
    legs: FloatArray,
    headings: FloatArray,
    words: WordArray,
    free: BoolArray,
    width: float,
    effort: Effort,
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Routes downhill from one, each with the slopes of the potential at its points (NaN: unknown).

    Args:
        legs: from each point to the next, shape (n, 2).
        headings: at the points, shape (n + 1,); varied where `free`.
        words: of each leg, which need not quite exist.
        width: distance of the first grid's headings (rad).
        effort: where that is spent, the last route is the best one until then.
    """
    smooth = headings.copy()
    if newton(legs, smooth, free):
        yield smooth, leg_slopes(legs, smooth)
        if (np.hypot(*legs.T) >= 4.0).all():  # nothing jumps: a grid finds nothing better
            return
    yield from settled_routes(
        legs, headings, free, words, route_nearly(legs, headings, words), effort
    )
    unknown = np.full(headings.size, math.nan)
    headings = headings.copy()
    shorten(legs, headings, free, (width, _FINE), effort)
    yield headings, unknown
    best, settled = route_length(legs, headings), math.inf
    words, segments = route_words(legs, headings)
    for result in settled_routes(legs, headings, free, words, segments, effort):
        settled = min(settled, route_length(legs, result[0]))
        yield result
    if settled > best:
        shorten(legs, headings, free, (width, _FINEST), effort)
        yield headings, unknown
        words, segments = route_words(legs, headings)
        yield from settled_routes(legs, headings, free, words, segments, effort)

"""Newton's method for a route that rests on edges: legs of two arcs that touch, or of one arc.

Everything is in units of the turning radius.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.closed_form.pose import pose_curvatures, pose_gradient
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.effort import Effort
from dubins_study.study.route.leg_bound import WordArray
from dubins_study.study.route.leg_words import between, nearest_segments

_PI = math.pi
_NEAR = (1e-3, 0.1)  # radii; a straight below it may be one that vanishes
_SHORT = (1e-3, 0.1)  # rad; so may an arc
_SETTLE_BOXES = 8  # a leg: how many bounds take as long as Newton's method


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


def settled_routes(
    legs: FloatArray,
    headings: FloatArray,
    free: BoolArray,
    words: WordArray,
    segments: FloatArray,
    effort: Effort,
) -> Iterator[tuple[FloatArray, FloatArray]]:
    """`settle` for every choice of segments that may be meant to vanish."""
    attempts: set[bytes] = set()
    for near in _NEAR:
        edges = _edges(words, segments, near)
        for short in _SHORT:
            start, moving, arcs = _single_arcs(legs, headings, free, words, segments, near, short)
            attempt = edges.tobytes() + moving.tobytes()
            if attempt not in attempts and not effort.spend(_SETTLE_BOXES * words.size):
                attempts.add(attempt)
                result = settle(legs, start, moving, words, edges, arcs)
                if result is not None:
                    yield result

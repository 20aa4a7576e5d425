"""Compiled leg lengths, and dynamic programs over headings.

The six words of a leg are found by circles and tangents.

No formula is shared with the package. Radius 1; headings in rad.
"""

import math
from typing import Any

import numba
import numpy as np

Array = Any  # numpy arrays, in compiled code
_TWO_PI = 2 * math.pi
_ROUNDS = 300  # of a descent, which may creep along an edge for ever; a few dozen are usual


@numba.njit(cache=True)
def _turned(angle: float, gap: float) -> float:
    """Angle of an arc in [0, 2 pi).

    An arc that lacks less than `gap` of a full turn is none.
    """
    angle -= _TWO_PI * math.floor(angle / _TWO_PI)
    return angle if angle < _TWO_PI - gap else 0.0


@numba.njit(cache=True)
def _leg(x: float, y: float, a: float, b: float, rates: Array, gap: float) -> float:
    """`leg_length` for sines and cosines that are known."""
    least = math.inf
    sin_a, cos_a, sin_b, cos_b = rates
    for s in (1.0, -1.0):
        for t in (s, -s):
            dx, dy = x - t * sin_b + s * sin_a, y + t * cos_b - s * cos_a
            apart = math.hypot(dx, dy)
            off = straight = math.inf
            if t == s:
                straight = apart
                if apart <= 4.0 + 0.01 * gap:
                    off = math.acos(min(1.0, apart / 4.0))
            elif apart >= 2.0 - 0.01 * gap:
                straight = math.sqrt(max(0.0, (apart - 2.0) * (apart + 2.0)))
            middle = math.pi + 2.0 * off  # of s -s s
            if straight >= least and middle >= least:
                continue
            way = math.atan2(dy, dx)
            if middle < least:
                after = way + s * (off + math.pi / 2)  # heading where the middle arc begins
                before = way + s * (1.5 * math.pi - off)  # and where it ends
                arcs = _turned(s * (after - a), gap) + _turned(s * (b - before), gap)
                least = min(least, arcs + middle)
            if straight < least:
                if t != s:
                    way += s * math.atan2(2.0, straight)
                arcs = _turned(s * (way - a), gap) + _turned(t * (b - way), gap)
                least = min(least, straight + arcs)
    return least


@numba.njit(cache=True)
def leg_length(x: float, y: float, a: float, b: float, gap: float) -> float:
    """Shortest path from the origin to (x, y).

    It starts with heading a and ends with heading b.

    An arc that lacks less than `gap` (rad) of a full turn counts as none. Circles that miss each
    other by less than a hundredth of it count as touching. Rounding may hide either.
    """
    return _leg(x, y, a, b, (math.sin(a), math.cos(a), math.sin(b), math.cos(b)), gap)


@numba.njit(cache=True)
def _arrivals(x: float, y: float, a: float, headings: Array) -> int:
    """Headings of arrival at (x, y) with fewer arcs.

    The last arc is missing, or the last but one.
    """
    n = 0
    for s in (1.0, -1.0):
        dx, dy = x + s * math.sin(a), y - s * math.cos(a)
        apart = math.hypot(dx, dy)
        way = math.atan2(dy, dx)
        if apart >= 1.0:
            headings[n] = way + s * math.atan2(1.0, math.sqrt((apart - 1.0) * (apart + 1.0)))
            n += 1
        if 1.0 <= apart <= 3.0:
            off = math.acos(min(1.0, (apart * apart + 3.0) / (4.0 * apart)))
            for side in (off, -off):
                u = dx - 2.0 * math.cos(way + side)
                v = dy - 2.0 * math.sin(way + side)
                headings[n] = math.atan2(v, u) - s * math.pi / 2
                n += 1
    return n


@numba.njit(cache=True)
def route_length(legs: Array, headings: Array) -> float:
    total = 0.0
    for i in range(len(legs)):
        total += leg_length(legs[i, 0], legs[i, 1], headings[i], headings[i + 1], 0.0)
    return total


@numba.njit(cache=True)
def length_table(x: float, y: float, a: Array, b: Array) -> Array:
    """Leg lengths from each a to each b."""
    table = np.empty((a.size, b.size))
    sin_b, cos_b = np.sin(b), np.cos(b)
    for i in range(a.size):
        sin_a, cos_a = math.sin(a[i]), math.cos(a[i])
        for j in range(b.size):
            table[i, j] = _leg(x, y, a[i], b[j], (sin_a, cos_a, sin_b[j], cos_b[j]), 0.0)
    return table


@numba.njit(cache=True)
def downhill(
    legs: Array, headings: Array, free: Array, rng: np.random.Generator, steps: Array
) -> float:
    """Improve the headings in place, downhill.

    Steps go along each heading, at random, and along the edges where legs jump.

    The least length often lies on an edge, where an arc of a leg has no length. A point moves along
    it if its neighbour's heading is changed and its own is then that of an arrival without an arc.
    """
    n = len(headings)
    best = route_length(legs, headings)
    trial = headings.copy()
    arrivals = np.empty(6)
    step, least = steps
    for _ in range(_ROUNDS):
        before = best
        for move in range(4 * n):
            trial[:] = headings
            i = move % n
            if move < 2 * n:
                trial[i] += step if move < n else -step
            else:
                for j in range(n):
                    trial[j] += step * rng.uniform(-1.0, 1.0)
            trial[:] = np.where(free, trial, headings)
            length = route_length(legs, trial)
            if length < best:
                best = length
                headings[:] = trial
                continue
            way = 1 if rng.random() < 0.5 else -1  # a neighbour follows, forwards or backwards
            j = i + way
            if not 0 <= j < n or not free[j]:
                continue
            leg = min(i, j)
            back = 0.0 if way == 1 else math.pi
            x, y = way * legs[leg, 0], way * legs[leg, 1]
            for k in range(_arrivals(x, y, trial[i] + back, arrivals)):
                trial[j] = arrivals[k] + back
                length = route_length(legs, trial)
                if length < best:
                    best = length
                    headings[:] = trial
        if best >= before * (1.0 - 1e-15):
            step *= 0.4
            if step < least:
                break
    return best

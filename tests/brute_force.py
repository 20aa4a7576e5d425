"""The shortest path to a point by search: every word driven, and its free angle bisected.

No formula is shared with the package: a word is a family of paths with one free angle, the others
are met by driving it, and the zeros of what is left over are searched on a grid and bisected.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
_GRID = np.linspace(0.0, 2 * math.pi, 4001)


def shortest_by_search(X: float, Y: float) -> float:
    """Length (radii) of the shortest path from the origin, heading along +x, to (X, Y)."""
    lengths = [_ending_straight(X, y) for y in (Y, -Y)] + [_two_arcs(X, y) for y in (Y, -Y)]
    return min(lengths)


def _ending_straight(X: float, Y: float) -> float:
    """LS: the least over the arcs after which the target lies straight ahead."""

    def off(a: Array) -> Array:
        x, y = np.sin(a), 1 - np.cos(a)
        return np.cos(a) * (Y - y) - np.sin(a) * (X - x)

    best = math.inf
    for a in _zeros(off):
        ahead = math.cos(a) * (X - math.sin(a)) + math.sin(a) * (Y - 1 + math.cos(a))
        if ahead >= 0:
            best = min(best, a + ahead)
    return best


def _two_arcs(X: float, Y: float) -> float:
    """LR: the least over the first arcs after which the target lies on the second circle."""

    def off(a: Array) -> Array:
        return np.hypot(X - 2 * np.sin(a), Y - 1 + 2 * np.cos(a)) - 1

    best = math.inf
    for a in _zeros(off):
        x, y = 2 * math.sin(a), 1 - 2 * math.cos(a)  # centre of the second circle
        begin = math.atan2(math.cos(a), -math.sin(a))
        end = math.atan2(Y - y, X - x)
        best = min(best, a + (begin - end) % (2 * math.pi))
    return best


def _zeros(function: Callable[[Array], Array]) -> list[float]:
    """Where a function of an angle in [0, 2 pi] changes its sign, bisected."""
    values = function(_GRID)
    at = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    low, high = _GRID[at].copy(), _GRID[at + 1].copy()
    below = np.sign(values[at])
    for _ in range(60):
        middle = (low + high) / 2
        same = np.sign(function(middle)) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return ((low + high) / 2).tolist()

"""Dynamic programs over a few headings a point, of a grid and of edges where a leg loses a segment.

Done again and again, on finer grids about the best headings, they shorten a route. Everything is
in units of the turning radius.
"""

from __future__ import annotations

import math

import numpy as np

from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.closed_form.pose import pose_delta, pose_shortest
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.effort import Effort
from dubins_study.study.route.leg_bound import WordArray
from dubins_study.study.route.leg_words import principal

_PI, _TWO_PI = math.pi, 2 * math.pi
_GRID, _MOST = 2, 24  # headings on each side of a point's; and at most in all, with edges
_ALL, _MOST_OF_ALL = 48, 112  # headings of the whole circle; and at most in all, with edges
_FINER = 0.5  # of one grid's width to the next
_REACH = 20.0  # grid widths; edges farther from a heading wait for a wider grid
_STEP_BOXES, _SURVEY_BOXES = 3, 400  # a leg: how many bounds take as long as a step of the search


@separate
def shortest_leg(x: float, y: float, a: float, b: float) -> tuple[float, int, float, float, float]:
    """Length, word and segments of a leg, whose data are rounded: on an edge it has both words."""
    size = abs(x) + abs(y)
    return pose_shortest(x, y, a, b, pose_delta(size, size))


@compiled
def leg_table(
    leg: FloatArray, first: FloatArray, last: FloatArray, live: WordArray
) -> tuple[FloatArray, WordArray]:
    """Lengths and words of a leg for all live pairs of headings, of shape (first, last)."""
    lengths, words = np.full(live.shape, math.inf), np.zeros(live.shape, np.int8)
    for i in range(first.size):
        for j in range(last.size):
            if live[i, j]:
                lengths[i, j], words[i, j], _, _, _ = shortest_leg(
                    leg[0], leg[1], first[i], last[j]
                )
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


@compiled
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
                length = shortest_leg(legs[i, 0], legs[i, 1], tried[i, j], tried[i + 1, k])[0]
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


def shorten(
    legs: FloatArray,
    headings: FloatArray,
    free: BoolArray,
    widths: tuple[float, float],
    effort: Effort,
) -> None:
    """Shorten a route in place, on grids about its headings and along the edges near them.

    The distance of the headings of a grid goes from the first to the second of `widths` (rad).
    """
    width, finest = widths
    while width > finest:
        for _ in range(8):
            if effort.spend(2 * _STEP_BOXES * len(legs)):
                return
            moved = _step(legs, headings, free, width, False, False)
            if not _step(legs, headings, free, width, True, False) | moved:
                break
        width *= _FINER


def survey(legs: FloatArray, headings: FloatArray, free: BoolArray, effort: Effort) -> None:
    """Set free headings to the best chain of a grid of the whole circle and of many edges."""
    for back in (False, True):
        if not effort.spend(_SURVEY_BOXES * len(legs)):
            _step(legs, headings, free, _TWO_PI / _ALL, back, True)

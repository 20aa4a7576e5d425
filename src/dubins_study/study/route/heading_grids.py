"""Shorten a route by dynamic programs over headings.

Each point has a few headings: those of a grid, and those of edges, where a leg loses a segment. The
programs are repeated on finer grids about the best headings. A program that runs out of time moves
the headings up to the leg that it has reached. Everything is in units of the turning radius.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import BoolArray, FloatArray, IntArray
from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.closed_form.pose import pose_delta, pose_shortest
from dubins_study.study.route.effort import Effort
from dubins_study.study.route.leg_bound import WordArray
from dubins_study.study.route.leg_words import principal

_PI = math.pi
_ALL = 48  # headings of the whole circle
_FINER = 0.5  # of one grid's width to the next
_MOST_ROUNDS = 8  # on one grid; a round is a step forward and one back
_STEP_BOXES = 3  # boxes a leg that take as long as a step
_SURVEY_BOXES = 400  # boxes a leg that take as long as a survey
_UNEQUAL = 0.1  # radii; if the costs of a point's headings differ by less, none is skipped
_PAIRS_AT_ONCE = 100_000  # a few hundredths of a second between looks at the clock
_CHAIN_NONE, _CHAIN_ARCS, _CHAIN_ALL = range(3)  # headings from which pairs of arcs are followed


class Grid(NamedTuple):
    """Headings that a dynamic program has at each point.

    Args:
        side: on each side of the point's own heading.
        most: in all, with those of edges.
        reach: grid widths; edges farther from the point's own heading wait for a wider grid.
        chained: the headings at the point before from which two arcs are followed: none, given
            ones and those of single arcs, or all.
    """

    side: int
    most: int
    reach: float
    chained: int


_FINE_GRID = Grid(side=2, most=24, reach=20.0, chained=_CHAIN_ALL)
_WIDE_GRID = Grid(side=_ALL // 2, most=112, reach=math.inf, chained=_CHAIN_ARCS)
_COARSE_GRID = Grid(side=6, most=21, reach=math.inf, chained=_CHAIN_NONE)


@separate
def shortest_leg(x: float, y: float, a: float, b: float) -> tuple[float, int, float, float, float]:
    """Length, word and segments of a leg.

    Its data count as rounded, so that on an edge both words exist.
    """
    size = abs(x) + abs(y)
    return pose_shortest(x, y, a, b, pose_delta(size, size))


@compiled
def leg_table(
    leg: FloatArray, first: FloatArray, last: FloatArray, live: WordArray
) -> tuple[FloatArray, WordArray]:
    """Lengths and words for all live pairs of headings.

    Both have the shape (headings at the start, headings at the end). The length of any other pair
    is infinite.
    """
    lengths = np.full(live.shape, math.inf)
    words = np.zeros(live.shape, np.int8)
    for i in range(first.size):
        for j in range(last.size):
            if live[i, j]:
                lengths[i, j], words[i, j], _, _, _ = shortest_leg(
                    leg[0], leg[1], first[i], last[j]
                )
    return lengths, words


@separate
def _touching_headings(x: float, y: float, heading: float, back: bool, found: FloatArray) -> int:
    """Write headings for which two arcs are the leg.

    They are those at the leg's other end. Returns how many there are.

    Args:
        x, y: the leg's end, seen from its start.
        heading: at its start, or at its end if `back`.
        found: written, shape (4,).
    """
    if back:  # a leg driven backwards is a leg too
        x = -x
        y = -y
        heading = heading + _PI
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
    """Write headings for which one arc is the leg.

    They are those at the leg's start, or at its end if `end`: up to four, written into `found`.
    Returns how many there are.
    """
    d = math.hypot(x, y)
    if d > 2.0:
        return 0
    chord = math.atan2(y, x)
    short = math.asin(0.5 * d)
    for k in range(4):
        half = short if k < 2 else _PI - short
        found[k] = chord + (half if (k % 2 == 0) == end else -half)
    return 4


@separate
def _add(headings: FloatArray, n: int, others: FloatArray, m: int, reach: float) -> int:
    """Add the headings that are within reach.

    `headings` holds n headings, and `others` m. Those of `others` that are within `reach` (rad) of
    the first of `headings` are added there. Returns the new number of headings.
    """
    for k in range(m):
        off = principal(others[k] - headings[0])
        if n < headings.size and abs(off) <= reach:
            headings[n] = headings[0] + off
            n += 1
    return n


@compiled
def _candidates(
    legs: FloatArray, headings: FloatArray, free: BoolArray, width: float, back: bool, grid: Grid
) -> tuple[FloatArray, IntArray]:
    """Headings at each point for a dynamic program.

    Returns the headings, a row for each point, and how many each row holds. They are those of a
    grid and those of edges. On an edge a leg is one arc, or two arcs from one of the headings at
    the point before (after it, if `back`), so that a chain of edges is followed.
    """
    n = legs.shape[0]
    reach = grid.reach * width
    candidates = np.empty((n + 1, grid.most))
    sizes = np.empty(n + 1, np.int64)
    edges = np.empty(4)
    for place in range(n + 1):
        i = n - place if back else place
        some = candidates[i]
        some[0] = headings[i]
        size = 1
        if free[i]:
            for k in range(1, grid.side + 1):
                some[size] = headings[i] + k * width
                some[size + 1] = headings[i] - k * width
                size += 2
            for leg in range(max(i - 1, 0), min(i + 1, n)):
                m = _arc_headings(legs[leg, 0], legs[leg, 1], leg < i, edges)
                size = _add(some, size, edges, m, reach)
            if place > 0 and grid.chained != _CHAIN_NONE:
                leg, other = (i, i + 1) if back else (i - 1, i - 1)
                # headings of edges come behind those of the grid
                arcs_alone = grid.chained == _CHAIN_ARCS and free[other]
                for k in range(1 + 2 * grid.side if arcs_alone else 0, sizes[other]):
                    m = _touching_headings(
                        legs[leg, 0], legs[leg, 1], candidates[other, k], back, edges
                    )
                    size = _add(some, size, edges, m, reach)
        sizes[i] = size
    return candidates, sizes


@compiled
def _chained(
    legs: FloatArray, candidates: FloatArray, sizes: IntArray, cost: FloatArray, before: IntArray
) -> FloatArray:
    """Least cost of chains extended over some legs.

    `cost` is that of the chains up to the first leg. `before` is filled: for each leg, the heading
    before each heading. A heading is skipped if even a straight leg from it is longer than the
    chain of the cheapest heading.
    """
    for i in range(legs.shape[0]):
        x, y = legs[i, 0], legs[i, 1]
        straight = math.hypot(x, y) * (1.0 - 1e-12) - 1e-9
        cheapest = np.argmin(cost[: sizes[i]])
        unequal = cost[: sizes[i]].max() - cost[cheapest] > _UNEQUAL
        following = np.full(cost.size, math.inf)
        enough = math.inf
        for k in range(sizes[i + 1]):
            if unequal:
                enough = (
                    cost[cheapest]
                    + shortest_leg(x, y, candidates[i, cheapest], candidates[i + 1, k])[0]
                )
            for j in range(sizes[i]):
                if cost[j] + straight > enough:
                    continue
                length = shortest_leg(x, y, candidates[i, j], candidates[i + 1, k])[0]
                # where lengths are equal nothing moves, so that the search comes to rest
                total = cost[j] + length + (0.0 if j == 0 else 1e-14)
                if total < following[k]:
                    following[k] = total
                    before[i, k] = j
        cost = following
    return cost


def _step(
    legs: FloatArray,
    headings: FloatArray,
    free: BoolArray,
    width: float,
    *,
    back: bool,
    grid: Grid,
    effort: Effort,
) -> bool:
    """Move a route to the best chain, in place.

    Returns whether any heading has changed. Out of time, the headings behind the last leg that was
    reached stay as they are.
    """
    n = len(legs)
    candidates, sizes = _candidates(legs, headings, free, width, back, grid)
    cost = np.zeros(grid.most)
    before = np.empty((n, grid.most), np.int64)
    legs_at_once = 1 + _PAIRS_AT_ONCE // grid.most**2
    legs_done = 0
    while legs_done < n and not effort.late:
        end = min(legs_done + legs_at_once, n)
        part = slice(legs_done, end)
        points = slice(legs_done, end + 1)
        cost = _chained(legs[part], candidates[points], sizes[points], cost, before[part])
        legs_done = end
    k = 0
    if legs_done == n:
        k = int(np.argmin(cost[: sizes[n]]))
    moved = False
    for i in range(legs_done, -1, -1):
        moved |= k != 0
        headings[i] = candidates[i, k]
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
    """Shorten a route in place, on finer grids.

    Grids lie about the headings, with the edges near them.

    Args:
        legs: steps between points, shape (n, 2).
        headings: at the n + 1 points (rad), changed in place.
        free: which of them may move, shape (n + 1,).
        widths: the distance (rad) of the headings on the first grid, and the distance that is too
            fine for a grid.
    """
    width, finest = widths
    while width > finest:
        for _ in range(_MOST_ROUNDS):
            if effort.spend(2 * _STEP_BOXES * len(legs)):
                return
            moved = False
            # chains of edges are followed one way at a time: from the start, then from the end
            for back in (False, True):
                moved |= _step(
                    legs, headings, free, width, back=back, grid=_FINE_GRID, effort=effort
                )
            if not moved:
                break
        width *= _FINER


def survey(legs: FloatArray, headings: FloatArray, free: BoolArray, effort: Effort) -> None:
    """Set free headings to the best wide chain.

    The chain is the best on a grid of the whole circle and on many edges.
    """
    for back in (False, True):
        if not effort.spend(_SURVEY_BOXES * len(legs)):
            width = TWO_PI / _ALL
            _step(legs, headings, free, width, back=back, grid=_WIDE_GRID, effort=effort)


def first_route(legs: FloatArray, given: Sequence[float | None], effort: Effort) -> FloatArray:
    """Headings of a good first route.

    The time is linear in the number of points. The choices are headings that bisect the chords of
    their neighbours, those of a coarse grid, and those of single arcs to a neighbour; the best
    chain of them is taken. Where points are dense, a heading that is off costs a full turn at each
    of them.

    Args:
        legs: from each point to the next, shape (n, 2).
        given: headings at the points (rad); None where free.
    """
    chord = np.arctan2(legs[:, 1], legs[:, 0])
    turn = np.remainder(np.diff(chord) + _PI, TWO_PI) - _PI
    inner = chord[:-1] + 0.5 * turn
    bisecting = np.concatenate((chord[:1], inner, chord[-1:]))
    free = np.array([heading is None for heading in given])
    headings = np.where(free, bisecting, np.array(given, np.float64))
    width = TWO_PI / (2 * _COARSE_GRID.side + 1)
    _step(legs, headings, free, width, back=False, grid=_COARSE_GRID, effort=effort)
    return headings

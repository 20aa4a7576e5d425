"""The shortest route through points in a given order, with a proof.

Everything is in units of the turning radius, headings in radians. The heading at each point lies in
one of some intervals and may jump inside it: the least sum of the legs' bounds
(`study.route.leg_bound`) over all chains of intervals, by a dynamic program, is a lower bound of the
route. Intervals and pairs of them that no route as short as the best one known can pass are left
out; the others are split until the bound meets that route's length (docs/derivation.md, section 15).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.closed_form.pose import WORDS6
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.descent import (
    descend,
    leg_slopes,
    leg_table,
    length_of,
    newton,
    route_words,
    settle,
    single_arcs,
)
from dubins_study.study.route.leg_bound import (
    BY_WORD,
    UNKNOWN,
    WordArray,
    bound_leg,
    halving_gains,
    slopes_across,
)

_TWO_PI = 2 * math.pi
_COARSE = 16  # headings a point of the first dynamic program
_NARROWEST = 1e-14  # rad; half the width of an interval that is not split any more
_MOST_PAIRS = 40_000_000


class Route(NamedTuple):
    """The best route found, and a proven interval around the shortest length of all."""

    headings: FloatArray  # shape (n + 1,), rad
    words: tuple[str, ...]  # of `pose.WORDS6`, one a leg
    segments: FloatArray  # shape (n, 3), radii
    length: float
    low: float
    high: float
    closed: bool  # whether low and high are within the tolerance
    rounds: int
    boxes: int  # pairs of intervals that a bound was computed for
    seconds: float


class _Intervals(NamedTuple):
    """The intervals of headings at a point: middles, halves of widths, slopes of the potential."""

    middle: FloatArray
    half: FloatArray
    slope: FloatArray


def search(
    points: ArrayLike,
    first: float | None,
    last: float | None = None,
    *,
    limit: float,
    tolerance: float = 1e-12,
) -> Route:
    """The shortest route through the points, or the interval that its length is proven to lie in.

    Args:
        points: shape (n + 1, 2), in radii, neighbours apart.
        first, last: headings at both ends (rad); None if free.
        limit: seconds.
        tolerance: of the interval's width, relative to the length.
    """
    return _Search(np.asarray(points, np.float64), first, last, limit, tolerance).run()


class _Search:
    def __init__(
        self,
        points: FloatArray,
        first: float | None,
        last: float | None,
        limit: float,
        tolerance: float,
    ) -> None:
        self.began, self.limit, self.tolerance = perf_counter(), limit, tolerance
        self.n = len(points) - 1
        self.legs = np.ascontiguousarray(np.diff(points, axis=0))
        self.far = bool((np.hypot(*self.legs.T) >= 4.0).all())
        given = [first, *[None] * (self.n - 1), last]
        self.free = np.array([heading is None for heading in given])
        width = _TWO_PI / _COARSE
        grid = -math.pi + width * (np.arange(_COARSE) + 0.5)
        self.intervals = [_start(heading, grid, 0.5 * width + 1e-14) for heading in given]
        self.live = [
            np.ones((a.middle.size, b.middle.size), np.bool_)
            for a, b in zip(self.intervals, self.intervals[1:], strict=False)
        ]
        self.length, self.headings = math.inf, np.zeros(self.n + 1)
        self.low, self.discarded = 0.0, math.inf
        self.boxes = self.rounds = 0
        self.tried: set[tuple[int, ...]] = set()

    def run(self) -> Route:
        tables = [
            leg_table(x, y, a.middle, b.middle)
            for (x, y), a, b in zip(self.legs, self.intervals, self.intervals[1:], strict=False)
        ]
        lengths, words = [table[0] for table in tables], [table[1] for table in tables]
        self._improve(lengths, words, _TWO_PI / _COARSE / 4)
        self._aim(lengths, words, _sums(lengths))
        while self._bound():
            self.rounds += 1
            ahead, behind = self.sums = _sums(self.bounds)
            least = ahead[-1].min() * (1.0 - (self.n + 2) * EPS)
            self.low = max(self.low, min(least, self.discarded, self.high))
            if self.low >= self.high * (1.0 - self.tolerance):
                break
            self._improve(
                self.bounds,
                self.words,
                0.2 * max(interval.half.max() for interval in self.intervals),
            )
            if self.low >= self.high * (1.0 - self.tolerance) or not self._split():
                break
        return self._route()

    @property
    def high(self) -> float:
        """More than the best route's length, whatever the rounding."""
        return self.length * (1.0 + (self.n + 8) * EPS) + 64.0 * self.n * EPS

    def _bound(self) -> bool:
        """Bounds of all pairs of intervals; False where the time is over."""
        self.bounds, self.words = [], []
        for i, (x, y) in enumerate(self.legs):
            if perf_counter() - self.began > self.limit:
                return False
            live = self.live[i]
            bounds, words = np.empty(live.shape), np.empty(live.shape, np.int8)
            bound_leg(x, y, self.intervals[i], self.intervals[i + 1], live, bounds, words)
            self.bounds.append(bounds)
            self.words.append(words)
            self.boxes += int(live.sum())
        return True

    def _improve(self, costs: list[FloatArray], words: list[WordArray], width: float) -> None:
        """Go downhill from the middles of the intervals on the cheapest chain."""
        ahead = _sums(costs)[0]
        headings, j = np.empty(self.n + 1), int(np.argmin(ahead[-1]))
        route = []
        for i in range(self.n, -1, -1):
            headings[i] = self.intervals[i].middle[j]
            if i:
                k = int(np.argmin(ahead[i - 1] + costs[i - 1][:, j]))
                route.append(int(words[i - 1][k, j]))
                j = k
        if tuple(route) in self.tried:
            return
        self.tried.add(tuple(route))
        trial = headings.copy()
        if newton(self.legs, trial, self.free):
            self._take(trial, leg_slopes(self.legs, trial))
            if self.far:  # no jumps: a finer grid finds nothing better
                return
        descend(self.legs, headings, self.free, width, 1e-4)
        self._take(headings)
        before, attempts = self.length, set()
        for near in (0.1, 0.01, 1e-3):
            found, segments = route_words(self.legs, headings)
            edges = _edges(found, segments, near)
            for short in (0.0, 0.03, 0.3):
                start, free = single_arcs(
                    self.legs, headings, self.free, found, segments, near, short
                )
                attempt = (edges.tobytes(), free.tobytes())
                if attempt in attempts:
                    continue
                attempts.add(attempt)
                settled = settle(self.legs, start, free, found, edges)
                if settled is not None:
                    self._take(*settled)
        if self.length == before:
            descend(self.legs, headings, self.free, 1e-4, 1e-13)
            self._take(headings)

    def _take(self, headings: FloatArray, slopes: FloatArray | None = None) -> None:
        """Keep a route if it is the shortest yet, and its slopes of the potential."""
        length = length_of(self.legs, headings)
        if length < self.length:
            self.length, self.headings = length, headings.copy()
            self.slopes = np.full(self.n + 1, math.nan) if slopes is None else slopes

    def _split(self) -> bool:
        """Leave out what no shorter route can pass, and split what is left."""
        ahead, behind = self.sums
        threshold = self.high * (1.0 - 0.5 * self.tolerance)
        self.discarded = min(self.discarded, threshold)
        margin = 1.0 - (2 * self.n + 4) * EPS
        kept = [(a + b) * margin <= threshold for a, b in zip(ahead, behind, strict=True)]
        worth = self._aim(self.bounds, self.words, self.sums)
        parents = []
        most = self._most_on_chain(worth)
        if not all(k.any() for k in kept):
            self.low = max(self.low, min(self.discarded, self.high))
            return False
        old = self.intervals
        self.intervals = []
        for i in range(self.n + 1):
            split = (worth[i] >= 0.25 * most[i]) & (old[i].half > _NARROWEST) & kept[i]
            chosen = np.flatnonzero(kept[i])
            parent = np.repeat(chosen, 1 + split[chosen])
            parents.append(parent)
            twin = np.zeros(parent.size)
            second = np.append(False, parent[1:] == parent[:-1])
            firsts = np.append(second[1:], False)
            twin[second], twin[firsts] = 0.5, -0.5
            half = old[i].half[parent]
            middle = old[i].middle[parent] + twin * half
            half = np.where(twin == 0.0, half, 0.5 * half + 1e-15)
            self.intervals.append(_Intervals(middle, half, old[i].slope[parent]))
        pairs = 0
        for i in range(self.n):
            alive = (ahead[i][:, None] + self.bounds[i] + behind[i + 1]) * margin <= threshold
            self.live[i] = np.ascontiguousarray(alive[np.ix_(parents[i], parents[i + 1])])
            pairs += self.live[i].size
        return pairs < _MOST_PAIRS

    def _aim(
        self,
        costs: list[FloatArray],
        words: list[WordArray],
        sums: tuple[list[FloatArray], list[FloatArray]],
    ) -> list[FloatArray]:
        """Set the slopes of the potential from the best chain through each interval.

        Returns for each interval what splitting it may gain.
        """
        ahead, behind = sums
        chains = [
            (
                np.argmin(ahead[i][:, None] + costs[i], axis=0),
                np.argmin(costs[i] + behind[i + 1], axis=1),
            )
            for i in range(self.n)
        ]
        self.chains = chains
        left, right = self._flat(chains, words, True), self._flat(chains, words, False)
        gains: list[FloatArray] = []
        old = list(self.intervals)
        for i, interval in enumerate(self.intervals):
            (rise, by_left), (fall, by_right) = left[i], right[i]
            both = (by_left == BY_WORD) & (by_right == BY_WORD)
            slope = np.where(by_right > by_left, fall, rise)
            slope = np.where(both, 0.5 * (rise + fall), slope)
            slope = np.where(both & (np.abs(rise) > 3.0), fall, slope)
            slope = np.where(both & (np.abs(fall) > 3.0), rise, slope)
            if i in (0, self.n):
                slope = np.zeros(interval.middle.size)
            slope = np.clip(np.where(np.isnan(slope), interval.slope, slope), -20.0, 20.0)
            # next to the best route, and everywhere at first, its own slopes
            if i not in (0, self.n) and not math.isnan(self.slopes[i]):
                away = interval.middle - self.headings[i]
                away -= _TWO_PI * np.round(away / _TWO_PI)
                near = (np.abs(away) <= 4.0 * interval.half) | (not hasattr(self, "sums"))
                slope = np.where(near, self.slopes[i], slope)
            self.intervals[i] = interval._replace(slope=slope)
        if not hasattr(self, "sums"):
            return []
        for i, interval in enumerate(self.intervals):
            every = np.arange(interval.middle.size)
            halves, whole = np.zeros((2, every.size)), np.zeros(every.size)
            for at, mine in ((i - 1, False), (i, True)):
                if 0 <= at < self.n:
                    other = chains[at][1] if mine else chains[at][0]
                    far = _Intervals(*(a[other] for a in old[at + 1 if mine else at]))
                    ends = (old[i], far) if mine else (far, old[i])
                    halves += halving_gains(self.legs[at], *ends, mine)
                    whole += costs[at][every, other] if mine else costs[at][other, every]
            gain = halves.min(0) - whole
            gain = np.maximum(np.where(np.isnan(gain), 0.0, np.minimum(gain, 1.0)), 0.0)
            gain = gain + 0.1 * interval.half**2
            gains.append(gain if self.free[i] else 0.0 * gain)
        return gains

    def _most_on_chain(self, gains: list[FloatArray]) -> list[FloatArray]:
        """The largest gain on the best chain through each interval."""
        ahead, behind = [gains[0]], [gains[-1]]
        for i in range(self.n):
            ahead.append(np.maximum(gains[i + 1], ahead[-1][self.chains[i][0]]))
        for i in range(self.n - 1, -1, -1):
            behind.insert(0, np.maximum(gains[i], behind[0][self.chains[i][1]]))
        return [np.maximum(a, b) for a, b in zip(ahead, behind, strict=True)]

    def _flat(self, chains, words, forward):
        """For each interval the slope that its leg on one side asks for, and what says so."""
        end = 0 if forward else self.n
        size = self.intervals[end].middle.size
        slope = np.full(size, 0.0 if self.free[end] else math.nan)
        found = [(slope, np.full(size, BY_WORD if self.free[end] else UNKNOWN, np.int8))]
        for i in range(self.n) if forward else range(self.n - 1, -1, -1):
            a, b = self.intervals[i], self.intervals[i + 1]
            every = np.arange((b if forward else a).middle.size)
            j, k = (chains[i][0], every) if forward else (every, chains[i][1])
            found.append(
                slopes_across(
                    *(self.legs[i], a.middle[j], b.middle[k], a.half[j] + b.half[k]),
                    *(words[i][j, k], found[-1][0][j if forward else k], forward),
                )
            )
        return found if forward else found[::-1]

    def _route(self) -> Route:
        words, segments = route_words(self.legs, self.headings)
        names = tuple(WORDS6[word] for word in words)
        closed = self.low >= self.high * (1.0 - self.tolerance)
        seconds = perf_counter() - self.began
        return Route(
            *(self.headings, names, segments, self.length, self.low, self.high),
            *(closed, self.rounds, self.boxes, seconds),
        )


DEBUG = False


def _edges(words: WordArray, segments: FloatArray, near: float) -> FloatArray:
    """For each leg that is nearly two arcs the turn of the first, else 0."""
    turn = np.where((words == 2) | (words == 5), 1.0, -1.0)
    a, p, c = segments.T
    cs = np.where(((words == 2) | (words == 3)) & (p < near), turn, 0.0)
    cs = np.where((words >= 4) & (a < near), -turn, cs)
    return np.where((words >= 4) & (c < near), turn, cs)


def _start(heading: float | None, grid: FloatArray, half: float) -> _Intervals:
    """All headings, or the one that is given."""
    if heading is None:
        return _Intervals(grid, np.full(grid.size, half), np.zeros(grid.size))
    reduced = math.remainder(heading, _TWO_PI)
    # a double of 2 pi is 2.5e-16 less than it
    turns = abs(heading - reduced) / _TWO_PI
    return _Intervals(np.array([reduced]), np.array([turns * 2.5e-16]), np.zeros(1))


def _sums(costs: list[FloatArray]) -> tuple[list[FloatArray], list[FloatArray]]:
    """The least costs from the start to each interval, and from each interval to the end."""
    ahead, behind = [np.zeros(costs[0].shape[0])], [np.zeros(costs[-1].shape[1])]
    for cost in costs:
        ahead.append((ahead[-1][:, None] + cost).min(0))
    for cost in reversed(costs):
        behind.insert(0, (cost + behind[0]).min(1))
    return ahead, behind

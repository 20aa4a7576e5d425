"""The shortest route through points in a given order, with a proof.

Everything is in units of the turning radius, headings in radians. The heading at each point lies in
one of some intervals and may jump inside it: the least sum of the legs' bounds
(`study.route.leg_bound`) over all chains of intervals, by a dynamic program, is a lower bound of
the route. Intervals and pairs of them that no route as short as the best one known can pass are
left out; the others are split until the bound meets that route's length (docs/derivation.md,
section 16).
"""

from __future__ import annotations

import logging
import math
from itertools import pairwise
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.closed_form.pose import WORDS6
from dubins_study.study.path import FloatArray
from dubins_study.study.route.descent import descents, leg_table, route_length, route_words, survey
from dubins_study.study.route.leg_bound import (
    BY_WORD,
    UNKNOWN,
    WordArray,
    bound_leg,
    bounds_of_parts,
    slopes_across,
)

IndexArray = NDArray[np.intp]
_LOG = logging.getLogger(__name__)

_TWO_PI = 2 * math.pi
_COARSE = 16  # intervals at each point to begin with
_OVERLAP = 1e-14  # rad; more than the rounding of an interval's ends
_NARROWEST = 1e-13  # rad; half the width of an interval that is not split any more
_STEEPEST = 2.5  # slope of the potential; a word with a straight asks for 2 at most
_EAGER = 6  # rounds
_SOON = 0.5  # of the gap: intervals whose bounds are nearer to the best route's length wait
_BOTH = 0.5  # weight of what both ends of a leg gain by halves together, beside one alone
_PAIRS_AT_ONCE = 50_000  # about a tenth of a second between looks at the clock
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


class _Chains:
    """The least cost of a chain through each interval, and its neighbours there."""

    def __init__(self, costs: list[FloatArray], words: list[WordArray]) -> None:
        self.costs, self.words = costs, words
        self.ahead, self.behind = [np.zeros(costs[0].shape[0])], [np.zeros(costs[-1].shape[1])]
        self._before: list[IndexArray] = []
        self._after: list[IndexArray] = []
        for cost in costs:
            total = self.ahead[-1][:, None] + cost
            self._before.append(np.argmin(total, axis=0))
            self.ahead.append(total.min(axis=0))
        for cost in reversed(costs):
            total = cost + self.behind[0]
            self._after.insert(0, np.argmin(total, axis=1))
            self.behind.insert(0, total.min(axis=1))

    def pairs(self, leg: int, forward: bool) -> tuple[IndexArray, IndexArray]:
        """For each interval at the end of a leg if `forward`, else at its start, the best pair."""
        if forward:
            return self._before[leg], np.arange(self._before[leg].size)
        return np.arange(self._after[leg].size), self._after[leg]

    def cheapest(self) -> tuple[list[int], tuple[int, ...]]:
        """The intervals and the words of the cheapest chain."""
        route = [int(np.argmin(self.ahead[-1]))]
        words: list[int] = []
        for i in range(len(self.costs) - 1, -1, -1):
            route.insert(0, int(self._before[i][route[0]]))
            words.insert(0, int(self.words[i][route[0], route[1]]))
        return route, tuple(words)

    def largest(self, values: list[FloatArray]) -> list[FloatArray]:
        """The largest value on the best chain through each interval."""
        ahead, behind = [values[0]], [values[-1]]
        for i, before in enumerate(self._before):
            ahead.append(np.maximum(values[i + 1], ahead[-1][before]))
        for i in range(len(self.costs) - 1, -1, -1):
            behind.insert(0, np.maximum(values[i], behind[0][self._after[i]]))
        return [np.maximum(a, b) for a, b in zip(ahead, behind, strict=True)]


class _Search:
    """The state of one search: the best route, the intervals left and the bounds of their pairs."""

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
        given = [first, *[None] * (self.n - 1), last]
        self.free = np.array([heading is None for heading in given])
        self.intervals = [_start(heading) for heading in given]
        self.live = [
            np.ones((a.middle.size, b.middle.size), np.bool_) for a, b in pairwise(self.intervals)
        ]
        self.length, self.headings = math.inf, np.zeros(self.n + 1)
        self.slopes = np.full(self.n + 1, math.nan)  # of the potential, at the best route
        # no path is shorter than the legs' straight lines; each is rounded, and so is their sum
        straight = float(np.hypot(self.legs[:, 0], self.legs[:, 1]).sum())
        self.low, self.discarded = straight * (1.0 - (self.n + 4) * EPS), math.inf
        self.boxes = self.rounds = 0
        self.tried: set[tuple[int, ...]] = set()

    def run(self) -> Route:
        """Bound, go downhill and split by turns until the gap is closed or the time is over."""
        _LOG.info("searching for the shortest route of %d legs", self.n)
        chains = self._middles()
        self._improve(chains)
        self._survey()
        self.intervals = self._aimed(chains)
        while not self.closed:
            bounded = self._bound()
            if bounded is None:
                break
            self.rounds += 1
            least = float(bounded.ahead[-1].min()) * (1.0 - (self.n + 2) * EPS)
            self.low = max(self.low, min(least, self.discarded, self.high))
            open_part = 1.0 - self.low / self.high
            _LOG.info("round %d: proven to within %.2g of the length", self.rounds, open_part)
            # a chain of other words, but not in every round of a long search
            if not self.closed and (self.rounds <= _EAGER or self.rounds % _EAGER == 0):
                self._improve(bounded)
                self._improve(self._middles())
            if self.closed or not self._split(bounded):
                break
        return self._route()

    @property
    def high(self) -> float:
        """More than the best route's length, whatever the rounding."""
        return self.length * (1.0 + (self.n + 8) * EPS) + 64.0 * self.n * EPS

    @property
    def closed(self) -> bool:
        """Whether the bounds are within the tolerance."""
        return self.low >= self.high * (1.0 - self.tolerance)

    def _bound(self) -> _Chains | None:
        """Bounds of all live pairs of intervals; None where the time is over."""
        bounds, words = [], []
        for leg, live, (a, b) in zip(self.legs, self.live, pairwise(self.intervals), strict=True):
            bounds.append(np.empty(live.shape))
            words.append(np.empty(live.shape, np.int8))
            rows = 1 + _PAIRS_AT_ONCE // live.shape[1]
            for low in range(0, live.shape[0], rows):
                if perf_counter() - self.began > self.limit:
                    return None
                part = slice(low, low + rows)
                some = _Intervals(*(column[part] for column in a))
                bound_leg(leg, some, b, live[part], bounds[-1][part], words[-1][part])
            self.boxes += int(live.sum())
        return _Chains(bounds, words)

    def _middles(self) -> _Chains:
        """Routes through the middles of the intervals, by live pairs."""
        tables = [
            leg_table(leg, a.middle, b.middle, live)
            for leg, live, (a, b) in zip(
                self.legs, self.live, pairwise(self.intervals), strict=True
            )
        ]
        return _Chains([lengths for lengths, _ in tables], [words for _, words in tables])

    def _survey(self) -> None:
        """Go downhill from a route that knows of edges, where there can be any."""
        if (np.hypot(*self.legs.T) < 4.0).any():
            headings = self.headings.copy()
            survey(self.legs, headings, self.free)
            self._descend(headings, route_words(self.legs, headings)[0], 0.5 * _TWO_PI / _COARSE)

    def _improve(self, chains: _Chains) -> None:
        """Go downhill from the middles of the intervals on the cheapest chain."""
        route, words = chains.cheapest()
        if words in self.tried or not math.isfinite(chains.ahead[-1].min()):
            return
        self.tried.add(words)
        middles = [interval.middle[j] for interval, j in zip(self.intervals, route, strict=True)]
        width = max(float(interval.half.max()) for interval in self.intervals)
        self._descend(np.array(middles), np.array(words, np.int8), 0.2 * width)

    def _descend(self, start: FloatArray, words: WordArray, width: float) -> None:
        """Go downhill from a route; keep the best."""
        for headings, slopes in descents(self.legs, start, words, self.free, width):
            length = route_length(self.legs, headings)
            if length < self.length:
                self.length, self.headings, self.slopes = length, headings, slopes

    def _split(self, chains: _Chains) -> bool:
        """Leave out what no shorter route can pass, and split what is left; False at the end."""
        threshold = self.high * (1.0 - 0.5 * self.tolerance)
        self.discarded = min(self.discarded, threshold)
        margin = 1.0 - (2 * self.n + 4) * EPS
        kept = [
            (a + b) * margin <= threshold for a, b in zip(chains.ahead, chains.behind, strict=True)
        ]
        if not all(some.any() for some in kept):
            self.low = max(self.low, min(self.discarded, self.high))
            return False
        gains = self._gains(chains)
        most = chains.largest(gains)
        aimed, self.intervals, parents = self._aimed(chains), [], []
        for i, interval in enumerate(aimed):
            split = (gains[i] >= 0.25 * most[i]) & (interval.half > _NARROWEST) & self.free[i]
            split &= chains.ahead[i] + chains.behind[i] <= self.low + _SOON * (threshold - self.low)
            whole, halved = np.flatnonzero(kept[i] & ~split), np.flatnonzero(kept[i] & split)
            parents.append(np.concatenate([whole, halved, halved]))
            side = np.repeat([0.0, -0.5, 0.5], [whole.size, halved.size, halved.size])
            middle, half, slope = (column[parents[i]] for column in interval)
            halves = np.where(side == 0.0, half, 0.5 * half + _OVERLAP)
            self.intervals.append(_Intervals(middle + side * half, halves, slope))
        for i in range(self.n):
            through = chains.ahead[i][:, None] + chains.costs[i] + chains.behind[i + 1]
            alive = through * margin <= threshold
            self.live[i] = np.ascontiguousarray(alive[np.ix_(parents[i], parents[i + 1])])
        return sum(live.size for live in self.live) <= _MOST_PAIRS

    def _aimed(self, chains: _Chains) -> list[_Intervals]:
        """The intervals with slopes of the potential from the best chain through each of them."""
        before, after = self._asked(chains, True), self._asked(chains, False)
        aimed = []
        for i, interval in enumerate(self.intervals):
            (rise, by_left), (fall, by_right) = before[i], after[i]
            both = (by_left == BY_WORD) & (by_right == BY_WORD)
            slope = np.where(by_right > by_left, fall, rise)
            slope = np.where(both, 0.5 * (rise + fall), slope)
            slope = np.where(np.isnan(slope), interval.slope, slope)
            if not math.isnan(self.slopes[i]):
                away = interval.middle - self.headings[i]
                away -= _TWO_PI * np.round(away / _TWO_PI)
                near = (np.abs(away) <= 4.0 * interval.half) | (self.rounds == 0)
                slope = np.where(near, self.slopes[i], slope)
            if i in (0, self.n):
                slope = np.zeros(slope.size)  # no other leg takes back what one leg is given
            aimed.append(interval._replace(slope=np.clip(slope, -_STEEPEST, _STEEPEST)))
        return aimed

    def _asked(self, chains: _Chains, forward: bool) -> list[tuple[FloatArray, WordArray]]:
        """The slope that the leg before each interval asks for, or after it, and what says so."""
        end = 0 if forward else self.n
        size = self.intervals[end].middle.size
        slope = np.full(size, 0.0 if self.free[end] else math.nan)
        asked = [(slope, np.full(size, BY_WORD if self.free[end] else UNKNOWN, np.int8))]
        for i in range(self.n) if forward else range(self.n - 1, -1, -1):
            a, b = self.intervals[i], self.intervals[i + 1]
            j, k = chains.pairs(i, forward)
            words, known = chains.words[i][j, k], asked[-1][0][j if forward else k]
            reach = a.half[j] + b.half[k]
            asked.append(
                slopes_across(
                    *(self.legs[i], a.middle[j], b.middle[k], reach, words, known, forward)
                )
            )
        return asked if forward else asked[::-1]

    def _gains(self, chains: _Chains) -> list[FloatArray]:
        """How much more the bound along the best chain through each interval is with its halves."""
        gains = []
        for i, interval in enumerate(self.intervals):
            halves, whole = np.zeros((2, interval.half.size)), np.zeros(interval.half.size)
            both = np.zeros(interval.half.size)
            for leg, forward in ((i - 1, True), (i, False)):
                if 0 <= leg < self.n:
                    j, k = chains.pairs(leg, forward)
                    ends = (
                        _Intervals(*(column[j] for column in self.intervals[leg])),
                        _Intervals(*(column[k] for column in self.intervals[leg + 1])),
                    )
                    parts, quarters = bounds_of_parts(self.legs[leg], *ends, not forward)
                    halves += parts
                    whole += chains.costs[leg][j, k]
                    both += np.clip(np.nan_to_num(quarters - chains.costs[leg][j, k]), 0.0, 1.0)
            gain = np.clip(np.nan_to_num(halves.min(0) - whole), 0.0, 1.0)
            # where nothing is gained by halves of this one alone, by those of all
            gains.append((gain + _BOTH * both + 1e-3 * interval.half**2) * self.free[i])
        return gains

    def _route(self) -> Route:
        words, segments = route_words(self.legs, self.headings)
        names = tuple(WORDS6[word] for word in words)
        return Route(
            *(self.headings, names, segments, self.length, self.low, self.high, self.closed),
            *(self.rounds, self.boxes, perf_counter() - self.began),
        )


def _start(heading: float | None) -> _Intervals:
    """All headings, or the one that is given."""
    if heading is None:
        width = _TWO_PI / _COARSE
        grid = np.linspace(0.5 * width - math.pi, math.pi - 0.5 * width, _COARSE)
        return _Intervals(grid, np.full(_COARSE, 0.5 * width + _OVERLAP), np.zeros(_COARSE))
    reduced = math.remainder(heading, _TWO_PI)
    # the double of 2 pi is less than 2 pi by 2.45e-16
    spread = 2.5e-16 * abs(heading - reduced) / _TWO_PI
    return _Intervals(np.array([reduced]), np.array([spread]), np.zeros(1))

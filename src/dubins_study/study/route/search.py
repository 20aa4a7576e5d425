"""Search for the shortest route, with a proof.

The points have a given order. Everything is in units of the turning radius, headings in radians.

The heading at each point lies in one of some intervals and may jump inside it. A dynamic program
takes the least sum of the legs' bounds (`study.route.leg_bound`) over all chains of intervals. It
is a lower bound of the route. Intervals and pairs of them that no route as short as the best known
one can pass are left out. The others are split until the bound meets that route's length
(docs/derivation.md, section 16).
"""

from __future__ import annotations

import logging
import math
from collections.abc import Sequence
from functools import cache
from itertools import pairwise
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import BoolArray, FloatArray, IntArray
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.closed_form.pose import WORDS6
from dubins_study.study.route.descent import downhill, route_length, route_words
from dubins_study.study.route.effort import Effort, SpentError
from dubins_study.study.route.heading_grids import first_route, leg_table, survey
from dubins_study.study.route.intervals import COARSE, Intervals, first_intervals
from dubins_study.study.route.leg_bound import (
    BY_WORD,
    UNKNOWN,
    WordArray,
    add_gains,
    bound_leg,
    potential_slopes,
    slopes_across,
)

_LOG = logging.getLogger(__name__)

_NARROWEST = 1e-13  # rad; an interval with this half width is not split any more
_AT_REST = 1e-6  # rad; more than the error of the headings of a route that came to rest
_EAGER = 6  # rounds; up to this one every round has descents
_MOST_ROUNDS = 15  # rounds of descents from a loop
_AT_LEAST = 4  # descents a round, each from another point
_HOPELESS = 1.5  # times the best route's length: chains this long are not worth a descent
_PROMISING = 1.02  # times the cutoff, where there is one
_SELDOM = 3  # rounds from one descent to the next, where there is a cutoff
_SOON = 0.5  # of the gap: intervals whose bounds are nearer to the best route's length wait
_BOTH = 0.5  # weight of the gain by halving both ends of a leg, against that by halving one
_PAIRS_AT_ONCE = 50_000  # about a tenth of a second between looks at the clock
_MOST_PAIRS = 40_000_000
_MOST_SUMS = 400_000_000  # of a round, over all programs of a loop


class Route(NamedTuple):
    """Best route found, with a proven interval.

    The interval holds the shortest length of all routes.
    """

    headings: FloatArray  # shape (n + 1,), rad
    words: tuple[str, ...]  # of `pose.WORDS6`, one a leg
    segments: FloatArray  # shape (n, 3), radii
    length: float
    low: float
    high: float
    closed: bool  # whether low and high are within the tolerance
    boxes: int  # pairs of intervals that were bounded, and local searches counted in them
    seconds: float

    def begun_at(self, place: int) -> Route:
        """The same loop, begun at another point."""
        headings = _rolled(self.headings, place)
        return self._replace(
            headings=np.append(headings, headings[0]),
            words=(*self.words[place:], *self.words[:place]),
            segments=np.roll(self.segments, -place, axis=0),
        )


def search(
    points: ArrayLike,
    first: float | None,
    last: float | None = None,
    *,
    via_headings: Sequence[float | None] | None = None,
    closed: bool = False,
    limit: float = math.inf,
    boxes: float = math.inf,
    tolerance: float = 1e-12,
    cutoff: float = math.inf,
    known: FloatArray | None = None,
) -> Route:
    """Shortest route, with a proven interval for its length.

    The interval is within the tolerance, unless a limit or the cutoff ends the search.

    Args:
        points: shape (n + 1, 2), in radii, neighbours apart.
        first, last: headings at both ends (rad); None if free.
        via_headings: at the points between; None where free, or for all of them.
        closed: whether the heading at the end is that at the start, both free.
        limit: seconds, beside those that compiling takes.
        boxes: how many bounds of pairs of intervals; the result does not depend on the machine's
            speed where these are fewer than it computes in `limit`.
        tolerance: of the interval's width, relative to the length.
        cutoff: a length (radii) above which nobody asks for the route: the search ends where the
            proven interval reaches it, and `high` is not above it.
        known: headings of a route to begin with, shape (n + 1,), rad; None to find one. Not read
            where a loop is given a heading.
    """
    compile_loops()
    places = np.asarray(points, np.float64)
    between = via_headings or [None] * (len(places) - 2)
    headings = [first, *between, last]
    places_given = [i for i, heading in enumerate(headings) if heading is not None]
    effort = Effort(boxes=boxes, seconds=limit)
    if not closed or not places_given:
        state = _Search(
            places,
            headings,
            effort,
            tolerance=tolerance,
            cutoff=cutoff,
            cyclic=closed,
            known=known,
        )
        return state.run()
    # a loop may begin anywhere: where a heading is given it is a route to that heading
    begin = places_given[0]
    around = np.vstack([_rolled(places, begin), places[begin]])
    headings_around = [*headings[begin:-1], *headings[:begin], headings[begin]]
    route = _Search(around, headings_around, effort, tolerance=tolerance, cutoff=cutoff).run()
    return route.begun_at(len(route.words) - begin)


def _rolled(around: FloatArray, begin: int) -> FloatArray:
    """Values at a loop's points, from `begin` on.

    The first point is not repeated.
    """
    return np.roll(around[:-1], -begin, axis=0)


@cache
def compile_loops() -> None:
    """Load the compiled loops of the search.

    Loops that no cache holds are compiled.
    """
    points = [(0.0, 0.0), (0.6, 0.0), (0.0, 1.5), (8.0, 1.0)]
    _Search(points, [2.0, None, None, None], Effort(), 1e-6).run()


def potential_at(
    points: ArrayLike, headings: FloatArray, given: Sequence[float | None], closed: bool
) -> FloatArray:
    """Slopes of the potential at a route's points.

    NaN where its legs leave the slope open.
    """
    return _Search(points, given, Effort(), 1.0, cyclic=closed)._slopes_at(headings)


def _through(cost: FloatArray, rows: FloatArray) -> tuple[FloatArray, IntArray]:
    """Least sums of rows of `cost` and `rows`.

    Returns two arrays of shape (len(rows), len(cost)). Element [r, i] of the first is the least of
    cost[i] + rows[r]; of the second, the column where that is.
    """
    ways = ((way.min(axis=1), way.argmin(axis=1)) for way in (cost + row for row in rows))
    least, mates = zip(*ways, strict=True)
    return np.array(least), np.array(mates)


def _program(begin: FloatArray, costs: list[FloatArray]) -> tuple[list[FloatArray], list[IntArray]]:
    """Dynamic program over legs, from given first costs.

    Returns two lists: for each point the least costs up to each of its intervals, and for each leg
    the intervals from which they come.
    """
    least = [begin]
    mates = []
    for cost in costs:
        sums, columns = _through(cost, least[-1])
        least.append(sums)
        mates.append(columns)
    return least, mates


def _of_rows(mates: IntArray, row: IntArray) -> IntArray:
    """Numbers of the columns, each from its row."""
    return mates[row, np.arange(row.size)]


class _Chains:
    """Cheapest chain through each interval.

    `through` has the chain's cost, an array a point with a number for each interval. `before` and
    `after` have its neighbours, an array a leg. `ahead` and `behind` have the least costs up to
    each interval and from it on. A `cyclic` chain ends in the interval in which it begins, so that
    there is a program for each of these: the first axis of `ahead` and `behind`. Otherwise that
    axis has one row.
    """

    def __init__(self, costs: list[FloatArray], words: list[WordArray], cyclic: bool) -> None:
        self.costs = costs
        self.words = words
        begin = np.zeros((1, costs[0].shape[0]))
        end = np.zeros((1, costs[-1].shape[1]))
        if cyclic:
            # a loop's program r begins and ends in interval r
            begin = np.where(np.eye(costs[0].shape[0]), 0.0, math.inf)
            end = begin
        self.ahead, self._before = _program(begin, [cost.T for cost in costs])
        behind, after = _program(end, costs[::-1])
        self.behind = behind[::-1]
        both = [a + b for a, b in zip(self.ahead, self.behind, strict=True)]
        self.through: list[FloatArray] = [each.min(axis=0) for each in both]
        # the program that has the cheapest chain
        rows = [each.argmin(axis=0) for each in both]
        # for each leg: the best interval at its start for each one at its end, and the reverse
        self.before = [_of_rows(*each) for each in zip(self._before, rows[1:], strict=True)]
        self.after = [_of_rows(*each) for each in zip(after[::-1], rows[:-1], strict=True)]
        self._row = rows[-1]

    @property
    def least(self) -> float:
        """Cost of the cheapest chain."""
        return float(self.through[-1].min())

    def through_pairs(self, leg: int) -> FloatArray:
        """Least chain through each pair of a leg.

        Returns its cost, shape (intervals at the leg's start, intervals at its end).
        """
        least = np.full(self.costs[leg].shape, math.inf)
        for ahead, behind in zip(self.ahead[leg], self.behind[leg + 1], strict=True):
            np.minimum(least, ahead[:, None] + self.costs[leg] + behind, out=least)
        return least

    def cheapest(self) -> tuple[list[int], tuple[int, ...]]:
        """Intervals and words of the cheapest chain."""
        route = [int(np.argmin(self.through[-1]))]
        row = self._row[route[0]]
        words: list[int] = []
        for i in range(len(self.costs) - 1, -1, -1):
            route.insert(0, int(self._before[i][row, route[0]]))
            words.insert(0, int(self.words[i][route[0], route[1]]))
        return route, tuple(words)

    def largest(self, values: list[FloatArray]) -> list[FloatArray]:
        """Largest value on each interval's best chain.

        `values` and the result are an array a point, with a number for each interval.
        """
        ahead = [values[0]]
        behind = [values[-1]]
        for i, before in enumerate(self.before):
            ahead.append(np.maximum(values[i + 1], ahead[-1][before]))
        for i in range(len(self.costs) - 1, -1, -1):
            behind.insert(0, np.maximum(values[i], behind[0][self.after[i]]))
        return [np.maximum(a, b) for a, b in zip(ahead, behind, strict=True)]


class _Search:
    """State of one search.

    It has the best route, the intervals that are left at each point, and which of their pairs are
    left on each leg (`live`).
    """

    def __init__(
        self,
        points: ArrayLike,
        given: Sequence[float | None],
        effort: Effort,
        tolerance: float,
        cutoff: float = math.inf,
        cyclic: bool = False,
        known: FloatArray | None = None,
    ) -> None:
        self.effort = effort
        self.tolerance = tolerance
        self.cutoff = cutoff
        self.cyclic = cyclic
        self.legs = np.ascontiguousarray(np.diff(np.asarray(points, np.float64), axis=0))
        self.n = len(self.legs)
        if known is None:
            known = first_route(self.legs, given, effort)
        self.headings = known.copy()
        if cyclic:
            self.headings[-1] = self.headings[0]
        self.length: float = route_length(self.legs, self.headings)
        self.free = np.array([heading is None for heading in given])
        # a descent varies these headings, but not the one that a loop begins with
        self.varied = self.free.copy()
        self.varied[[0, -1]] &= not cyclic
        self.intervals, self.live = first_intervals(self.legs, given)
        self.arc_ends = [interval.middle[COARSE:] for interval in self.intervals]
        self.slopes: FloatArray | None = None  # of the potential, at the best route
        # no path is shorter than the legs' straight lines; each is rounded, and so is their sum
        straight = float(np.hypot(self.legs[:, 0], self.legs[:, 1]).sum())
        self.low = straight * (1.0 - (self.n + 4) * EPS)
        self.discarded = math.inf
        self.rounds = 0
        self.descended: set[tuple[int, ...]] = set()

    def run(self) -> Route:
        """Search until the gap is closed.

        Bounding, descents and splits take turns. The search also ends when its effort is spent.
        """
        _LOG.info("searching for the shortest route of %d legs", self.n)
        try:
            self._begin()
            while not self.closed:
                if not self._round():
                    break
        except SpentError:
            _LOG.info("the search has spent its effort")
        return self._route()

    def _begin(self) -> None:
        """Shorten the first route, and aim the potential."""
        width = 0.5 * TWO_PI / COARSE
        chains = self._middles()
        if self.worth(chains):
            self._descend(self.headings, width)
        if self.cutoff == math.inf:
            self._improve(chains)
            if (np.hypot(*self.legs.T) < 4.0).any():  # there can be edges
                headings = self.headings.copy()
                survey(self.legs, headings, self.varied, self.effort)
                self._descend(headings, width)
        self.intervals = self._aimed(chains)

    def _round(self) -> bool:
        """Bound and split once; False at the end.

        Descents are made in some rounds only.
        """
        bounded = self._bound()
        self.rounds += 1
        least = bounded.least * (1.0 - (self.n + 2) * EPS)
        self.low = max(self.low, min(least, self.discarded, self.high))
        open_part = 1.0 - self.low / self.high
        _LOG.info("round %d: proven to within %.2g of the length", self.rounds, open_part)
        # a chain of other words, but not in every round of a long search
        eager = self.rounds <= _EAGER or self.rounds % _EAGER == 0
        if self.cutoff < math.inf:
            eager = self.rounds % _SELDOM == 0
        if eager and not self.closed:
            self._improve(bounded)
        if self.closed or not self._split(bounded):
            return False
        if eager:
            self._improve(self._middles())
        return True

    @property
    def high(self) -> float:
        """Upper bound, whatever the rounding.

        It is more than the best route's length, or the cutoff if that is less.
        """
        high = self.length * (1.0 + (self.n + 8) * EPS) + 64.0 * self.n * EPS
        return min(high, self.cutoff)

    @property
    def closed(self) -> bool:
        """Whether the bounds are within the tolerance."""
        return self.low >= self.high * (1.0 - self.tolerance)

    def _bound(self) -> _Chains:
        """Chains whose costs are bounds.

        All live pairs of intervals are bounded.
        """
        bounds = []
        words = []
        for leg, live, (first, last) in zip(
            self.legs, self.live, pairwise(self.intervals), strict=True
        ):
            bounds.append(np.empty(live.shape))
            words.append(np.empty(live.shape, np.int8))
            rows = 1 + _PAIRS_AT_ONCE // live.shape[1]
            for low in range(0, live.shape[0], rows):
                part = slice(low, low + rows)
                self.effort.spend_or_end(int(np.count_nonzero(live[part])))
                bound_leg(leg, first.at(part), last, live[part], bounds[-1][part], words[-1][part])
        return _Chains(bounds, words, self.cyclic)

    def _middles(self) -> _Chains:
        """Chains whose costs are lengths.

        The lengths are those between the middles of live pairs of intervals.
        """
        tables = []
        for leg, live, (a, b) in zip(self.legs, self.live, pairwise(self.intervals), strict=True):
            self.effort.look_at_the_clock()
            tables.append(leg_table(leg, a.middle, b.middle, live))
        lengths, words = zip(*tables, strict=True)
        return _Chains([*lengths], [*words], self.cyclic)

    def _improve(self, chains: _Chains) -> None:
        """Go downhill from the cheapest chain.

        The descent starts at the middles of its intervals. Each chain of words is tried once.
        """
        route, words = chains.cheapest()
        if words in self.descended or not self.worth(chains):
            return
        self.descended.add(words)
        middles = [interval.middle[j] for interval, j in zip(self.intervals, route, strict=True)]
        width = max(float(interval.half.max()) for interval in self.intervals)
        self._descend(np.array(middles), 0.2 * width)

    def worth(self, chains: _Chains) -> bool:
        """Whether the cheapest chain is worth a descent.

        It has to be short enough.
        """
        if self.cutoff < math.inf:
            return chains.least < _PROMISING * self.cutoff
        return chains.least < _HOPELESS * self.length

    def _descend(self, start: FloatArray, width: float) -> None:
        """Go downhill from a route; keep the best.

        `start` has the route's headings, `width` is that of the first grid (rad).
        """
        headings = downhill(
            self.legs,
            start,
            self.varied,
            self.arc_ends,
            width=width,
            best=self.length,
            effort=self.effort,
        )
        if self.cyclic:
            headings = self._descend_around(headings, width)
        length = route_length(self.legs, headings)
        if length < self.length:
            self.length = length
            self.headings = headings
            self.slopes = None

    def _descend_around(self, headings: FloatArray, width: float) -> FloatArray:
        """Go downhill from a loop while it gets shorter.

        The loop begins at another point each time. Returns the headings from its first point on.
        """
        # about half of the loop, so that every point comes to be the first
        step = next(k for k in range(self.n // 2, self.n + 1) if math.gcd(k, self.n) == 1)
        legs = self.legs
        begin = 0
        length = math.inf
        for _ in range(_MOST_ROUNDS):
            for _ in range(min(self.n, _AT_LEAST)):
                begin = (begin + step) % self.n
                legs = np.ascontiguousarray(np.roll(legs, -step, axis=0))
                rolled = _rolled(headings, step)
                closed = np.append(rolled, rolled[0])
                headings = downhill(
                    legs,
                    closed,
                    self.varied,
                    self.arc_ends,
                    width=width,
                    best=self.length,
                    effort=self.effort,
                )
            before = length
            length = route_length(legs, headings)
            if length > before * (1.0 - EPS):
                break
        rolled = _rolled(headings, self.n - begin)
        return np.append(rolled, rolled[0])

    def _slopes_at(self, headings: FloatArray) -> FloatArray:
        """Slopes of the potential at a route's points.

        NaN where its legs leave the slope open.
        """
        points = [
            Intervals(np.array([heading]), np.array([_AT_REST]), np.array([math.nan]))
            for heading in headings
        ]
        words = list(route_words(self.legs, headings)[0][:, None, None])
        only = [np.zeros(1, np.intp)] * self.n
        before = self._leg_slopes(points, words, only, forward=True)
        after = self._leg_slopes(points, words, only, forward=False)
        if self.cyclic:
            before[0] = before[-1]
            after[-1] = after[0]
        # the legs alone decide: no best route's heading or slope is given
        slopes = [
            potential_slopes(point, rise, fall, math.nan, math.nan, False)
            for point, rise, fall in zip(points, before, after, strict=True)
        ]
        return np.concatenate(slopes)

    def _split(self, chains: _Chains) -> bool:
        """Leave out intervals and split the others.

        No shorter route can pass an interval that is left out. False at the end of the search.
        """
        threshold = self.high * (1.0 - 0.5 * self.tolerance)
        self.discarded = min(self.discarded, threshold)
        margin = 1.0 - (2 * self.n + 4) * EPS
        possible = [through * margin <= threshold for through in chains.through]
        if not all(mask.any() for mask in possible):
            self.low = max(self.low, min(self.discarded, self.high))
            return False
        soon = self.low + _SOON * (threshold - self.low)
        promising = [
            (through <= soon) & free
            for through, free in zip(chains.through, self.free, strict=True)
        ]
        gains = self._gains(chains, promising)
        most = chains.largest(gains)
        aimed = self._aimed(chains)
        self.intervals = []
        parents = []
        for i, interval in enumerate(aimed):
            # halved: what gains a quarter or more of the most on its best chain
            split = promising[i] & (gains[i] >= 0.25 * most[i]) & (interval.half > _NARROWEST)
            whole = np.flatnonzero(possible[i] & ~split)
            halved = np.flatnonzero(possible[i] & split)
            parents.append(np.concatenate([whole, halved, halved]))
            # whole intervals, lower halves, upper halves
            side = np.repeat([0.0, -0.5, 0.5], [whole.size, halved.size, halved.size])
            self.intervals.append(interval.at(parents[i]).halved(side))
        if self.cyclic:
            parents[-1] = parents[0]
            self.intervals[-1] = self.intervals[0]
        for i in range(self.n):
            alive = chains.through_pairs(i) * margin <= threshold
            live = np.where(alive, self.live[i], 0)
            self.live[i] = np.ascontiguousarray(live[np.ix_(parents[i], parents[i + 1])])
        pairs = sum(live.size for live in self.live)
        programs = 1
        if self.cyclic:
            programs = self.intervals[0].middle.size
        return pairs <= _MOST_PAIRS and pairs * programs <= _MOST_SUMS

    def _aimed(self, chains: _Chains) -> list[Intervals]:
        """Intervals with new slopes of the potential.

        The slopes come from the best chain through each interval.
        """
        if self.slopes is None:
            self.slopes = self._slopes_at(self.headings)
        before = self._leg_slopes(self.intervals, chains.words, chains.before, forward=True)
        after = self._leg_slopes(self.intervals, chains.words, chains.after, forward=False)
        if self.cyclic:
            before[0] = before[-1]
            after[-1] = after[0]
        aimed = []
        for i, interval in enumerate(self.intervals):
            # at the ends no other leg cancels the slope of the potential
            if i in (0, self.n) and not self.cyclic:
                slope = np.zeros(interval.slope.size)
            else:
                # before the first round the best route's slope is taken everywhere
                slope = potential_slopes(
                    interval,
                    before[i],
                    after[i],
                    self.headings[i],
                    self.slopes[i],
                    self.rounds == 0,
                )
            aimed.append(interval._replace(slope=slope))
        return aimed

    def _leg_slopes(
        self,
        intervals: list[Intervals],
        words: list[WordArray],
        mates: list[IntArray],
        forward: bool,
    ) -> list[tuple[FloatArray, WordArray]]:
        """Slopes that legs ask for, with their sources.

        A pair for each point: a slope for each interval, and what it is derived from (`UNKNOWN`,
        `BY_EDGE` or `BY_WORD`). The leg before the point asks if `forward`, else the leg after it.
        """
        end = 0
        legs = range(self.n)
        if not forward:
            end = self.n
            legs = legs[::-1]
        size = intervals[end].middle.size
        slope = math.nan
        source = UNKNOWN
        if self.free[end] and not self.cyclic:
            slope = 0.0
            source = BY_WORD
        slopes = [(np.full(size, slope), np.full(size, source, np.int8))]
        for i in legs:
            self.effort.look_at_the_clock()
            ends = intervals[i], intervals[i + 1]
            known_slopes, _ = slopes[-1]
            slopes.append(
                slopes_across(self.legs[i], *ends, words[i], mates[i], known_slopes, forward)
            )
        if not forward:
            slopes.reverse()
        return slopes

    def _gains(self, chains: _Chains, promising: list[BoolArray]) -> list[FloatArray]:
        """Gains of the bound from halving each interval.

        The bound is that along the best chain through the interval. Returns an array a point.
        """
        gains = []
        for i, interval in enumerate(self.intervals):
            self.effort.look_at_the_clock()
            halves = np.zeros((2, interval.half.size))
            both = np.zeros(interval.half.size)
            for leg, mates in ((i - 1, chains.before), (i, chains.after)):
                if 0 <= leg < self.n:
                    ends = self.intervals[leg], self.intervals[leg + 1]
                    add_gains(
                        self.legs[leg],
                        *ends,
                        self.live[leg],
                        chains.costs[leg],
                        mates[leg],
                        promising[i],
                        leg < i,
                        halves,
                        both,
                    )
            # halves of this interval alone may gain nothing where halves of both ends do
            gain = np.clip(halves.min(0), 0.0, 1.0) + _BOTH * both
            gains.append((gain + 1e-3 * interval.half**2) * self.free[i])
        if self.cyclic:
            gains[0] = gains[-1] = gains[0] + gains[-1]
        return gains

    def _route(self) -> Route:
        """Best route, with the proven interval."""
        words, segments = route_words(self.legs, self.headings)
        names = tuple(WORDS6[word] for word in words)
        return Route(
            headings=self.headings,
            words=names,
            segments=segments,
            length=self.length,
            low=self.low,
            high=self.high,
            closed=self.closed,
            boxes=self.effort.spent,
            seconds=perf_counter() - self.effort.began,
        )

"""Search for the shortest tour, with a proof.

Via points are passed in any order. Everything is in units of the turning radius, headings in
radians.

The bound of a leg over two intervals of headings belongs to two points, whatever the order. Chains
of legs that remember only a few points bound all tours from below. Prices on the points make the
cheapest chain pass each of them once. The least cost from an interval on leaves out pairs of
intervals, and sets of points in an exact program, that no tour as short as the best known one can
have. Intervals are halved until few orders are left. Each of these is searched as a route with the
best tour's length as its cutoff (docs/derivation.md, section 18).
"""

from __future__ import annotations

import logging
import math
from copy import copy
from functools import cache
from itertools import permutations
from time import perf_counter
from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import cdist

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray, IntArray
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.route.effort import Effort, SpentError
from dubins_study.study.route.intervals import OVERLAP, Intervals
from dubins_study.study.route.leg_bound import bound_leg
from dubins_study.study.route.search import Route, compile_loops, potential_at, search
from dubins_study.study.tour.chains import (
    bounds_between,
    cheapest_chain,
    cheapest_through,
    extend_chains,
    first_chains,
    memories_after,
)
from dubins_study.study.tour.orders import MOST_IN_SET, OrderBounds, ToGo, orders_within
from dubins_study.study.tour.short_orders import CHAIN_BOXES, Legs, short_orders
from dubins_study.study.tour.stops import Stops

_LOG = logging.getLogger(__name__)

# Most points, first intervals at each, and number of near points, itself included, that a chain
# remembers. With more points the result is a good tour, and the least tree as a bound.
_SIZES = ((12, 16, 5), (40, 16, 7), (62, 8, 6), (100, 8, 4))
_ROUNDS = 40  # of prices, at first
_LATER_ROUNDS = 16  # of prices, where they are good
_STEP = 1.0  # of prices, at first: a share of Polyak's
_LATER_STEP = 0.5
_SHRINK = 0.6  # factor of the step after `_PATIENCE` rounds
_PATIENCE = 3  # rounds without a better bound
_LEAST_STEP = 0.02
_SOON = 1.0  # of the gap: intervals whose chains are nearer to the best tour's length wait
_ALL_ORDERS = 4  # points up to which every order is searched
_QUICK = 1_000  # boxes a leg, for a tour that is not to be proved
_ORDER_BOXES = 4_000  # about what the search of one order takes
_MOST_PAIRS = 20_000_000
_NARROWEST = 1e-9  # rad; half the width of an interval that is not halved any more
_AT_ENDS = 16  # intervals of a free heading at the start or the target


class Tour(NamedTuple):
    """Best tour found, with a proven interval.

    The interval holds the shortest length of all tours.
    """

    order: tuple[int, ...]  # of the via points
    route: Route  # through them in this order
    low: float
    high: float
    closed: bool  # whether low and high are within the tolerance
    boxes: int
    seconds: float
    orders: int  # that were searched one by one


def search_tour(
    stops: Stops,
    *,
    limit: float = math.inf,
    boxes: float = math.inf,
    tolerance: float = 1e-9,
) -> Tour:
    """Shortest tour, with a proven interval for its length.

    The interval is within the tolerance, unless a limit ends the search.

    Args:
        stops: two or more different points.
        limit: seconds, beside those that compiling takes.
        boxes: how many bounds of pairs of intervals, and work counted in them.
        tolerance: of the interval's width, relative to the length.
    """
    compile_tour_loops()
    effort = Effort(boxes=boxes, seconds=limit)
    fixed = [i for i, heading in enumerate(stops.headings) if heading is not None]
    if not stops.closed or not fixed:
        tour = _TourSearch(stops, effort, tolerance).run()
        if stops.closed and tour.order[0] > tour.order[-1]:
            return _backwards(tour)
        return tour
    place = fixed[0]
    tour = _TourSearch(stops.begun_at(place), effort, tolerance).run()
    # points of that search: the old start, then the old points except the one that it began at
    points = [i for i in range(len(stops.points)) if i != place]
    began = tour.order.index(0)
    order = [points[i - 1] for i in tour.order[began + 1 :]] + [place]
    order += [points[i - 1] for i in tour.order[:began]]
    return tour._replace(order=tuple(order), route=tour.route.begun_at(began + 1))


def _backwards(loop: Tour) -> Tour:
    """A loop driven the other way round.

    It is as long. Of both, the search returns the one whose first point is listed before its last,
    so that the result is always the same.
    """
    route = loop.route
    other_side = str.maketrans("LR", "RL")
    words = [word[::-1].translate(other_side) for word in reversed(route.words)]
    route = route._replace(
        headings=route.headings[::-1] + math.pi,
        words=tuple(words),
        segments=route.segments[::-1, ::-1],
    )
    return loop._replace(order=loop.order[::-1], route=route)


@cache
def compile_tour_loops() -> None:
    """Load the compiled loops of the search.

    Loops that no cache holds are compiled.
    """
    compile_loops()
    points = np.array([(3.0, 1.0), (0.5, -2.0), (-2.0, 2.0), (6.0, 3.0), (1.0, 6.0)])
    stops = Stops(points, [None] * len(points), first=0.0, target=(1.0, 5.0), last=None)
    _TourSearch(stops, Effort(), tolerance=1e-6).run()


class _TourSearch:
    """State of one search.

    It has the best tour, the intervals left and the bounds of their pairs.
    """

    def __init__(self, stops: Stops, effort: Effort, tolerance: float) -> None:
        self.stops = stops
        self.effort = effort
        self.tolerance = tolerance
        self.n = len(stops.points)
        self.order: tuple[int, ...] = tuple(range(self.n))
        self.best: Route | None = None
        self.low = _least_tree(stops)
        self.searched: dict[tuple[int, ...], Route] = {}
        self.prices = np.zeros(self.n)
        self.priced = False
        self.around: Intervals | None = None  # of a loop: the interval of its heading at the start

    @property
    def length(self) -> float:
        if self.best is None:
            return math.inf
        return self.best.length

    @property
    def high(self) -> float:
        """Upper bound: the best tour's, whatever the rounding."""
        if self.best is None:
            return math.inf
        return self.best.high

    @property
    def slack(self) -> float:
        """Upper limit of a chain's rounding error.

        It holds with and without prices.
        """
        size = self.high + 2.0 * float(np.abs(self.prices).sum())
        return (4 * self.n + 16) * EPS * size

    @property
    def closed(self) -> bool:
        return self.low >= self.high * (1.0 - self.tolerance)

    def run(self) -> Tour:
        """Search until the gap is closed.

        Short orders are searched first; then a proof follows. The search also ends when its effort
        is spent.
        """
        _LOG.info("searching for the shortest tour of %d points", self.n)
        try:
            for order in short_orders(self.stops, self.effort):
                self._search_order(order, quick=True)
            _LOG.info("a tour of length %.6g", self.length)
            size = next((size for size in _SIZES if self.n <= size[0]), None)
            if self.n <= _ALL_ORDERS:
                self._search_all()
            elif size is not None:
                self._prove(*size[1:])  # first intervals at each point, and points remembered
        except SpentError:
            _LOG.info("the search has spent its effort")
        if self.best is None:  # an answer in any case, whatever the limit
            self._search_order(self.order, quick=True)
        assert self.best is not None
        return Tour(
            order=self.order,
            route=self.best,
            low=min(self.low, self.high),
            high=self.high,
            closed=self.closed,
            boxes=self.effort.spent,
            seconds=perf_counter() - self.effort.began,
            orders=len(self.searched),
        )

    def _prove(self, intervals: int, remembered: int) -> None:
        """Raise the lower bound to the best tour's length.

        It stops when nothing more can be done. `near` are the points that a chain remembers, by its
        last point.
        """
        distances = cdist(self.stops.points, self.stops.points)
        distances[np.diag_indices(self.n)] = -1.0  # each point is the first of those near it
        self.near = np.argsort(distances, axis=1, kind="stable")[:, :remembered]
        self.after = memories_after(self.near)
        self._cover(intervals)
        if self.stops.closed:
            self._prove_around()
            return
        while not self.closed and self._level():
            pass

    def _prove_around(self) -> None:
        """Prove a loop, one first interval at a time.

        A loop ends in the interval of headings in which it begins. Each of these intervals has a
        search of its own, and the least of their lower bounds counts. Driven backwards a loop is as
        long, so that half of the circle is enough.
        """
        self._aim()
        self._bound()
        self._price()
        lows = []
        circle = _intervals_at(None, _AT_ENDS)
        for place in np.flatnonzero(np.sin(circle.middle) > 0.0):
            part = copy(self)
            part.around = circle.at([place])
            part.live = self.live.copy()
            part.bounds = self.bounds.copy()
            try:
                while not part.closed and part._level():
                    pass
            finally:
                self.best = part.best
                self.order = part.order
            lows.append(part.low)
        self.low = max(self.low, min(*lows, self.high))

    def _search_order(self, order: tuple[int, ...], quick: bool = False) -> Route:
        """Search one order; keep the best route.

        The best tour's length is the cutoff. A `quick` search has few boxes.
        """
        points, headings = self.stops.route(order)
        seconds_left = self.effort.seconds - (perf_counter() - self.effort.began)
        boxes = self.effort.boxes - self.effort.spent
        if quick:
            boxes = _QUICK * (self.n + 1)
        known = None
        if self.best is not None and order == self.order:
            known = self.best.headings
        route = search(
            points,
            first=headings[0],
            last=headings[-1],
            via_headings=headings[1:-1],
            limit=max(seconds_left, 0.0),
            boxes=boxes,
            tolerance=self.tolerance,
            cutoff=self.high,
            known=known,
            closed=self.stops.closed,
        )
        self.effort.spent += route.boxes
        if self.best is None or route.length < self.length:
            self.best = route
            self.order = order
        return route

    # Bounds

    def _cover(self, intervals: int) -> None:
        """Set up intervals of headings, and their pairs.

        `owner` is the point of each interval. `live` is the mask of the pairs that a tour may pass,
        `new` of those whose bounds are not known.
        """
        of_points = [_intervals_at(heading, intervals) for heading in self.stops.headings]
        self.owner = np.repeat(np.arange(self.n), [each.middle.size for each in of_points])
        columns = zip(*of_points, strict=True)
        self.intervals = Intervals(*(np.concatenate(column) for column in columns))
        self.live = self.owner[:, None] != self.owner[None, :]
        self.new = self.live  # pairs whose bounds are not known
        self.bounds = np.full(self.live.shape, math.inf)

    @property
    def begin(self) -> IntArray:
        """Where the intervals of each point begin.

        Shape (n + 1,).
        """
        begin: IntArray = np.searchsorted(self.owner, np.arange(self.n + 1))
        return begin

    def _level(self) -> bool:
        """Bound, leave out and halve once.

        If few orders are left, they are searched instead. False at the end.
        """
        began = self.effort.spent
        self._aim()
        self._bound()
        self._price()
        if self.closed:
            return False
        behind = self._leave_out()
        if np.unique(self.owner).size < self.n:  # no tour as short passes one of the points
            self.low = self.high
            return False
        orders = self._orders_left(behind)
        pairs = 3 * int(np.count_nonzero(self.live))
        spent = self.effort.spent - began
        if orders is not None:
            _LOG.info("%d orders are left", len(orders))
            # few: to search them costs no more than another level is likely to
            few = len(orders) * _ORDER_BOXES <= max(2 * spent, pairs)
            if few or pairs > _MOST_PAIRS or not self._halve():
                self._search_orders(orders)
                return False
            return True
        return pairs <= _MOST_PAIRS and self._halve()

    def _aim(self) -> None:
        """Aim the potential at the best tour.

        All intervals of a point get the slope of the best tour's potential there.
        """
        assert self.best is not None
        points, headings = self.stops.route(self.order)
        slopes = potential_at(points, self.best.headings, headings, self.stops.closed)
        if self.around is not None:  # the last leg cancels the slope that the first one is given
            self.around = self.around._replace(slope=np.nan_to_num(slopes[:1]))
        of_points = np.zeros(self.n)
        of_points[list(self.order)] = np.nan_to_num(slopes)[1 : self.n + 1]
        slope = of_points[self.owner]
        moved = slope != self.intervals.slope
        self.intervals = self.intervals._replace(slope=slope)
        self.new = self.live & (self.new | moved[:, None] | moved[None, :])

    def _bound(self) -> None:
        """Bound all live pairs of intervals.

        `bounds` is filled where it is not known. `starts` and `ends` are the bounds of the legs
        from the start and to the end.
        """
        size = self.owner.size
        begin = self.begin
        for i in range(self.n):
            self.effort.spend_or_end(float(np.count_nonzero(self.new[begin[i] : begin[i + 1]])))
            bounds_between(self.stops.points, begin, self.intervals, self.new, i, self.bounds)
        self.starts = np.zeros(size)
        self.ends = np.zeros(size)
        first = self.around or _intervals_at(self.stops.first, _AT_ENDS)
        last = self.around or _intervals_at(self.stops.last, _AT_ENDS)
        for i, point in enumerate(self.stops.points):
            part = slice(begin[i], begin[i + 1])
            here = self.intervals.at(part)
            self.starts[part] = _pair_bounds(point, first, here).min(axis=0)
            if self.stops.target is None:  # no leg cancels the slope that the last one is given
                self.ends[part] = -np.abs(here.slope) * here.half
            else:
                way = np.array(self.stops.target) - point
                self.ends[part] = _pair_bounds(way, here, last).min(axis=1)

    def _chains(self, prices: FloatArray, back: bool = False) -> FloatArray:
        """Costs of chains from the start.

        With `back` they are those of chains backwards, from the end. The array's axes are those of
        `first_chains`.
        """
        bounds = self.bounds
        ends = self.starts
        if back:
            bounds = np.ascontiguousarray(self.bounds.T)
            ends = self.ends
        begin = self.begin
        goes = np.minimum.reduceat(bounds, begin[:-1], axis=1) < math.inf
        sums = np.count_nonzero(goes) * self.after.shape[1] / 2 * self.owner.size
        self.effort.spend_or_end(sums * CHAIN_BOXES)
        costs: FloatArray = first_chains(begin, self.after, ends, prices)
        for k in range(self.n - 1):
            self.effort.look_at_the_clock()
            extend_chains(costs, k, bounds, goes, begin, self.after, prices)
        return costs

    def _price(self) -> None:
        """Improve the prices of points, and the lower bound.

        Prices of points that the cheapest chain misses rise, and those of repeated points fall. A
        step is a share of the one that would close the gap, were the bound linear (Polyak 1969).
        """
        prices = self.prices
        best = -math.inf
        idle_rounds = 0
        rounds = _ROUNDS
        step = _STEP
        if self.priced:
            rounds = _LATER_ROUNDS
            step = _LATER_STEP
        self.priced = True
        for _ in range(rounds):
            costs = self._chains(prices)
            bound = float((costs[-1] + self.ends).min() + prices.sum())
            idle_rounds += 1
            if bound > best * (1.0 + 1e-6):
                idle_rounds = 0
            if bound > best:
                best = bound
                self.prices = prices
                self.low = max(self.low, min(bound - self.slack, self.high))
            if idle_rounds >= _PATIENCE:
                step *= _SHRINK
                idle_rounds = 0
            if bound == math.inf or self.closed or step < _LEAST_STEP:
                break
            chain = cheapest_chain(costs, self.bounds, self.begin, self.after, self.ends)
            missing = 1 - np.bincount(chain, minlength=self.n)
            if not missing.any():
                order = tuple(chain.tolist())
                if order != self.order:
                    self._search_order(order, quick=True)
                break
            open_part = max(self.high - bound, 0.0)
            prices = prices + step * open_part * missing / (missing @ missing)
        _LOG.info("proven to within %.2g of the length", 1.0 - self.low / self.high)

    def _leave_out(self) -> FloatArray:
        """Leave out pairs of intervals that are too long.

        No tour as short as the best one can pass them. Intervals without a pair are left out too,
        of all arrays of this search.

        Returns:
            Costs of chains back from the end, of the intervals that are kept.
        """
        ahead = self._chains(self.prices)
        behind = self._chains(self.prices, back=True)
        through = cheapest_through(ahead.min(axis=1), self.bounds, behind.min(axis=1))
        through += self.prices.sum()
        self.live &= through <= self.high + self.slack
        self.least = np.minimum(through.min(axis=0), through.min(axis=1))
        places = np.flatnonzero(self.live.any(axis=0) | self.live.any(axis=1))
        self.owner = self.owner[places]
        self.intervals = self.intervals.at(places)
        self.live = self.live[np.ix_(places, places)]
        self.bounds = np.where(self.live, self.bounds[np.ix_(places, places)], math.inf)
        self.starts = self.starts[places]
        self.ends = self.ends[places]
        self.least = self.least[places]
        return behind[:, :, places]

    def _halve(self) -> bool:
        """Halve the intervals that short tours can pass.

        False if none can be halved.
        """
        soon = self.low + _SOON * (self.high - self.low)
        free = np.array([heading is None for heading in self.stops.headings])[self.owner]
        split = free & (self.least <= soon) & (self.intervals.half > _NARROWEST)
        if not split.any():
            return False
        parents = np.repeat(np.arange(self.owner.size), 1 + split)
        # of an interval that stands twice, the second one is the upper half
        second = np.diff(parents, prepend=-1) == 0
        side = np.where(split[parents], np.where(second, 0.5, -0.5), 0.0)
        self.intervals = self.intervals.at(parents).halved(side)
        self.owner = self.owner[parents]
        self.live = self.live[np.ix_(parents, parents)]
        self.bounds = self.bounds[np.ix_(parents, parents)]
        halved = split[parents]
        self.new = self.live & (halved[:, None] | halved[None, :])
        return True

    # Orders

    def _orders_left(self, behind: FloatArray) -> OrderBounds | None:
        """Bounds of all orders that may be shortest.

        They can be as short as the best tour. None if there are too many to list.
        """
        if self.n > MOST_IN_SET:
            return None
        legs = Legs(self.begin, self.bounds, starts=self.starts, ends=self.ends)
        ahead = ToGo(costs=behind, near=self.near, prices=self.prices)
        cutoff = self.high + self.slack
        orders = orders_within(legs, ahead, cutoff, self.effort)
        if orders is None:
            return None
        return {order: least - self.slack for order, least in orders.items()}

    def _search_all(self) -> None:
        """Search every order of few points.

        Each is first searched for a while, so that none takes all the time.
        """
        orders: OrderBounds = {}
        for order in (self.order, *permutations(range(self.n))):
            backwards = self.stops.closed and order[::-1] in orders
            if order not in orders and not backwards:
                orders[order] = self._search_order(order, quick=True).low
        self._search_orders(orders)

    def _search_orders(self, orders: OrderBounds) -> None:
        """Search orders one by one.

        The best tour's order comes first, the others follow by their bounds.
        """
        order_bounds = dict(sorted(orders.items(), key=lambda item: item[1]))
        low = math.inf
        for order in [self.order, *(order for order in order_bounds if order != self.order)]:
            bound = order_bounds.get(order, 0.0)
            if order in self.searched:
                bound = max(bound, self.searched[order].low)
            if bound < self.high * (1.0 - self.tolerance):
                try:
                    self.effort.look_at_the_clock()
                    route = self._search_order(order)
                except SpentError:
                    # orders that are not searched keep their bounds
                    self.low = max(self.low, min(low, *order_bounds.values()))
                    raise
                self.searched[order] = route
                bound = max(bound, route.low)
            low = min(low, bound)
            order_bounds[order] = bound
        self.low = max(self.low, min(low, self.high))


def _least_tree(stops: Stops) -> float:
    """Length of the least tree between all points.

    No tour is shorter.
    """
    points = np.vstack([np.zeros(2), stops.points])
    if stops.target is not None and not stops.closed:
        points = np.vstack([points, stops.target])
    # by hand: a distance below 1e-8 is no edge to SciPy's trees
    tree = 0.0
    place = 0
    away = np.full(len(points), math.inf)
    joined = np.zeros(len(points), np.bool_)
    for _ in range(len(points) - 1):
        joined[place] = True
        away = np.minimum(away, np.hypot(*(points - points[place]).T))
        place = int(np.where(joined, math.inf, away).argmin())
        tree += float(away[place])
    return tree * (1.0 - 4 * len(points) * EPS)


def _intervals_at(heading: float | None, count: int) -> Intervals:
    """Intervals of headings; `count` if free."""
    if heading is not None:
        return Intervals(
            np.array([math.remainder(heading, TWO_PI)]), np.array([OVERLAP]), np.zeros(1)
        )
    width = TWO_PI / count
    middle = np.linspace(0.5 * width - math.pi, math.pi - 0.5 * width, count)
    return Intervals(middle, np.full(count, 0.5 * width + OVERLAP), np.zeros(count))


def _pair_bounds(way: FloatArray, first: Intervals, last: Intervals) -> FloatArray:
    """Bounds of a leg for all pairs of intervals.

    Shape (first intervals, last intervals).
    """
    live = np.ones((first.middle.size, last.middle.size), np.int8)
    bounds = np.empty(live.shape)
    words = np.empty(live.shape, np.int8)
    bound_leg(way, first, last, live, bounds, words)
    return bounds

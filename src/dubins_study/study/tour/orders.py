"""Find all orders of a tour within a length.

An exact program over sets of points finds them. A state is a set of points that are passed, the
last of them, and the least cost up to each of its intervals of headings. Chains backwards bound the
cost that is left from there on, which excludes most states (docs/derivation.md, section 18).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dubins_study.study.arrays import FloatArray, IntArray
from dubins_study.study.route.effort import Effort
from dubins_study.study.tour.chains import SetArray, extended, leave_out
from dubins_study.study.tour.short_orders import CHAIN_BOXES, Legs

MOST_IN_SET = 62  # points, of which a set is an int64
_MOST_STATES = 100_000
_MOST_ORDERS = 1_000

# for each size of set, costs by (set, last point)
_Levels = list[dict[tuple[int, int], FloatArray]]
# a set of points, the last of them, the points after it, and the costs from the last one on
_OpenEnd = tuple[int, int, tuple[int, ...], FloatArray]


class ToGo(NamedTuple):
    """Lower bounds of the cost that is left."""

    costs: FloatArray  # of chains backwards, less prices: shape (points, memories, intervals)
    near: IntArray  # the points that a memory is of, shape (points, remembered)
    prices: FloatArray  # shape (points,)


# for each order, a lower bound of its tours
OrderBounds = dict[tuple[int, ...], float]


def orders_within(legs: Legs, to_go: ToGo, cutoff: float, effort: Effort) -> OrderBounds | None:
    """Lower bounds of all orders within the cutoff.

    Returns a bound for each order. None if there are too many orders, or states.
    """
    levels = _states(legs, to_go, cutoff, effort)
    if levels is None:
        return None
    orders: OrderBounds = {}
    begin = legs.begin
    n = begin.size - 1
    # backwards from the end, with all points in the set
    every = (1 << n) - 1
    open_ends: list[_OpenEnd] = [
        (every, i, (), legs.ends[begin[i] : begin[i + 1]]) for i in range(n)
    ]
    while open_ends:
        passed, here, following, to_end = open_ends.pop()
        costs = levels[passed.bit_count() - 1].get((passed, here))
        if costs is None:
            continue
        # a state's costs have room for the most intervals of a point
        least = float((costs[: to_end.size] + to_end).min())
        if least > cutoff:
            continue
        order = (here, *following)
        if len(order) == n:
            orders[order] = least
            if len(orders) > _MOST_ORDERS:
                return None
            continue
        others = passed ^ (1 << here)
        ends = slice(begin[here], begin[here + 1])
        for before in range(n):
            if others >> before & 1:
                way = legs.costs[begin[before] : begin[before + 1], ends]
                open_ends.append((others, before, order, (way + to_end).min(axis=1)))
    return orders


def _states(legs: Legs, to_go: ToGo, cutoff: float, effort: Effort) -> _Levels | None:
    """States that may end within the cutoff.

    Returns a dict for each size of set, with costs by set and last point. None if there are too
    many states.
    """
    begin = legs.begin
    n = begin.size - 1
    most = int(np.diff(begin).max())
    remembered = _sets_of(to_go.near)
    sets = np.left_shift(np.int64(1), np.arange(n))
    lasts = np.arange(n)
    costs = np.full((n, most), math.inf)
    for i in range(n):
        starts = legs.starts[begin[i] : begin[i + 1]]
        costs[i, : starts.size] = starts
    levels = []
    for k in range(n):
        ahead = to_go.costs[n - 1 - k]
        within = leave_out(sets, lasts, costs, ahead, remembered, begin, to_go.prices, cutoff)
        sets = sets[within]
        lasts = lasts[within]
        costs = costs[within]
        if sets.size * n > _MOST_STATES:
            return None
        keys = zip(sets.tolist(), lasts.tolist(), strict=True)
        levels.append(dict(zip(keys, costs, strict=True)))
        effort.spend_or_end(sets.size * n * most**2 * CHAIN_BOXES)
        sets, lasts, costs = extended(sets, lasts, costs, legs.costs, begin)
        sets, lasts, costs = _united(sets, lasts, costs)
    return levels


def _sets_of(near: IntArray) -> SetArray:
    """Sets of points that the memories stand for.

    Shape (points, memories).
    """
    memories = np.arange(1 << near.shape[1])
    has = memories[:, None] >> np.arange(near.shape[1]) & 1
    sets: SetArray = (has[None] << near[:, None, :]).sum(axis=2)
    return sets


def _united(
    sets: SetArray, lasts: IntArray, costs: FloatArray
) -> tuple[SetArray, IntArray, FloatArray]:
    """Unite states of one set and last point.

    The least costs are kept.
    """
    if not sets.size:
        return sets, lasts, costs
    order = np.lexsort((lasts, sets))
    sets = sets[order]
    lasts = lasts[order]
    new = np.append(True, (np.diff(sets) != 0) | (np.diff(lasts) != 0))
    begins = np.flatnonzero(new)
    return sets[begins], lasts[begins], np.minimum.reduceat(costs[order], begins)

"""Compiled loops of the search for tours.

They compute bounds between points, chains, and sets of points. A point has some intervals of
headings; `begin` says where those of each point begin, shape (points + 1,). A chain goes from
interval to interval, from one point to another: its cost is the sum of the bounds of its legs. A
chain remembers only a few of the points that it has passed, and may come back to the others. So the
cheapest chain costs no more than any tour (docs/derivation.md, section 18). Everything is in units
of the turning radius, headings in radians.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.arrays import BoolArray, FloatArray, IntArray
from dubins_study.study.closed_form.kernel_compile import compiled
from dubins_study.study.route.box import Box
from dubins_study.study.route.leg_bound import box_bound

SetArray = NDArray[np.int64]  # of sets of points: bit i is that of point i
_NO_POINT = -1


@compiled
def bounds_between(
    points: FloatArray,
    begin: IntArray,
    intervals: tuple[FloatArray, FloatArray, FloatArray],
    new: BoolArray,
    row: int,
    bounds: FloatArray,
) -> None:
    """Write bounds of the legs from one point.

    The legs go from the point's intervals to those of all points.

    Args:
        intervals: middles, halves of widths and slopes of the potential.
        new: mask of the pairs to be bounded, shape (intervals, intervals).
        row: the point.
        bounds: written where `new`, shape (intervals, intervals).
    """
    middle, half, slope = intervals
    for other in range(points.shape[0]):
        x = points[other, 0] - points[row, 0]
        y = points[other, 1] - points[row, 1]
        for p in range(begin[row], begin[row + 1]):
            for q in range(begin[other], begin[other + 1]):
                if new[p, q]:
                    box = Box(x, y, middle[p], half[p], slope[p], middle[q], half[q], slope[q], 0)
                    bounds[p, q] = box_bound(box)[0]


@compiled
def memories_after(near: IntArray) -> IntArray:
    """Memory of a chain after each next point.

    Element [here, memory, there] is the memory at `there` of a chain that comes from `here`. It is
    -1 if the chain remembers `there`, since then it does not go there. A memory at a point is a set
    of its near points: bit k is that of `near[point, k]`. Bit 0 is the point itself and always set,
    so that memories are odd.
    """
    n, size = near.shape
    after = np.full((n, 1 << size, n), _NO_POINT)
    for here in range(n):
        for memory in range(1, 1 << size, 2):
            for there in range(n):
                remembered = False
                following = 1
                for k in range(size):
                    if memory >> k & 1:
                        remembered |= near[here, k] == there
                        for slot in range(1, size):
                            if near[there, slot] == near[here, k]:
                                following |= 1 << slot
                if not remembered:
                    after[here, memory, there] = following
    return after


@compiled
def first_chains(
    begin: IntArray, after: IntArray, starts: FloatArray, prices: FloatArray
) -> FloatArray:
    """Costs of chains of one point.

    The array has room for longer ones.

    Args:
        after: `memories_after`.
        starts: bounds from the start, shape (intervals,).
        prices: shape (points,).

    Returns:
        Shape (points, memories, intervals). Element [k, memory, interval] is the least cost of
        chains of k + 1 points that end there with this memory; infinite for k > 0.
    """
    n = after.shape[0]
    memories = after.shape[1]
    costs = np.full((n, memories, starts.size), math.inf)
    for i in range(n):
        for p in range(begin[i], begin[i + 1]):
            costs[0, 1, p] = starts[p] - prices[i]
    return costs


@compiled
def _leave_out_dearer(costs: FloatArray, first: int, end: int) -> None:
    """Leave out chains that another chain makes needless.

    The other chain costs no more and remembers fewer of the same points. It can go on wherever the
    first can, and as cheaply. The costs left out become infinite.
    """
    memories = costs.shape[0]
    fewer = np.full((memories, end - first), math.inf)
    for memory in range(1, memories, 2):
        bit = 2
        while bit < memories:
            if memory & bit:
                less = memory ^ bit
                for p in range(first, end):
                    least = min(costs[less, p], fewer[less, p - first])
                    fewer[memory, p - first] = min(fewer[memory, p - first], least)
            bit *= 2
        for p in range(first, end):
            if fewer[memory, p - first] <= costs[memory, p]:
                costs[memory, p] = math.inf


@compiled
def extend_chains(
    costs: FloatArray,
    k: int,
    bounds: FloatArray,
    goes: BoolArray,
    begin: IntArray,
    after: IntArray,
    prices: FloatArray,
) -> None:
    """Write least costs of chains with another point.

    `costs[k + 1]` is filled: chains of k + 2 points, less the prices of their points. In `costs[k]`
    chains that others make needless become infinite.

    Args:
        costs: `first_chains`, with those of k + 1 points.
        bounds: of legs, shape (intervals, intervals).
        goes: whether a chain can go on from an interval to a point, shape (intervals, points).
        after: `memories_after`.
        prices: shape (points,).
    """
    n = after.shape[0]
    memories = after.shape[1]
    for here in range(n):
        first, end = begin[here], begin[here + 1]
        _leave_out_dearer(costs[k], first, end)
        for memory in range(1, memories, 2):
            if not costs[k, memory, first:end].min() < math.inf:
                continue
            for there in range(n):
                following = after[here, memory, there]
                if following == _NO_POINT:
                    continue
                target = costs[k + 1, following]
                for p in range(first, end):
                    cost = costs[k, memory, p] - prices[there]
                    if not (goes[p, there] and cost < math.inf):
                        continue
                    for q in range(begin[there], begin[there + 1]):
                        total = cost + bounds[p, q]
                        target[q] = total if total < target[q] else target[q]


@compiled
def cheapest_chain(
    costs: FloatArray,
    bounds: FloatArray,
    begin: IntArray,
    after: IntArray,
    ends: FloatArray,
) -> IntArray:
    """Points of the cheapest chain, first to last.

    A point may be passed more than once. `costs` are those of `first_chains`, extended by
    `extend_chains`.
    """
    n = after.shape[0]
    memories = after.shape[1]
    owner = np.empty(ends.size, np.int64)
    for i in range(n):
        owner[begin[i] : begin[i + 1]] = i
    least = math.inf
    memory = 1
    place = 0
    for m in range(1, memories, 2):
        for p in range(ends.size):
            total = costs[n - 1, m, p] + ends[p]
            if total < least:
                least = total
                memory = m
                place = p
    chain = np.empty(n, np.int64)
    for k in range(n - 1, -1, -1):
        chain[k] = owner[place]
        least = math.inf
        memory_before = 1
        place_before = 0
        for p in range(ends.size):
            for m in range(1, memories, 2):
                if k > 0 and after[owner[p], m, owner[place]] == memory:
                    total = costs[k - 1, m, p] + bounds[p, place]
                    if total < least:
                        least = total
                        memory_before = m
                        place_before = p
        memory = memory_before
        place = place_before
    return chain


@compiled
def cheapest_through(ahead: FloatArray, bounds: FloatArray, behind: FloatArray) -> FloatArray:
    """Least cost of a chain through each pair.

    Pairs are of intervals: shape (intervals, intervals).

    Args:
        ahead: least costs of chains of k + 1 points that end in an interval, over all memories.
        behind: the same backwards, from the tour's end.
    """
    n, size = ahead.shape
    through = np.full((size, size), math.inf)
    for k in range(n - 1):
        for p in range(size):
            for q in range(size):
                total = ahead[k, p] + bounds[p, q] + behind[n - 2 - k, q]
                through[p, q] = total if total < through[p, q] else through[p, q]
    return through


@compiled
def extended(
    sets: SetArray, lasts: IntArray, costs: FloatArray, bounds: FloatArray, begin: IntArray
) -> tuple[SetArray, IntArray, FloatArray]:
    """States that have passed one more point.

    A state is a set of passed points, its last point, and costs by that point's intervals.

    Args:
        sets, lasts: shape (states,).
        costs: shape (states, most intervals of a point).
    """
    n = begin.size - 1
    most = costs.shape[1]
    room = 0
    for state in range(sets.size):
        for there in range(n):
            room += 1 - (sets[state] >> there & 1)
    new_sets = np.empty(room, np.int64)
    new_lasts = np.empty(room, np.int64)
    new_costs = np.full((room, most), math.inf)
    count = 0
    for state in range(sets.size):
        here = lasts[state]
        for there in range(n):
            if sets[state] >> there & 1:
                continue
            new_sets[count] = sets[state] | (1 << there)
            new_lasts[count] = there
            row = new_costs[count]
            for p in range(begin[here + 1] - begin[here]):
                cost = costs[state, p]
                for q in range(begin[there + 1] - begin[there]):
                    total = cost + bounds[begin[here] + p, begin[there] + q]
                    row[q] = total if total < row[q] else row[q]
            count += 1
    return new_sets, new_lasts, new_costs


@compiled
def leave_out(
    sets: SetArray,
    lasts: IntArray,
    costs: FloatArray,
    to_go: FloatArray,
    remembered: SetArray,
    begin: IntArray,
    prices: FloatArray,
    cutoff: float,
) -> BoolArray:
    """Mask of states that may end within the cutoff.

    Costs from which no chain ends within it become infinite, in place.

    Args:
        to_go: costs of chains backwards, for all points that are left and the last one.
        remembered: the points of each memory, shape (points, memories).
    """
    within = np.zeros(sets.size, np.bool_)
    for state in range(sets.size):
        here = lasts[state]
        # the chains backwards have earned the prices of the points left, and of this one
        paid = prices[here]
        for i in range(prices.size):
            if not (sets[state] >> i & 1):
                paid += prices[i]
        for place in range(begin[here + 1] - begin[here]):
            least = math.inf
            for memory in range(1, remembered.shape[1], 2):
                # the chain backwards may remember no point of the set but this one
                if remembered[here, memory] & sets[state] == 1 << here:
                    least = min(least, to_go[memory, begin[here] + place])
            if costs[state, place] + least + paid <= cutoff:
                within[state] = True
            else:
                costs[state, place] = math.inf
    return within

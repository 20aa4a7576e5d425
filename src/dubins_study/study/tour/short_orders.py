"""Find short orders of a tour's points.

Exchanges on a grid of headings find them, and a proof begins with them. Everything is in units of
the turning radius, headings in radians.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.spatial.distance import cdist

from dubins_study.study.arrays import FloatArray, IntArray
from dubins_study.study.closed_form.kernel_compile import compiled
from dubins_study.study.route.effort import Effort
from dubins_study.study.route.heading_grids import leg_table, shortest_leg
from dubins_study.study.tour.stops import Stops

_FEW = 12  # points up to which an order of straight lines is not tried
_ON_GRID = 100  # points up to which an order is improved with headings, not with straight lines
_IMPROVED = 200  # points up to which an order is improved at all
_SOME = 40  # points up to which there are more headings
_HEADINGS = 24  # at each point
_FEWER = 16
_MOST_ARCS = 24  # further ones of single arcs to near points, where there are more
_KICKED = 62  # points up to which an order is changed and shortened anew
_KICKS = 16  # how often
_NEARLY = 1.02  # times the best length on the grid; longer orders are not searched
CHAIN_BOXES = 2e-5  # boxes that take as long as one sum of two costs


class Legs(NamedTuple):
    """Costs of the legs between points.

    On a grid (`_heading_grid`) they are lengths between headings. In the proof (`tour.orders`) they
    are bounds of lengths between intervals of headings.
    """

    begin: IntArray  # where the headings or intervals of each point begin, shape (points + 1,)
    costs: FloatArray  # shape (headings, headings)
    starts: FloatArray  # from the start, shape (headings,)
    ends: FloatArray  # to the end, shape (headings,)


def short_orders(stops: Stops, effort: Effort) -> Iterator[tuple[int, ...]]:
    """Yield orders that may be short.

    Of more than `_FEW` points, the first order is by straight lines. Of up to `_ON_GRID` points,
    orders by lengths with headings follow, the best first.
    """
    n = len(stops.points)
    order = _nearest_neighbours(stops.points)
    if n <= _IMPROVED:
        _shorten(order, _straight_lines(stops), effort)
    if n > _FEW:
        yield tuple(order.tolist())
    if n > _ON_GRID:
        return
    grid = _heading_grid(stops, effort)
    length = _shorten(order, grid, effort)
    lengths = {tuple(order.tolist()): length}
    if n <= _KICKED:
        random = np.random.default_rng(0)  # so that the same tour is found every time
        for _ in range(_KICKS):
            order = _kicked(min(lengths, key=lengths.__getitem__), random)
            length = _shorten(order, grid, effort)
            lengths[tuple(order.tolist())] = length
    shortest = min(lengths.values())
    for candidate, length in sorted(lengths.items(), key=lambda item: item[1]):
        if length <= _NEARLY * shortest:
            yield candidate


def _kicked(order: tuple[int, ...], random: np.random.Generator) -> IntArray:
    """Order with two neighbouring parts exchanged.

    See Martin, Otto and Felten (1991).
    """
    cuts = random.choice(np.arange(1, len(order) + 1), 3)
    a, b, c = np.sort(cuts).tolist()
    return np.array([*order[:a], *order[b:c], *order[a:b], *order[c:]])


def _shorten(order: IntArray, grid: Legs, effort: Effort) -> float:
    """Shorten an order in place; return its length.

    It ends when no small change makes the order shorter.
    """
    length = math.inf
    sums = order.size * grid.starts.size**2
    while True:
        effort.spend_or_end(sums * CHAIN_BOXES)
        before = length
        # the fields of `Legs` are the other arguments, in their order
        length = float(better_order(order, *grid))
        if length == before:
            return length


def _straight_lines(stops: Stops) -> Legs:
    """Grid of straight lines between the points.

    Each point has one heading, which does not count.
    """
    points = stops.points
    ends = np.zeros(len(stops.points))
    if stops.target is not None:
        ends = np.hypot(*(points - stops.target).T)
    begin = np.arange(len(points) + 1)
    lengths = cdist(points, points)
    return Legs(begin, lengths, starts=np.hypot(*points.T), ends=ends)


def _nearest_neighbours(points: FloatArray) -> IntArray:
    """Order that goes to the nearest point left."""
    unvisited = list(range(len(points)))
    here = np.zeros(2)
    order = []
    while unvisited:
        away = np.hypot(*(points[unvisited] - here).T)
        following = unvisited.pop(int(away.argmin()))
        order.append(following)
        here = points[following]
    return np.array(order)


def _heading_grid(stops: Stops, effort: Effort) -> Legs:
    """Grid of headings at each point.

    Headings are spread evenly, and those of single arcs to near points are added.
    """
    n = len(stops.points)
    count = _FEWER
    if n <= _SOME:
        count = _HEADINGS
    evenly = np.linspace(-math.pi, math.pi, count, endpoint=False)
    sizes = [0]
    of_points = []
    for i, heading in enumerate(stops.headings):
        choices = evenly
        if heading is not None:
            choices = np.array([heading])
        elif n <= _SOME:
            arcs = _arc_headings(stops.points - stops.points[i])
            choices = np.append(evenly, arcs[:_MOST_ARCS])
        of_points.append(choices)
        sizes.append(choices.size)
    begin = np.cumsum(sizes)
    headings = np.concatenate(of_points)
    effort.spend_or_end(headings.size**2 / 10)
    lengths = lengths_between(stops.points, begin, headings)
    starts, ends = _to_ends(stops, begin, headings)
    return Legs(begin, lengths, starts=starts, ends=ends)


def _to_ends(stops: Stops, begin: IntArray, headings: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lengths from the start and to the end.

    Each array has one length for each heading of the grid.
    """
    circle = np.linspace(-math.pi, math.pi, 2 * _HEADINGS, endpoint=False)
    first = circle
    if stops.first is not None:
        first = np.array([stops.first])
    last = circle
    if stops.last is not None:
        last = np.array([stops.last])
    starts = np.zeros(headings.size)
    ends = np.zeros(headings.size)
    for i, point in enumerate(stops.points):
        part = slice(begin[i], begin[i + 1])
        here = headings[part]
        starts[part] = _lengths(point, first, here).min(axis=0)
        if stops.target is not None:
            ends[part] = _lengths(stops.target - point, here, last).min(axis=1)
    return starts, ends


def _lengths(way: FloatArray, first: FloatArray, last: FloatArray) -> FloatArray:
    lengths: FloatArray = leg_table(way, first, last, np.ones((first.size, last.size), np.int8))[0]
    return lengths


def _arc_headings(ways: FloatArray) -> FloatArray:
    """Headings with which one arc joins two points.

    The headings are those at one point; `ways` lead from there to the others, shape (n, 2). The arc
    goes to the other point or comes from it. Headings for nearer points come first.
    """
    distances = np.hypot(*ways.T)
    near = np.argsort(distances, kind="stable")
    near = near[(distances[near] > 0.0) & (distances[near] < 2.0)]
    chords = np.arctan2(ways[near, 1], ways[near, 0])
    halves = np.arcsin(0.5 * distances[near])
    to = (chords + halves, chords - halves, chords + math.pi - halves, chords - math.pi + halves)
    both = [*to, *(heading + math.pi for heading in to)]
    return np.array(both).T.ravel()


@compiled
def lengths_between(points: FloatArray, begin: IntArray, headings: FloatArray) -> FloatArray:
    """Shortest lengths between headings of different points.

    Shape (headings, headings).
    """
    lengths = np.full((headings.size, headings.size), math.inf)
    for i in range(points.shape[0]):
        for j in range(points.shape[0]):
            if i == j:
                continue
            x = points[j, 0] - points[i, 0]
            y = points[j, 1] - points[i, 1]
            for p in range(begin[i], begin[i + 1]):
                for q in range(begin[j], begin[j + 1]):
                    lengths[p, q] = shortest_leg(x, y, headings[p], headings[q])[0]
    return lengths


@compiled
def _go(
    costs: FloatArray,
    here: int,
    there: int,
    lengths: FloatArray,
    begin: IntArray,
    following: FloatArray,
) -> None:
    """Write least costs of going on to a point.

    `following` is filled at the headings of the point `there`, from `costs` at those of the point
    `here`.
    """
    first, end = begin[there], begin[there + 1]
    following[first:end] = math.inf
    for p in range(begin[here], begin[here + 1]):
        for q in range(first, end):
            total = costs[p] + lengths[p, q]
            following[q] = total if total < following[q] else following[q]


@compiled
def _costs_along(
    order: IntArray,
    lengths: FloatArray,
    begin: IntArray,
    starts: FloatArray,
    costs: FloatArray,
) -> None:
    """Write least costs along an order.

    `costs` is filled at the headings of the order's points: the least cost up to each. `starts` are
    the costs at the first point.
    """
    first = slice(begin[order[0]], begin[order[0] + 1])
    costs[first] = starts[first]
    for k in range(1, order.size):
        _go(costs, order[k - 1], order[k], lengths, begin, costs)


_MOST_MOVED = 3  # points that change their place together
_SHORTER = 1e-9  # radii; a smaller gain is no reason for another order


@compiled
def better_order(
    order: IntArray, begin: IntArray, lengths: FloatArray, starts: FloatArray, ends: FloatArray
) -> float:
    """Shorten an order in place, once.

    Returns its length by the best headings. A part of it is turned round, or up to three points are
    moved to another place. Each change is tried once, so that a shorter order may be left: call it
    again as long as the length decreases.
    """
    n = order.size
    back = np.ascontiguousarray(lengths.T)
    ahead = np.empty(starts.size)
    behind = np.empty(starts.size)
    costs = np.empty(starts.size)
    _costs_along(order, lengths, begin, starts, ahead)
    _costs_along(order[::-1], back, begin, ends, behind)
    least = (starts + behind)[begin[order[0]] : begin[order[0] + 1]].min()
    for i in range(n):
        for j in range(i + 1, n):
            for moved in range(-_MOST_MOVED, min(_MOST_MOVED, j - i) + 1):
                # moved points of order[i : j + 1] go from its front to its end, or back
                size = abs(moved)
                if size > j - i:
                    continue
                part = order[i : j + 1].copy()
                if moved == 0:
                    part[:] = order[i : j + 1][::-1]
                elif moved > 0:
                    part[: part.size - size] = order[i + size : j + 1]
                    part[part.size - size :] = order[i : i + size]
                else:
                    part[:size] = order[j + 1 - size : j + 1]
                    part[size:] = order[i : j + 1 - size]
                if i == 0:
                    _costs_along(part, lengths, begin, starts, costs)
                else:
                    _go(ahead, order[i - 1], part[0], lengths, begin, costs)
                    _costs_along(part, lengths, begin, costs, costs)
                last = slice(begin[part[-1]], begin[part[-1] + 1])
                if j == n - 1:
                    length = (costs[last] + ends[last]).min()
                else:
                    _go(costs, part[-1], order[j + 1], lengths, begin, costs)
                    last = slice(begin[order[j + 1]], begin[order[j + 1] + 1])
                    length = (costs[last] + behind[last]).min()
                if length < least - _SHORTER:
                    least = length
                    order[i : j + 1] = part
                    _costs_along(order, lengths, begin, starts, ahead)
                    _costs_along(order[::-1], back, begin, ends, behind)
    return float(least)

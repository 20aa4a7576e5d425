"""The shortest order of places by straight lines."""

from __future__ import annotations

import math
from collections.abc import Iterator
from time import perf_counter

import numpy as np

from dubins_study.solvers.tour.places import Places
from dubins_study.study.arrays import FloatArray

_MOST_EXACT = 12  # via points whose subsets are all tried
_MOST_MOVED = 3  # neighbours that are moved together
_SHORTER = 1e-12  # of the length; less is no reason for another order


def euclidean_order(places: Places, until: float) -> list[int]:
    """The shortest order of places by straight lines.

    The start is first. The order is exact up to 12 via points. With more of them it is improved
    until no change helps, or until the time `until` (s, on `perf_counter`).
    """
    m = places.count
    via = list(range(1, m - places.with_target))
    if places.in_order or len(via) < 2:
        return list(range(m))
    between = np.hypot(*(places.points[:, None] - places.points[None]).T)
    last = [m - 1] * places.with_target  # empty without a target
    if len(via) > _MOST_EXACT:
        return _improved(places, [0, *_nearest(between, via), *last], until)
    ends = np.zeros(m)
    if places.with_target:
        ends = between[:, m - 1]
    elif places.closed:
        ends = between[:, 0]
    order = _exact(between[0, via], between[np.ix_(via, via)], ends[via])
    return [0, *(via[i] for i in order), *last]


def _exact(starts: FloatArray, between: FloatArray, ends: FloatArray) -> list[int]:
    """The shortest order of n points, as indices.

    The distances are `starts` (n,) from the start, `between` (n, n) from point to point, and `ends`
    (n,) to the end. A dynamic program over subsets finds the order (Held and Karp 1962). Its
    costs[s, i] are those from the start through the points whose bits are set in s, to the point i.
    """
    n = starts.size
    costs = np.full((1 << n, n), math.inf)
    before = np.zeros((1 << n, n), np.int64)
    costs[1 << np.arange(n), np.arange(n)] = starts
    for subset in range(1, 1 << n):
        through = costs[subset][:, None] + between
        for i in range(n):
            if not subset >> i & 1:
                costs[subset | 1 << i, i] = through[:, i].min()
                before[subset | 1 << i, i] = through[:, i].argmin()
    remaining = (1 << n) - 1
    order = [int((costs[remaining] + ends).argmin())]
    while len(order) < n:
        last = order[0]
        order.insert(0, int(before[remaining, last]))
        remaining ^= 1 << last
    return order


def _nearest(between: FloatArray, via: list[int]) -> list[int]:
    """The order that goes on to the nearest place.

    The via points are sorted: first the one nearest to the start, then always the one nearest to
    the point before. The start is not in the result.
    """
    remaining = list(via)
    order: list[int] = []
    here = 0
    while remaining:
        here = min(remaining, key=lambda place: between[here, place])
        remaining.remove(here)
        order.append(here)
    return order


def _improved(places: Places, order: list[int], until: float) -> list[int]:
    """The order, improved by local changes.

    Parts are turned round (2-opt, Croes 1958) or moved (Or 1976) until no change makes the order
    shorter, or until the time `until`.
    """
    length = _length(places, order)
    again = True
    while again:
        again = False
        for i in range(1, len(order)):
            if perf_counter() > until:
                return order
            for trial in _changed(order, i, len(order) - places.with_target):
                changed = _length(places, trial)
                if changed < length * (1.0 - _SHORTER):
                    order = trial
                    length = changed
                    again = True
    return order


def _changed(order: list[int], i: int, end: int) -> Iterator[list[int]]:
    """Orders with one changed part that begins at i.

    The part is turned round, or up to three places move from one of its ends to the other. The part
    ends before `end` at the latest.
    """
    for j in range(i + 2, end + 1):
        part = order[i:j]
        moved = [part[k:] + part[:k] for k in range(-_MOST_MOVED, _MOST_MOVED + 1)]
        for changed in (part[::-1], *moved):
            yield order[:i] + changed + order[j:]


def _length(places: Places, order: list[int]) -> float:
    return float(np.hypot(*places.steps(order).T).sum())

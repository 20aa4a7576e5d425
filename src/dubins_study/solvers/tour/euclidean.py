"""The shortest order of places by straight lines."""

from __future__ import annotations

import math
from time import perf_counter

import numpy as np

from dubins_study.solvers.tour.places import Places
from dubins_study.study.arrays import FloatArray

_MOST_EXACT = 12  # via points whose subsets are all tried
_MOST_MOVED = 3  # neighbours that are moved together
_SHORTER = 1e-12  # of the length; less is no reason for another order


def euclidean_order(places: Places, until: float) -> list[int]:
    """The places in the order that is shortest by straight lines, the start first.

    It is exact up to 12 via points, else improved until nothing does, or a time (s, on
    `perf_counter`).
    """
    m = places.count
    via = list(range(1, m - places.with_target))
    if places.in_order or len(via) < 2:
        return list(range(m))
    between = np.hypot(*(places.points[:, None] - places.points[None]).T)
    ends = np.zeros(m)
    if places.with_target:
        ends = between[:, m - 1]
    elif places.closed:
        ends = between[:, 0]
    if len(via) <= _MOST_EXACT:
        order = _exact(between[0, via], between[np.ix_(via, via)], ends[via])
        tour = [via[i] for i in order]
    else:
        tour = _improved(between, ends, _nearest(between, via), until)
    return [0, *tour, m - 1] if places.with_target else [0, *tour]


def _exact(starts: FloatArray, between: FloatArray, ends: FloatArray) -> list[int]:
    """The shortest order of n points by a program over their subsets (Held and Karp 1962)."""
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
    left = (1 << n) - 1
    order = [int((costs[left] + ends).argmin())]
    while len(order) < n:
        last = order[0]
        order.insert(0, int(before[left, last]))
        left ^= 1 << last
    return order


def _nearest(between: FloatArray, via: list[int]) -> list[int]:
    """From each place on to the nearest one that is left."""
    left = list(via)
    order: list[int] = []
    here = 0
    while left:
        here = min(left, key=lambda place: between[here, place])
        left.remove(here)
        order.append(here)
    return order


def _improved(between: FloatArray, ends: FloatArray, order: list[int], until: float) -> list[int]:
    """The order with parts turned round, and up to three neighbours moved, while it gets shorter.

    Croes 1958 (2-opt), Or 1976.
    """
    length = _length(between, ends, order)
    again = True
    while again:
        again = False
        for i in range(len(order)):
            if perf_counter() > until:
                return order
            for trial in _changed(order, i):
                changed = _length(between, ends, trial)
                if changed < length * (1.0 - _SHORTER):
                    order = trial
                    length = changed
                    again = True
    return order


def _changed(order: list[int], i: int) -> list[list[int]]:
    """Orders with a part from the place i on turned round, or moved elsewhere."""
    n = len(order)
    changed = [order[:i] + order[i : j + 1][::-1] + order[j + 1 :] for j in range(i + 1, n)]
    for size in range(1, _MOST_MOVED + 1):
        part = order[i : i + size]
        rest = order[:i] + order[i + size :]
        for place in range(len(rest) + 1):
            changed.append(rest[:place] + part + rest[place:])
            changed.append(rest[:place] + part[::-1] + rest[place:])
    return changed


def _length(between: FloatArray, ends: FloatArray, order: list[int]) -> float:
    passed = np.array([0, *order])
    return float(between[passed[:-1], passed[1:]].sum() + ends[order[-1]])

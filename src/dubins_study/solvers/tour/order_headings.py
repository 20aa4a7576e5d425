"""The best headings of one order: dynamic programs over grids, finer and finer about the best."""

from __future__ import annotations

import math
from time import perf_counter

import numpy as np

from dubins_study.solvers.route.grid import Layers, layers_between
from dubins_study.solvers.tour.places import Places
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray

_OFFSETS = np.linspace(-1.0, 1.0, 9)  # of a finer grid, in widths of the one before
_FINER = 0.6  # of one grid's width to the next
_FINEST = 1e-9  # rad


def headings_on_grid(places: Places, order: list[int], count: int) -> FloatArray:
    """The best headings of an order with this many at each place; shape (legs + 1,)."""
    grid = places.headings(count)
    return _best(places, order, [grid[place] for place in order])


def polished(
    places: Places, order: list[int], headings: FloatArray, count: int, until: float = math.inf
) -> FloatArray:
    """Headings of a grid of this many, improved on finer and finer ones, down to 1e-9 rad.

    It ends early at a time (s, on `perf_counter`).
    """
    free = [places.given[place] is None for place in order]
    width = TWO_PI / count
    while width > _FINEST and perf_counter() < until:
        about = [
            heading + width * _OFFSETS if is_free else np.array([heading])
            for heading, is_free in zip(headings, free, strict=False)
        ]
        headings = _best(places, order, about)
        width *= _FINER
    return headings


def _best(places: Places, order: list[int], candidates: list[FloatArray]) -> FloatArray:
    """The best of some headings at each place of an order."""
    steps = places.steps(order)
    if not places.closed:
        return layers_between(candidates, steps).shortest()
    found = layers_between([*candidates, candidates[0]], steps)
    best = np.empty(0)
    least = math.inf
    for k in range(candidates[0].size):  # a closed tour ends with the heading that it began with
        inner = found.lengths[1:-1]
        lengths = [found.lengths[0][k : k + 1], *inner, found.lengths[-1][:, k : k + 1]]
        same = candidates[0][k : k + 1]
        closed = Layers([same, *found.headings[1:-1], same], lengths)
        length = closed.least()
        if length < least:
            least = length
            best = closed.shortest()
    return best

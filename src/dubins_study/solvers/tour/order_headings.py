"""The best headings of one order.

Dynamic programs find them on grids, finer and finer about the best.
"""

from __future__ import annotations

import math
from itertools import pairwise
from time import perf_counter
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.legs import legs
from dubins_study.solvers.tour.places import Places
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray

_OFFSETS = np.linspace(-1.0, 1.0, 9)  # of a finer grid, in widths of the one before
_FINER = 0.6  # of one grid's width to the next
_FINEST = 1e-9  # rad


class Layers(NamedTuple):
    """Headings at the points, and lengths between them.

    For n legs there are n + 1 arrays of headings (rad), and n arrays of lengths (radii) with shape
    (headings before, after).
    """

    headings: list[FloatArray]
    lengths: list[FloatArray]

    def least(self) -> float:
        """The length of the shortest path through the layers."""
        least = np.zeros(1)
        for lengths in self.lengths:
            least = (least[:, None] + lengths).min(axis=0)
        return float(least.min())

    def shortest(self) -> FloatArray:
        """The headings of the shortest path.

        A dynamic program finds it in the layers.
        """
        least = np.zeros(1)
        chosen = []
        for lengths in self.lengths:
            through = least[:, None] + lengths
            chosen.append(through.argmin(axis=0))
            least = through.min(axis=0)
        place = int(least.argmin())
        places = [place]
        for before in reversed(chosen):
            place = int(before[place])
            places.insert(0, place)
        pairs = zip(self.headings, places, strict=True)
        return np.array([headings[place] for headings, place in pairs])


def layers_between(headings: list[FloatArray], steps: FloatArray) -> Layers:
    """The layers of some headings at each point.

    The points are `steps` apart, shape (n, 2), in radii.
    """
    lengths = []
    for (before, after), (x, y) in zip(pairwise(headings), steps, strict=True):
        # every heading before with every heading after
        a, b = (each.ravel() for each in np.meshgrid(before, after, indexing="ij"))
        segments, _ = legs(np.full(a.size, x), np.full(a.size, y), a, b)
        lengths.append(segments.sum(axis=0).reshape(before.size, after.size))
    return Layers(headings, lengths)


def headings_on_grid(places: Places, order: list[int], count: int) -> FloatArray:
    """The best headings of an order on a grid.

    The grid has `count` headings at each place. Shape (legs + 1,).
    """
    grid = places.headings(count)
    return _best(places, order, [grid[place] for place in order])


def polished(
    places: Places, order: list[int], headings: FloatArray, count: int, until: float = math.inf
) -> FloatArray:
    """The headings of a grid, improved off it.

    The grid had `count` headings at each place. Finer and finer ones follow, down to 1e-9 rad. The
    search ends early at the time `until` (s, on `perf_counter`).
    """
    free = [k for k, place in enumerate(order) if places.given[place] is None]
    width = TWO_PI / count
    while width > _FINEST and perf_counter() < until:
        candidates = [np.array([heading]) for heading in headings[: len(order)]]
        for k in free:
            candidates[k] = headings[k] + width * _OFFSETS
        headings = _best(places, order, candidates)
        width *= _FINER
    return headings


def _best(places: Places, order: list[int], candidates: list[FloatArray]) -> FloatArray:
    """The best choice among candidates at each place.

    Returns the headings (rad), shape (legs + 1,).
    """
    steps = places.steps(order)
    if not places.closed:
        return layers_between(candidates, steps).shortest()
    layers = layers_between([*candidates, candidates[0]], steps)
    loops = []
    for k in range(candidates[0].size):  # a closed tour ends with the heading that it began with
        end_heading = candidates[0][k : k + 1]
        first = layers.lengths[0][k : k + 1]
        last = layers.lengths[-1][:, k : k + 1]
        headings = [end_heading, *layers.headings[1:-1], end_heading]
        loops.append(Layers(headings, [first, *layers.lengths[1:-1], last]))
    return min(loops, key=Layers.least).shortest()

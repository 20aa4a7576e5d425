"""Points of a tour, seen from its start.

Lengths are in radii.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from dubins_study.study.arrays import FloatArray


class Stops(NamedTuple):
    """Points that a tour passes, and their headings.

    They are seen from the start.
    """

    points: FloatArray  # via points, shape (n, 2)
    headings: Sequence[float | None]  # at the via points; None where free
    first: float | None  # heading at the start; None if free
    target: tuple[float, float] | None  # None: the tour ends at whichever point comes last
    last: float | None  # heading at the target; None if free
    closed: bool = False  # whether the tour ends with the heading that it starts with, both free

    def route(self, order: Sequence[int]) -> tuple[FloatArray, list[float | None]]:
        """Points and headings of one order.

        Both begin at the start.
        """
        points = np.vstack([np.zeros(2), self.points[list(order)]])
        headings = [self.first, *(self.headings[i] for i in order)]
        if self.target is None:
            return points, headings
        return np.vstack([points, self.target]), [*headings, self.last]

    def begun_at(self, place: int) -> Stops:
        """The same loop, begun at another point.

        The new start is via point `place`, which has a heading. The old start becomes the first via
        point.
        """
        others = np.delete(self.points, place, axis=0)
        around = np.vstack([np.zeros(2), others]) - self.points[place]
        headings = [None, *self.headings]
        heading = headings.pop(place + 1)
        return Stops(around, headings, first=heading, target=(0.0, 0.0), last=heading)

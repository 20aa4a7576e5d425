"""First intervals of headings for the certified search.

They cover the circle at each point. A point may lie on the turning circle of a heading that is
given. Then only one heading there is the end of an arc, and it has an interval of its own. For all
other pairs of headings it is known which words they cannot have (docs/derivation.md, section 16).
Everything is in units of the turning radius, headings in radians.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.route.box import (
    END_HALF,
    END_LEFT,
    END_RIGHT,
    START_HALF,
    START_LEFT,
    START_RIGHT,
)
from dubins_study.study.route.leg_bound import WordArray

COARSE = 16  # intervals at each point to begin with
OVERLAP = 1e-14  # rad; more than the rounding of an interval's ends
# square radii; more than rounding changes the power of a point to a turning circle
_ON_CIRCLE = 16.0 * EPS
_ONE_HEADING = 2e-15  # rad; more than the rounding of a heading to which an arc leads


class Intervals(NamedTuple):
    """Intervals of headings at a point.

    Three arrays have the middle, half the width (rad) and the potential's slope of each.
    """

    middle: FloatArray
    half: FloatArray
    slope: FloatArray

    def at(self, places: Any) -> Intervals:
        """The intervals at some places."""
        return Intervals(*(column[places] for column in self))

    def halved(self, side: FloatArray) -> Intervals:
        """Lower (side -0.5) or upper (0.5) halves.

        The whole interval where the side is 0.
        """
        half = np.where(side == 0.0, self.half, 0.5 * self.half + OVERLAP)
        return Intervals(self.middle + side * self.half, half, self.slope)


class _Arc(NamedTuple):
    """An arc between neighbouring points.

    It leads from a known heading to the only one that it can end with.
    """

    ends: tuple[int, int]  # the point with the known heading, and the other
    place: int  # of the known heading among those of its point
    others: list[int]  # places of the heading at the other end; none if another one is given there
    apart: int  # `Box.apart` of the heading's pairs with any other


def first_intervals(
    legs: FloatArray, given: Sequence[float | None]
) -> tuple[list[Intervals], list[WordArray]]:
    """Intervals at each point, and their pairs.

    The second value is an array a leg, shape (intervals at its start, intervals at its end). It has
    the form of `live` in `bound_leg`: 1 and twice `Box.apart`.

    Args:
        legs: from each point to the next, shape (n, 2).
        given: headings at the points, n + 1; None for those that are free.
    """
    known: list[list[float]] = []
    for heading in given:
        known.append([])
        if heading is not None:
            known[-1].append(math.remainder(heading, TWO_PI))
    arcs = [*_arcs(legs, given, known, step=1), *_arcs(legs, given, known, step=-1)]
    intervals = []
    for heading, headings in zip(given, known, strict=True):
        if heading is None:
            width = TWO_PI / COARSE
            grid = np.linspace(0.5 * width - math.pi, math.pi - 0.5 * width, COARSE)
            half = np.full(COARSE + len(headings), 0.5 * width + OVERLAP)
            half[COARSE:] = _ONE_HEADING
            intervals.append(Intervals(np.append(grid, headings), half, np.zeros(half.size)))
        else:
            # the double of 2 pi is less than 2 pi by 2.45e-16
            spread = 2.5e-16 * abs(heading - headings[0]) / TWO_PI
            intervals.append(Intervals(np.array(headings), np.array([spread]), np.zeros(1)))
    live = [np.ones((a.middle.size, b.middle.size), np.int8) for a, b in pairwise(intervals)]
    for arc in arcs:
        # known headings come behind the intervals of a free point
        here, there = (intervals[i].middle.size - len(known[i]) for i in arc.ends)
        pairs = live[min(arc.ends)]
        if arc.ends[0] > arc.ends[1]:
            pairs = pairs.T
        row = pairs[here + arc.place]
        row += 2 * arc.apart
        # the pair of the arc's own two headings can have all words
        row[[there + k for k in arc.others]] -= 2 * arc.apart
    return intervals, live


def _arcs(
    legs: FloatArray, given: Sequence[float | None], known: list[list[float]], step: int
) -> Iterator[_Arc]:
    """Arcs to the next or the previous point.

    They lead to the next point if `step` is 1, to the previous one if it is -1. The headings at
    their ends are added to `known`.
    """
    left_bit = START_LEFT
    right_bit = START_RIGHT
    half_bit = START_HALF
    if step < 0:
        left_bit = END_LEFT
        right_bit = END_RIGHT
        half_bit = END_HALF
    for leg in range(len(legs))[::step]:
        here, there = (leg, leg + 1)[::step]
        x, y = step * legs[leg]
        square = x * x + y * y
        for place, heading in enumerate(known[here]):
            side = y * math.cos(heading) - x * math.sin(heading)
            # whether the other point is on the left or right turning circle of the heading
            left = abs(square - 2.0 * side) <= _ON_CIRCLE
            right = abs(square + 2.0 * side) <= _ON_CIRCLE
            if not (left or right):
                continue
            end = math.remainder(2.0 * math.atan2(y, x) - heading, TWO_PI)
            away = [abs(math.remainder(some - end, TWO_PI)) for some in known[there]]
            if given[there] is None and min(away, default=math.inf) > _ONE_HEADING:
                known[there].append(end)
                away.append(0.0)
            others = [k for k, off in enumerate(away) if off <= _ONE_HEADING]
            apart = right_bit
            if left:
                apart = left_bit
            if abs(square - 4.0) <= _ON_CIRCLE:
                apart += half_bit
            yield _Arc((here, there), place, others, apart)

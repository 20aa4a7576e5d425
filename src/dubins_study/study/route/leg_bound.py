"""Proven lower bound of a leg's length.

Each end of the leg has an interval of headings. The bound is the least over the six words
(`csc_bound`, `lrl_bound`). Everything is in units of the turning radius.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.arrays import BoolArray, FloatArray, IntArray
from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.route.box import LONGEST_COSTATE, Box, mirrored
from dubins_study.study.route.csc_bound import csc_bound
from dubins_study.study.route.leg_words import between, principal, straight_direction, turns
from dubins_study.study.route.lrl_bound import lrl_bound

WordArray = NDArray[np.int8]
Ends = tuple[FloatArray, FloatArray, FloatArray]  # middles, halves of widths and slopes

_PI = math.pi
NO_WORD = -1


@separate
def box_bound(box: Box) -> tuple[float, int]:
    """Lower bound over a box, and its word.

    The bound is for the length plus the potential's slopes times the turns from the middle headings
    (see `Box`). The word is the one that gives the bound, as a place in `WORDS6`; `NO_WORD` if
    there is no path.
    """
    best = math.inf
    word = NO_WORD
    # RLR and LRL are shortest only where the ends are within 4 radii; 1e-12 is for rounding
    near = box.x * box.x + box.y * box.y < 16.0 + 1e-12
    # 0: the words LSL, LSR and LRL, at the places 0, 2 and 5 of `WORDS6`;
    # 1: their mirror images RSR, RSL and RLR, at 1, 3 and 4
    for image in range(2):
        if image == 1:
            box = mirrored(box)
        value = csc_bound(box, 1.0, best)
        if value < best:
            best = value
            word = image
        value = csc_bound(box, -1.0, best)
        if value < best:
            best = value
            word = 2 + image
        if near:
            value = lrl_bound(box)
            if value < best:
                best = value
                word = 5 - image
    return best, word


@separate
def _box(leg: FloatArray, first: Ends, last: Ends, i: int, j: int, live: int) -> Box:
    """Box of two intervals of a leg.

    Interval i is at its start and j at its end. `live` is 1 and twice `Box.apart`.
    """
    c1, h1, slope1 = first
    c2, h2, slope2 = last
    return Box(leg[0], leg[1], c1[i], h1[i], slope1[i], c2[j], h2[j], slope2[j], live // 2)


@compiled
def bound_leg(
    leg: FloatArray,
    first: Ends,
    last: Ends,
    live: WordArray,
    bounds: FloatArray,
    words: WordArray,
) -> None:
    """Write `box_bound` of every live pair of intervals.

    The bound is infinite for the others.

    Args:
        leg: (x, y), the end seen from the start (radii).
        first, last: the intervals at both ends.
        live: 0 for pairs that are left out, else 1 and twice `Box.apart`.
        bounds, words: written. They and `live` have the shape (intervals at the start, intervals at
            the end).
    """
    for i in range(live.shape[0]):
        for j in range(live.shape[1]):
            bounds[i, j] = math.inf
            words[i, j] = NO_WORD
            if live[i, j]:
                box = _box(leg, first, last, i, j, live[i, j])
                bounds[i, j], words[i, j] = box_bound(box)


@separate
def _word_slopes(x: float, y: float, t1: float, t2: float, word: int) -> tuple[float, float]:
    """Derivatives of a word's length by both headings.

    The word exists or nearly does.
    """
    s1, s2 = turns(word)
    dx, dy = between(x, y, s1, s2, t1, t2)
    if word < 4:
        direction = straight_direction(dx, dy, s1, s2)
        return -s1 * (1.0 - math.cos(direction - t1)), s2 * (1.0 - math.cos(t2 - direction))
    axis = math.atan2(dy, dx)
    quarter = 0.0625 * (dx * dx + dy * dy)
    rho = 1.0 / math.sqrt(max(1.0 / LONGEST_COSTATE**2, 1.0 - quarter))
    return -s1 * (1.0 + rho * math.cos(t1 - axis)), s1 * (1.0 + rho * math.cos(t2 - axis))


_STEEPEST_BY_WORD = 2.0  # slope that a word with a straight asks for
UNKNOWN, BY_EDGE, BY_WORD = range(3)  # what a slope at one end of a leg is derived from


@separate
def _slope_across(
    x: float, y: float, t1: float, t2: float, reach: float, word: int, slope: float, forward: bool
) -> tuple[float, int]:
    """Slope of the potential that makes a leg flat.

    The leg is flat at its other end. The source of the slope is returned too.

    A word that may change in the box takes any slope at one end: the multiplier of its condition
    adapts, and gives the slope at the other end. Otherwise both slopes are the word's derivatives.
    """
    s1, s2 = turns(word)
    dx, dy = between(x, y, s1, s2, t1, t2)
    m = math.hypot(dx, dy)
    if word < 2 and m < 4.0 * reach:
        return math.nan, UNKNOWN
    turn = 0.0
    if word == 2 or word == 3:
        turn = s1 if m < 2.0 + 2.0 * reach else 0.0
    elif word >= 4 and m < 4.0:
        psi = _PI - math.asin(0.25 * m)
        axis = math.atan2(dy, dx)
        a, c = principal(psi + s1 * (axis - t1)), principal(psi + s1 * (t2 - axis))
        turn = -s1 if abs(a) < 2.0 * reach else s1 if abs(c) < 2.0 * reach else 0.0
    d1, d2 = _word_slopes(x, y, t1, t2, word)
    if turn != 0.0:
        dx, dy = between(x, y, turn, -turn, t1, t2)
        switch = math.atan2(dy, dx) + 0.5 * turn * _PI
        near, far = (t1, t2) if forward else (t2, t1)
        near, far = turn * (switch - near), turn * (switch - far)
        if math.isnan(slope) or min(abs(math.sin(near)), abs(math.sin(far))) < 1e-3 + 3.0 * reach:
            return math.nan, UNKNOWN
        kappa = turn * slope if forward else -turn * slope
        tau = (kappa - 1.0 + math.cos(near)) / math.sin(near)
        if tau > 0.0:
            other = 1.0 - math.cos(far) + tau * math.sin(far)
            return (-turn * other if forward else turn * other), BY_EDGE
    slope = d2 if forward else -d1
    if abs(slope) > _STEEPEST_BY_WORD:
        return math.nan, UNKNOWN
    return slope, BY_WORD


@compiled
def slopes_across(
    leg: FloatArray,
    first: Ends,
    last: Ends,
    words: WordArray,
    mates: IntArray,
    slopes: FloatArray,
    forward: bool,
) -> tuple[FloatArray, WordArray]:
    """Slopes of a leg's intervals, by `_slope_across`.

    Returns the slopes and their sources, at the leg's end if `forward`, else at its start.

    Args:
        words: of pairs of intervals, shape (intervals at the start, intervals at the end).
        mates: for each of these intervals, the one at the other end.
        slopes: of the intervals at the other end.
    """
    across = np.empty(mates.size)
    kinds = np.empty(mates.size, np.int8)
    for m in range(mates.size):
        i, j = (mates[m], m) if forward else (m, mates[m])
        c1 = first[0][i]
        c2 = last[0][j]
        reach = first[1][i] + last[1][j]
        across[m], kinds[m] = _slope_across(
            *(leg[0], leg[1], c1, c2, reach, words[i, j], slopes[mates[m]], forward)
        )
    return across, kinds


_STEEPEST = 2.5  # slope of the potential; a word with a straight asks for 2 at most


@compiled
def potential_slopes(
    interval: Ends,
    before: tuple[FloatArray, WordArray],
    after: tuple[FloatArray, WordArray],
    heading: float,
    best: float,
    everywhere: bool,
) -> FloatArray:
    """Slopes of the potential at a point's intervals.

    `before` and `after` are what both legs ask for, by `slopes_across`. Near the best route's
    heading, or `everywhere`, the slope is `best`, the best route's (NaN: unknown).
    """
    middle, half, slope = interval
    rise, by_left = before
    fall, by_right = after
    chosen = np.empty(middle.size)
    for j in range(middle.size):
        # the leg with the better source decides; if neither knows a slope, it stays
        aim = fall[j] if by_right[j] > by_left[j] else rise[j]
        if by_left[j] == BY_WORD and by_right[j] == BY_WORD:
            aim = 0.5 * (rise[j] + fall[j])
        if not math.isnan(best) and (
            everywhere or abs(principal(middle[j] - heading)) <= 4.0 * half[j]
        ):
            aim = best
        aim = slope[j] if math.isnan(aim) else aim
        chosen[j] = min(max(aim, -_STEEPEST), _STEEPEST)
    return chosen


@separate
def _part_bound(box: Box, side1: float, side2: float) -> float:
    """Bound of a part of a box.

    A side of -0.5 or 0.5 is a half of an interval; 0 is all of it.
    """
    d1, d2 = side1 * box.h1, side2 * box.h2
    bound, _ = box_bound(
        Box(
            *(box.x, box.y, box.c1 + d1, box.h1 - abs(d1), box.slope1),
            *(box.c2 + d2, box.h2 - abs(d2), box.slope2, box.apart),
        )
    )
    return bound + box.slope1 * d1 - box.slope2 * d2


@compiled
def add_gains(
    leg: FloatArray,
    first: Ends,
    last: Ends,
    live: WordArray,
    costs: FloatArray,
    mates: IntArray,
    wanted: BoolArray,
    at_end: bool,
    halves: FloatArray,
    both: FloatArray,
) -> None:
    """Add the gains of bounding parts of boxes.

    A gain is the bound of a part less the box's own bound, which is in `costs`.

    Args:
        mates: for each of n intervals, the one at the leg's other end. The n intervals are those at
            the leg's end if `at_end`, else those at its start.
        wanted: shape (n,); nothing is computed for the others.
        halves: with half the interval, the lower and the upper one, shape (2, n).
        both: with half of both intervals, the least of four, between 0 and 1; shape (n,).
    """
    for m in range(mates.size):
        if wanted[m]:
            i, j = (mates[m], m) if at_end else (m, mates[m])
            box = _box(leg, first, last, i, j, live[i, j])
            least = math.inf
            for k, side in enumerate((-0.5, 0.5)):
                half = _part_bound(box, 0.0 if at_end else side, side if at_end else 0.0)
                halves[k, m] += half - costs[i, j]
                for other in (-0.5, 0.5):
                    least = min(least, _part_bound(box, side, other))
            both[m] += min(1.0, max(0.0, least - costs[i, j]))

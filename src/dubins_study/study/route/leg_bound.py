"""A proven lower bound of a leg's length over an interval of headings at each of its ends.

The least over the six words (`study.route.word_bounds`). Everything is in units of the turning
radius.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.closed_form.kernel_compile import compiled, separate
from dubins_study.study.path import BoolArray, FloatArray
from dubins_study.study.route.leg_words import between, principal, straight_direction, turns
from dubins_study.study.route.word_bounds import (
    LONGEST_COSTATE,
    Box,
    csc_bound,
    lrl_bound,
    mirrored,
)

WordArray = NDArray[np.int8]

_PI = math.pi
NO_WORD = -1


@separate
def box_bound(box: Box) -> tuple[float, int]:
    """A lower bound of the length with the potential over a box, and the word that gives it."""
    best, word = math.inf, NO_WORD
    near = box.x * box.x + box.y * box.y < 16.0 + 1e-12
    for image in range(2):
        if image == 1:
            box = mirrored(box)
        value = csc_bound(box, 1.0, best)
        if value < best:
            best, word = value, image
        value = csc_bound(box, -1.0, best)
        if value < best:
            best, word = value, 2 + image
        if near:
            value = lrl_bound(box)
            if value < best:
                best, word = value, 5 - image
    return best, word


@compiled
def bound_leg(
    leg: FloatArray,
    first: tuple[FloatArray, FloatArray, FloatArray],
    last: tuple[FloatArray, FloatArray, FloatArray],
    live: BoolArray,
    bounds: FloatArray,
    words: WordArray,
) -> None:
    """`box_bound` of every live pair of intervals; infinite for the others.

    Args:
        leg: (x, y), the end seen from the start (radii).
        first, last: middles, halves of widths and slopes of the intervals at both ends.
        live, bounds, words: shape (intervals at the start, intervals at the end); two are written.
    """
    c1, h1, slope1 = first
    c2, h2, slope2 = last
    for i in range(c1.size):
        for j in range(c2.size):
            bounds[i, j], words[i, j] = math.inf, NO_WORD
            if live[i, j]:
                bounds[i, j], words[i, j] = box_bound(
                    Box(leg[0], leg[1], c1[i], h1[i], slope1[i], c2[j], h2[j], slope2[j])
                )


@separate
def _word_slopes(x: float, y: float, t1: float, t2: float, word: int) -> tuple[float, float]:
    """Derivatives of a word's length by both headings, where it exists or nearly does."""
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
    """The slope of the potential for which a leg is flat at its other end, and what says so.

    A word that may change in the box takes any slope at one end, the multiplier of its condition
    adapting to it, and says the other end's; else both slopes are the word's derivatives.
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
        psi, axis = _PI - math.asin(0.25 * m), math.atan2(dy, dx)
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
    headings1: FloatArray,
    headings2: FloatArray,
    reach: FloatArray,
    words: WordArray,
    slopes: FloatArray,
    forward: bool,
) -> tuple[FloatArray, WordArray]:
    """`_slope_across` of some boxes: of their last ends if `forward`, else of their first."""
    across, kinds = np.empty(words.size), np.empty(words.size, np.int8)
    for j in range(words.size):
        across[j], kinds[j] = _slope_across(
            *(leg[0], leg[1], headings1[j], headings2[j], reach[j], words[j], slopes[j], forward)
        )
    return across, kinds


@separate
def _part_bound(box: Box, side1: float, side2: float) -> float:
    """The bound of a part of a box: side -0.5 or 0.5 is a half of an interval, 0 all of it."""
    d1, d2 = side1 * box.h1, side2 * box.h2
    bound, _ = box_bound(
        Box(
            *(box.x, box.y, box.c1 + d1, box.h1 - abs(d1), box.slope1),
            *(box.c2 + d2, box.h2 - abs(d2), box.slope2),
        )
    )
    return bound + box.slope1 * d1 - box.slope2 * d2


@compiled
def bounds_of_parts(
    leg: FloatArray,
    first: tuple[FloatArray, FloatArray, FloatArray],
    last: tuple[FloatArray, FloatArray, FloatArray],
    forward: bool,
) -> tuple[FloatArray, FloatArray]:
    """Bounds of n boxes with half an interval, shape (2, n), and the least of their quarters, (n,).

    The halves are the lower and the upper one of the first interval if `forward`, else of the last.
    """
    c1, h1, slope1 = first
    c2, h2, slope2 = last
    halves, quarters = np.empty((2, c1.size)), np.full(c1.size, math.inf)
    for j in range(c1.size):
        box = Box(leg[0], leg[1], c1[j], h1[j], slope1[j], c2[j], h2[j], slope2[j])
        for k, side in enumerate((-0.5, 0.5)):
            halves[k, j] = _part_bound(box, side if forward else 0.0, 0.0 if forward else side)
            for other in (-0.5, 0.5):
                quarters[j] = min(quarters[j], _part_bound(box, side, other))
    return halves, quarters

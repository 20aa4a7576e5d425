"""Proven intervals around the shortest lengths of legs to given headings, in compiled loops.

They do for frames what `enclosure.enclose_pose` does for one row: an interval holds the lengths of
all data within delta of a row's (`closed_form.pose.Leg`), by the arithmetic of `interval_kernel`.
The check of frames compares answers with them. A row is left to `enclose_pose` where that
arithmetic does not decide on which side of an edge of the branch all of the data lie, or where its
interval would be much wider than their lengths are. The words to a given heading are in
docs/derivation.md, section 15.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dubins_study.study.arrays import BoolArray, FloatArray
from dubins_study.study.body_coordinates import EPS, PER_DISTANCE, PER_EXTENT
from dubins_study.study.check.interval_kernel import (
    FULL_TURN,
    GROWTH,
    SINE_COSINE_ERROR,
    TINY,
    Interval,
    angle_above,
    chosen,
    exact,
    is_signed,
    minus,
    negative,
    over,
    plus,
    positive,
    root,
    times,
    widened,
)
from dubins_study.study.closed_form.kernel_compile import inlined, loop_input, threaded
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE, sine_cosine
from dubins_study.study.closed_form.pose import PER_HEADINGS, WORDS6
from dubins_study.study.closed_form.pose_kernel import PoseArrays, turn_between

# A row is left where the radius of its interval is above these parts of the length and of delta:
# the arithmetic makes of one delta some five, but next to (0, 2) any number.
_WIDEST, _STEEPEST = 2.0**-42, 32.0
# So is one whose radius is above this part of the length (or of the turning radius): far from the
# origin it could reach what the gap's tolerance, 1e-4, keeps apart from the ball's interval.
_BLUNTEST = 1e-6
# An interval is made an eighth wider, so that it holds the one that `enclose` gives, whose balls
# may be a twentieth wider next to an edge.
_MARGIN = 1.125
# rad, of `turn_between` (docs/derivation.md, section 15)
_TURN_ERROR = 2e-15
_BEST = -1  # beside places in `WORDS6`


class Bounds(NamedTuple):
    """Proven bounds of the shortest lengths of n rows: arrays of shape (n,)."""

    low: FloatArray  # as in `enclosure.Enclosure`, length unit
    high: FloatArray  # both are infinite where there is no path
    left: BoolArray  # rows that the loops leave, without bounds


def bound_rows(legs: PoseArrays, branch: str = "best") -> Bounds:
    """Enclose the shortest length of every row, but for the rows that are left."""
    n = legs.x.size
    bounds = Bounds(np.empty(n), np.empty(n), np.empty(n, np.bool_))
    word = _BEST if branch == "best" else WORDS6.index(branch)
    _bound_poses(n, PoseArrays(*map(loop_input, legs)), word, bounds)
    return bounds


@inlined
def _ends_in_units(length: Interval, radius: float, delta: float) -> tuple[float, float, bool]:
    """The ends of a length (radii) in the length unit, and whether they are near enough.

    Both are infinite where there is no path, and as near as they should be.
    """
    none = length.mid == math.inf
    useful = length.rad <= _WIDEST * length.mid + _STEEPEST * delta
    useful &= length.rad <= _BLUNTEST * max(length.mid, 1.0)
    scaled = times(Interval(length.mid, _MARGIN * length.rad), exact(radius))
    # one step outwards for the rounding of each end
    below = (scaled.mid - scaled.rad) * (1.0 - 2.0 * EPS)
    above = (scaled.mid + scaled.rad) * (1.0 + 2.0 * EPS)
    useful &= below > 0.0
    return math.inf if none else below, math.inf if none else above, none | useful


@inlined
def _full_angle(rise: Interval, run: Interval) -> tuple[Interval, bool]:
    """The angle of the point (run, rise), from 0 to 2 pi, and whether it is decided.

    It jumps where the rise changes its sign and the run is positive.
    """
    below = rise.mid < 0.0
    angle = angle_above(Interval(abs(rise.mid), rise.rad), run)
    decided = (abs(rise.mid) > rise.rad) | positive(negative(run))
    return chosen(below, minus(FULL_TURN, angle), angle), decided


class _Ends(NamedTuple):
    """The ends in the start's frame: X, Y, sine and cosine of the heading there, and delta."""

    X: Interval
    Y: Interval
    s: Interval
    c: Interval
    turn: Interval  # the heading, from 0 to 2 pi
    delta: float


class _Word(NamedTuple):
    """Bounds of a word's length in radii, and whether it is decided; infinite without a path."""

    low: float
    high: float
    decided: bool


@inlined
def _ends(
    x: float, y: float, heading: float, tx: float, ty: float, radius: float, final: float
) -> _Ends:
    sine_a, cosine_a = sine_cosine(heading)
    sine_b, cosine_b = sine_cosine(final)
    s1, c1 = Interval(sine_a, SINE_COSINE_ERROR), Interval(cosine_a, SINE_COSINE_ERROR)
    s2, c2 = Interval(sine_b, SINE_COSINE_ERROR), Interval(cosine_b, SINE_COSINE_ERROR)
    R = exact(radius)
    dx, dy = over(minus(exact(tx), exact(x)), R), over(minus(exact(ty), exact(y)), R)
    distance = abs(dx.mid) + dx.rad + abs(dy.mid) + dy.rad
    extent = (abs(x) + abs(y) + abs(tx) + abs(ty)) / radius
    delta = (PER_EXTENT * extent + PER_DISTANCE * distance + PER_HEADINGS) * GROWTH + TINY
    return _Ends(
        widened(plus(times(dx, c1), times(dy, s1)), delta),
        widened(minus(times(dy, c1), times(dx, s1)), delta),
        widened(minus(times(s2, c1), times(c2, s1)), delta),
        widened(plus(times(c2, c1), times(s2, s1)), delta),
        Interval(turn_between(heading, final), (_TURN_ERROR + delta) * GROWTH),
        delta,
    )


@inlined
def _mirrored(ends: _Ends) -> _Ends:
    X, Y, s, c, turn, delta = ends
    return _Ends(X, negative(Y), negative(s), c, minus(FULL_TURN, turn), delta)


@inlined
def _word(length: Interval, exists: bool, decided: bool) -> _Word:
    low, high = length.mid - length.rad, length.mid + length.rad
    return _Word(low if exists else math.inf, high if exists else math.inf, decided)


@inlined
def _wrapped(angle: Interval, spread: float) -> tuple[Interval, bool]:
    """An angle from -2 pi to 4 pi as one between 0 and 2 pi, and whether that is decided.

    It is if no angle at most `spread` away would need other turns.
    """
    beyond = angle.mid >= FULL_TURN.mid
    rest = chosen(beyond, minus(angle, FULL_TURN), angle)
    arc = chosen(rest.mid < 0.0, plus(rest, FULL_TURN), rest)
    most = (arc.rad + spread) * GROWTH
    return arc, (arc.mid > most) & (arc.mid + most < FULL_TURN.mid)


@inlined
def _left_straight_left(ends: _Ends) -> _Word:
    """LSL: |E - C|, the turn, and a turn more unless S lies between both headings.

    It does if both arcs' sines are not negative; of a turn above pi, if one is.
    """
    X, Y, s, c, turn, _ = ends
    less = minus(c, exact(1.0))
    x, y = minus(X, s), plus(Y, less)
    across = plus(minus(times(X, s), times(Y, c)), less)
    first, last = y.mid > 0.0, across.mid > 0.0
    between = (first & last) | ((first | last) & (turn.mid > math.pi))
    straight = root(plus(times(x, x), times(y, y)))
    length = plus(straight, turn)
    length = chosen(between, length, plus(length, FULL_TURN))
    return _word(length, True, is_signed(y) & is_signed(across))


@inlined
def _left_straight_right(ends: _Ends) -> _Word:
    X, Y, s, c, turn, _ = ends
    x, y = plus(X, s), minus(Y, plus(c, exact(1.0)))
    square = plus(times(x, x), times(minus(y, exact(2.0)), plus(y, exact(2.0))))
    exists = square.mid > 0.0
    straight = root(Interval(max(square.mid, 0.0), square.rad))
    # S as if its length were the double: it moves the first arc by half as much at most, and
    # the sum of both arcs and S, which is p - 2 atan(p / 2) and what p is not in, by little
    p, most = exact(straight.mid), straight.mid + straight.rad
    rise, run = plus(plus(x, x), times(p, y)), minus(times(p, x), plus(y, y))
    first, _ = _full_angle(rise, run)
    t, first_decided = _wrapped(first, straight.rad)
    q, last_decided = _wrapped(minus(t, turn), straight.rad)
    known = is_signed(square) & (first_decided & last_decided | (not exists))
    spread = straight.rad * min(1.0, 0.25 * most * most) * GROWTH
    length = widened(plus(plus(p, t), q), spread)
    return _word(length, exists, known)


@inlined
def _left_right_left(ends: _Ends) -> _Word:
    X, Y, s, c, turn, _ = ends
    x, y = minus(X, s), plus(Y, minus(c, exact(1.0)))
    square = plus(times(x, x), times(y, y))
    room = minus(exact(16.0), square)
    exists = room.mid > 0.0
    rise = root(Interval(max(room.mid, 0.0), room.rad))
    # pi / 2 and the angle whose cosine is d / 4
    half = angle_above(root(square), negative(rise))
    first, _ = _full_angle(y, x)
    t, first_decided = _wrapped(plus(first, half), 0.0)
    middle = plus(half, half)
    arcs = plus(turn, middle)
    q, last_decided = _wrapped(minus(arcs, t), 0.0)
    more = t.mid + q.mid > arcs.mid + math.pi
    less = t.mid + q.mid < arcs.mid - math.pi
    both = chosen(more, plus(arcs, FULL_TURN), chosen(less, minus(arcs, FULL_TURN), arcs))
    length = plus(middle, both)
    known = is_signed(room) & (first_decided & last_decided | (not exists))
    return _word(length, exists, known)


@inlined
def _least(a: _Word, b: _Word) -> _Word:
    return _Word(min(a.low, b.low), min(a.high, b.high), a.decided & b.decided)


@inlined
def _of_word(ends: _Ends, word: int) -> _Word:
    """The shortest of all, or one of `WORDS6`."""
    other = _mirrored(ends)
    if word == _BEST:
        same = _least(_left_straight_left(ends), _left_straight_left(other))
        crossed = _least(_left_straight_right(ends), _left_straight_right(other))
        return _least(
            _least(same, crossed), _least(_left_right_left(ends), _left_right_left(other))
        )
    if word in (1, 3, 4):
        ends = other
    if word < 2:
        return _left_straight_left(ends)
    if word < 4:
        return _left_straight_right(ends)
    return _left_right_left(ends)


@threaded
def _bound_poses(begin: int, end: int, legs: PoseArrays, word: int, bounds: Bounds) -> None:
    x, y, heading, tx, ty, radius, final = legs
    low, high, left = bounds
    for i in range(np.uint64(begin), np.uint64(end)):  # no index counts from the end
        ends = _ends(x[i], y[i], heading[i], tx[i], ty[i], radius[i], final[i])
        found = _of_word(ends, word)
        middle = 0.5 * (found.low + found.high)
        length = Interval(middle, (0.5 * (found.high - found.low)) * GROWTH + TINY)
        length = Interval(math.inf, 0.0) if found.low == math.inf else length
        low[i], high[i], useful = _ends_in_units(length, radius[i], ends.delta)
        sound = (abs(heading[i]) <= LARGEST_ANGLE) & (abs(final[i]) <= LARGEST_ANGLE)
        left[i] = not (found.decided & useful & sound)

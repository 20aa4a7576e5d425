"""Proven intervals around the shortest lengths of frames: `enclosure.enclose` in compiled loops.

An interval holds the lengths of all targets whose X and Y are within delta of the exact values that
a row's doubles give (`study.body_coordinates.Local`), by the arithmetic of `interval_kernel`. A row
is left to `enclose` where that arithmetic does not decide on which side of an edge of the branch
all of these targets lie, or where its interval would be much wider than their lengths are.

Which word is the shortest is taken from the synthesis (docs/derivation.md, section 6): outside the
disc on the target's side the one that turns toward the target and goes straight, inside it the
other side's turn and the long second arc. `enclose` does not assume that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

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
    lesser,
    minus,
    negative,
    over,
    plus,
    positive,
    root,
    times,
    widened,
)
from dubins_study.study.closed_form.kernel import ScenarioArrays, chunk_bounds, chunks
from dubins_study.study.closed_form.kernel_compile import inlined, loop_input, threaded
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE, sine_cosine
from dubins_study.study.path import BoolArray, FloatArray

# A row is left where the radius of its interval is above these parts of the length and of delta:
# the arithmetic makes of one delta some five, but next to (0, 2) any number.
_WIDEST, _STEEPEST = 2.0**-42, 32.0
# So is one whose radius is above this part of the length (or of the turning radius): far from the
# origin it could reach what the gap's tolerance, 1e-4, keeps apart from the ball's interval.
_BLUNTEST = 1e-6
# An interval is made an eighth wider, so that it holds the one that `enclose` gives, whose balls
# may be a twentieth wider next to an edge.
_MARGIN = 1.125
_BEST, _STRAIGHT, _ARCS = range(3)
_FORMS = {"best": _BEST, "LS": _STRAIGHT, "RS": _STRAIGHT, "RL": _ARCS, "LR": _ARCS}


class Bounds(NamedTuple):
    """Proven bounds of the shortest lengths of n rows: arrays of shape (n,)."""

    low: FloatArray  # as in `enclosure.Enclosure`, length unit
    high: FloatArray  # both are infinite where there is no path
    left: BoolArray  # rows that the loops leave to `enclosure.enclose`, without bounds


def bound_rows(scenarios: ScenarioArrays, branch: str = "best") -> Bounds:
    """Enclose the shortest length of every row, but for the rows that are left."""
    scenarios = ScenarioArrays(*map(loop_input, scenarios))
    n = scenarios.x.size
    bounds = Bounds(np.empty(n), np.empty(n), np.empty(n, np.bool_))
    _bound_rows(n)(scenarios, _FORMS[branch], branch in ("RS", "LR"), bounds)
    return bounds


class _Shortest(NamedTuple):
    """A shortest length in radii, and whether it is decided; infinite where there is no path."""

    length: Interval
    decided: bool


@inlined
def _square(
    x: float, y: float, heading: float, tx: float, ty: float, radius: float
) -> tuple[Interval, Interval, float]:
    """X and Y of the scenario's targets, and a bound on delta."""
    sine, cosine = sine_cosine(heading)
    s, c = Interval(sine, SINE_COSINE_ERROR), Interval(cosine, SINE_COSINE_ERROR)
    dx, dy, R = minus(exact(tx), exact(x)), minus(exact(ty), exact(y)), exact(radius)
    X = over(plus(times(dx, c), times(dy, s)), R)
    Y = over(minus(times(dy, c), times(dx, s)), R)
    extent = (abs(x) + abs(y) + abs(tx) + abs(ty)) / radius
    distance = abs(X.mid) + X.rad + abs(Y.mid) + Y.rad
    delta = (PER_EXTENT * extent + PER_DISTANCE * distance) * GROWTH + TINY
    return widened(X, delta), widened(Y, delta), delta


@inlined
def full_angle(rise: Interval, run: Interval) -> tuple[Interval, bool]:
    """The angle of the point (run, rise), from 0 to 2 pi, and whether it is decided.

    It jumps where the rise changes its sign and the run is positive.
    """
    below = rise.mid < 0.0
    angle = angle_above(Interval(abs(rise.mid), rise.rad), run)
    decided = (abs(rise.mid) > rise.rad) | positive(negative(run))
    return chosen(below, minus(FULL_TURN, angle), angle), decided


@inlined
def _left_straight(X: Interval, Y: Interval, w: Interval) -> _Shortest:
    """LS of a target outside the left disc: its bearing from the circle's centre, and s - atan s.

    The bearing of the tangent's point of contact is less by atan s, that of a triangle with sides
    1 and s. s - atan s changes by s^2 / (1 + s^2) times what s does: little, next to the circle.
    """
    s = root(negative(w))
    bearing, decided = full_angle(X, minus(exact(1.0), Y))
    # for a target ahead and to the right the turn is nearly a full one
    ahead_right = (X.mid >= 0.0) & (Y.mid < 0.0)
    bearing = plus(bearing, FULL_TURN) if ahead_right else bearing
    corner = angle_above(exact(s.mid), exact(1.0))
    most = s.mid + s.rad
    spread = s.rad * min(most * most, 1.0) * GROWTH
    rest = minus(exact(s.mid), corner)
    return _Shortest(plus(bearing, Interval(rest.mid, rest.rad + spread)), decided)


@inlined
def _right_left(X: Interval, Y: Interval, p: Interval, long: bool) -> _Shortest:
    """RL of a target that the right circle's centre is 1 to 3 radii from, p = d^2 - 1.

    The triangle of that centre, the second arc's centre and the target has sides 2, 1 and d, so
    4 d times the cosine of its angle at the first is p + 4, and 4 times that at the second 4 - p;
    with the root D of p (8 - p) in place of both for the sines. The first arc is the angle of a
    product of complex numbers, the direction to the target turned by the triangle's angle.
    """
    D = root(times(p, minus(exact(8.0), p)))
    up, side = plus(Y, exact(1.0)), plus(p, exact(4.0))
    signed = D if long else negative(D)
    rise = plus(times(X, side), times(up, signed))
    run = minus(times(up, side), times(X, signed))
    first, decided = full_angle(rise, run)
    corner = angle_above(D, minus(exact(4.0), p))
    second = minus(FULL_TURN, corner) if long else corner
    return _Shortest(plus(first, second), decided)


@inlined
def _squares(X: Interval, Y: Interval) -> tuple[Interval, Interval]:
    """1 - |T - C_L|^2 and |T - C_R|^2 - 1."""
    square, double = plus(times(X, X), times(Y, Y)), plus(Y, Y)
    return minus(double, square), plus(double, square)


@inlined
def _best(X: Interval, Y: Interval) -> _Shortest:
    """The shortest of all for Y = |Y|, which is as far from the right circle as -Y from the left.

    The edges are both circles, and the start lies on them.
    """
    w, p = _squares(X, Y)
    shortest = _right_left(X, Y, p, True) if w.mid > 0.0 else _left_straight(X, Y, w)
    return _Shortest(shortest.length, shortest.decided & is_signed(w))


@inlined
def _straight_word(X: Interval, Y: Interval) -> _Shortest:
    """LS; its edges are the left circle and the axis ahead, where the start is."""
    w, _ = _squares(X, Y)
    if w.mid > 0.0:
        return _Shortest(exact(math.inf), is_signed(w))
    shortest = _left_straight(X, Y, w)
    off_axis = is_signed(Y) | positive(negative(X))
    return _Shortest(shortest.length, shortest.decided & is_signed(w) & off_axis)


@inlined
def _arcs_word(X: Interval, Y: Interval) -> _Shortest:
    """The shorter RL; its edges are the circles of 1 and 3 radii about C_R, and the left circle.

    On that one a first arc begins or ends to be a whole turn, which its bearing tells.
    """
    _, p = _squares(X, Y)
    q = minus(exact(8.0), p)
    in_reach = is_signed(p) & is_signed(q)
    if p.mid < 0.0 or q.mid < 0.0:
        return _Shortest(exact(math.inf), in_reach)
    a, b = _right_left(X, Y, p, True), _right_left(X, Y, p, False)
    return _Shortest(lesser(a.length, b.length), a.decided & b.decided & in_reach)


@inlined
def _of_form(X: Interval, Y: Interval, form: int, mirrored: bool) -> _Shortest:
    if form == _BEST:
        return _best(X, Interval(abs(Y.mid), Y.rad))
    Y = negative(Y) if mirrored else Y
    return _straight_word(X, Y) if form == _STRAIGHT else _arcs_word(X, Y)


@threaded
def _bound_rows(scenarios: ScenarioArrays, form: int, mirrored: bool, bounds: Bounds) -> None:
    x, y, heading, tx, ty, radius = scenarios
    low, high, left = bounds
    for chunk in numba.prange(chunks(x.size)):
        first, end = chunk_bounds(chunk, x.size)
        for i in range(first, end):
            X, Y, delta = _square(x[i], y[i], heading[i], tx[i], ty[i], radius[i])
            length, decided = _of_form(X, Y, form, mirrored)
            low[i], high[i], useful = ends_in_units(length, radius[i], delta)
            left[i] = not (decided & useful & (abs(heading[i]) <= LARGEST_ANGLE))


@inlined
def ends_in_units(length: Interval, radius: float, delta: float) -> tuple[float, float, bool]:
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

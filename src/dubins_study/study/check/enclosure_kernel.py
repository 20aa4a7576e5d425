"""Proven intervals around the shortest lengths of frames: `enclosure.enclose` in compiled loops.

The bounds hold for the exact target that a row's doubles give, by `interval_kernel`'s arithmetic.
A row is left to `enclose` where that arithmetic does not decide, or where more than the exact
target counts: where the target's neighbours within `delta` may lie beyond an edge of the branch.

Which word is the shortest is taken from the synthesis (docs/derivation.md, section 6): outside the
disc on the target's side the one that turns toward the target and goes straight, inside it the
other side's turn and the long second arc. `enclose` does not assume that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

from dubins_study.study.check.interval_kernel import (
    GROWTH,
    ROUNDING,
    SINE_COSINE_ERROR,
    TINY,
    Interval,
    angle_above,
    exact,
    full_turn,
    minus,
    negative,
    over,
    plus,
    positive,
    root,
    times,
)
from dubins_study.study.closed_form.kernel import chunk_bounds, chunks
from dubins_study.study.closed_form.kernel_compile import inlined, loop_input, threaded
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE, sine_cosine
from dubins_study.study.closed_form.kernel_words import ScenarioArrays
from dubins_study.study.path import FloatArray
from dubins_study.study.paths import BoolArray
from dubins_study.study.vehicle_frame import EPS

_WIDEST = 2.0**-42  # of a length: where the radius of its interval is wider, `enclose` is asked
_BEST, _STRAIGHT, _ARCS = range(3)
_FORMS = {"best": _BEST, "LS": _STRAIGHT, "RS": _STRAIGHT, "RL": _ARCS, "LR": _ARCS}


class Bounds(NamedTuple):
    """Proven bounds of the shortest lengths of n rows: arrays of shape (n,).

    Args:
        low, high: as in `enclosure.Enclosure` (length unit); both infinite where there is no path.
        left: rows that the loops leave to `enclosure.enclose`; their bounds mean nothing.
    """

    low: FloatArray
    high: FloatArray
    left: BoolArray


def bound_rows(scenarios: ScenarioArrays, branch: str = "best") -> Bounds:
    """Enclose the shortest length of every row, but for the rows that are left.

    Args:
        scenarios: n rows, read as the exact values of their doubles.
        branch: one of `study.words.BRANCHES`.
    """
    scenarios = ScenarioArrays(*map(loop_input, scenarios))
    n = scenarios.x.size
    bounds = Bounds(np.empty(n), np.empty(n), np.empty(n, np.bool_))
    _bound_rows(n)(scenarios, _FORMS[branch], branch in ("RS", "LR"), bounds)
    return bounds


class _Target(NamedTuple):
    """The exact target in the vehicle's frame at unit radius, and how far its neighbours lie."""

    X: Interval
    Y: Interval
    delta: float


class _Found(NamedTuple):
    """A shortest length in radii, and whether it is decided; infinite where there is no path."""

    length: Interval
    decided: bool


@inlined
def _target(x: float, y: float, heading: float, tx: float, ty: float, radius: float) -> _Target:
    sine, cosine = sine_cosine(heading)
    s, c = Interval(sine, SINE_COSINE_ERROR), Interval(cosine, SINE_COSINE_ERROR)
    dx, dy, R = minus(exact(tx), exact(x)), minus(exact(ty), exact(y)), exact(radius)
    X = over(plus(times(dx, c), times(dy, s)), R)
    Y = over(minus(times(dy, c), times(dx, s)), R)
    # never below the true one: GROWTH and the radii are more than what doubles lose in these sums
    extent = (abs(x) + abs(y) + abs(tx) + abs(ty)) / radius
    size = abs(X.mid) + X.rad + abs(Y.mid) + Y.rad
    return _Target(X, Y, EPS * (2.0 * extent + 12.0 * size) * GROWTH + TINY)


@inlined
def _clear(value: Interval, X: float, Y: float, delta: float) -> bool:
    """Whether |T' - C|^2 - d^2 has one sign for all targets T' within delta of T in X and Y.

    Args:
        value: |T - C|^2 - d^2, or its negative.
        X, Y: bounds of the absolute values of T - C.
    """
    return abs(value.mid) > (value.rad + 2.0 * delta * (X + Y + delta)) * GROWTH


@inlined
def _bearing(rise: Interval, run: Interval) -> tuple[Interval, bool]:
    """The angle of the point (run, rise), from 0 to 2 pi, and whether it is decided.

    It jumps where the rise changes its sign and the run is positive.
    """
    below = rise.mid < 0.0
    angle = angle_above(negative(rise) if below else rise, run)
    decided = (abs(rise.mid) > rise.rad) | positive(negative(run))
    return minus(full_turn(), angle) if below else angle, decided


@inlined
def _left_straight(X: Interval, Y: Interval, w: Interval) -> _Found:
    """LS of a target outside the left disc: its bearing from the circle's centre, and s - atan s.

    The bearing of the tangent's point of contact is less by atan s, that of a triangle with sides
    1 and s. s - atan s changes by s^2 / (1 + s^2) times what s does: little, next to the circle.
    """
    s = root(negative(w))
    below = Y.mid < 0.0
    bearing, decided = _bearing(X, minus(exact(1.0), Y))
    # the target is ahead and to the right: the turn is nearly a full one
    more = below & (X.mid >= 0.0)
    bearing = plus(bearing, full_turn()) if more else bearing
    decided |= below
    corner = angle_above(exact(s.mid), exact(1.0))
    most = s.mid + s.rad
    spread = s.rad * min(most * most, 1.0) * GROWTH
    rest = minus(exact(s.mid), corner)
    return _Found(plus(bearing, Interval(rest.mid, rest.rad + spread)), decided)


@inlined
def _right_left(X: Interval, Y: Interval, p: Interval, long: bool) -> _Found:
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
    first, decided = _bearing(rise, run)
    corner = angle_above(D, minus(exact(4.0), p))
    second = minus(full_turn(), corner) if long else corner
    return _Found(plus(first, second), decided)


@inlined
def _squares(X: Interval, Y: Interval) -> tuple[Interval, Interval]:
    """1 - |T - C_L|^2 and |T - C_R|^2 - 1."""
    square, double = plus(times(X, X), times(Y, Y)), plus(Y, Y)
    return minus(double, square), plus(double, square)


@inlined
def _best(X: Interval, Y: Interval, delta: float) -> _Found:
    """The shortest of all for Y = |Y|; its edges are both circles, and the start lies on them."""
    w, p = _squares(X, Y)
    # |w| is below |p| here, so that who is off the left circle by this is off the right one too
    clear = _clear(w, abs(X.mid) + X.rad, 1.0 + Y.mid + Y.rad, delta)
    found = _right_left(X, Y, p, True) if w.mid > 0.0 else _left_straight(X, Y, w)
    return _Found(found.length, found.decided & clear)


@inlined
def _straight_word(X: Interval, Y: Interval, delta: float) -> _Found:
    """LS; its edges are the left circle and the axis ahead, where the start is."""
    w, _ = _squares(X, Y)
    clear = _clear(w, abs(X.mid) + X.rad, abs(Y.mid - 1.0) + (Y.rad + ROUNDING), delta)
    off_axis = (abs(Y.mid) > (Y.rad + delta) * GROWTH) | (-X.mid > (X.rad + delta) * GROWTH)
    if w.mid > 0.0:
        return _Found(exact(math.inf), clear)
    found = _left_straight(X, Y, w)
    return _Found(found.length, found.decided & clear & off_axis)


@inlined
def _arcs_word(X: Interval, Y: Interval, delta: float) -> _Found:
    """The shorter RL; its edges are the left circle and the circles of 1 and 3 about C_R."""
    w, p = _squares(X, Y)
    q = minus(exact(8.0), p)
    x, left, right = abs(X.mid) + X.rad, abs(Y.mid - 1.0), abs(Y.mid + 1.0)
    clear = _clear(p, x, right + (Y.rad + ROUNDING), delta)
    clear &= _clear(q, x, right + (Y.rad + ROUNDING), delta)
    if p.mid < 0.0 or q.mid < 0.0:
        return _Found(exact(math.inf), clear)
    clear &= _clear(w, x, left + (Y.rad + ROUNDING), delta)
    a, b = _right_left(X, Y, p, True), _right_left(X, Y, p, False)
    return _Found(_lesser(a.length, b.length), a.decided & b.decided & clear)


@inlined
def _lesser(a: Interval, b: Interval) -> Interval:
    """The smaller of two numbers: it differs from that of the middles by the larger radius."""
    return Interval(min(a.mid, b.mid), max(a.rad, b.rad))


@inlined
def _row(target: _Target, form: int, mirrored: bool) -> _Found:
    X, Y, delta = target
    if form == _BEST:
        return _best(X, Interval(abs(Y.mid), Y.rad), delta)
    Y = negative(Y) if mirrored else Y
    return _straight_word(X, Y, delta) if form == _STRAIGHT else _arcs_word(X, Y, delta)


@threaded
def _bound_rows(scenarios: ScenarioArrays, form: int, mirrored: bool, bounds: Bounds) -> None:
    x, y, heading, tx, ty, radius = scenarios
    low, high, left = bounds
    for chunk in numba.prange(chunks(x.size)):
        first, end = chunk_bounds(chunk, x.size)
        for i in range(first, end):
            target = _target(x[i], y[i], heading[i], tx[i], ty[i], radius[i])
            length, decided = _row(target, form, mirrored)
            none = length.mid == math.inf
            useful = length.rad <= _WIDEST * length.mid
            sound = decided & (useful | none) & (abs(heading[i]) <= LARGEST_ANGLE)
            scaled = times(length, exact(radius[i]))
            # one step outwards for the rounding of each end
            below, above = scaled.mid - scaled.rad, scaled.mid + scaled.rad
            low[i] = math.inf if none else below * (1.0 - 2.0 * EPS)
            high[i] = math.inf if none else above * (1.0 + 2.0 * EPS)
            left[i] = not (sound & (none | (below > 0.0)))

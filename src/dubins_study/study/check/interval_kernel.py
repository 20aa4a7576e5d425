"""Interval arithmetic in compiled loops: numbers known to lie within a proven distance of a double.

Every function returns an interval that contains its exact result for all numbers of the intervals
that it is given. Doubles are rounded to nearest, and what that may cost is in the radius:

* A sum, product, quotient, square root or fused multiply-add v of doubles is the double nearest to
  the exact result, so it is off by at most ROUNDING |v|, or by less than TINY where it underflows,
  even on a processor that is told to flush such numbers to zero. Where it overflows, ROUNDING |v|
  is infinite.
* A radius is itself computed: some eight operations on numbers that are not negative. Each loses at
  most a relative 2^-53, all of them less than GROWTH gives back, or less than TINY by underflow.
* Sine, cosine and arctangent are the polynomials of `study.closed_form.kernel_math`. How far they
  are off is proven in ball arithmetic over their whole range by tests/unit/study/test_interval.py.

Where nothing is known a radius is infinite or NaN: a caller asks whether it is small enough.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dubins_study.study.closed_form.kernel_compile import inlined
from dubins_study.study.closed_form.kernel_math import TAN_3PI_8, TAN_PI_8, small_arctangent

ROUNDING = 2.0**-53  # relative: half an ulp, at most
GROWTH = 1.0 + 2.0**-48
TINY = 1e-290
# absolute: of `sine_cosine`, for angles up to LARGEST_ANGLE
SINE_COSINE_ERROR = 2.1e-16
# relative to the slope: of `small_arctangent`, for slopes up to tan(pi/8) + 1e-9
ARCTANGENT_ERROR = 1.5e-16


class Interval(NamedTuple):
    """All numbers that are at most `rad` from `mid`."""

    mid: float
    rad: float


_ERROR_OF_PI = 1.23e-16  # pi less its double is 1.2246e-16
_QUARTER, _HALF, _PI, FULL_TURN = (
    Interval(part * math.pi, part * _ERROR_OF_PI) for part in (0.25, 0.5, 1.0, 2.0)
)


@inlined
def exact(value: float) -> Interval:
    """A double itself."""
    return Interval(value, 0.0)


@inlined
def _rounded(value: float, propagated: float) -> Interval:
    """The interval around a computed value, given what its operands' radii add up to."""
    return Interval(value, (propagated + ROUNDING * abs(value)) * GROWTH + TINY)


@inlined
def plus(a: Interval, b: Interval) -> Interval:
    """a + b"""
    return _rounded(a.mid + b.mid, a.rad + b.rad)


@inlined
def minus(a: Interval, b: Interval) -> Interval:
    """a - b"""
    return _rounded(a.mid - b.mid, a.rad + b.rad)


@inlined
def negative(a: Interval) -> Interval:
    """-a"""
    return Interval(-a.mid, a.rad)


@inlined
def times(a: Interval, b: Interval) -> Interval:
    """a b"""
    return _rounded(a.mid * b.mid, abs(a.mid) * b.rad + (abs(b.mid) + b.rad) * a.rad)


@inlined
def over(a: Interval, b: Interval) -> Interval:
    """a / b; of infinite radius where b may be zero.

    a'/b' - a/b = ((a' - a) - (a/b) (b' - b)) / b', and |b'| is at least |b| less its radius.
    """
    quotient, least = a.mid / b.mid, abs(b.mid) - b.rad
    spread = (a.rad + (abs(quotient) + TINY) * b.rad + TINY) / least
    return _rounded(quotient, spread if least > 0.0 else math.inf)


@inlined
def root(a: Interval) -> Interval:
    """The square root of a number that is known not to be negative; NaN if `mid` is.

    The root of a' differs from that of a by (a' - a) / (root of a' + root of a).
    """
    value = math.sqrt(a.mid)
    least = math.sqrt(max(a.mid - a.rad, 0.0))
    return _rounded(value, (a.rad + TINY) / (value + least))


@inlined
def angle_above(rise: Interval, run: Interval) -> Interval:
    """The angle of the point (run, rise), for a rise that is not negative: from 0 to pi.

    Where the rise may be zero and the run is positive, angles below 0 stand for what lies below;
    where the run is negative, those above pi do. The slope is brought to tan(pi/8) or less by
    turning the point back by 0, pi/4 or pi/2; the arctangent's derivative is at most 1.
    """
    behind = run.mid < 0.0
    ahead = Interval(abs(run.mid), run.rad)
    steep, flat = rise.mid > TAN_3PI_8 * ahead.mid, rise.mid <= TAN_PI_8 * ahead.mid
    # selects, with one division, so that a loop over rows can be vectorised
    top = chosen(flat, rise, chosen(steep, negative(ahead), minus(rise, ahead)))
    bottom = chosen(flat, ahead, chosen(steep, rise, plus(rise, ahead)))
    turned = chosen(flat, exact(0.0), chosen(steep, _HALF, _QUARTER))
    slope = over(top, bottom)
    spread = slope.rad + ARCTANGENT_ERROR * abs(slope.mid)
    angle = plus(turned, Interval(small_arctangent(slope.mid), spread * GROWTH + TINY))
    return chosen(behind, minus(_PI, angle), angle)


@inlined
def chosen(condition: bool, a: Interval, b: Interval) -> Interval:
    """a if the condition holds, else b: a select, not a branch."""
    return Interval(a.mid if condition else b.mid, a.rad if condition else b.rad)


@inlined
def positive(a: Interval) -> bool:
    """Whether all numbers of an interval are above zero."""
    return a.mid > a.rad


@inlined
def is_signed(a: Interval) -> bool:
    """Whether all numbers of an interval have the same sign, and none is zero."""
    return abs(a.mid) > a.rad


@inlined
def widened(a: Interval, by: float) -> Interval:
    """All numbers that are at most `by` from an interval."""
    return Interval(a.mid, (a.rad + by) * GROWTH)

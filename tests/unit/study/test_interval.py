"""Interval arithmetic in compiled loops: its error bounds proven, its intervals against fractions.

The proofs are by ball arithmetic over the whole range of an argument: the polynomial's distance
from its function by Taylor expansion on every piece of the range, what rounding adds step by step.
"""

import math
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import NamedTuple

import numpy as np
import pytest
from flint import arb, arb_poly, ctx, fmpq

from dubins_study.study.check import interval_kernel as ik
from dubins_study.study.check.interval_kernel import Interval
from dubins_study.study.closed_form import kernel_math
from dubins_study.study.closed_form.kernel_compile import compiled
from dubins_study.study.closed_form.kernel_math import ARCTANGENT, COSINE, LARGEST_ANGLE, SINE

PIECES, TERMS, BITS = 64, 40, 200
# the reduced angle exceeds pi/4 by what rounding 2/pi leaves in the number of quarter turns
LARGEST_REDUCED = math.pi / 4 + 1e-6
LARGEST_SLOPE = math.tan(math.pi / 8) + 1e-9


@pytest.fixture(autouse=True)
def _many_bits() -> Iterator[None]:
    with ctx.workprec(BITS):
        yield


def pieces(largest: float) -> Iterator[arb]:
    """Balls that cover [0, largest]."""
    step = arb(largest) / PIECES
    for i in range(PIECES):
        yield (i + arb(0.5, 0.5000001)) * step


def magnitude(ball: arb) -> arb:
    """The largest absolute value in a ball."""
    return ball.abs_upper()


def furthest(series: Callable[[int], Fraction], coefficients: list[float], piece: arb) -> arb:
    """The largest distance of a polynomial in z from sum_k series(k) z^k, for z in a ball.

    The series alternates with falling terms, so that the first one left out bounds the rest.
    """
    exact = [arb(c.numerator) / c.denominator for c in map(series, range(TERMS))]
    ours = [arb(c) for c in coefficients] + [arb(0)] * (TERMS - len(coefficients))
    difference = arb_poly([a - b for a, b in zip(ours, exact, strict=True)])
    about_middle = difference(arb_poly([piece.mid(), 1]))
    bound = sum(magnitude(c) * piece.rad() ** k for k, c in enumerate(about_middle.coeffs()))
    return bound + magnitude(exact[-1] * piece ** (TERMS - 1))


class Computed(NamedTuple):
    """What exact arithmetic would give, as a ball, and how far the computed double is from it."""

    exact: arb
    error: arb


def half_ulp(largest: arb) -> arb:
    """Half an ulp of every double up to a size: 2^-54 below 1, for instance."""
    return arb(2) ** (math.frexp(float(largest.upper()) * (1 + 1e-12))[1] - 54)


def fma(a: Computed, b: Computed, c: Computed) -> Computed:
    """One rounding of a b + c."""
    product = magnitude(a.exact) * b.error + (magnitude(b.exact) + b.error) * a.error
    exact, spread = a.exact * b.exact + c.exact, product + c.error
    return Computed(exact, spread + half_ulp(magnitude(exact) + spread))


ZERO = Computed(arb(0), arb(0))


def constant(value: float) -> Computed:
    return Computed(arb(value), arb(0))


def horner(coefficients: tuple[float, ...], z: Computed) -> Computed:
    p = constant(coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        p = fma(p, z, constant(coefficient))
    return p


def reduction_error() -> arb:
    """Of the reduced angle: two roundings below 1, and the third word of pi/2, quarter by quarter.

    Quarter turns are integers below 2^30 and pi/2 has 53 bits, so that no product is rounded.
    """
    words = arb(kernel_math._HALF_PI[0]) + arb(kernel_math._HALF_PI[1])
    quarters = LARGEST_ANGLE / (math.pi / 2) + 1
    assert quarters < 2**30
    return 2 * half_ulp(arb(0.99)) + quarters * abs(arb.pi() / 2 - words)


def test_the_reduced_angle_stays_in_the_range_that_is_proven():
    """The rounded number of quarter turns is off by a half and what 2/pi's rounding makes of it."""
    off = abs(arb(kernel_math._TWO_OVER_PI) - 2 / arb.pi()) * LARGEST_ANGLE
    largest = (arb(0.5) + off) * arb.pi() / 2 + reduction_error()

    assert largest < LARGEST_REDUCED < 1


def test_the_error_of_the_sine_is_proven():
    for r in pieces(LARGEST_REDUCED):
        z = fma(Computed(r, arb(0)), Computed(r, arb(0)), ZERO)
        p = horner(SINE, z)
        computed = fma(fma(Computed(r, arb(0)), z, ZERO), p, Computed(r, arb(0)))
        off = furthest(
            lambda k: Fraction((-1) ** k, math.factorial(2 * k + 1)), [1.0, *SINE], r * r
        )
        total = computed.error + magnitude(r) * off + reduction_error()
        assert total < ik.SINE_COSINE_ERROR


def test_the_error_of_the_cosine_is_proven():
    """1 - z/2 is rounded once, and what that loses is added again exactly, so not counted."""
    for r in pieces(LARGEST_REDUCED):
        z = fma(Computed(r, arb(0)), Computed(r, arb(0)), ZERO)
        p = horner(COSINE, z)
        lost = Computed(arb(0, 2.0**-54), arb(0))  # 1 - z/2 lies in (0.6, 1]
        spread = fma(fma(z, z, ZERO), p, lost).error + z.error / 2
        off = furthest(
            lambda k: Fraction((-1) ** k, math.factorial(2 * k)), [1.0, -0.5, *COSINE], r * r
        )
        # the sum is at most 1; the cosine's slope is below r
        total = spread + half_ulp(arb(0.99)) + off + magnitude(r) * reduction_error()
        assert total < ik.SINE_COSINE_ERROR


def test_the_error_of_the_arctangent_is_proven():
    """Relative to the slope t: of 1 + z p(z), times t."""
    unit = arb(2) ** -53
    for t in pieces(LARGEST_SLOPE):
        z = fma(Computed(t, arb(0)), Computed(t, arb(0)), ZERO)
        p = horner(ARCTANGENT, z)
        off = furthest(lambda k: Fraction((-1) ** k, 2 * k + 1), [1.0, *ARCTANGENT], t * t)
        # t z, rounded twice, times p, off by its error; then the sum is rounded
        product = magnitude(t * t) * ((1 + unit) ** 2 * (magnitude(p.exact) + p.error))
        product -= magnitude(t * t) * magnitude(p.exact)
        total = off + product + unit * (magnitude(1 + t * t * p.exact) + product)
        assert total < ik.ARCTANGENT_ERROR


def test_the_parts_of_pi_are_within_their_radii():
    for part, interval in ((4, ik._QUARTER), (2, ik._HALF), (1, ik._PI), (0.5, ik.FULL_TURN)):
        assert abs(arb.pi() / part - interval.mid) <= interval.rad


@compiled
def _operations(a, b, out):
    for i in range(a.shape[1]):
        p, q = Interval(a[0, i], a[1, i]), Interval(b[0, i], b[1, i])
        results = (
            ik.plus(p, q),
            ik.minus(p, q),
            ik.times(p, q),
            ik.over(p, q),
            ik.root(p),
            ik.angle_above(p, q),
        )
        for k in range(6):
            out[k, 0, i], out[k, 1, i] = results[k].mid, results[k].rad


def intervals(rng: np.random.Generator, n: int, most: int) -> np.ndarray:
    """n middles of sizes from 10^-most to 10^most and radii, of which a third are 0."""
    mid = rng.choice([-1, 1], n) * 10 ** rng.uniform(-most, most, n)
    mid[::7] = rng.choice([0.0, 1.0, -1.0, 2.0, 0.5], mid[::7].size)
    rad = abs(mid) * 10 ** rng.uniform(-17, 1, n) * (rng.random(n) < 2 / 3)
    rad[::11] = 10 ** rng.uniform(-most, most, rad[::11].size)
    return np.array([mid, rad])


def rational(value: float) -> fmpq:
    return fmpq(*value.as_integer_ratio())


def ends(interval: np.ndarray) -> list[fmpq]:
    """Both ends of an interval and a number between them."""
    mid, rad = map(rational, interval.tolist())
    return [mid + rad * part for part in (-1, fmpq(1, 3), 1)]


@pytest.mark.parametrize("most", [*(pytest.param(n, marks=pytest.mark.slow) for n in (1, 20)), 165])
def test_operations_hold_what_fractions_say(most):
    """Of all combinations of ends: middles from 10^-165 to 10^165, where products underflow."""
    rng, n = np.random.default_rng(most), 20_000
    a, b = intervals(rng, n, most), intervals(rng, n, most)
    out = np.empty((6, 2, n))
    _operations(a, b, out)
    held = np.isfinite(out).all(axis=1)

    assert held[:4].mean() > 0.7
    for i in range(n):
        found = [list(map(rational, out[k, :, i])) if held[k, i] else None for k in range(5)]
        for p in ends(a[:, i]):
            for q in ends(b[:, i]):
                exact = [p + q, p - q, p * q, p / q if q else None]
                for interval, value in zip(found[:4], exact, strict=True):
                    if value is not None and interval is not None:
                        assert abs(interval[0] - value) <= interval[1], (i, p, q)
            if p >= 0 and found[4] is not None:
                mid, rad = found[4]
                assert max(mid - rad, 0) ** 2 <= p <= (mid + rad) ** 2, (i, p)


def test_angles_hold_what_balls_say():
    """Of the corners of boxes above the axis."""
    rng = np.random.default_rng(3)
    rise, run = intervals(rng, 3000, 6), intervals(rng, 3000, 6)
    rise[0] = abs(rise[0])
    rise[1] = np.minimum(rise[1], rise[0])
    out = np.empty((6, 2, 3000))
    _operations(rise, run, out)
    held = np.isfinite(out[5]).all(axis=0)

    assert held.mean() > 0.7
    for i in np.flatnonzero(held):
        mid, rad = out[5, :, i]
        for p in ends(rise[:, i]):
            for q in ends(run[:, i]):
                if (p, q) == (0, 0):
                    continue
                y, x = arb(p), arb(q)
                assert abs(arb.atan2(y, x) - mid) <= rad, (i, p, q)


def test_a_quotient_by_what_may_be_zero_is_not_known():
    out = np.empty((6, 2, 3))
    _operations(np.array([[1.0] * 3, [0.0] * 3]), np.array([[0.0, 1e-9, 1], [0.0, 1e-9, 2]]), out)

    assert not np.isfinite(out[3, 1]).any()

"""Sine, cosine and arctangent that LLVM can vectorise: polynomials and selects, no branch, no call.

Correct to about one ulp, in strict IEEE arithmetic; the fused multiply-add is asked for by name,
so every machine gives the same bits (one without the instruction is slow, not different).

The coefficients are Chebyshev interpolants found with mpmath at 40 digits,
`chebyfit(f, [0, z_max], n)[::-1]`, of (z = the argument squared)

    SINE        (sin(r) / r - 1) / z            z_max = (pi/4)^2      n = 6    error 2.0e-17
    COSINE      (cos(r) - 1 + z/2) / z^2        z_max = (pi/4)^2      n = 6    error 1.3e-18
    ARCTANGENT  (atan(t) / t - 1) / z           z_max = tan(pi/8)^2   n = 11   error 3.2e-17

Errors are multiplied by z r, z^2 and z t.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic

from dubins_study.study.angle import TWO_PI
from dubins_study.study.closed_form.kernel_compile import inlined

SINE = (
    -0.16666666666666666,
    0.008333333333330948,
    -0.00019841269836758574,
    2.755731610255244e-06,
    -2.5051131845003624e-08,
    1.5918129294866608e-10,
)
COSINE = (
    0.041666666666666664,
    -0.0013888888888887398,
    2.480158729876569e-05,
    -2.7557317271729793e-07,
    2.08761462684032e-09,
    -1.1382632425521717e-11,
)
ARCTANGENT = (
    -0.3333333333333333,
    0.1999999999999552,
    -0.14285714284666542,
    0.11111111015256361,
    -0.09090904578123903,
    0.07692183190826087,
    -0.06664511447381948,
    0.0585814891280221,
    -0.0508544973794026,
    0.03923165829558719,
    -0.01917688711906226,
)

# pi/2 and what its rounding left out: to 106 bits. One rounding in each fused step keeps the
# reduced angle correct to an ulp of itself, and to 1e-22 where it is next to zero.
_HALF_PI = (math.pi / 2, 6.123233995736766e-17)
LARGEST_ANGLE = 1.0e9  # rad
_ROUNDER = 1.5 * 2.0**52  # adding it rounds to an integer, which then stands in the lowest bits
_TWO_OVER_PI = 2.0 / math.pi
_TAN_PI_8 = math.tan(math.pi / 8)
_TAN_3PI_8 = math.tan(3 * math.pi / 8)
_PI_4, _PI_2, _PI = math.pi / 4, math.pi / 2, math.pi


def _fma(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c, rounded once."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), generate


def _as_bits(typing_context: Any, a: Any) -> Any:
    """The 64 bits of a double as an integer."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), generate


def _negate(typing_context: Any, a: Any, k: Any) -> Any:
    """a, or -a if bit 1 of the integer k is set."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        i64 = ir.IntType(64)
        a, k = arguments
        sign = builder.shl(builder.and_(k, ir.Constant(i64, 2)), ir.Constant(i64, 62))
        return builder.bitcast(builder.xor(builder.bitcast(a, i64), sign), ir.DoubleType())

    return types.float64(types.float64, types.int64), generate


# Any, since what compiled code calls has not the arguments of the function that generates it
_intrinsic: Any = intrinsic
fma: Callable[[float, float, float], float] = _intrinsic(_fma)
_bits: Callable[[float], int] = _intrinsic(_as_bits)
_negated_by_bit_1: Callable[[float, int], float] = _intrinsic(_negate)


def _polynomial(coefficients: tuple[float, ...]) -> Callable[[float], float]:
    """c0 + c1 z + c2 z^2 + ... by Horner's rule, rounded once a step."""

    def horner(typing_context: Any, z: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            value, *others = (ir.Constant(ir.DoubleType(), c) for c in reversed(coefficients))
            for coefficient in others:
                value = builder.fma(value, *arguments, coefficient)
            return value

        return types.float64(types.float64), generate

    polynomial: Callable[[float], float] = _intrinsic(horner)
    return polynomial


_sine, _cosine, _arctangent = map(_polynomial, (SINE, COSINE, ARCTANGENT))


@inlined
def reduced(angle: float) -> tuple[float, float, int]:
    """An angle (rad) of at most `LARGEST_ANGLE` less the quarter turns nearest to it.

    Returns the rest, in [-pi/4, pi/4], the number of quarter turns, and an integer with the
    number's last two bits.
    """
    shifted = fma(angle, _TWO_OVER_PI, _ROUNDER)
    quarters = shifted - _ROUNDER
    rest = fma(quarters, -_HALF_PI[1], fma(quarters, -_HALF_PI[0], angle))
    return rest, quarters, _bits(shifted)


@inlined
def quarter_turns(number: float, rest: float) -> float:
    """A small number of quarter turns and a rest, as one angle (rad)."""
    return fma(number, _HALF_PI[0], fma(number, _HALF_PI[1], rest))


@inlined
def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle (rad) of at most `LARGEST_ANGLE`."""
    r, _, quadrant = reduced(angle)
    z = r * r
    sine = fma(r * z, _sine(z), r)
    half = 0.5 * z
    top = 1.0 - half
    cosine = top + fma(z * z, _cosine(z), (1.0 - top) - half)  # what the rounding of 1 - z/2 lost
    odd = (quadrant & 1) == 1
    first = cosine if odd else sine
    second = sine if odd else cosine
    return _negated_by_bit_1(first, quadrant), _negated_by_bit_1(second, quadrant + 1)


@inlined
def upper_arctangent(y: float, x: float) -> float:
    """atan2(y, x) for y >= 0: the angle of (x, y), from 0 to pi; 0 at the origin.

    The slope is brought to [-tan(pi/8), tan(pi/8)] by turning (|x|, y) back by 0, pi/4 or pi/2,
    which is done before the one division.
    """
    a = abs(x)
    steep = y > _TAN_3PI_8 * a
    flat = y <= _TAN_PI_8 * a
    low, sum_ = y - a, y + a
    top = -a if steep else low
    bottom = y if steep else sum_
    turned = _PI_2 if steep else _PI_4
    top = y if flat else top
    bottom = a if flat else bottom
    turned = 0.0 if flat else turned
    t = top / max(bottom, 1e-300)  # 0 / 0 is wanted to be 0
    z = t * t
    angle = turned + fma(t * z, _arctangent(z), t)
    other = _PI - angle
    return other if x < 0 else angle


@inlined
def full_arctangent(y: float, x: float) -> float:
    """The angle of (x, y), from 0 to 2 pi; 0 at the origin."""
    angle = upper_arctangent(abs(y), x)
    other = TWO_PI - angle
    return other if y < 0.0 else angle

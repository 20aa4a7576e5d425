"""Sine, cosine and arctangent that LLVM can vectorise.

They consist of polynomials and selects, without branches and calls. They are correct to about one
ulp, in strict IEEE arithmetic. The fused multiply-add is asked for by name, so every machine gives
the same bits (one without the instruction is slow, not different).

The coefficients are Chebyshev interpolants found with mpmath at 40 digits,
`chebyfit(f, [0, z_max], n)`, of (z = the argument squared)

    SINE        (sin(r) / r - 1) / z            z_max = (pi/4)^2      n = 6    error 2.0e-17
    COSINE      (cos(r) - 1 + z/2) / z^2        z_max = (pi/4)^2      n = 6    error 1.3e-18
    ARCTANGENT  (atan(t) / t - 1) / z           z_max = tan(pi/8)^2   n = 11   error 3.2e-17

Errors are multiplied by z r, z^2 and z t.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic

from dubins_study.study.angle import TWO_PI
from dubins_study.study.closed_form.kernel_compile import inlined

_SINE = (
    1.5918129294866608e-10,
    -2.5051131845003624e-08,
    2.755731610255244e-06,
    -0.00019841269836758574,
    0.008333333333330948,
    -0.16666666666666666,
)
_COSINE = (
    -1.1382632425521717e-11,
    2.08761462684032e-09,
    -2.7557317271729793e-07,
    2.480158729876569e-05,
    -0.0013888888888887398,
    0.041666666666666664,
)
_ARCTANGENT = (
    -0.01917688711906226,
    0.03923165829558719,
    -0.0508544973794026,
    0.0585814891280221,
    -0.06664511447381948,
    0.07692183190826087,
    -0.09090904578123903,
    0.11111111015256361,
    -0.14285714284666542,
    0.1999999999999552,
    -0.3333333333333333,
)

# pi/2 to 106 bits, as a double and the rest. One rounding in each fused step keeps the reduced
# angle correct to an ulp of itself, and to 1e-22 where it is next to zero.
_HALF_PI = (math.pi / 2, 6.123233995736766e-17)
LARGEST_ANGLE = 1.0e9  # rad
_ROUNDER = 1.5 * 2.0**52  # adding it rounds to an integer
_TWO_OVER_PI = 2.0 / math.pi
_TAN_PI_8 = math.tan(math.pi / 8)
_TAN_3PI_8 = math.tan(3 * math.pi / 8)
_PI_4 = math.pi / 4
_PI_2 = math.pi / 2
_PI = math.pi


def _fma(typing_context: Any, a: Any, b: Any, c: Any) -> Any:
    """a b + c, rounded once."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.fma(*arguments)

    return types.float64(types.float64, types.float64, types.float64), generate


# Any: the intrinsic has other arguments than the function that generates it
_intrinsic: Any = intrinsic
fma: Callable[[float, float, float], float] = _intrinsic(_fma)


@inlined
def _polynomial(coefficients: tuple[float, ...], z: float) -> float:
    """Polynomial by Horner's rule, rounded once a step.

    It is ... + c1 z + c0; the coefficient of the highest power comes first.
    """
    value = 0.0
    for coefficient in coefficients:
        value = fma(value, z, coefficient)
    return value


@inlined
def reduced(angle: float) -> tuple[float, float]:
    """Angle less its nearest quarter turns.

    The angle (rad) is at most `LARGEST_ANGLE`. Returns the rest, in [-pi/4, pi/4], and the number
    of quarter turns.
    """
    quarters = fma(angle, _TWO_OVER_PI, _ROUNDER) - _ROUNDER
    rest = fma(quarters, -_HALF_PI[1], fma(quarters, -_HALF_PI[0], angle))
    return rest, quarters


@inlined
def quarters_of_turn(quarters: float) -> float:
    """Quarter turns without full turns: 0 to 3."""
    full_turns: float = np.floor(0.25 * quarters)
    return quarters - 4.0 * full_turns


@inlined
def quarter_turns(number: float, rest: float) -> float:
    """Angle (rad) of some quarter turns and a rest.

    The number of quarter turns is small.
    """
    return fma(number, _HALF_PI[0], fma(number, _HALF_PI[1], rest))


@inlined
def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of an angle (rad).

    The angle is at most `LARGEST_ANGLE`.
    """
    r, quarters = reduced(angle)
    z = r * r
    sine = fma(r * z, _polynomial(_SINE, z), r)
    half = 0.5 * z
    top = 1.0 - half
    lost = (1.0 - top) - half  # in the rounding of 1 - z/2
    cosine = top + fma(z * z, _polynomial(_COSINE, z), lost)
    quadrant = quarters_of_turn(quarters)
    odd = (quadrant == 1.0) | (quadrant == 3.0)
    first = cosine if odd else sine
    second = sine if odd else cosine
    turned = (quadrant == 1.0) | (quadrant == 2.0)
    return -first if quadrant >= 2.0 else first, -second if turned else second


@inlined
def upper_arctangent(y: float, x: float) -> float:
    """atan2(y, x) for y that is not negative.

    It is the angle of (x, y), from 0 to pi, and 0 at the origin. The slope is brought to
    [-tan(pi/8), tan(pi/8)] by turning (|x|, y) back by 0, pi/4 or pi/2, which is done before the
    one division.
    """
    a = abs(x)
    steep = y > _TAN_3PI_8 * a
    flat = y <= _TAN_PI_8 * a
    low = y - a
    sum_ = y + a
    top = -a if steep else low
    bottom = y if steep else sum_
    turned = _PI_2 if steep else _PI_4
    top = y if flat else top
    bottom = a if flat else bottom
    turned = 0.0 if flat else turned
    t = top / max(bottom, 1e-300)  # 0 / 0 has to be 0
    z = t * t
    angle = turned + fma(t * z, _polynomial(_ARCTANGENT, z), t)
    other = _PI - angle
    return other if x < 0 else angle


@inlined
def full_arctangent(y: float, x: float) -> float:
    """Angle of (x, y), from 0 to 2 pi.

    It is 0 at the origin.
    """
    angle = upper_arctangent(abs(y), x)
    other = TWO_PI - angle
    return other if y < 0.0 else angle

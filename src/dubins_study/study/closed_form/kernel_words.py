"""One word over arrays: `shortest.left_straight` and `right_left`, line by line, with libm.

Nobody asks for speed here; only `best` has vector loops (`study.closed_form.kernel`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.closed_form.kernel_compile import compiled, inlined
from dubins_study.study.closed_form.shortest import EPS
from dubins_study.study.path import FloatArray

CodeArray = NDArray[np.uint8]

NO_PATH = 255  # the word code of a row whose branch has no path
_TWO_PI = 2 * math.pi


class ScenarioArrays(NamedTuple):
    """n scenarios: arrays of shape (n,), units as in `study.scenario.Scenario`."""

    x: FloatArray
    y: FloatArray
    heading: FloatArray
    target_x: FloatArray
    target_y: FloatArray
    radius: FloatArray


class Rows(NamedTuple):
    """The shortest paths of n rows: arrays of shape (n,).

    Args:
        length: of the whole path, in the length unit; NaN where the branch has none.
        first, second: lengths of its two segments, in the length unit; 0 for a letter left out.
        word: index into `kernel.WORDS`, or `NO_PATH`.
    """

    length: FloatArray
    first: FloatArray
    second: FloatArray
    word: CodeArray

    @classmethod
    def empty(cls, n: int) -> Rows:
        """Room for n rows."""
        return cls(np.empty(n), np.empty(n), np.empty(n), np.empty(n, np.uint8))


@inlined
def to_local_exactly(
    x: float, y: float, heading: float, tx: float, ty: float, radius: float
) -> tuple[float, float, float]:
    """As `kernel.to_local`, for every heading and radius: libm's sine and cosine, divisions."""
    dx, dy = tx - x, ty - y
    sine, cosine = math.sin(heading), math.cos(heading)
    X, Y = (dx * cosine + dy * sine) / radius, (dy * cosine - dx * sine) / radius
    rounding = 2.0 * EPS * (abs(x) + abs(y) + abs(tx) + abs(ty)) / radius
    if abs(X) <= rounding and abs(Y) <= 4.0 * rounding:
        return 0.0, 0.0, rounding
    return X, 0.0 if abs(Y) <= rounding else Y, rounding


@inlined
def _left_straight(X: float, Y: float, rounding: float) -> tuple[float, float]:
    """`shortest.left_straight`; NaN where there is none."""
    w = _snapped(X, Y, rounding)
    if w > 0.0:
        return math.nan, math.nan
    s = math.sqrt(-w)
    if s == 0.0:
        a = math.atan2(X, 1.0 - Y)
    else:
        a = 2.0 * math.atan2(Y, X + s) if X >= 0.0 else 2.0 * math.atan2(s - X, Y - 2.0)
    return a if a >= 0.0 else a + _TWO_PI, s


@inlined
def _right_left(X: float, Y: float, rounding: float) -> tuple[float, float]:
    """`shortest.right_left`; NaN where there is none."""
    w = _snapped(X, Y, rounding)
    p = X * X + Y * (Y + 2.0)
    q = 4.0 * (2.0 - Y) + w
    slack = 8.0 * rounding * (1.0 + abs(X) + abs(Y))
    if p < -slack or q < -slack:
        return math.nan, math.nan
    A = p + 4.0 * Y + 8.0
    D = math.sqrt(max(0.0, p * q))
    bend = 2.0 * math.atan2(math.sqrt(max(0.0, p)), math.sqrt(max(0.0, q)))
    if A > 1.0:
        plus = 2.0 * (math.atan2(4.0 * X + D, A) if X >= 0.0 else math.atan2(w, D - 4.0 * X))
        minus = 2.0 * (math.atan2(4.0 * X - D, A) if X < 0.0 else math.atan2(-w, D + 4.0 * X))
    else:
        bearing, between = math.atan2(X, 1.0 + Y), math.atan2(D, p + 4.0)
        plus, minus = bearing + between, bearing - between
    long, short = _wrapped(plus), _wrapped(minus)
    if long + (_TWO_PI - bend) <= short + bend:
        return long, _TWO_PI - bend
    return short, bend


@inlined
def _snapped(X: float, Y: float, rounding: float) -> float:
    """`shortest.Local.w`."""
    w = Y * (2.0 - Y) - X * X
    return 0.0 if abs(w) <= 8.0 * rounding * (1.0 + abs(X) + abs(Y)) else w


@inlined
def _wrapped(angle: float) -> float:
    wrapped = angle % _TWO_PI
    return 0.0 if wrapped >= _TWO_PI else wrapped


@compiled
def word_rows(scenarios: ScenarioArrays, arcs: bool, right: bool, rows: Rows) -> None:
    """LS, or RL if `arcs`; mirrored, RS or LR, if `right`. With libm."""
    x, y, heading, tx, ty, radius = scenarios
    length, first, second, word = rows
    for i in range(x.size):
        X, Y, rounding = to_local_exactly(x[i], y[i], heading[i], tx[i], ty[i], radius[i])
        if right:
            Y = -Y
        a, b = _right_left(X, Y, rounding) if arcs else _left_straight(X, Y, rounding)
        first[i], second[i] = a * radius[i], b * radius[i]
        length[i] = first[i] + second[i]
        word[i] = _word(a, b, arcs, right)


@inlined
def _word(a: float, b: float, arcs: bool, right: bool) -> int:
    """The code of a word in `WORDS`, letters without length left out."""
    if not (a + b >= 0.0):
        return NO_PATH
    # the second letter of RL and LR is the first one's opposite
    start_right = right != arcs
    if a > 0.0 and b > 0.0:
        return 7 - right if arcs else 4 + right
    if a > 0.0:
        return 2 + start_right
    if b > 0.0:
        return 2 + (not start_right) if arcs else 1
    return 0

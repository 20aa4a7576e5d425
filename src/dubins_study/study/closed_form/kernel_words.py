"""One word over arrays: `shortest.left_straight` and `right_left`, compiled, with libm.

Nobody asks for speed here; only `best` has vector loops (`study.closed_form.kernel`).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba.extending import register_jitable
from numpy.typing import NDArray

from dubins_study.study.body_coordinates import PER_DISTANCE, PER_EXTENT, power
from dubins_study.study.closed_form.kernel_compile import compiled, inlined
from dubins_study.study.closed_form.shortest import (
    best_segments,
    chosen_side,
    left_straight,
    right_left,
    right_left_pair,
    wrapped,
)
from dubins_study.study.path import FloatArray

CodeArray = NDArray[np.uint8]

NO_PATH = 255  # the word code of a row whose branch has no path


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
    """`body_coordinates.local` to the bit, for every heading and radius: libm and divisions."""
    dx, dy = tx - x, ty - y
    sine, cosine = math.sin(heading), math.cos(heading)
    X, Y = (dx * cosine + dy * sine) / radius, (dy * cosine - dx * sine) / radius
    spread = PER_EXTENT * (abs(x) + abs(y) + abs(tx) + abs(ty)) / radius
    return X, Y, spread + PER_DISTANCE * (abs(X) + abs(Y))


_left_straight, _right_left = inlined(left_straight), inlined(right_left)
_best_segments, _chosen_side = inlined(best_segments), inlined(chosen_side)
for _called in (left_straight, power, right_left_pair, wrapped):
    register_jitable(_called)


@inlined
def best_exactly(X: float, Y: float, delta: float) -> tuple[float, float, int]:
    """`shortest.shortest_local` without a branch, to the bit: both segments and the word's code."""
    right = not _chosen_side(Y, delta)
    first, second, arcs = _best_segments(X, abs(Y), delta)
    return first, second, _word(first, second, arcs, right)


@compiled
def word_rows(scenarios: ScenarioArrays, arcs: bool, right: bool, rows: Rows) -> None:
    """LS, or RL if `arcs`; mirrored, RS or LR, if `right`. With libm."""
    x, y, heading, tx, ty, radius = scenarios
    length, first, second, word = rows
    for i in range(x.size):
        X, Y, delta = to_local_exactly(x[i], y[i], heading[i], tx[i], ty[i], radius[i])
        if right:
            Y = -Y
        a, b = _right_left(X, Y, delta) if arcs else _left_straight(X, Y, delta)
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

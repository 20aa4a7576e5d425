"""The closed form over arrays: `study.closed_form.shortest` for millions of targets at once.

Strict IEEE arithmetic and the formulas of `study.closed_form.shortest`. Lengths differ from its
lengths by a few ulp, since sine, cosine and arctangent are computed here; a word differs only where
the last ulp decides whether a target is snapped to a circle or to the axis.
"""

from __future__ import annotations

import math
from typing import Any

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from dubins_study.study.closed_form.kernel_compile import (
    compiled,
    inlined,
    loop_input,
    threaded,
)
from dubins_study.study.closed_form.kernel_math import (
    LARGEST_ANGLE,
    fma,
    sine_cosine,
    upper_arctangent,
)
from dubins_study.study.closed_form.kernel_words import (
    NO_PATH,
    Rows,
    ScenarioArrays,
    to_local_exactly,
    word_rows,
)
from dubins_study.study.vehicle_frame import EPS
from dubins_study.study.words import BRANCHES

WORDS = ("", "S", "L", "R", "LS", "RS", "LR", "RL")

CHUNK = 512  # rows; what a chunk reads and writes stays in the first-level cache
_TWO_PI = 2 * math.pi
_LARGEST = np.finfo(np.float64).max


def shortest_rows(
    x: ArrayLike,
    y: ArrayLike,
    heading: ArrayLike,
    target_x: ArrayLike,
    target_y: ArrayLike,
    radius: ArrayLike,
    *,
    branch: str = "best",
    out: Rows | None = None,
) -> Rows:
    """The shortest path of every row, as `study.closed_form.shortest.shortest` finds it.

    Args:
        x, y, heading: start poses, shape (n,), length unit and rad.
        target_x, target_y: targets, shape (n,), length unit.
        radius: turning radii, shape (n,), length unit.
        branch: `best`, or a word: `LS`, `RS`, `LR`, `RL`.
        out: arrays to write to (C-contiguous, not overlapping the input); new ones if None.

    Nothing is checked: a row with NaN or a radius that is not positive yields NaN.

    Raises:
        ValueError: if the shapes differ or there is no such branch.
    """
    scenarios = ScenarioArrays(*map(loop_input, (x, y, heading, target_x, target_y, radius)))
    n = scenarios.x.size
    rows = Rows.empty(n) if out is None else out
    arrays: list[NDArray[Any]] = [*scenarios, *rows]
    for shape in {array.shape for array in arrays} - {(n,)}:
        raise ValueError(f"an array has shape {shape}; expected {(n,)} as x has")
    if branch == "best":
        if _best_rows(n)(scenarios, rows):
            _redo_unusual(scenarios, rows)
    elif branch in BRANCHES:
        word_rows(scenarios, branch in ("LR", "RL"), branch in ("RS", "LR"), rows)
    else:
        raise ValueError(f"no branch {branch!r}; choose one of: {', '.join(BRANCHES)}")
    return rows


@inlined
def to_local(
    x: float, y: float, sine: float, cosine: float, tx: float, ty: float, radius: float
) -> tuple[float, float, float]:
    """The target in the vehicle's frame and the rounding, as `vehicle_frame.local` has them.

    A quotient by the reciprocal, then one Newton step with the remainder, is the quotient rounded
    correctly (Markstein 1990): two divisions fewer, and the same bits.
    """
    dx, dy = tx - x, ty - y
    inverse = 1.0 / radius
    forward = dx * cosine + dy * sine
    left = dy * cosine - dx * sine
    X = forward * inverse
    X = fma(fma(-X, radius, forward), inverse, X)
    Y = left * inverse
    Y = fma(fma(-Y, radius, left), inverse, Y)
    rounding = 2.0 * EPS * (abs(x) + abs(y) + abs(tx) + abs(ty)) * inverse
    on_axis = abs(Y) <= rounding
    at_start = (abs(Y) <= 4.0 * rounding) & (abs(X) <= rounding)
    return 0.0 if at_start else X, 0.0 if on_axis | at_start else Y, rounding


@inlined
def _best(X: float, y: float, rounding: float, right: int) -> tuple[float, float, int]:
    """`shortest.shortest_local` for y = |Y| without a branch: both segments and the word.

    Outside the disc LS needs one arctangent, inside it RL needs two; the arguments of the first
    are selected before it is taken. sqrt(p q) is the D of `shortest.right_left_pair`, and the
    second arc is 2 pi - 2 atan(sqrt(p / q)) = 2 pi - atan2(D, (q - p) / 2), with p + q = 8.
    """
    xx = X * X
    w = y * (2.0 - y) - xx
    on_circle = abs(w) <= 8.0 * rounding * (1.0 + abs(X) + y)
    w = 0.0 if on_circle else w
    inside = w > 0.0
    p = xx + y * (y + 2.0)
    q = 4.0 * (2.0 - y) + w
    A = p + 4.0 * y + 8.0
    inner, outer = p * q, -w
    root = math.sqrt(inner if inside else outer)  # D inside, the straight part outside
    # tan(a/2) is y / (X + s) ahead and (s - X) / (y - 2) behind. On the circle, s = 0, either loses
    # its digits at one end: the first next to the start, the second next to (0, 2).
    four_x, below, on_arc = 4.0 * X, y - 2.0, root == 0.0
    low, high = on_arc & (y <= 1.0), on_arc & (y > 1.0)
    rise_front, run_front = X if low else y, -below if low else X + root
    rise_front = four_x + root if inside else rise_front
    run_front = A if inside else run_front
    rise_rear = w if inside else root - X
    run_rear = root - four_x if inside else below
    front = (X >= 0.0) | high
    rise = rise_front if front else rise_rear
    run = run_front if front else run_rear
    first = 2.0 * upper_arctangent(rise, run)
    arc = _TWO_PI - upper_arctangent(root, 4.0 - p)
    second = arc if inside else root
    turns = first > 0.0
    one = 1 if second > 0.0 else 0
    two = (4 if second > 0.0 else 2) + right
    outside_word = two if turns else one
    inside_word = 7 - right
    return first, second, inside_word if inside else outside_word


@inlined
def chunks(n: int) -> int:
    """The number of chunks of n rows."""
    return (n + CHUNK - 1) // CHUNK


@inlined
def chunk_bounds(chunk: int, n: int) -> tuple[np.uint64, np.uint64]:
    """The first row of a chunk of n rows and the row after its last.

    Unsigned, so that the compiler knows that no index counts from the end.
    """
    low = np.uint64(chunk) * np.uint64(CHUNK)
    return low, min(low + np.uint64(CHUNK), np.uint64(n))


@inlined
def _best_chunk(chunk: int, scenarios: ScenarioArrays, rows: Rows) -> int:
    """One chunk of rows in two loops, each small enough for the vector registers.

    Between them the target in the vehicle's frame lies in the output arrays. Returns how many
    rows are unusual. That count does a second service: LLVM interleaves two vectors only in loops
    that have a reduction.
    """
    x, y, heading, tx, ty, radius = scenarios
    length, first, second, word = rows
    low, high = chunk_bounds(chunk, x.size)
    unusual = 0
    for i in range(low, high):
        sine, cosine = sine_cosine(heading[i])
        X, Y, rounding = to_local(x[i], y[i], sine, cosine, tx[i], ty[i], radius[i])
        first[i] = X
        second[i] = abs(Y)
        length[i] = rounding
        word[i] = 0 if Y >= 0.0 else 1
        unusual += not (abs(heading[i]) <= LARGEST_ANGLE)
    for i in range(low, high):
        a, b, code = _best(first[i], second[i], length[i], word[i])
        a *= radius[i]
        b *= radius[i]
        first[i] = a
        second[i] = b
        length[i] = a + b
        word[i] = code
        unusual += not (a + b <= _LARGEST)
    return unusual


@threaded
def _best_rows(scenarios: ScenarioArrays, rows: Rows) -> int:
    unusual = 0
    for chunk in numba.prange(chunks(scenarios.x.size)):
        unusual += _best_chunk(chunk, scenarios, rows)
    return unusual


@compiled
def _redo_unusual(scenarios: ScenarioArrays, rows: Rows) -> None:
    """The rows that the vector loops cannot do: huge headings, and radii next to underflow."""
    x, y, heading, tx, ty, radius = scenarios
    length, first, second, word = rows
    for i in range(x.size):
        if abs(heading[i]) <= LARGEST_ANGLE and length[i] <= _LARGEST:
            continue
        X, Y, rounding = to_local_exactly(x[i], y[i], heading[i], tx[i], ty[i], radius[i])
        a, b, code = _best(X, abs(Y), rounding, 0 if Y >= 0.0 else 1)
        first[i], second[i] = a * radius[i], b * radius[i]
        sound = rounding <= _LARGEST and a + b >= 0.0
        length[i] = first[i] + second[i] if sound else math.nan
        word[i] = code if sound else NO_PATH

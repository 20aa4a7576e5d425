"""Closed form over arrays, for millions of targets.

The formulas are those of `study.closed_form.shortest`, in strict IEEE arithmetic. Sine, cosine and
arctangent are computed here, so that lengths differ from its lengths by up to 4 EPS max(length, R).
Some rows are computed with the functions of that module and of the C library instead, and are equal
to the bit. They are those where the last ulp decides the word, or would move the length by more.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import CodeArray, FloatArray
from dubins_study.study.body_coordinates import EPS, PER_DISTANCE, PER_EXTENT
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
from dubins_study.study.closed_form.shortest import (
    best_segments,
    chosen_side,
    left_straight,
    right_left,
)
from dubins_study.study.words import BRANCHES, TURN

WORDS = ("", "S", "L", "R", "LS", "RS", "LR", "RL")
NO_PATH = 255  # the word code of a row whose branch has no path


class ScenarioArrays(NamedTuple):
    """n scenarios as arrays of shape (n,).

    Units are those of `study.scenario.Scenario`.
    """

    x: FloatArray
    y: FloatArray
    heading: FloatArray
    target_x: FloatArray
    target_y: FloatArray
    radius: FloatArray


class Rows(NamedTuple):
    """Shortest paths of n rows (length unit)."""

    length: FloatArray  # NaN where the branch has no path; shape (n,)
    segments: FloatArray  # 0 for a letter left out; shape (m, n)
    word: CodeArray  # index into the words, or `NO_PATH`; shape (n,)

    @classmethod
    def empty(cls, segments: int, n: int) -> Rows:
        """Room for n rows."""
        return cls(np.empty(n), np.empty((segments, n)), np.empty(n, np.uint8))


Index = int | np.uint64  # unsigned where the compiler should know that no index counts from the end
CHUNK = 512  # rows; what a chunk reads and writes stays in the first-level cache
LARGEST = np.finfo(np.float64).max
# A row is delicate below this w, and inside the disc below this q. At that q the length changes by
# 3.4 per shift of the target. Of 4e7 rows beyond it none was off by 3.6 EPS or more.
_NEAR = 1e-5
_STEEP = 0.7
# delta is at most 2 + 12 sqrt(2) EPS times the coordinates' size in radii
_FOUR_DELTA = 80.0 * EPS


def prepared(
    columns: Iterable[ArrayLike], segments: int, out: Rows | None
) -> tuple[list[FloatArray], Rows]:
    """Columns as loops read them, and output rows.

    The rows are `out`, or new ones if `out` is None. Arrays of other shapes are a ValueError.
    """
    arrays = [loop_input(column) for column in columns]
    n = arrays[0].size
    rows = out or Rows.empty(segments, n)
    checked: list[NDArray[Any]] = [*arrays, *rows]
    for array in checked:
        if array.shape not in ((n,), (segments, n)):
            raise ValueError(f"an array has shape {array.shape}; expected {(n,)} as x has")
    return arrays, rows


def shortest_rows(*columns: ArrayLike, branch: str = "best", out: Rows | None = None) -> Rows:
    """Shortest path of every row.

    It is the path of `study.closed_form.shortest.shortest`.

    Args:
        columns: those of `ScenarioArrays`, in their order, shape (n,).
        branch: `best`, or a word: `LS`, `RS`, `LR`, `RL`.
        out: arrays to write to (C-contiguous, not overlapping the input); new ones if None.

    Words are indices into `WORDS`. Only shapes are checked: a row with NaN yields NaN, and one
    whose radius is not positive means nothing.
    """
    arrays, rows = prepared(columns, 2, out)
    scenarios = ScenarioArrays(*arrays)
    n = scenarios.x.size
    if branch == "best":
        _best_rows(n, scenarios, rows)
    elif branch in BRANCHES:
        # `arcs`: two arcs, else one and a straight; `right`: the mirror image of LS or RL
        _word_rows(scenarios, branch in ("LR", "RL"), branch in ("RS", "LR"), rows)
    else:
        raise ValueError(f"no branch {branch!r}; choose one of: {', '.join(BRANCHES)}")
    return rows


@inlined
def to_local_exactly(
    x: float, y: float, heading: float, tx: float, ty: float, radius: float
) -> tuple[float, float, float]:
    """`body_coordinates.local` of a scenario, to the bit.

    Returns X, Y and delta, for every heading and radius. The C library's functions and divisions
    compute them.
    """
    dx, dy = tx - x, ty - y
    sine, cosine = math.sin(heading), math.cos(heading)
    X, Y = (dx * cosine + dy * sine) / radius, (dy * cosine - dx * sine) / radius
    spread = PER_EXTENT * (abs(x) + abs(y) + abs(tx) + abs(ty)) / radius
    return X, Y, spread + PER_DISTANCE * (abs(X) + abs(Y))


_left_straight = inlined(left_straight)
_right_left = inlined(right_left)
_best_segments = inlined(best_segments)
_chosen_side = inlined(chosen_side)


@inlined
def _exactly(
    i: Index, best: bool, arcs: bool, right: bool, scenarios: ScenarioArrays, rows: Rows
) -> None:
    """Compute row i by the scalar functions and libm.

    The path is the shortest of all if `best`, else that of one word. The word is LS, or RL if
    `arcs`; mirrored, RS or LR, if `right`.
    """
    x, y, heading, tx, ty, radius = scenarios
    R = radius[i]
    X, Y, delta = to_local_exactly(x[i], y[i], heading[i], tx[i], ty[i], R)
    if best:
        a, b, arcs = _best_segments(X, abs(Y), delta)
        right = not _chosen_side(Y, delta)
    else:
        Y = -Y if right else Y
        a, b = _right_left(X, Y, delta) if arcs else _left_straight(X, Y, delta)
    sound = delta <= LARGEST and a + b >= 0.0
    rows.segments[0, i] = a * R
    rows.segments[1, i] = b * R
    rows.length[i] = a * R + b * R if sound else math.nan
    rows.word[i] = _word(a, b, arcs, right) if sound else NO_PATH


@compiled
def _word_rows(scenarios: ScenarioArrays, arcs: bool, right: bool, rows: Rows) -> None:
    for i in range(scenarios.x.size):
        _exactly(i, False, arcs, right, scenarios, rows)


@inlined
def _word(a: float, b: float, arcs: bool, right: bool) -> int:
    """Code of a word in `WORDS`.

    Letters without length are left out.
    """
    # places in `WORDS`: S 1, L 2, R 3, LS 4, RS 5, LR 6, RL 7
    # the second letter of RL and LR is the first one's opposite
    start_right = right != arcs
    if a > 0.0 and b > 0.0:
        return 7 - right if arcs else 4 + right
    if a > 0.0:
        return 2 + start_right
    if b > 0.0:
        return 2 + (not start_right) if arcs else 1
    return 0


@inlined
def to_local(
    x: float, y: float, sine: float, cosine: float, tx: float, ty: float, radius: float
) -> tuple[float, float, float]:
    """Target in the vehicle's frame, and 4 delta.

    The coordinates are those of `body_coordinates.local`. The last number is at least 4 delta.

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
    return X, Y, _FOUR_DELTA * (abs(x) + abs(y) + abs(tx) + abs(ty)) * inverse


@inlined
def _best(X: float, y: float, right: int) -> tuple[float, float, int, float]:
    """`best_segments` with the word and the edge distance.

    The word is given by its code; the last number is the target's distance from an edge. Where that
    is not above 4 delta the row is delicate: two evaluations of X, Y and w differ by less than
    delta, and may take different sides of the edge. The distance is below zero so near (0, 2) that
    the last ulp counts too much: inside the disc the length changes by 1 / sqrt(q / 8) per shift of
    the target (docs/derivation.md, section 9).

    Outside the disc LS needs one arctangent, inside it RL needs two; the arguments of the first are
    selected before it is taken. sqrt(p q) is the D of `shortest.right_left_pair`, and the second
    arc is 2 pi - 2 atan(sqrt(p / q)) = 2 pi - atan2(D, (q - p) / 2), with p + q = 8.
    """
    xx = X * X
    w = y * (2.0 - y) - xx
    inside = w > 0.0
    p = xx + y * (y + 2.0)
    q = 4.0 * (2.0 - y) + w
    A = p + 4.0 * y + 8.0
    inner = p * q
    outer = -w
    root = math.sqrt(inner if inside else outer)  # D inside, the straight part outside
    # tan(a/2) is y / (X + s) ahead and (s - X) / (y - 2) behind
    four_x = 4.0 * X
    rise_front = four_x + root if inside else y
    run_front = A if inside else X + root
    rise_rear = w if inside else root - X
    run_rear = root - four_x if inside else y - 2.0
    front = X >= 0.0
    rise = rise_front if front else rise_rear
    run = run_front if front else run_rear
    first = 2.0 * upper_arctangent(rise, run)
    arc = TWO_PI - upper_arctangent(root, 4.0 - p)
    second = arc if inside else root
    steepness = q - _STEEP if inside else y
    clear = min(min(abs(w) - _NEAR, y), steepness)
    return first, second, 7 - right if inside else 4 + right, clear


@inlined
def chunk_from(begin: int, end: int) -> tuple[np.uint64, np.uint64]:
    """First row of a chunk, and its end.

    The end is the row after its last, and at most `end`. Both are unsigned, so that the compiler
    knows that no index counts from the end.
    """
    return np.uint64(begin), np.uint64(min(begin + CHUNK, end))


@inlined
def _best_chunk(low: Index, high: Index, scenarios: ScenarioArrays, rows: Rows) -> int:
    """Compute one chunk of rows in two loops.

    Each loop is small enough for the vector registers. Between them the target in the vehicle's
    frame lies in the output arrays.

    Returns how many rows are left: those of a huge heading, and those without a finite length. The
    count has a second use: LLVM interleaves two vectors only in loops that have a reduction.
    """
    x, y, heading, tx, ty, radius = scenarios
    length, segments, word = rows
    first = segments[0]
    second = segments[1]
    rows_left = 0
    for i in range(low, high):
        sine, cosine = sine_cosine(heading[i])
        X, Y, four_delta = to_local(x[i], y[i], sine, cosine, tx[i], ty[i], radius[i])
        first[i] = X
        second[i] = abs(Y)
        length[i] = four_delta
        word[i] = 0 if Y >= 0.0 else 1
        rows_left += not (abs(heading[i]) <= LARGEST_ANGLE)
    for i in range(low, high):
        a, b, code, clear = _best(first[i], second[i], word[i])
        a *= radius[i]
        b *= radius[i]
        first[i] = a
        second[i] = b
        length[i] = a + b if clear > length[i] else math.nan
        word[i] = code
        rows_left += not (length[i] <= LARGEST)
    return rows_left


@threaded
def _best_rows(begin: int, end: int, scenarios: ScenarioArrays, rows: Rows) -> None:
    for chunk in range(begin, end, CHUNK):
        low, high = chunk_from(chunk, end)
        if _best_chunk(low, high, scenarios, rows):
            for i in range(low, high):
                # delicate rows, huge headings, radii near underflow: the shortest of all words
                if not (abs(scenarios.heading[i]) <= LARGEST_ANGLE and rows.length[i] <= LARGEST):
                    _exactly(i, True, False, False, scenarios, rows)


# Rates of each word's first and last letter. NaN for the third letter, and for the empty word.
RATES = np.full((len(WORDS), 3), math.nan)
RATES[1:, :2] = [(TURN[word[0]], TURN[word[-1]]) for word in WORDS[1:]]


@compiled
def flatten(
    curvature: FloatArray,
    length: FloatArray,
    offsets: np.ndarray[tuple[int], np.dtype[np.int64]],
    flat_curvature: FloatArray,
    flat_length: FloatArray,
) -> None:
    """Write the arcs with a length, path after path.

    Args:
        curvature, length: controls of n paths of at most m arcs, shape (m, n).
        offsets: out, shape (n + 1,): where each path begins in the flat arrays.
        flat_curvature, flat_length: out, with room for m n + 1.
    """
    place = 0
    offsets[0] = 0
    for i in range(curvature.shape[1]):
        for arc in range(curvature.shape[0]):
            # always written, and overwritten if it does not count: quicker than a branch
            flat_curvature[place] = curvature[arc, i]
            flat_length[place] = length[arc, i]
            place += length[arc, i] != 0.0
        offsets[i + 1] = place

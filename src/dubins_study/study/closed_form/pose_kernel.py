"""Legs with a given final heading, over arrays.

It does the same as `study.closed_form.pose`, for millions of legs at once. Arithmetic is strict
IEEE. Lengths need fewer angles than in the scalar form: signs decide which of two lengths a turn
apart LSL has (docs/derivation.md, section 14). Rows whose word or length an ulp decides are
computed with the scalar functions.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.closed_form import pose
from dubins_study.study.closed_form.kernel import CHUNK, LARGEST, NO_PATH, Index, Rows, prepared
from dubins_study.study.closed_form.kernel_compile import compiled, inlined, separate, threaded
from dubins_study.study.closed_form.kernel_math import (
    LARGEST_ANGLE,
    fma,
    full_arctangent,
    quarter_turns,
    quarters_of_turn,
    reduced,
    sine_cosine,
    upper_arctangent,
)
from dubins_study.study.closed_form.pose import WORDS6
from dubins_study.study.words import TURN


class PoseArrays(NamedTuple):
    """n legs as arrays of shape (n,).

    Units are those of `study.scenario.Scenario`.
    """

    x: FloatArray
    y: FloatArray
    heading: FloatArray
    target_x: FloatArray
    target_y: FloatArray
    radius: FloatArray
    final_heading: FloatArray


# the rates of each word's letters: curvature times radius
SIDES = np.array([[TURN[letter] for letter in word] for word in WORDS6])


_PI = math.pi
# at least 4 delta: four times the sum in `pose.pose_delta`, with |x| + |y| at most the extent
_FOUR_EXTENT = 60.0 * EPS
_FOUR_HEADINGS = 4.0 * pose.PER_HEADINGS
# A row is delicate where its distance from an arc's edge (radii or rad), or |V|^2 - 4 of a
# straight, is below this.
_NEAR = 1e-6
# Below this 16 - d^2 the length of RLR or LRL changes by more than 12 per shift of the end.
_STEEP = 0.1

# chords of acos(d / 4) through d = 0, 3 and 4: from the first, its fall, and four times the last's
_CHORD = (math.pi / 2, (math.pi / 2 - math.acos(0.75)) / 3.0, 4.0 * math.acos(0.75))

pose_shortest = separate(pose.pose_shortest)
pose_segments = separate(pose.pose_segments)
_pose_delta = inlined(pose.pose_delta)


def pose_rows(*columns: ArrayLike, branch: str = "best", out: Rows | None = None) -> Rows:
    """Shortest path of every row.

    It is the path of `study.closed_form.pose.pose_shortest`.

    Args:
        columns: those of `PoseArrays`, in their order, shape (n,).
        branch: `best`, or one of `pose.WORDS6`.
        out: arrays to write to (C-contiguous, not overlapping the input); new ones if None.

    Words are indices into `pose.WORDS6`. Only shapes are checked: a row with NaN or a radius that
    is not positive yields NaN.
    """
    arrays, rows = prepared(columns, 3, out)
    legs = PoseArrays(*arrays)
    if branch == "best":
        _best_rows(legs.x.size, legs, rows)
    elif branch in WORDS6:
        _word_rows(legs, WORDS6.index(branch), rows)
    else:
        raise ValueError(f"no branch {branch!r}; choose one of: best, {', '.join(WORDS6)}")
    return rows


@separate
def _exactly(i: int, word: int, legs: PoseArrays, rows: Rows) -> None:
    """Compute row i by the scalar functions.

    The path is that of `word`, or the shortest of all if `word` is negative.
    """
    x, y, heading, tx, ty, radius, final = legs
    R = radius[i]
    dx, dy = (tx[i] - x[i]) / R, (ty[i] - y[i]) / R
    extent = (abs(x[i]) + abs(y[i]) + abs(tx[i]) + abs(ty[i])) / R
    delta = _pose_delta(extent, abs(dx) + abs(dy))
    if word < 0:
        _, code, t, p, q = pose_shortest(dx, dy, heading[i], final[i], delta)
    else:
        code = word
        t, p, q = pose_segments(dx, dy, heading[i], final[i], word, delta)
    sound = R > 0.0 and delta <= LARGEST and t + p + q >= 0.0
    _write(i, t, p, q, code if sound else NO_PATH, R if sound else math.nan, rows)


@inlined
def _write(i: Index, t: float, p: float, q: float, code: int, R: float, rows: Rows) -> None:
    """Write row i of `rows`, in the length unit.

    Segments t, p, q are in radii; `code` is the word's.
    """
    length, segments, word = rows
    segments[0, i] = t * R
    segments[1, i] = p * R
    segments[2, i] = q * R
    length[i] = t * R + p * R + q * R
    word[i] = code


@compiled
def _word_rows(legs: PoseArrays, word: int, rows: Rows) -> None:
    for i in range(legs.x.size):
        _exactly(i, word, legs, rows)


@inlined
def to_body(
    x: float, y: float, heading: float, tx: float, ty: float, radius: float, final: float
) -> tuple[float, float, float, float, float]:
    """End in the start's frame.

    X, Y, sine and cosine of its heading, and that heading in [0, 2 pi).
    """
    sine_a, cosine_a = sine_cosine(heading)
    sine_b, cosine_b = sine_cosine(final)
    inverse = 1.0 / radius
    dx, dy = (tx - x) * inverse, (ty - y) * inverse
    X, Y = fma(dx, cosine_a, dy * sine_a), fma(dy, cosine_a, -dx * sine_a)
    sine = fma(sine_b, cosine_a, -cosine_b * sine_a)
    cosine = fma(cosine_b, cosine_a, sine_b * sine_a)
    return X, Y, sine, cosine, turn_between(heading, final)


@inlined
def turn_between(heading: float, final: float) -> float:
    """Angle between two headings, from 0 to 2 pi.

    It keeps its digits for large headings.
    """
    rest_a, quarters_a = reduced(heading)
    rest_b, quarters_b = reduced(final)
    turn = quarter_turns(quarters_of_turn(quarters_b - quarters_a), rest_b - rest_a)
    return turn + TWO_PI if turn < 0.0 else turn


@inlined
def _turns(forward: bool, backward: bool, turn: float) -> float:
    """Extra turn of CSC's two equal-sided arcs.

    It is 2 pi where the arcs add up to a turn more than `turn`, else 0. It is 0 where S lies
    between the first heading and the last one, as they turn.
    """
    majority = (forward & backward) | ((forward | backward) & (turn > _PI))
    return 0.0 if majority else TWO_PI


@inlined
def _opposite(x1: float, y1: float, turn: float) -> tuple[float, float, float, float]:
    """LSR: t, p, q and the square of p.

    The arguments are the last centre, seen from the first, and the turn.
    """
    square = fma(x1, x1, (y1 - 2.0) * (y1 + 2.0))
    p = math.sqrt(max(square, 0.0))
    t = full_arctangent(fma(p, y1, 2.0 * x1), fma(p, x1, -2.0 * y1))
    q = t - turn
    return t, p, q + TWO_PI if q < 0.0 else q, square


@inlined
def _with_straight(
    X: float, Y: float, s: float, c: float, turn: float
) -> tuple[float, float, float, int, float, float]:
    """Shortest of LSL, RSR, LSR and RSL.

    Returns t, p, q, the word index, the distance from an edge, and a bound of RLR and LRL. The
    distance is zero at the edges where an arc vanishes, |E - C|^2 = 4, and words tie. No path RLR
    or LRL is shorter than the bound.
    """
    back = TWO_PI - turn
    across = fma(X, s, -Y * c)
    # side distance of the last centre from the first: for LSL and RSR, then seen from the end
    left1, right1 = Y + (c - 1.0), -Y + (c - 1.0)
    left2, right2 = across + (c - 1.0), -across + (c - 1.0)
    x_left, x_right = X - s, X + s
    d_left = math.sqrt(fma(x_left, x_left, left1 * left1))
    d_right = math.sqrt(fma(x_right, x_right, right1 * right1))
    lsl = d_left + turn + _turns(left1 >= 0.0, left2 >= 0.0, turn)
    rsr = d_right + back + _turns(right1 >= 0.0, right2 >= 0.0, back)
    mirrored = rsr < lsl
    x1 = x_right if mirrored else x_left
    y1 = right1 if mirrored else left1
    first = full_arctangent(y1, x1)
    last = (back if mirrored else turn) - first
    last = last + TWO_PI if last < 0.0 else last
    same = rsr if mirrored else lsl
    t1, p1, q1, lsr_square = _opposite(x_right, Y - (c + 1.0), turn)
    t2, p2, q2, rsl_square = _opposite(x_left, -Y - (c + 1.0), back)
    lsr = t1 + p1 + q1 if lsr_square >= 0.0 else math.inf
    rsl = t2 + p2 + q2 if rsl_square >= 0.0 else math.inf
    second = rsl < lsr
    crossed = rsl if second else lsr
    cross = crossed < same
    t = (t2 if second else t1) if cross else first
    p = (p2 if second else p1) if cross else (d_right if mirrored else d_left)
    q = (q2 if second else q1) if cross else last
    word = (3 if second else 2) if cross else (1 if mirrored else 0)
    runner_up = min(max(same, crossed), min(max(lsl, rsr), max(lsr, rsl)))
    edges = min(min(abs(left1), abs(right1)), min(abs(left2), abs(right2)))
    squares = min(abs(lsr_square), abs(rsl_square))
    clear = min(runner_up - min(same, crossed), min(edges, squares) - _NEAR)
    least = min(least_bound(d_left, turn), least_bound(d_right, back))
    return t, p, q, word, clear, least


@inlined
def least_bound(d: float, turn: float) -> float:
    """Lower bound of LRL's length, centres d apart.

    The length is p + t + q, where t + q = turn + p - 2 pi k. The middle arc p = pi + 2 acos(d / 4)
    is above pi and twice two chords of the arccosine, and below 2 pi - d / 2. k is 0 for a turn so
    small that t + q would be negative.
    """
    p = _PI + 2.0 * min(_CHORD[0] - _CHORD[1] * d, _CHORD[2] - 0.25 * _CHORD[2] * d)
    whole = 0.0 if turn < 0.5 * d else TWO_PI
    return max(p, 2.0 * p + (turn - whole)) if d <= 4.0 else math.inf


@inlined
def _three_arcs(x1: float, y1: float, turn: float) -> tuple[float, float, float, float, float]:
    """LRL: its arcs and its distances from edges.

    Returns t, p, q, how far an arc is from vanishing, and 16 - d^2, which is negative where LRL has
    no path. Here (x1, y1) is the last arc's centre seen from the first one's, and d its distance.
    """
    square = fma(x1, x1, y1 * y1)
    room = 16.0 - square
    # pi + 2 acos(d / 4), by the double angle: one root
    middle = _PI + upper_arctangent(math.sqrt(max(room * square, 0.0)), square - 8.0)
    t = full_arctangent(y1, x1) + 0.5 * middle
    t = t - TWO_PI if t >= TWO_PI else t
    q = turn - t + middle
    q = q + TWO_PI if q < 0.0 else q
    q = q - TWO_PI if q >= TWO_PI else q
    return t, middle, q, min(min(t, TWO_PI - t), min(q, TWO_PI - q)), room


@inlined
def _curves_only(
    X: float, Y: float, s: float, c: float, turn: float, best: float
) -> tuple[float, float, float, int, float]:
    """Shorter of RLR and LRL.

    Returns t, p, q, the word index, and how clearly its length differs from `best`. Where its
    length is steep, it is clear only if it is longer than the best of the other words.
    """
    t1, p1, q1, edge1, room1 = _three_arcs(X + s, -Y + (c - 1.0), TWO_PI - turn)
    t2, p2, q2, edge2, room2 = _three_arcs(X - s, Y + (c - 1.0), turn)
    rlr = t1 + p1 + q1 if room1 >= 0.0 else math.inf
    lrl = t2 + p2 + q2 if room2 >= 0.0 else math.inf
    left = lrl < rlr
    shorter = lrl if left else rlr
    gap = min(best - shorter, abs(lrl - rlr)) if shorter < best else shorter - best
    gap1 = min(gap, rlr - best - _NEAR) if abs(room1) < _STEEP else gap
    gap2 = min(gap1, lrl - best - _NEAR) if abs(room2) < _STEEP else gap1
    clear = min(gap2, min(edge1, edge2) - _NEAR)
    return t2 if left else t1, p2 if left else p1, q2 if left else q1, 4 + left, clear


@inlined
def _best_block(
    begin: int,
    end: int,
    legs: PoseArrays,
    rows: Rows,
    scratch: FloatArray,
    waiting: NDArray[np.int64],
) -> int:
    """Compute one block of rows.

    The steps are the change of frame, then the words with a straight, then RLR and LRL where they
    count. Returns how many rows are left: delicate ones, and those without a finite length. The
    loops pass values on in `scratch`, shape (7, `CHUNK`), and `waiting`, shape (`CHUNK`,).
    """
    x, y, heading, tx, ty, radius, final = legs
    length = rows.length
    X = scratch[0]
    Y = scratch[1]
    sine = scratch[2]
    cosine = scratch[3]
    turn = scratch[4]
    best = scratch[5]
    least = scratch[6]
    low = np.uint64(begin)
    n = np.uint64(end - begin)
    rows_left = 0
    for j in range(n):
        i = low + j
        X[j], Y[j], sine[j], cosine[j], angle = to_body(
            x[i], y[i], heading[i], tx[i], ty[i], radius[i], final[i]
        )
        reducible = (abs(heading[i]) <= LARGEST_ANGLE) & (abs(final[i]) <= LARGEST_ANGLE)
        turn[j] = angle if reducible else math.nan
        rows_left += not reducible
    for j in range(n):
        i = low + j
        t, p, q, code, clear, least[j] = _with_straight(X[j], Y[j], sine[j], cosine[j], turn[j])
        best[j] = t + p + q
        _write(i, t, p, q, code, radius[i], rows)
        sound = _is_clear(clear, x[i], y[i], tx[i], ty[i], radius[i])
        length[i] = length[i] if sound else math.nan
        rows_left += not (length[i] <= LARGEST)
    count = 0
    for j in range(n):
        # always written, and overwritten if RLR and LRL cannot be shorter
        waiting[count] = j
        count += least[j] <= best[j]
    for k in range(count):
        j = waiting[k]
        X[k], Y[k], sine[k], cosine[k] = X[j], Y[j], sine[j], cosine[j]
        turn[k], best[k] = turn[j], best[j]
    # up to a whole number of vectors: a remainder would be computed one by one
    for k in range(min((count + 15) // 16 * 16, CHUNK)):
        t, p, q, code, clear = _curves_only(X[k], Y[k], sine[k], cosine[k], turn[k], best[k])
        # from here on the scratch arrays hold these instead
        X[k], Y[k], sine[k], cosine[k], turn[k] = t, p, q, code, clear
    for k in range(count):
        i = low + np.uint64(waiting[k])
        if not _is_clear(turn[k], x[i], y[i], tx[i], ty[i], radius[i]):
            length[i] = math.nan
            rows_left += 1
        elif X[k] + Y[k] + sine[k] < best[k] and length[i] <= LARGEST:
            _write(i, X[k], Y[k], sine[k], int(cosine[k]), radius[i], rows)
    return rows_left


@inlined
def _is_clear(clear: float, x: float, y: float, tx: float, ty: float, radius: float) -> bool:
    """Whether a distance in radii is above 4 delta."""
    extent = abs(x) + abs(y) + abs(tx) + abs(ty)
    return clear * radius > _FOUR_EXTENT * extent + _FOUR_HEADINGS * radius


@threaded
def _best_rows(begin: int, end: int, legs: PoseArrays, rows: Rows) -> None:
    scratch = np.empty((7, CHUNK))
    waiting = np.empty(CHUNK, np.int64)
    for low in range(begin, end, CHUNK):
        high = min(low + CHUNK, end)
        if _best_block(low, high, legs, rows, scratch, waiting):
            for i in range(low, high):
                if not rows.length[i] <= LARGEST:
                    _exactly(i, -1, legs, rows)  # -1: the shortest of all words

"""Closed form of a leg to a given heading.

It holds the six words, and the shortest of them. Everything is in units of the radius, with the
start at the origin (docs/derivation.md, section 14). `study.closed_form.pose_kernel` does the same
for arrays.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dubins_study.study.angle import TWO_PI
from dubins_study.study.body_coordinates import EPS, PER_DISTANCE, PER_EXTENT
from dubins_study.study.closed_form.shortest import Shortest, as_path, named
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose
from dubins_study.study.words import POSE_BRANCHES

WORDS6 = POSE_BRANCHES[1:]
# Error of a pose beside that of `body_coordinates`: by the rounding of both headings, of their
# sines and cosines, and of the circles' centres (docs/derivation.md, section 14).
PER_HEADINGS = 16.0 * EPS

_PI = math.pi
_NEAR_ZERO = 1e-3  # rad; the sign of a smaller angle is taken from coordinates, not from the angle


class Leg(NamedTuple):
    """A question in units of the radius.

    The end is at (x, y) from the start; the headings are a and b (rad). `delta` is the uncertainty
    of the data: every end whose two coordinates in the start's frame and whose heading there are
    within delta of these stands for the same question.
    """

    x: float
    y: float
    a: float
    b: float
    delta: float


def leg(start: Pose, end: Pose, radius: float) -> Leg:
    """Leg between two poses (docs/derivation.md, section 14)."""
    x = (end.x - start.x) / radius
    y = (end.y - start.y) / radius
    extent = (abs(start.x) + abs(start.y) + abs(end.x) + abs(end.y)) / radius
    delta = pose_delta(extent, abs(x) + abs(y))
    return Leg(x, y, a=start.heading, b=end.heading, delta=delta)


# Python runs the functions from here to `pose_gradient` for one leg; `pose_kernel` compiles the
# same functions for arrays. So they take and return plain numbers.


def pose_delta(extent: float, distance: float) -> float:
    """Uncertainty of a leg.

    The arguments are the sum of the four coordinates' sizes in radii, and |x| + |y|.
    """
    return PER_EXTENT * extent + PER_DISTANCE * distance + PER_HEADINGS


def pose_shortest(
    x: float, y: float, a: float, b: float, delta: float
) -> tuple[float, int, float, float, float]:
    """Length, word index and segments of the shortest path.

    If words are equally long, it is the first of them.
    """
    X, Y, sine, cosine = body_pose(x, y, a, b)
    best = math.inf
    index = 0
    t = math.nan
    p = math.nan
    q = math.nan
    for word_index in range(6):
        t1, p1, q1 = word_in_body(X, Y, sine, cosine, word_index, delta)
        length = t1 + p1 + q1
        if length < best:  # False for NaN
            best = length
            index = word_index
            t = t1
            p = p1
            q = q1
    return best, index, t, p, q


def pose_segments(
    x: float, y: float, a: float, b: float, word_index: int, delta: float
) -> tuple[float, float, float]:
    """Segments of a word (radii, rad).

    An arc is given as its angle (rad). All three are NaN where the word has no path.

    An end within delta / 2 of an edge of the word is taken to be there. Where an arc vanishes it is
    nothing, not a full turn. The edge of the word's reach belongs to its reach. The middle arc of
    RLR and LRL is at least pi.

    Args:
        x, y: the end, seen from the start (radii).
        a, b: headings of the start and of the end (rad).
        word_index: of `WORDS6`.
        delta: uncertainty of the data, as `pose_delta` has it.
    """
    X, Y, sine, cosine = body_pose(x, y, a, b)
    return word_in_body(X, Y, sine, cosine, word_index, delta)


def body_pose(x: float, y: float, a: float, b: float) -> tuple[float, float, float, float]:
    """End in the start's frame.

    X, Y, and the sine and cosine of its heading there.
    """
    sine_a = math.sin(a)
    cosine_a = math.cos(a)
    sine_b = math.sin(b)
    cosine_b = math.cos(b)
    X, Y = x * cosine_a + y * sine_a, y * cosine_a - x * sine_a
    return X, Y, sine_b * cosine_a - cosine_b * sine_a, cosine_b * cosine_a + sine_b * sine_a


def word_in_body(
    X: float, Y: float, sine: float, cosine: float, word_index: int, delta: float
) -> tuple[float, float, float]:
    """`pose_segments` of an end in the start's frame.

    The end is given as `body_pose` returns it.
    """
    if word_index in (1, 3, 4):  # the mirror images of LSL, LSR and LRL
        Y = -Y
        sine = -sine
    if word_index < 2:
        return _left_straight_left(X, Y, sine, cosine, delta)
    if word_index < 4:
        return _left_straight_right(X, Y, sine, cosine, delta)
    return _left_right_left(X, Y, sine, cosine, delta)


# In these three (x1, y1) is the last arc's centre seen from the first one's, in the start's frame.
# (x2, y2) is the same vector in the frame in which the path driven backwards is a path of such a
# word. So where the centres are close and neither arc is known well, the sum of both arcs still is.
# s and c are the sine and cosine of the end's heading in the start's frame.


def _left_straight_left(
    X: float, Y: float, s: float, c: float, delta: float
) -> tuple[float, float, float]:
    """Segments of LSL: first arc, straight, last arc.

    They lead to the end (X, Y) with sine s and cosine c of its heading, known to delta.
    """
    half = 0.5 * delta
    x1, y1 = X - s, Y + (c - 1.0)
    x2, y2 = x1 * c + y1 * s, x1 * s - y1 * c
    # the first arc is within its error of none: the last one turns the whole way
    if abs(y1) <= half and x1 >= -half:
        return 0.0, max(x1, 0.0), _turn(math.atan2(s, c), half)
    # likewise the last arc
    if abs(y2) <= half and x2 >= -half:
        return _turn(math.atan2(s, c), half), max(x2, 0.0), 0.0
    t, q = math.atan2(y1, x1), math.atan2(y2, x2)
    return _on_side(t, y1 >= 0.0), math.hypot(x1, y1), _on_side(q, y2 >= 0.0)


def _left_straight_right(
    X: float, Y: float, s: float, c: float, delta: float
) -> tuple[float, float, float]:
    """Segments of LSR: first arc, straight, last arc.

    They lead to the end (X, Y) with sine s and cosine c of its heading, known to delta. All three
    are NaN where the word has no path.
    """
    half = 0.5 * delta
    x1, y1 = X + s, Y - (c + 1.0)
    x2, y2 = x1 * c + y1 * s, y1 * c - x1 * s
    square = x1 * x1 + (y1 - 2.0) * (y1 + 2.0)
    if square < -2.0 * delta:  # the circles overlap: LSR has no tangent between them
        return math.nan, math.nan, math.nan
    # the first arc is within its error of none: the last one turns the whole way, to the right
    if abs(y1 + 2.0) <= half and x1 >= -half:
        return 0.0, max(x1, 0.0), _turn(math.atan2(-s, c), half)
    # likewise the last arc: the first one turns the whole way, to the left
    if abs(y2 + 2.0) <= half and x2 >= -half:
        return _turn(math.atan2(s, c), half), max(x2, 0.0), 0.0
    p = math.sqrt(max(square, 0.0))
    t = math.atan2(2.0 * x1 + p * y1, p * x1 - 2.0 * y1)
    q = math.atan2(2.0 * x2 + p * y2, p * x2 - 2.0 * y2)
    left = x1 >= 0.0 and y1 >= -2.0
    right = x2 >= 0.0 and y2 >= -2.0
    return _on_side(t, left), p, _on_side(q, right)


def _left_right_left(
    X: float, Y: float, s: float, c: float, delta: float
) -> tuple[float, float, float]:
    """Segments of LRL: first, middle and last arc.

    They lead to the end (X, Y) with sine s and cosine c of its heading, known to delta. All three
    are NaN where the word has no path.
    """
    half = 0.5 * delta
    x1, y1 = X - s, Y + (c - 1.0)
    x2, y2 = x1 * c + y1 * s, x1 * s - y1 * c
    d = math.hypot(x1, y1)
    if d > 4.0 + half:  # no middle circle touches both
        return math.nan, math.nan, math.nan
    if d <= half:  # one circle: a full turn of the middle arc
        return _turn(math.atan2(s, c), half), TWO_PI, 0.0
    # |C - (0, -1)|^2 - 4 of the last centre C: zero where the first arc vanishes
    first = x1 * x1 + y1 * (y1 + 4.0)
    last = x2 * x2 + y2 * (y2 + 4.0)
    # the first arc is within its error of none: the middle and the last one turn the whole way
    if abs(first) <= 2.0 * delta and x1 <= half:
        p = TWO_PI - math.atan2(max(-x1, 0.0), y1 + 2.0)
        return 0.0, p, _turn(_principal(math.atan2(s, c) + p), half)
    # likewise the last arc
    if abs(last) <= 2.0 * delta and x2 <= half:
        p = TWO_PI - math.atan2(max(-x2, 0.0), y2 + 2.0)
        return _turn(_principal(math.atan2(s, c) + p), half), p, 0.0
    middle = 0.5 * _PI + math.atan2(math.sqrt(max((4.0 - d) * (4.0 + d), 0.0)), d)
    t = _principal(math.atan2(y1, x1) + middle)
    q = _principal(math.atan2(y2, x2) + middle)
    left = first <= 0.0 or x1 > 0.0
    right = last <= 0.0 or x2 > 0.0
    return _on_side(t, left), 2.0 * middle, _on_side(q, right)


def _principal(angle: float) -> float:
    """Angle in (-pi, 3 pi] brought to (-pi, pi]."""
    return angle if angle <= _PI else angle - TWO_PI


def _turn(angle: float, uncertainty: float) -> float:
    """Angle in (-pi, pi] brought to [0, 2 pi).

    It is zero where it is within its uncertainty of zero.
    """
    if abs(angle) <= uncertainty:
        return 0.0
    return angle if angle > 0.0 else angle + TWO_PI


def _on_side(angle: float, positive: bool) -> float:
    """Angle in (-pi, pi] brought to [0, 2 pi].

    Next to zero it has the sign that is given.
    """
    if abs(angle) < _NEAR_ZERO:
        return max(angle, 0.0) if positive else min(angle, 0.0) + TWO_PI
    return angle if angle > 0.0 else angle + TWO_PI


def pose_gradient(word_index: int, t: float, p: float, q: float) -> tuple[float, float]:
    """Derivatives of a word's length by both headings.

    Lengths are in radii; the headings are those of the start and of the end. The derivatives are
    the distances of both ends from the line on which the path's costates have their inflections
    (docs/derivation.md, eq. 16). They are infinite or huge where a middle arc is pi.

    Args:
        word_index: of `WORDS6`.
        t, p, q: its segments, as `pose_segments` returns them.
    """
    first, last = math.sin(0.5 * t), math.sin(0.5 * q)
    d_first, d_last = 2.0 * first * first, 2.0 * last * last
    if word_index >= 4:
        slope = math.tan(0.5 * p)
        d_first -= slope * math.sin(t)
        d_last -= slope * math.sin(q)
    d_first = d_first if word_index in (1, 3, 4) else -d_first
    return d_first, -d_last if word_index in (1, 2, 4) else d_last


def pose_curvatures(word_index: int, t: float, p: float, q: float) -> tuple[float, float, float]:
    """Second derivatives of a word's length by both headings.

    They are 11, 12 and 22, for lengths in radii. They are infinite or huge where a straight
    vanishes or a middle arc is pi. Arguments are those of `pose_gradient`; these are its
    derivatives while the end stays where it is.
    """
    if word_index < 4:
        first, last = math.sin(t), math.sin(q)
        inverse = 1.0 / p if p > 0.0 else math.inf
        return (
            first * (1.0 + first * inverse) if first != 0.0 else 0.0,
            first * last * inverse if first * last != 0.0 else 0.0,
            last * (1.0 + last * inverse) if last != 0.0 else 0.0,
        )
    half = 0.5 * p
    sine = math.sin(half)
    rho = -1.0 / math.cos(half)
    u, v = half - t, q - half
    across, along = 0.25 * rho / sine, 0.25 * sine * rho**3
    return (
        rho * math.sin(u) - across * math.sin(u) ** 2 - along * math.cos(u) ** 2,
        across * math.sin(u) * math.sin(v) + along * math.cos(u) * math.cos(v),
        -rho * math.sin(v) - across * math.sin(v) ** 2 - along * math.cos(v) ** 2,
    )


def shortest_to_pose(
    start: Pose, end: Pose, radius: float, branch: str = "best"
) -> Shortest | None:
    """Shortest path of a branch to a pose.

    A branch is `best` or one of `WORDS6`. None where it has no path.
    """
    x, y, a, b, delta = leg(start, end, radius)
    if branch == "best":
        _, index, t, p, q = pose_shortest(x, y, a, b, delta)
    else:
        index = WORDS6.index(branch)
        t, p, q = pose_segments(x, y, a, b, index, delta)
    if math.isnan(t):
        return None
    return named(WORDS6[index], (t, p, q))


def pose_path(start: Pose, end: Pose, radius: float, branch: str = "best") -> Path | None:
    """Shortest path to a pose, as controls.

    None where the branch has none.
    """
    shortest = shortest_to_pose(start, end, radius, branch)
    if shortest is None:
        return None
    return as_path(start, radius, shortest.word, shortest.segments)

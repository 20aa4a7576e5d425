"""The six words of one leg in compiled code, for headings that a search varies.

Everything is in units of the turning radius; words as in `study.closed_form.pose.WORDS6`.
"""

from __future__ import annotations

import math

from dubins_study.study.closed_form.kernel_compile import separate

_PI, _TWO_PI = math.pi, 2 * math.pi
# Rounding moves an arc's end by less. An arc that is less than this short of a full turn is none,
# and circles that overlap by less touch.
_ROUNDING = 1e-14


@separate
def turns(word: int) -> tuple[float, float]:
    """The turns of a word's first and last arc, 1 to the left; words as in `pose.WORDS6`."""
    first = 1.0 if word == 0 or word == 2 or word == 5 else -1.0
    return first, (-first if word == 2 or word == 3 else first)


@separate
def between(x: float, y: float, s1: float, s2: float, t1: float, t2: float) -> tuple[float, float]:
    """From the first arc's centre to the last one's."""
    return (
        x - s2 * math.sin(t2) + s1 * math.sin(t1),
        y + s2 * math.cos(t2) - s1 * math.cos(t1),
    )


@separate
def straight_direction(dx: float, dy: float, s1: float, s2: float) -> float:
    """The heading on the straight, given the way between the centres; at most 3 pi / 2."""
    angle = math.atan2(dy, dx)
    if s1 != s2:
        square = dx * dx + dy * dy - 4.0
        angle += s1 * math.atan2(2.0, math.sqrt(max(square, 0.0)))
    return angle


@separate
def _turned(angle: float) -> float:
    """An angle brought to [0, 2 pi)."""
    angle -= _TWO_PI * math.floor(angle / _TWO_PI)
    return 0.0 if angle > _TWO_PI - _ROUNDING else angle


@separate
def word_segments(
    x: float, y: float, t1: float, t2: float, word: int
) -> tuple[float, float, float]:
    """The three segments of a word from (0, 0, t1) to (x, y, t2); NaN where it has no path."""
    s1, s2 = turns(word)
    dx, dy = between(x, y, s1, s2, t1, t2)
    square = dx * dx + dy * dy
    if word >= 4:
        if square > 16.0:
            return math.nan, math.nan, math.nan
        psi = _PI - math.asin(0.25 * math.sqrt(square))
        axis = math.atan2(dy, dx)
        return _turned(psi + s1 * (axis - t1)), 2.0 * psi, _turned(psi + s1 * (t2 - axis))
    if s1 != s2:
        square -= 4.0
        if square < -_ROUNDING:
            return math.nan, math.nan, math.nan
    direction = straight_direction(dx, dy, s1, s2)
    p = math.sqrt(max(square, 0.0))
    return _turned(s1 * (direction - t1)), p, _turned(s2 * (t2 - direction))


@separate
def nearest_segments(
    x: float, y: float, t1: float, t2: float, word: int
) -> tuple[float, float, float]:
    """The segments of a word that exists or nearly does: arcs from -1 on, a straight 0 for none."""
    s1, s2 = turns(word)
    dx, dy = between(x, y, s1, s2, t1, t2)
    square = dx * dx + dy * dy
    if word >= 4:
        middle, angle = _PI - math.asin(0.25 * min(4.0, math.sqrt(square))), math.atan2(dy, dx)
        a, p, c = middle + s1 * (angle - t1), 2.0 * middle, middle + s1 * (t2 - angle)
    else:
        angle = straight_direction(dx, dy, s1, s2)
        p = math.sqrt(max(square - (0.0 if s1 == s2 else 4.0), 0.0))
        a, c = s1 * (angle - t1), s2 * (t2 - angle)
    a -= _TWO_PI * math.floor((a + 1.0) / _TWO_PI)
    c -= _TWO_PI * math.floor((c + 1.0) / _TWO_PI)
    return a, p, c


@separate
def shortest_word(
    x: float, y: float, t1: float, t2: float
) -> tuple[float, int, float, float, float]:
    """Length, word and segments of the shortest path from (0, 0, t1) to (x, y, t2)."""
    best, index, t, p, q = math.inf, 0, math.nan, math.nan, math.nan
    for word in range(6 if x * x + y * y < 16.0 else 4):
        t_, p_, q_ = word_segments(x, y, t1, t2, word)
        length = t_ + p_ + q_
        if length < best:  # False for NaN
            best, index, t, p, q = length, word, t_, p_, q_
    return best, index, t, p, q

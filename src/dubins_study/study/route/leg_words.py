"""Where the arcs of a leg's six words lie, for headings that a search varies.

Everything is in units of the turning radius; words as in `study.closed_form.pose.WORDS6`.
"""

from __future__ import annotations

import math

from dubins_study.study.closed_form.kernel_compile import separate

_PI, _TWO_PI = math.pi, 2 * math.pi


@separate
def principal(angle: float) -> float:
    """An angle brought to [-pi, pi)."""
    return angle - _TWO_PI * math.floor(angle / _TWO_PI + 0.5)


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

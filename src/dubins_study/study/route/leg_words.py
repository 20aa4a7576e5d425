"""Where the arcs of a leg's six words lie, for headings that a search varies.

Everything is in units of the turning radius; words as in `study.closed_form.pose.WORDS6`.
"""

from __future__ import annotations

import math

from dubins_study.study.angle import TWO_PI
from dubins_study.study.closed_form.kernel_compile import separate


@separate
def principal(angle: float) -> float:
    """An angle brought to [-pi, pi)."""
    return angle - TWO_PI * math.floor(angle / TWO_PI + 0.5)


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

"""Geometry of a leg's six words.

The headings at both ends may vary. Everything is in units of the turning radius; words are those of
`study.closed_form.pose.WORDS6`.
"""

from __future__ import annotations

import math

from dubins_study.study.angle import TWO_PI
from dubins_study.study.closed_form.kernel_compile import separate


@separate
def principal(angle: float) -> float:
    """Angle brought to [-pi, pi)."""
    return angle - TWO_PI * math.floor(angle / TWO_PI + 0.5)


@separate
def turns(word: int) -> tuple[float, float]:
    """Turns of a word's first and last arc.

    A turn to the left is 1, to the right -1; words are those of `pose.WORDS6`.
    """
    first = 1.0 if word == 0 or word == 2 or word == 5 else -1.0
    return first, (-first if word == 2 or word == 3 else first)


@separate
def between(x: float, y: float, s1: float, s2: float, t1: float, t2: float) -> tuple[float, float]:
    """Way from the first arc's centre to the last.

    The leg ends at (x, y). Its arcs turn by s1 and s2 (`turns`), its headings are t1 and t2.
    """
    return (
        x - s2 * math.sin(t2) + s1 * math.sin(t1),
        y + s2 * math.cos(t2) - s1 * math.cos(t1),
    )


@separate
def straight_direction(dx: float, dy: float, s1: float, s2: float) -> float:
    """Heading on the straight.

    It is at most 3 pi / 2. (dx, dy) is the way between the centres.
    """
    angle = math.atan2(dy, dx)
    if s1 != s2:
        square = dx * dx + dy * dy - 4.0
        angle += s1 * math.atan2(2.0, math.sqrt(max(square, 0.0)))
    return angle

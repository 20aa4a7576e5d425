"""Read angles as people write them.

Examples are `120deg`, `2.0944` and `2pi/3`.
"""

from __future__ import annotations

import math
import re

from dubins_study.errors import DubinsStudyError
from dubins_study.study.values import short

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
# sign, number, unit; or pi and its divisor
_ANGLE = re.compile(rf"([+-]?)({_NUMBER})?\s*(?:(deg|°|rad)|\*?\s*(pi)(?:\s*/\s*({_NUMBER}))?)?")
TWO_PI = 2 * math.pi  # rad, a full turn
# rad; largest number without a unit. A full turn may be written with few digits, such as 6.2832.
LARGEST_BARE = TWO_PI * (1 + 1e-4)


class AngleError(DubinsStudyError, ValueError):
    """The text is not an angle."""


def parse_angle(text: str | float) -> float:
    """Angle in radians, from a number or a text.

    Angles are counter-clockwise. A number is in radians. A text is like `120deg`, `2.0944`, `7rad`,
    `-pi/2`, `2pi/3` or `0.5*pi`.

    A number, or a text without a unit, may be at most a full turn.

    Raises:
        AngleError: if it is not an angle.
    """
    value = _evaluate(str(text).strip())
    if value is None or not math.isfinite(value):
        raise AngleError(f"{short(text)} is not an angle; expected e.g. 120deg, 2.0944 or 2pi/3")
    return value


def _evaluate(text: str) -> float | None:
    """Radians of a text; None if no angle.

    Raises:
        AngleError: if a number without a unit is more than a full turn.
    """
    match = _ANGLE.fullmatch(text)
    if match is None:
        return None
    sign, number, unit, pi, divisor = match.groups()
    # such as "deg", or "pi/0"
    if not (number or pi) or float(divisor or 1) == 0:
        return None
    value = float(f"{sign}{number or 1}")
    if pi:
        return value * math.pi / float(divisor or 1)
    if unit == "rad":
        return value
    if unit:
        return math.radians(value)
    if LARGEST_BARE < abs(value) < math.inf:
        remedy = "write its unit, deg or rad"
        if len(text) < 40:
            remedy = f"write {text}deg, or {text}rad"
        raise AngleError(f"{short(text)[1:-1]} is more than a full turn; {remedy}")
    return value

"""Angles as people write them: `120deg`, `2.0944`, `2pi/3`."""

from __future__ import annotations

import math
import re

from dubins_study.errors import DubinsStudyError
from dubins_study.study.values import short

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_WITH_UNIT = re.compile(rf"([+-]?{_NUMBER})\s*(deg|°|rad)")
_PI = re.compile(rf"([+-]?)({_NUMBER})?\s*\*?\s*pi(?:\s*/\s*({_NUMBER}))?")
_NO_UNIT = re.compile(rf"[+-]?{_NUMBER}")
TWO_PI = 2 * math.pi  # rad, a full turn
# rad, of a number without a unit; a full turn written with few digits, such as 6.2832, is still one
LARGEST_BARE = TWO_PI * (1 + 1e-4)


class AngleError(DubinsStudyError, ValueError):
    """The text is not an angle."""


def parse_angle(text: str | float) -> float:
    """Angle in radians, counter-clockwise, from a number (radians) or a text.

    A text is like `120deg`, `2.0944`, `7rad`, `-pi/2`, `2pi/3` or `0.5*pi`; without a unit, and as
    a number, it is in radians, up to a full turn. Anything else is an `AngleError`.
    """
    value = _evaluate(str(text).strip())
    if value is None or not math.isfinite(value):
        raise AngleError(f"{short(text)} is not an angle; expected e.g. 120deg, 2.0944 or 2pi/3")
    return value


def _evaluate(text: str) -> float | None:
    """Radians, or None if the text is not an angle."""
    if match := _WITH_UNIT.fullmatch(text):
        number = float(match[1])
        return number if match[2] == "rad" else math.radians(number)
    if match := _PI.fullmatch(text):
        sign, factor, divisor = match[1], float(match[2] or 1), float(match[3] or 1)
        if divisor == 0:
            return None
        return (-1 if sign == "-" else 1) * factor * math.pi / divisor
    if not _NO_UNIT.fullmatch(text):
        return None
    value = float(text)
    if LARGEST_BARE < abs(value) < math.inf:
        wanted = (
            f"write {text}deg, or {text}rad" if len(text) < 40 else "write its unit, deg or rad"
        )
        raise AngleError(f"{short(text)[1:-1]} is more than a full turn; {wanted}")
    return value

"""Angles as people write them: `120deg`, `2.0944`, `2pi/3`."""

from __future__ import annotations

import math
import re

from dubins_study.errors import DubinsStudyError

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_DEGREES = re.compile(rf"([+-]?{_NUMBER})\s*(?:deg|°)")
_PI = re.compile(rf"([+-]?)({_NUMBER})?\s*\*?\s*pi(?:\s*/\s*({_NUMBER}))?")
_RADIANS = re.compile(rf"[+-]?{_NUMBER}")


class AngleError(DubinsStudyError, ValueError):
    """The text is not an angle."""


def parse_angle(text: str | float) -> float:
    """Angle in radians, counter-clockwise.

    Args:
        text: a number (radians) or a text such as `120deg`, `2.0944`, `-pi/2`, `2pi/3`, `0.5*pi`.

    Raises:
        AngleError: if the text is none of these, or not finite.
    """
    value = _evaluate(text.strip()) if isinstance(text, str) else float(text)
    if value is None or not math.isfinite(value):
        raise AngleError(f"{text!r} is not an angle; expected e.g. 120deg, 2.0944 or 2pi/3")
    return value


def _evaluate(text: str) -> float | None:
    if match := _DEGREES.fullmatch(text):
        return math.radians(float(match[1]))
    if match := _PI.fullmatch(text):
        sign, factor, divisor = match[1], float(match[2] or 1), float(match[3] or 1)
        if divisor == 0:
            return None
        return (-1 if sign == "-" else 1) * factor * math.pi / divisor
    return float(text) if _RADIANS.fullmatch(text) else None

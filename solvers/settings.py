"""Checks that solvers share on their settings."""

from __future__ import annotations

import math
from collections.abc import Collection


def one_of(**settings: tuple[str, Collection[str]]) -> None:
    """Refuse a setting that is not one of its choices.

    Raises:
        ValueError: naming the setting, its value and the choices.
    """
    for name, (value, choices) in settings.items():
        if value not in choices:
            raise ValueError(f"{name} is {value!r}; expected one of: {', '.join(choices)}")


def positive(**settings: float) -> None:
    """Refuse a number that is not above zero, or not finite.

    Raises:
        ValueError: naming the setting and its value.
    """
    for name, value in settings.items():
        if not (value > 0 and math.isfinite(value)):
            raise ValueError(f"{name} is {value}; expected a number above 0")

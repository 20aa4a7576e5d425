"""Checks that solvers share on their settings and packages. A refusal is a ValueError that names
the setting, its value and what was expected.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Collection

from dubins_study.study.values import did_you_mean


def missing_package(*names: str) -> str | None:
    """Which of some packages cannot be imported here, as a reason; None if all can."""
    for name in names:
        if importlib.util.find_spec(name) is None:
            return f"the package {name} is not installed"
    return None


def one_of(**settings: tuple[str, Collection[str]]) -> None:
    """Refuse a setting that is not one of its choices."""
    for name, (value, choices) in settings.items():
        if value not in choices:
            near = did_you_mean(value, choices)
            raise ValueError(f"{name} is {value!r}; {near}expected one of: {', '.join(choices)}")


def positive(**settings: float) -> None:
    """Refuse a number that is not above zero, or not finite."""
    for name, value in settings.items():
        if not (value > 0 and math.isfinite(value)):
            raise ValueError(f"{name} is {value}; expected a number above 0")


def within(**settings: tuple[float, float, float]) -> None:
    """Refuse a number outside its range; each setting is (value, least, most)."""
    for name, (value, least, most) in settings.items():
        if not least <= value <= most:  # NaN is not either
            raise ValueError(f"{name} is {value}; expected a number from {least:g} to {most:g}")


def whole(**settings: tuple[object, int, int]) -> None:
    """Refuse what is no whole number in a range; each setting is (value, least, most)."""
    for name, (value, least, most) in settings.items():
        if not isinstance(value, int) or isinstance(value, bool) or not least <= value <= most:
            raise ValueError(f"{name} is {value!r}; expected a whole number from {least} to {most}")

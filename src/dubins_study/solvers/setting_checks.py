"""Settings of solvers with what they may be, and whether packages are installed.

`n: int = whole(50, 2, 2000)` declares one; `Solver` refuses another value by a ValueError that
names the setting, its value and what was expected.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable, Collection
from dataclasses import field, fields
from typing import Any

from dubins_study.study.values import did_you_mean


def missing_package(*names: str) -> str | None:
    """Which of some packages cannot be imported here, as a reason; None if all can."""
    for name in names:
        if importlib.util.find_spec(name) is None:
            return f"the package {name} is not installed"
    return None


def check_settings(solver: Any) -> None:
    """Refuse a dataclass with a setting that is not what its declaration says."""
    for setting in fields(solver):
        value, complaint = getattr(solver, setting.name), setting.metadata.get(_COMPLAINT)
        if complaint is not None and (text := complaint(value)):
            raise ValueError(f"{setting.name} is {value!r}; {text}")


_COMPLAINT = object()  # the key of what says why a value is refused


def _setting(default: Any, complaint: Callable[[Any], str | None]) -> Any:
    return field(default=default, metadata={_COMPLAINT: complaint})


def one_of(default: str, choices: Collection[str]) -> Any:
    """A setting that is one of some texts."""

    def complaint(value: Any) -> str | None:
        if value in choices:
            return None
        return f"{did_you_mean(value, choices)}expected one of: {', '.join(choices)}"

    return _setting(default, complaint)


def positive(default: float) -> Any:
    """A finite number above zero."""
    return _setting(
        default,
        lambda value: None if 0 < value < math.inf else "expected a number above 0",
    )


def within(default: float, least: float, most: float, ends: bool = True) -> Any:
    """A number in a range, with its ends or without."""

    def complaint(value: Any) -> str | None:
        inside = least <= value <= most and (ends or least < value < most)  # NaN is not
        return None if inside else f"expected a number from {least:g} to {most:g}"

    return _setting(default, complaint)


def unless_zero(least: float, most: float) -> Any:
    """A number in a range, or 0: another setting decides."""

    def complaint(value: Any) -> str | None:
        right = value == 0 or least <= value <= most
        return None if right else f"expected 0, or a number from {least:g} to {most:g}"

    return _setting(0.0, complaint)


def whole(default: int, least: int, most: int) -> Any:
    """A whole number in a range."""

    def complaint(value: Any) -> str | None:
        right = isinstance(value, int) and not isinstance(value, bool) and least <= value <= most
        return None if right else f"expected a whole number from {least} to {most}"

    return _setting(default, complaint)

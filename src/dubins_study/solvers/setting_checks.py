"""Settings of solvers with what they may be, sets of engines' options, and what is installed.

`n: int = whole(50, 2, 2000)` declares one; `Solver` refuses another value by a ValueError that
names the setting, its value and what was expected.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import field, fields
from types import MappingProxyType
from typing import Any, NamedTuple

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


# Three sets of options for every engine: equal tolerances, its makers' defaults, their advice. An
# option that no set names is left to the engine.
# `equal` comes first: it is the default of the setting `options`.
OPTION_SETS = ("equal", "default", "tuned")

# Of the set `equal`: a thousandth of what counts as arriving (`study.tolerances.ARRIVES`), and what
# qpbenchmark asks for as high accuracy.
FEASIBILITY = OPTIMALITY = 1e-9


class Options(NamedTuple):
    """An engine's options, by its own names; a dot leads into a table of options."""

    feasibility: tuple[str, ...] = ()  # tolerances on equations
    optimality: tuple[str, ...] = ()
    iterations: str = ""  # the limit of iterations
    always: Mapping[str, Any] = MappingProxyType({})  # in every set
    why: str = ""  # of `always`
    tuned: Mapping[str, Any] = MappingProxyType({})  # what the makers advise, beside `always`
    source: str = ""  # of `tuned`

    def of(self, name: str, tol: float = 0.0, max_iter: int = 0) -> dict[str, Any]:
        """The options of a set; a tolerance or a number of iterations other than 0 replaces its."""
        values = dict(self.always)
        if name == "equal":
            values |= dict.fromkeys(self.optimality, OPTIMALITY)
            values |= dict.fromkeys(self.feasibility, FEASIBILITY)
        elif name == "tuned":
            values |= self.tuned
        if tol:
            values |= dict.fromkeys((*self.feasibility, *self.optimality), tol)
        if max_iter and self.iterations:
            values[self.iterations] = max_iter
        return values


def option_set() -> Any:
    """The setting `options`."""
    return one_of(OPTION_SETS[0], OPTION_SETS)


def tolerance() -> Any:
    """The setting `tol`, 0 for that of the engine's options."""
    return unless_zero(1e-14, 1e-2)


def iterations() -> Any:
    """The setting `max_iter`, 0 for that of the engine's options."""
    return whole(0, 0, 10**9)


def nested(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options whose names lead into tables, as tables."""
    tables: dict[str, Any] = {}
    for name, value in options.items():
        table, dot, inner = name.partition(".")
        if dot:
            tables.setdefault(table, {})[inner] = value
        else:
            tables[name] = value
    return tables

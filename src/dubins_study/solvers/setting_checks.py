"""Settings of solvers, their checks, and engines' option sets.

`n: int = whole(50, 2, 2000)` declares one setting. `Solver` refuses another value by a ValueError
that names the setting, its value and what was expected. `missing_package` looks for packages.
"""

from __future__ import annotations

import importlib.util
import math
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import field, fields
from types import MappingProxyType
from typing import Any, NamedTuple

from dubins_study.study.values import did_you_mean


def missing_package(*names: str) -> str | None:
    """The reason that a package is missing, or None.

    The reason names the first package that cannot be imported here.
    """
    for name in names:
        if importlib.util.find_spec(name) is None:
            return f"the package {name} is not installed"
    return None


class _Rule(NamedTuple):
    """The rule of a setting, with its message."""

    holds: Callable[[Any], bool]
    expected: str
    choices: Collection[str] = ()


_RULE = object()  # the key of a setting's rule


def check_settings(solver: Any) -> None:
    """Refuse a solver with a forbidden setting.

    A setting that breaks the rule of its declaration is a ValueError. A setting without a rule is
    not checked.
    """
    for setting in fields(solver):
        value = getattr(solver, setting.name)
        rule = setting.metadata.get(_RULE)
        if rule is not None and not rule.holds(value):
            near = did_you_mean(value, rule.choices)
            raise ValueError(f"{setting.name} is {value!r}; {near}expected {rule.expected}")


def _setting(default: Any, *rule: Any) -> Any:
    return field(default=default, metadata={_RULE: _Rule(*rule)})


def one_of(default: str, choices: Collection[str]) -> Any:
    """Declare a setting that is one of some texts."""
    expected = f"one of: {', '.join(choices)}"
    return _setting(default, lambda value: value in choices, expected, choices)


# No path: it would let the author of an experiment choose the file that is run.
_PROGRAM = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


def name_or_program(default: str, choices: Collection[str], taken: Collection[str]) -> Any:
    """Declare a setting for a text or a program.

    The value is one of some texts, or any other name of a program that is not among `taken`.
    """
    expected = (
        f"one of: {', '.join(choices)}, or the name of an executable on PATH: letters, digits, "
        "'_', '.' and '-', no folders"
    )

    def known(value: str) -> bool:
        return value in choices or (value not in taken and bool(_PROGRAM.fullmatch(value)))

    return _setting(default, known, expected, choices)


def positive(default: float) -> Any:
    """Declare a finite number above zero."""
    return _setting(default, lambda value: 0 < value < math.inf, "a number above 0")


def within(default: float, least: float, most: float, ends: bool = True) -> Any:
    """Declare a number in a range.

    The ends of the range count unless `ends` is False.
    """

    def inside(value: Any) -> bool:
        return least <= value <= most and (ends or least < value < most)  # NaN is not

    return _setting(default, inside, f"a number from {least:g} to {most:g}")


def whole(default: int, least: int, most: int) -> Any:
    """Declare a whole number in a range."""

    def inside(value: Any) -> bool:
        return isinstance(value, int) and not isinstance(value, bool) and least <= value <= most

    return _setting(default, inside, f"a whole number from {least} to {most}")


# Three sets of options for every engine: equal tolerances, its makers' defaults, their advice. An
# option that no set names is left to the engine.
# `equal` comes first: it is the default of the setting `options`.
OPTION_SETS = ("equal", "default", "tuned")

# The tolerances of the set `equal`: a thousandth of the distance that counts as arriving
# (`study.tolerances.ARRIVES`). qpbenchmark asks for the same as high accuracy.
FEASIBILITY = OPTIMALITY = 1e-9


# the values of an engine's options, by its own names
OptionValues = dict[str, Any]


class Options(NamedTuple):
    """An engine's options, by its own names.

    A dot in a name leads into a table of options.
    """

    feasibility: tuple[str, ...] = ()  # tolerances on equations
    optimality: tuple[str, ...] = ()
    iterations: str = ""  # the limit of iterations
    always: Mapping[str, Any] = MappingProxyType({})  # in every set
    why: str = ""  # of `always`
    tuned: Mapping[str, Any] = MappingProxyType({})  # the makers' advice, beside `always`
    source: str = ""  # of `tuned`

    def of(self, name: str, tol: float = 0.0, max_iter: int = 0) -> OptionValues:
        """The options in a set: names and values.

        `name` is one of `OPTION_SETS`. `tol` and `max_iter`, if not 0, replace the set's tolerances
        and limit of iterations.
        """
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


class Keywords(NamedTuple):
    """The names that an executable gives its options.

    An option without a name is not passed on.
    """

    options: Options = Options()
    gap: str = ""  # relative, of branch and bound
    seconds: str = ""

    def until(self, seconds: float) -> OptionValues:
        """The time limit as an option, by its name.

        The limit is rounded down to milliseconds. The result is empty if the executable has no such
        option, or if no time is left.
        """
        limit = math.floor(1000 * seconds) / 1000
        if self.seconds and limit > 0:
            return {self.seconds: limit}
        return {}


def option_set() -> Any:
    """Declare the setting `options`."""
    return one_of(OPTION_SETS[0], OPTION_SETS)


def tolerance() -> Any:
    """Declare the setting `tol`.

    0 stands for the tolerance of the engine's options.
    """
    expected = "0, or a number from 1e-14 to 0.01"
    return _setting(0.0, lambda value: value == 0 or 1e-14 <= value <= 1e-2, expected)


def iterations() -> Any:
    """Declare the setting `max_iter`.

    0 stands for the limit of the engine's options.
    """
    return whole(0, 0, 10**9)


def nested(options: Mapping[str, Any]) -> dict[str, Any]:
    """Options as tables, split at the dots of names.

    `{"ipopt.tol": 1e-9, "expand": True}` becomes `{"ipopt": {"tol": 1e-9}, "expand": True}`.
    """
    tables: dict[str, Any] = {}
    for name, value in options.items():
        table, dot, inner = name.partition(".")
        if dot:
            tables.setdefault(table, {})[inner] = value
        else:
            tables[name] = value
    return tables

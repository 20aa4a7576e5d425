"""Three sets of options for every engine: equal tolerances, its makers' defaults, their advice.

An option that no set names is left to the engine.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

from dubins_study.solvers.setting_checks import one_of, unless_zero, whole

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

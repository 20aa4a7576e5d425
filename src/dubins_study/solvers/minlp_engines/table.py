"""The engines that prove bounds, by the name that specs use; nothing is imported until asked."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import NamedTuple

from dubins_study.solvers.minlp_engines.program import MinlpEngine, Settings
from dubins_study.solvers.setting_checks import missing_package


class MinlpEntry(NamedTuple):
    """An engine of this room.

    Args:
        label: its name as its makers write it, which rows hold.
        package: the package that must be installed. Whether a licence is missing, too small or
            expired is seen when a program is solved, and is then the row's message: to ask for it
            here would load every licensed library for a mere list of solvers.
    """

    label: str
    package: str


# each is a function of its own name in the module of this room that has its name
ENGINES = {
    "scip": MinlpEntry("SCIP", "pyscipopt"),
    "gurobi": MinlpEntry("Gurobi", "gurobipy"),
    "xpress": MinlpEntry("Xpress", "xpress"),
    "maingo": MinlpEntry("MAiNGO", "maingopy"),
}


def engine(name: str, settings: Settings) -> MinlpEngine:
    """The engine of a name in `ENGINES`."""
    module = import_module(f"dubins_study.solvers.minlp_engines.{name}")
    make: Callable[[Settings], MinlpEngine] = getattr(module, name)
    return make(settings)


def unavailable(name: str) -> str | None:
    """Why an engine cannot run here, or None."""
    return missing_package(ENGINES[name].package)

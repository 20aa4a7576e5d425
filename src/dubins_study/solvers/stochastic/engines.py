"""The engines of the penalty function by the name that specs use; none is imported until asked."""

from __future__ import annotations

from importlib import import_module
from typing import NamedTuple

from dubins_study.solvers.setting_checks import missing_package
from dubins_study.solvers.stochastic.search import Engine


class EngineEntry(NamedTuple):
    """An engine of this room.

    Args:
        label: its name as its makers write it, which rows hold.
        evaluations: its budget for one search if none is given. Engines spend from 3 to 100
            microseconds on one evaluation of their own accord, and so the budgets differ: the two
            searches that a target outside the discs takes are over in about 0.15 s.
        place: `module:function` in this room; the function is an `Engine`.
        package: the package that must be installed.
        guided: whether it begins at an initial guess; others search the whole box.
    """

    label: str
    evaluations: int
    place: str
    package: str = "scipy"
    guided: bool = False


_SCIPY = "scipy_engines:"
ENGINES = {
    "differential-evolution": EngineEntry(
        "differential evolution", 8000, _SCIPY + "differential_evolution"
    ),
    "dual-annealing": EngineEntry("dual annealing", 3000, _SCIPY + "dual_annealing"),
    "shgo": EngineEntry("SHGO", 3000, _SCIPY + "shgo"),
    "direct": EngineEntry("DIRECT", 8000, _SCIPY + "direct"),
    "cma-es": EngineEntry("CMA-ES", 1000, "cma_es:cma_es", "cma"),
    # these end by themselves long before
    "nelder-mead": EngineEntry("Nelder-Mead", 3000, _SCIPY + "nelder_mead", guided=True),
    "powell": EngineEntry("Powell", 3000, _SCIPY + "powell", guided=True),
}


def engine(name: str) -> Engine:
    """The engine of a name in `ENGINES`."""
    module, _, function = ENGINES[name].place.partition(":")
    room = __name__.rpartition(".")[0]
    found: Engine = getattr(import_module(f"{room}.{module}"), function)
    return found


def unavailable(name: str) -> str | None:
    """Why an engine cannot run here, or None."""
    return missing_package(ENGINES[name].package)

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
        place: `module:function` in this room; the function is an `Engine`.
        package: the package that must be installed.
        guided: whether it begins at an initial guess; others search the whole box.
    """

    label: str
    place: str
    package: str = "scipy"
    guided: bool = False


_SCIPY = "scipy_engines:"
ENGINES = {
    "differential-evolution": EngineEntry(
        "differential evolution", _SCIPY + "differential_evolution"
    ),
    "dual-annealing": EngineEntry("dual annealing", _SCIPY + "dual_annealing"),
    "shgo": EngineEntry("SHGO", _SCIPY + "shgo"),
    "direct": EngineEntry("DIRECT", _SCIPY + "direct"),
    "cma-es": EngineEntry("CMA-ES", "cma_es:cma_es", "cma"),
    "nelder-mead": EngineEntry("Nelder-Mead", _SCIPY + "nelder_mead", guided=True),
    "powell": EngineEntry("Powell", _SCIPY + "powell", guided=True),
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

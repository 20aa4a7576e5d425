"""The engines of nonlinear programs by the name that specs use; nothing is imported until asked."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from dubins_study.solvers.nlp_engines.program import Engine
from dubins_study.solvers.setting_checks import missing_package


class EngineEntry(NamedTuple):
    """An engine of this room.

    Args:
        label: its name as its makers write it, which rows hold.
        place: `module:function` in this package; the function takes `tol` (the feasibility, and
            with most engines the optimality, asked for) and `max_iter`, and returns an `Engine`.
        packages: the packages that must be installed.
        reason: `module:function` that says why it cannot run here although its packages are
            installed (a licence), or returns None; empty if nothing else is needed.
    """

    label: str
    place: str
    packages: tuple[str, ...]
    reason: str = ""


_CASADI = "dubins_study.solvers.nlp_engines.casadi_nlpsol:"
_APOPT = "dubins_study.solvers.nlp_engines.apopt:"
_CONOPT = "dubins_study.solvers.nlp_engines.conopt_grg:"
_GAMS = "dubins_study.solvers.nlp_engines.gams:"
_NLOPT = "dubins_study.solvers.nlp_engines.nlopt_local:"
_UNO = "dubins_study.solvers.nlp_engines.uno:"
ENGINES = {
    "ipopt": EngineEntry("Ipopt", _CASADI + "ipopt", ("casadi",)),
    "apopt": EngineEntry("APOPT", _APOPT + "apopt", ("gekko",), _APOPT + "unavailable"),
    "conopt": EngineEntry("CONOPT", _CONOPT + "conopt", ("conopt",)),
    "gams-minos": EngineEntry(
        "MINOS", _GAMS + "minos", ("gamspy_base", "gamspy_minos"), _GAMS + "unavailable"
    ),
    "gams-snopt": EngineEntry(
        "SNOPT", _GAMS + "snopt", ("gamspy_base", "gamspy_snopt"), _GAMS + "unavailable"
    ),
    "nlopt-slsqp": EngineEntry("NLopt SLSQP", _NLOPT + "slsqp", ("nlopt",)),
    "nlopt-auglag": EngineEntry("NLopt AUGLAG", _NLOPT + "auglag", ("nlopt",)),
    "nlopt-cobyla": EngineEntry("NLopt COBYLA", _NLOPT + "cobyla", ("nlopt",)),
    "uno-filtersqp": EngineEntry("Uno filterSQP", _UNO + "filtersqp", ("unopy",)),
}


def engine(name: str, tol: float, max_iter: int) -> Engine:
    """The engine of a name in `ENGINES`."""
    made: Engine = _load(ENGINES[name].place)(tol, max_iter)
    return made


def unavailable(name: str) -> str | None:
    """Why an engine cannot run here, or None."""
    entry = ENGINES[name]
    missing = missing_package(*entry.packages)
    if missing or not entry.reason:
        return missing
    reason: str | None = _load(entry.reason)()
    return reason


def _load(place: str) -> Callable[..., Any]:
    module, _, name = place.partition(":")
    function: Callable[..., Any] = getattr(import_module(module), name)
    return function

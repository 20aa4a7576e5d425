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
        keeps_limit: whether a run ends at most a second after its seconds are up.
        fixed_tol: the feasibility, if it is the engine's own whatever `tol` is.
    """

    label: str
    place: str
    packages: tuple[str, ...]
    reason: str = ""
    keeps_limit: bool = True
    fixed_tol: float | None = None


_SCIPY = "dubins_study.solvers.nlp_engines.scipy_minimize:"
_TRUST_CONSTR = "dubins_study.solvers.nlp_engines.trust_constr:trust_constr"
_CASADI = "dubins_study.solvers.nlp_engines.casadi_nlpsol:"
_APOPT = "dubins_study.solvers.nlp_engines.apopt:"
_CONOPT = "dubins_study.solvers.nlp_engines.conopt_grg:"
_GAMS = "dubins_study.solvers.nlp_engines.gams:"
_NLOPT = "dubins_study.solvers.nlp_engines.nlopt_local:"
_UNO = "dubins_study.solvers.nlp_engines.uno:"
ENGINES = {
    "slsqp": EngineEntry("SLSQP", _SCIPY + "slsqp", ("scipy",)),
    "trust-constr": EngineEntry("trust-constr", _TRUST_CONSTR, ("scipy",)),
    "cobyqa": EngineEntry("COBYQA", _SCIPY + "cobyqa", ("scipy",)),
    "ipopt": EngineEntry("Ipopt", _CASADI + "ipopt", ("casadi",)),
    "uno": EngineEntry("Uno", _CASADI + "uno", ("casadi",)),
    "fatrop": EngineEntry("fatrop", _CASADI + "fatrop", ("casadi",), keeps_limit=False),
    "alpaqa": EngineEntry("alpaqa", _CASADI + "alpaqa", ("casadi",), keeps_limit=False),
    "bonmin": EngineEntry("Bonmin", _CASADI + "bonmin", ("casadi",), keeps_limit=False),
    # loads casadi's HiGHS, whose symbols then stand in for those of the package highspy
    "sleqp": EngineEntry("SLEQP", _CASADI + "sleqp", ("casadi",), keeps_limit=False),
    "sqpmethod": EngineEntry("casadi sqpmethod", _CASADI + "sqpmethod", ("casadi",)),
    "qrsqp": EngineEntry("casadi qrsqp", _CASADI + "qrsqp", ("casadi",)),
    "blocksqp": EngineEntry(
        "blockSQP", _CASADI + "blocksqp", ("casadi",), _CASADI + "blocksqp_unavailable"
    ),
    "feasiblesqpmethod": EngineEntry(
        "casadi feasiblesqpmethod",
        _CASADI + "feasiblesqpmethod",
        ("casadi",),
        _CASADI + "feasiblesqpmethod_unavailable",
    ),
    "apopt": EngineEntry("APOPT", _APOPT + "apopt", ("gekko",), _APOPT + "unavailable"),
    "conopt": EngineEntry("CONOPT", _CONOPT + "conopt", ("conopt",), fixed_tol=1e-7),
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


def tolerance(name: str, tol: float) -> float:
    """The feasibility that an engine is run with if it is asked for `tol`."""
    return ENGINES[name].fixed_tol or tol


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

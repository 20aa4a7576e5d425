"""Every optimisation library that a formulation is solved with: one table, by the names of specs.

Nothing is imported until it is asked.
"""

from __future__ import annotations

import ctypes
import re
import subprocess
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path as FilePath
from pkgutil import resolve_name
from types import MappingProxyType
from typing import Any, NamedTuple

from dubins_study.solvers.protocol import Solver
from dubins_study.solvers.setting_checks import missing_package
from dubins_study.study.words import DERIVATIVE_FREE, NLP, PROVEN, QP, ROOTS, SAMPLING


class Engine(NamedTuple):
    """An optimisation library.

    Whether a licence is too small or expired is seen when a problem is solved, and is then the
    row's message: to ask for it here would load every licensed library for a mere list of solvers.
    """

    label: str  # its name as its makers write it, which rows hold
    kind: str  # of the problems that it reads; heads it in tables
    packages: tuple[str, ...]  # those that must be installed
    place: str = ""  # `room.module:function` of its adapter; empty if one solver has it itself
    options: Mapping[str, Any] = MappingProxyType({})  # of the adapter, beside a question's numbers
    broken: str | None = None  # why it answers no question here, though its packages are installed
    check: str = ""  # `room.module:function` that says this, or returns None
    versions: Callable[[], dict[str, str]] | None = None  # of the library inside the package
    keeps_limit: bool = True  # whether a run ends at most a second after its seconds are up
    fixed_tol: float | None = None  # the feasibility, if it is the engine's own whatever is asked
    # The budget of one search if none is given: the two searches that a target outside the discs
    # takes are over in about 0.15 s.
    evaluations: int = 0

    def unavailable(self) -> str | None:
        """Why the engine cannot run here, or None."""
        reason = missing_package(*self.packages) or self.broken
        if reason or not self.check:
            return reason
        checked: str | None = _resolved(self.check)()
        return checked

    def load(self) -> Any:
        """The adapter; what it takes and returns depends on the kind of engine."""
        adapter = _resolved(self.place)
        return partial(adapter, **self.options) if self.options else adapter


def _resolved(place: str) -> Any:
    return resolve_name(f"{__package__}.{place}")


@cache
def ipopt_in_casadi() -> dict[str, str]:
    """The version of the Ipopt library that casadi's wheel carries."""
    import casadi

    # libipopt.so.3, libipopt.3.dylib or libipopt-3.dll
    libraries = sorted(FilePath(casadi.__file__).parent.glob("libipopt*3*"))
    numbers = tuple(ctypes.c_int() for _ in range(3))
    try:
        library = ctypes.CDLL(str(libraries[0]))
        library.GetIpoptVersion(*map(ctypes.byref, numbers))
    except (IndexError, OSError, AttributeError):
        return {"ipopt": "unknown"}
    return {"ipopt": ".".join(str(number.value) for number in numbers)}


@cache
def ipopt_executable() -> dict[str, str]:
    """The version of the executable `ipopt` on PATH, as it prints it."""
    try:
        process = subprocess.run(["ipopt", "-v"], capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired, UnicodeDecodeError):
        return {"ipopt": "unknown"}
    match = re.search(r"\d+(?:\.\d+)+", process.stdout)
    return {"ipopt": match.group() if match else "unknown"}


@cache
def scip_in_pyscipopt() -> dict[str, str]:
    """The version of the SCIP library inside pyscipopt."""
    from pyscipopt import Model

    model = Model()
    parts = (model.getMajorVersion(), model.getMinorVersion(), model.getTechVersion())
    return {"scip": ".".join(map(str, parts))}


def _nlp(label: str, package: str, adapter: str, **more: Any) -> Engine:
    return Engine(label, NLP, (package,), f"nlp_engines.{adapter}", **more)


def _nlpsol(label: str, plugin: str, **more: Any) -> Engine:
    return _nlp(label, "casadi", "casadi_nlpsol:nlpsol", options={"plugin": plugin}, **more)


def _nlopt(label: str, algorithm: str, **inner: str) -> Engine:
    return _nlp(label, "nlopt", "nlopt_local:nlopt", options={"algorithm": algorithm} | inner)


def _gams(label: str, solver: str) -> Engine:
    packages, place = ("gamspy_base", f"gamspy_{solver}"), "nlp_engines.gams:gams"
    check = "nlp_engines.gams:unavailable"
    return Engine(label, NLP, packages, place, {"solver": solver}, check=check)


def _proven(label: str, package: str, name: str, **more: Any) -> Engine:
    return Engine(label, PROVEN, (package,), f"minlp_engines.{name}:{name}", **more)


def _search(label: str, function: str, evaluations: int) -> Engine:
    place = f"stochastic.penalty_function:{function}"
    return Engine(label, SAMPLING, ("scipy",), place, evaluations=evaluations)


def _minimizer(method: str, steps: str, values: str) -> Engine:
    """One that ends by itself long before the budget."""
    options = {"method": method, "steps": steps, "values": values}
    place = "stochastic.penalty_function:minimize"
    return Engine(method, DERIVATIVE_FREE, ("scipy",), place, options, evaluations=3000)


ENGINES = {
    "slsqp": _nlp("SLSQP", "scipy", "scipy_minimize:slsqp"),
    "trust-constr": _nlp("trust-constr", "scipy", "scipy_minimize:trust_constr"),
    "cobyqa": _nlp("COBYQA", "scipy", "scipy_minimize:cobyqa"),
    "ipopt": _nlpsol("Ipopt", "ipopt"),
    "uno": _nlpsol("Uno", "uno"),
    "fatrop": _nlpsol("fatrop", "fatrop", keeps_limit=False),
    "alpaqa": _nlpsol("alpaqa", "alpaqa", keeps_limit=False),
    "bonmin": _nlpsol("Bonmin", "bonmin", keeps_limit=False),
    # loads casadi's HiGHS, whose symbols then stand in for those of the package highspy
    "sleqp": _nlpsol("SLEQP", "sleqp", keeps_limit=False),
    "sqpmethod": _nlpsol("casadi sqpmethod", "sqpmethod"),
    "qrsqp": _nlpsol("casadi qrsqp", "qrsqp"),
    "blocksqp": _nlpsol(
        "blockSQP",
        "blocksqp",
        broken="casadi's wheel lacks the linear solver of blockSQP's quadratic programs (HSL MA27)",
    ),
    "feasiblesqpmethod": _nlpsol(
        "casadi feasiblesqpmethod",
        "feasiblesqpmethod",
        broken="feasiblesqpmethod asks for an initial guess that satisfies all equations",
    ),
    "apopt": _nlp("APOPT", "gekko", "apopt:apopt", check="nlp_engines.apopt:unavailable"),
    "conopt": _nlp("CONOPT", "conopt", "conopt_grg:conopt", fixed_tol=1e-7),
    "gams-minos": _gams("MINOS", "minos"),
    "gams-snopt": _gams("SNOPT", "snopt"),
    "nlopt-slsqp": _nlopt("NLopt SLSQP", "LD_SLSQP"),
    # the augmented Lagrangian of Birgin and Martinez, minimised within the bounds by L-BFGS
    "nlopt-auglag": _nlopt("NLopt AUGLAG", "LD_AUGLAG", inner="LD_LBFGS"),
    "nlopt-cobyla": _nlopt("NLopt COBYLA", "LN_COBYLA"),
    "uno-filtersqp": _nlp("Uno filterSQP", "unopy", "uno:filtersqp"),
    # reads nothing but Pyomo's model of (4.12), with its own tolerances
    "knitro": Engine(
        "KNITRO", NLP, ("knitro",), check="paper_nlp.program:unlicensed", keeps_limit=False
    ),
    "scip": _proven("SCIP", "pyscipopt", "scip", versions=scip_in_pyscipopt),
    "gurobi": _proven("Gurobi", "gurobipy", "gurobi"),
    "xpress": _proven("Xpress", "xpress", "xpress"),
    # counts the processor's seconds, and whole ones
    "maingo": _proven("MAiNGO", "maingopy", "maingo", keeps_limit=False),
    "differential-evolution": _search("differential evolution", "differential_evolution", 8000),
    "dual-annealing": _search("dual annealing", "dual_annealing", 3000),
    "shgo": _search("SHGO", "shgo", 3000),
    "direct": _search("DIRECT", "direct", 8000),
    "cma-es": Engine(
        "CMA-ES", SAMPLING, ("cma",), "stochastic.penalty_function:cma_es", evaluations=1000
    ),
    "nelder-mead": _minimizer("Nelder-Mead", "xatol", "fatol"),
    "powell": _minimizer("Powell", "xtol", "ftol"),
    "hybr": Engine("MINPACK hybr", ROOTS, ("scipy",)),
    "lm": Engine("MINPACK lm", ROOTS, ("scipy",)),
    "piqp": Engine("PIQP", QP, ("cvxpy", "piqp")),
    "clarabel": Engine("Clarabel", QP, ("cvxpy", "clarabel")),
    "osqp": Engine("OSQP", QP, ("cvxpy", "osqp")),
    "highs": Engine("HiGHS", QP, ("cvxpy", "highspy")),
}


def names(*kinds: str) -> tuple[str, ...]:
    """The engines of some kinds, in the order of the table."""
    return tuple(name for name, engine in ENGINES.items() if engine.kind in kinds)


def packages(engines: tuple[str, ...]) -> tuple[str, ...]:
    """The packages of some engines, each once."""
    return tuple(dict.fromkeys(p for name in engines for p in ENGINES[name].packages))


# those with solvers of their own for the paper's model
APART = ("slsqp", "ipopt")
# the engines that read any program of `nlp_engines.program`
NLP_ENGINES = tuple(name for name in names(NLP) if ENGINES[name].place)
MINLP_ENGINES = names(PROVEN)


class EngineSolver(Solver):
    """A solver whose setting `engine` is a name of the table."""

    engine: str

    def unavailable(self) -> str | None:
        return ENGINES[self.engine].unavailable()

    def library_versions(self) -> dict[str, str]:
        versions = ENGINES[self.engine].versions
        return versions() if versions else {}

    @property
    def keeps_limit(self) -> bool:
        return ENGINES[self.engine].keeps_limit


class SearchSolver(EngineSolver):
    """A solver whose engines begin at a guess, but for those that search a whole box."""

    initial_guess: str

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.initial_guess != "bearing" and not self.guided:
            raise ValueError(
                f"initial_guess is {self.initial_guess!r}, but the engine {self.engine} searches "
                "the whole box and takes none; leave it out"
            )

    @property
    def guided(self) -> bool:
        """Whether the engine begins at a guess."""
        return ENGINES[self.engine].kind != SAMPLING

    @property
    def guess(self) -> str:
        """The column `guess`."""
        return self.initial_guess if self.guided else "none"

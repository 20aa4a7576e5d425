"""Engines: one table of the optimisation libraries, by name.

An engine's name is also its name in specs. Nothing is imported until an engine is needed.
"""

from __future__ import annotations

import ctypes
import shutil
from collections.abc import Callable, Mapping
from functools import cache, partial
from pathlib import Path as FilePath
from pkgutil import resolve_name
from types import MappingProxyType
from typing import Any, ClassVar, NamedTuple

from dubins_study.solvers.protocol import Method, Solver
from dubins_study.solvers.setting_checks import (
    OPTION_SETS,
    Keywords,
    Options,
    missing_package,
    name_or_program,
)
from dubins_study.study.values import did_you_mean
from dubins_study.study.words import (
    CONSTRAINTS,
    DERIVATIVE_FREE,
    MILP,
    NLP,
    PROVEN,
    QP,
    ROOTS,
    ROUTING,
    SAMPLING,
)


class Engine(NamedTuple):
    """An optimisation library.

    A licence that is too small or expired is noticed when a problem is solved; the row's message
    then says so. To ask for it here would load every licensed library for a mere list of solvers.
    """

    label: str  # its name as its makers write it, which rows hold
    kind: str  # of the problems that it reads; also its heading in tables
    packages: tuple[str, ...]  # those that must be installed
    # its adapter, or that one's `package.module:function`; empty if a solver calls it directly
    place: str | Callable[..., Any] = ""
    arguments: Mapping[str, Any] = MappingProxyType({})  # of the adapter, beside the options
    options: Options = Options()
    # `package.module:function` that returns the reason why it cannot run here, or None
    check: str = ""
    versions: Callable[[], dict[str, str]] | None = None  # of the library inside the package
    keeps_limit: bool = True  # whether a run ends at most a second after its seconds are up
    # The default budget of one search. A target outside the discs takes two searches, which are
    # then over in about 0.15 s.
    evaluations: int = 0

    def unavailable(self) -> str | None:
        """The reason why the engine cannot run, or None."""
        reason = missing_package(*self.packages)
        if reason or not self.check:
            return reason
        checked: str | None = _resolved(self.check)()
        return checked

    def load(self) -> Any:
        """The engine's adapter.

        Its parameters and results depend on the kind of engine. The adapter of an engine of
        nonlinear programs, or of a search, takes `tol`, `max_iter` and `options` as the settings of
        a solver have them. It returns an `NlpCall` or a `penalty_function.Search`.
        """
        place: Any = self.place
        if isinstance(place, str):
            place = _resolved(place)
        adapter = partial(place, **self.arguments)
        if self.kind == PROVEN:
            return adapter

        def call(tol: float = 0.0, max_iter: int = 0, options: str = OPTION_SETS[0]) -> Any:
            adapted = adapter(self.options.of(options, tol, max_iter))
            if self.kind == NLP:
                return _resolved(_MEASURED)(adapted)
            return adapted

        return call

    def tolerance(self, options: str, tol: float = 0.0) -> float | None:
        """The tolerance on equations of an option set.

        `options` is the set's name. None if the set leaves the tolerance to the engine.
        """
        chosen = self.options.of(options, tol)
        tolerances = (chosen[name] for name in self.options.feasibility if name in chosen)
        return next(tolerances, None)

    def method(self, formulation: str, guess: str, options: str, tol: float) -> Method:
        """The `Method` of a solver with these settings."""
        return Method(formulation, self.label, guess, self.tolerance(options, tol))


# adds the slope of the violation to the results of engines of nonlinear programs
_MEASURED = "nlp_engines.violation:measured"


@cache
def _resolved(place: str) -> Any:
    return resolve_name(f"{__package__}.{place}")


@cache
def ipopt_in_casadi() -> dict[str, str]:
    """The version of Ipopt in casadi's wheel: {"ipopt": "3.14.11"}."""
    import casadi

    # libipopt.so.3, libipopt.3.dylib or libipopt-3.dll
    libraries = sorted(FilePath(casadi.__file__).parent.glob("libipopt*3*"))
    numbers = tuple(ctypes.c_int() for _ in range(3))
    ctypes.CDLL(str(libraries[0])).GetIpoptVersion(*map(ctypes.byref, numbers))
    return {"ipopt": ".".join(str(number.value) for number in numbers)}


@cache
def scip_in_pyscipopt() -> dict[str, str]:
    """The version of SCIP inside pyscipopt: {"scip": "10.0.0"}."""
    from pyscipopt import Model

    model = Model()
    parts = (model.getMajorVersion(), model.getMinorVersion(), model.getTechVersion())
    return {"scip": ".".join(map(str, parts))}


def _nlp(label: str, package: str, adapter: str, options: Options, **more: Any) -> Engine:
    return Engine(label, NLP, (package,), f"nlp_engines.{adapter}", options=options, **more)


def _nlpsol(label: str, plugin: str, options: Options, **more: Any) -> Engine:
    adapter = "casadi_nlpsol:nlpsol"
    return _nlp(label, "casadi", adapter, options, arguments={"plugin": plugin}, **more)


def _nlopt(label: str, algorithm: str, **inner: str) -> Engine:
    arguments = {"algorithm": algorithm} | inner
    return _nlp(label, "nlopt", "nlopt_local:nlopt", _OF_NLOPT, arguments=arguments)


def _search(
    label: str, name: str, budget: int, optimality: tuple[str, ...] = (), **options: Any
) -> Engine:
    """An engine for one of SciPy's searches."""
    return Engine(
        label,
        SAMPLING,
        ("scipy",),
        "stochastic.penalty_function:scipy_search",
        arguments={"name": name},
        options=Options(optimality=optimality, **options),
        evaluations=budget,
    )


_PRINTS_NOTHING = "prints nothing"
# An interior-point method stops at a scaled error; the tolerances on the unscaled ones count too.
_OF_BONMIN = Options(
    ("bonmin.tol", "bonmin.constr_viol_tol"),
    ("bonmin.tol", "bonmin.dual_inf_tol", "bonmin.compl_inf_tol"),
    "bonmin.max_iter",
    {
        "bonmin.print_level": 0,
        "bonmin.sb": "yes",
        "bonmin.bb_log_level": 0,
        "bonmin.nlp_log_level": 0,
    },
    _PRINTS_NOTHING,
)
_OF_IPOPT = Options(
    ("ipopt.tol", "ipopt.constr_viol_tol"),
    ("ipopt.tol", "ipopt.dual_inf_tol", "ipopt.compl_inf_tol"),
    "ipopt.max_iter",
    {"ipopt.print_level": 0, "ipopt.sb": "yes"},
    _PRINTS_NOTHING,
    {"ipopt.bound_relax_factor": 0.0},
    "where points off the bounds are no use: [a maker's answer]"
    "(https://github.com/coin-or/Ipopt/discussions/440)",
)
_OF_NLOPT = Options(
    ("constraint_tol",),
    ("xtol_rel", "ftol_rel"),
    "maxeval",
    {"xtol_rel": 1e-4, "constraint_tol": 1e-8},
    "NLopt has no criterion to stop by of its own; these are its "
    "[tutorial](https://nlopt.readthedocs.io/en/latest/NLopt_Tutorial/)'s",
)


# `plugin` begins each option's name: `uno.` in casadi, nothing in unopy
def _of_uno(plugin: str = "") -> Options:
    return Options(
        (f"{plugin}primal_tolerance",),
        (f"{plugin}dual_tolerance",),
        f"{plugin}max_iterations",
        {f"{plugin}logger": "SILENT"},
        _PRINTS_NOTHING,
    )


# `inner` are options of the quadratic subproblems' solver, by which it prints nothing
def _of_sqp(**inner: Any) -> Options:
    always = {"print_header": False, "print_iteration": False}
    always |= {f"qpsol_options.{name}": value for name, value in inner.items()}
    return Options(("tol_pr",), ("tol_du",), "max_iter", always, _PRINTS_NOTHING)


# `Options` without names are, in this order: feasibility, optimality, iterations, always, why,
# tuned, source.
ENGINES = {
    "slsqp": _nlp(
        "SLSQP", "scipy", "scipy_minimize:slsqp", Options(("ftol",), ("ftol",), "maxiter")
    ),
    "trust-constr": _nlp(
        "trust-constr",
        "scipy",
        "scipy_minimize:trust_constr",
        Options(("gtol",), ("gtol", "barrier_tol"), "maxiter"),
    ),
    "cobyqa": _nlp(
        "COBYQA",
        "scipy",
        "scipy_minimize:cobyqa",
        Options(("feasibility_tol",), (), "maxiter"),
    ),
    "ipopt": _nlpsol("Ipopt", "ipopt", _OF_IPOPT, versions=ipopt_in_casadi),
    "uno": _nlpsol("Uno", "uno", _of_uno("uno.")),
    "fatrop": _nlpsol(
        "fatrop",
        "fatrop",
        Options(
            ("fatrop.tolerance", "fatrop.constr_viol_tol"),
            ("fatrop.tolerance",),
            "fatrop.max_iter",
            {"fatrop.print_level": 0},
            _PRINTS_NOTHING,
        ),
        keeps_limit=False,
    ),
    "alpaqa": _nlpsol(
        "alpaqa",
        "alpaqa",
        Options(("alpaqa.alm.dual_tolerance",), ("alpaqa.alm.tolerance",), "alpaqa.alm.max_iter"),
        keeps_limit=False,
    ),
    "bonmin": _nlpsol("Bonmin", "bonmin", _OF_BONMIN, keeps_limit=False),
    # loads casadi's HiGHS, whose symbols then replace those of the package highspy
    "sleqp": _nlpsol(
        "SLEQP",
        "sleqp",
        Options(
            ("sleqp.feas_tol",),
            ("sleqp.stat_tol", "sleqp.slack_tol"),
            "max_iter",
            {"print_level": 0},
            _PRINTS_NOTHING,
        ),
        keeps_limit=False,
    ),
    "sqpmethod": _nlpsol("casadi sqpmethod", "sqpmethod", _of_sqp(printLevel="none")),
    "qrsqp": _nlpsol(
        "casadi qrsqp",
        "qrsqp",
        _of_sqp(print_iter=False, print_header=False, print_info=False),
    ),
    "apopt": _nlp(
        "APOPT",
        "gekko",
        "apopt:apopt",
        Options(("rtol",), ("otol",), "max_iter"),
        check="nlp_engines.apopt:unavailable",
    ),
    "nlopt-slsqp": _nlopt("NLopt SLSQP", "LD_SLSQP"),
    # the augmented Lagrangian of Birgin and Martinez, minimised within the bounds by L-BFGS
    "nlopt-auglag": _nlopt("NLopt AUGLAG", "LD_AUGLAG", inner="LD_LBFGS"),
    "nlopt-cobyla": _nlopt("NLopt COBYLA", "LN_COBYLA"),
    "uno-filtersqp": _nlp("Uno filterSQP", "unopy", "uno:filtersqp", _of_uno()),
    # reads nothing but Pyomo's model of (4.12), with its own tolerances
    "knitro": Engine(
        "KNITRO", NLP, ("knitro",), check="paper_nlp.pyomo_model:unlicensed", keeps_limit=False
    ),
    "scip": Engine(
        "SCIP", PROVEN, ("pyscipopt",), "minlp_engines.scip:scip", versions=scip_in_pyscipopt
    ),
    # its time limit is in whole seconds of processor time
    "maingo": Engine(
        "MAiNGO", PROVEN, ("maingopy",), "minlp_engines.maingo:maingo", keeps_limit=False
    ),
    "differential-evolution": _search(
        "differential evolution",
        "differential_evolution",
        8000,
        ("tol", "atol"),
        tuned={
            "strategy": "rand1bin",
            "popsize": 10,
            "mutation": 0.5,
            "recombination": 0.9,
            "vectorized": True,
            "updating": "deferred",
        },
        source="Storn and Price 1997, Journal of Global Optimization 11, pages 341 to 359: "
        "populations of ten a variable, which change once a generation",
    ),
    "dual-annealing": _search("dual annealing", "dual_annealing", 3000),
    "shgo": _search("SHGO", "shgo", 3000),
    "direct": _search("DIRECT", "direct", 8000),
    "cma-es": Engine(
        "CMA-ES",
        SAMPLING,
        ("cma",),
        "stochastic.penalty_function:cma_es",
        options=Options(
            (),
            ("tolx", "tolfun"),
            "",
            {"sigma0": 0.25, "verbose": -9, "verb_log": 0},
            "the first step, which has no default, is a quarter of the box, as `cma` advises; "
            "prints and writes nothing",
            {"restarts": 9},
            "with doubled populations: Auger and Hansen 2005, IEEE Congress on Evolutionary "
            "Computation, pages 1769 to 1776; `cma` does nine in its examples",
        ),
        evaluations=1000,
    ),
    # both end long before the budget is spent
    "nelder-mead": Engine(
        "Nelder-Mead",
        DERIVATIVE_FREE,
        ("scipy",),
        "stochastic.penalty_function:minimize",
        {"method": "Nelder-Mead"},
        Options(
            (),
            ("xatol", "fatol"),
            tuned={"adaptive": True},
            source="Gao and Han 2012, Computational Optimization and Applications 51, 259 to 277",
        ),
        evaluations=3000,
    ),
    "powell": Engine(
        "Powell",
        DERIVATIVE_FREE,
        ("scipy",),
        "stochastic.penalty_function:minimize",
        {"method": "Powell"},
        Options((), ("xtol", "ftol")),
        evaluations=3000,
    ),
    "hybr": Engine("MINPACK hybr", ROOTS, ("scipy",), options=Options((), ("xtol",), "maxfev")),
    "lm": Engine("MINPACK lm", ROOTS, ("scipy",), options=Options((), ("xtol", "ftol"), "maxiter")),
    # cvxpy calls the engines of quadratic programs
    "piqp": Engine(
        "PIQP",
        QP,
        ("cvxpy", "piqp"),
        options=Options(
            ("eps_abs", "eps_rel"),
            ("eps_duality_gap_abs", "eps_duality_gap_rel"),
            always={"compute_timings": True},
            why="its own time is told",
        ),
    ),
    "clarabel": Engine(
        "Clarabel",
        QP,
        ("cvxpy", "clarabel"),
        options=Options(("tol_feas",), ("tol_gap_abs", "tol_gap_rel")),
    ),
    "osqp": Engine(
        "OSQP",
        QP,
        ("cvxpy", "osqp"),
        options=Options(
            ("eps_abs", "eps_rel"),
            always={"eps_abs": 1e-3, "eps_rel": 1e-3, "max_iter": 4000, "polishing": False},
            why="OSQP's own, which cvxpy replaces",
            tuned={"eps_abs": 1e-5, "eps_rel": 1e-5, "max_iter": 10000, "polishing": True},
            source="what cvxpy chooses; the higher of the two accuracies in Stellato et al. 2020, "
            "Mathematical Programming Computation 12, pages 637 to 672",
        ),
    ),
    "highs": Engine(
        "HiGHS",
        QP,
        ("cvxpy", "highspy"),
        options=Options(
            ("primal_feasibility_tolerance",),
            ("dual_feasibility_tolerance",),
            always={"threads": 1},
            why="one thread, as all engines have",
        ),
    ),
    "glpk": Engine("GLPK", MILP, ("swiglpk",), keeps_limit=False),
    # CBC, CP-SAT and the routing library are those of OR-tools. Its package has another HiGHS than
    # highspy's: a process that has loaded one of the two cannot load the other.
    # The time limit of CBC is in seconds of processor time.
    "cbc": Engine("CBC", MILP, ("ortools",), keeps_limit=False),
    "cp-sat": Engine("CP-SAT", CONSTRAINTS, ("ortools",), keeps_limit=False),
    "routing": Engine("OR-Tools routing", ROUTING, ("ortools",), keeps_limit=False),
}


# By the beginning of an executable's name: the names of its options in AMPL. The time limit holds
# without an option too: the executable is ended when the time is up.
EXECUTABLES = {
    "ipopt": Keywords(
        Options(("tol", "constr_viol_tol"), ("tol", "dual_inf_tol", "compl_inf_tol"), "max_iter"),
        seconds="max_cpu_time",
    ),
    "knitro": Keywords(
        Options(("feastol", "feastol_abs"), ("opttol", "opttol_abs"), "maxit"),
        gap="mip_opt_gap_rel",
        seconds="maxtime_real",
    ),
    "uno": Keywords(
        Options(("primal_tolerance",), ("dual_tolerance",), "max_iterations"),
        seconds="time_limit",
    ),
    "baron": Keywords(gap="epsr", seconds="maxtime"),
}


def program_engine(name: str, kind: str) -> Engine:
    """An engine for an executable on PATH.

    The executable is called as AMPL calls a solver. The names of its options are those of the entry
    of `EXECUTABLES` with which its name begins, if there is one.
    """
    candidates = (each for begin, each in EXECUTABLES.items() if name.startswith(begin))
    keywords = next(candidates, Keywords())
    place = "nlp_engines.ampl:ampl_nlp"
    if kind == PROVEN:
        place = "nlp_engines.ampl:ampl_minlp"
    arguments = {"executable": name, "names": keywords}
    return Engine(name, kind, ("pyomo",), place, arguments, keywords.options)


def names(*kinds: str) -> tuple[str, ...]:
    """Names of the engines of some kinds.

    The names are in the order of the table.
    """
    return tuple(name for name, engine in ENGINES.items() if engine.kind in kinds)


def packages(engines: tuple[str, ...]) -> tuple[str, ...]:
    """The packages of some engines, each once."""
    return tuple(dict.fromkeys(p for name in engines for p in ENGINES[name].packages))


def others(solver: str, engines: tuple[str, ...], *default: str) -> tuple[str, ...]:
    """A solver's specs for engines other than the default.

    `others("nlp", ("slsqp", "uno"), "slsqp")` is `("nlp[engine=uno]",)`.
    """
    return tuple(f"{solver}[engine={name}]" for name in engines if name not in default)


# engines that have solvers of their own for the paper's model
APART = ("slsqp", "ipopt")
# the engines that read any program of `nlp_engines.program`
NLP_ENGINES = tuple(name for name in names(NLP) if ENGINES[name].place)
MINLP_ENGINES = names(PROVEN)


def engine_or_program(default: str, engines: tuple[str, ...]) -> Any:
    """Declare the setting `engine`.

    Its value is a name in `engines`, or an executable on PATH that reads NL files. Other names of
    the table are refused.
    """
    return name_or_program(default, engines, taken=ENGINES)


class EngineSolver(Solver):
    """A solver whose setting `engine` names an engine.

    The name is one of the table, or of a plug-in's own table. If the setting was declared by
    `engine_or_program`, it may also be the name of an executable. `program_kind` is the kind of
    engine that an executable stands for.
    """

    engine: str
    engines: ClassVar[Mapping[str, Engine]] = ENGINES
    program_kind: ClassVar[str] = NLP

    @property
    def library(self) -> Engine:
        """The entry of the solver's engine in the table."""
        return self.engines.get(self.engine) or program_engine(self.engine, self.program_kind)

    @property
    def runs(self) -> str | None:
        if self.engine in self.engines:
            return None
        return self.engine

    def unavailable(self) -> str | None:
        # whether an executable is a solver is seen when it is run
        if self.runs is None or shutil.which(self.runs):
            return self.library.unavailable()
        known = names(self.program_kind)
        near = did_you_mean(self.engine, known)
        return (
            f"no executable {self.engine!r} on PATH, and no engine of that name; {near}there are: "
            f"{', '.join(known)}"
        )

    def library_versions(self) -> dict[str, str]:
        versions = self.library.versions
        if versions is None:
            return {}
        return versions()

    @property
    def keeps_limit(self) -> bool:
        return self.library.keeps_limit


class SearchSolver(EngineSolver):
    """A solver whose engine starts at a guess.

    Engines that search a whole box take no guess; for these a guess other than the default is a
    ValueError. So are `restarts` of an engine that does not search.
    """

    initial_guess: str
    restarts: bool

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.restarts and self.library.kind == NLP:
            raise ValueError(f"restarts are of searches, which {self.engine} is not; leave it out")
        if self.initial_guess != "bearing" and not self.guided:
            raise ValueError(
                f"initial_guess is {self.initial_guess!r}, but the engine {self.engine} searches "
                "the whole box and takes none; leave it out"
            )

    @property
    def guided(self) -> bool:
        """Whether the engine starts at a guess."""
        return self.library.kind != SAMPLING

    @property
    def guess(self) -> str:
        """The value of the column `guess`."""
        if self.guided:
            return self.initial_guess
        return "none"

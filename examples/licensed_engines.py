"""Gurobi and Xpress as engines of a plug-in.

They need a licence, and solve formulations of this package.

    pip install gurobipy xpress
    dubins-study solve 3 2 --solver 'licensed_engines.py:GlobalNlp[engine=xpress]'
    dubins-study solve 3 2 --solver 'licensed_engines.py:Disjunctive[engine=gurobi]'
    dubins-study solve 3 2 --solver 'licensed_engines.py:HeadingMilp[engine=gurobi,headings=20]'

The size-limited licences in both wheels suffice for `GlobalNlp`. Read their terms first: Gurobi's
evaluation licence (2.2) says "You will not publish any benchmark testing results on the Product";
Xpress' (2.4 vii) asks for Fair Isaac's consent.

An engine that proves bounds is an adapter and a line of a table. The adapter takes `Settings` and
returns a function of a `MixedProgram` and the seconds left, which returns a `ProvenResult`.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from dubins_study import Claim
from dubins_study.solvers.engines import Engine
from dubins_study.solvers.global_minlp import disjunctive, global_nlp
from dubins_study.solvers.minlp_engines.mixed_program import (
    MinlpCall,
    MixedProgram,
    ProvenResult,
    Settings,
)
from dubins_study.solvers.route import grid
from dubins_study.solvers.setting_checks import one_of
from dubins_study.study.words import PROVEN


def gurobi(settings: Settings) -> MinlpCall:
    """Gurobi with MIPGap and FeasibilityTol; `lean` changes nothing."""

    def run(program: MixedProgram, seconds: float) -> ProvenResult:
        import gurobipy

        try:
            with gurobipy.Model(env=gurobi_environment()) as model:
                return run_gurobi(model, program, settings, seconds)
        except gurobipy.GurobiError as error:  # a licence too small or expired among others
            return failed(str(error.errno), f"Gurobi error {error.errno}: {error}")

    return run


# The smallest of FeasibilityTol, IntFeasTol and OptimalityTol that Gurobi takes.
GUROBI_LEAST_TOLERANCE = 1e-9
# By the names of `gurobipy.GRB.Status`.
GUROBI_CLAIMS = {
    "OPTIMAL": Claim.OPTIMAL,
    "SUBOPTIMAL": Claim.FEASIBLE,
    "INFEASIBLE": Claim.INFEASIBLE,
    "INF_OR_UNBD": Claim.INFEASIBLE,
    "TIME_LIMIT": Claim.LIMIT,
    "MEM_LIMIT": Claim.LIMIT,
    "NUMERIC": Claim.FAILED,
}


@cache
def gurobi_environment() -> Any:
    """One silent environment for the process.

    Starting it reads the licence.
    """
    import gurobipy

    return gurobipy.Env(params={"OutputFlag": 0, "LogToConsole": 0})


def run_gurobi(
    model: Any, program: MixedProgram, settings: Settings, seconds: float
) -> ProvenResult:
    """Write the program into a model; solve it.

    The model is empty before.
    """
    import gurobipy

    kinds = np.where(program.binary, gurobipy.GRB.BINARY, gurobipy.GRB.CONTINUOUS)
    x = model.addMVar(program.lower.size, program.lower, program.upper, vtype=kinds).tolist()
    written = program.write(x, gurobipy.nlfunc)
    model.setObjective(written.objective)
    for row in written.rows:
        if isinstance(row.body, gurobipy.NLExpr):  # taken only as the value of a variable
            model.addConstr(model.addVar(row.lower, row.upper) == row.body)
        else:
            for relation in row.relations():
                model.addConstr(relation)
    model.Params.Threads = 1
    model.Params.MIPGap = settings.gap
    model.Params.MIPGapAbs = 0.0
    model.Params.FeasibilityTol = max(settings.feastol, GUROBI_LEAST_TOLERANCE)
    model.Params.TimeLimit = max(seconds, 0.0)
    model.optimize()
    codes = gurobipy.GRB.Status
    if model.Status == codes.INTERRUPTED:
        raise KeyboardInterrupt
    point = None
    if model.SolCount:
        point = np.array([variable.X for variable in x])
    names = {getattr(codes, name): name for name in dir(codes) if name.isupper()}
    name = names[model.Status]
    unnamed = Claim.FAILED if point is None else Claim.FEASIBLE
    claim = GUROBI_CLAIMS.get(name, unnamed)
    bound = math.inf if claim is Claim.INFEASIBLE else float(model.ObjBound)
    status = name.lower().replace("_", " ")
    return ProvenResult(
        point,
        claim,
        bound=bound,
        nodes=int(model.NodeCount),
        iterations=int(model.IterCount),
        status=status,
        message=status,
    )


def xpress(settings: Settings) -> MinlpCall:
    """Xpress' global solver with MIPRELSTOP and FEASTOL.

    `lean` changes nothing.
    """

    def run(program: MixedProgram, seconds: float) -> ProvenResult:
        library = xpress_library()
        try:
            start_xpress()
            return run_xpress(library, program, settings, seconds)
        except (library.SolverError, library.ModelError, library.InterfaceError) as error:
            # a licence too small or expired among others
            return failed(type(error).__name__, str(error))

    return run


XPRESS_CTRL_C = 2  # XPRS_STOP_CTRLC
XPRESS_NO_BOUND = 1e20
# By the names of `xpress.SolStatus`.
XPRESS_CLAIMS = {
    "OPTIMAL": Claim.OPTIMAL,
    "FEASIBLE": Claim.FEASIBLE,
    "INFEASIBLE": Claim.INFEASIBLE,
}


@cache
def xpress_library() -> Any:
    """The module of Xpress.

    Where Pyomo is loaded, it then asks Xpress for its version in an outdated way.
    """
    # recorded, since Xpress changes the filters of warnings while it is imported
    with warnings.catch_warnings(record=True):
        return import_module("xpress")


@cache
def start_xpress() -> None:
    """Read the licence once a process.

    The warning that it is the one in the wheel is left out.
    """
    library = xpress_library()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", library.LicenseWarning)
        library.init()


def run_xpress(
    library: Any, program: MixedProgram, settings: Settings, seconds: float
) -> ProvenResult:
    """Write the program into a problem; solve it.

    The problem is new.
    """
    problem = library.problem()
    problem.controls.outputlog = 0
    kinds = library.continuous, library.binary
    x = [
        problem.addVariable(lb=lower, ub=upper, vartype=kinds[binary])
        for lower, upper, binary in program.variables
    ]
    written = program.write(x, library)
    problem.setObjective(written.objective)
    problem.addConstraint([relation for row in written.rows for relation in row.relations()])
    controls = {
        "threads": 1,
        "miprelstop": settings.gap,
        "mipabsstop": 0.0,
        # by default no node is looked at that may gain less than 1e-5, or 1e-4 of the objective:
        # then bounds stay that far below, whatever gap is asked for
        "mipaddcutoff": 0.0,
        "miprelcutoff": 0.0,
        "feastol": settings.feastol,
        "timelimit": max(seconds, 1e-3),  # 0 stands for no limit
    }
    problem.setControl(controls)
    solve_status, solution_status = (status.name for status in problem.optimize())
    claim = XPRESS_CLAIMS.get(solution_status, Claim.FAILED)
    if solve_status == "STOPPED":
        if problem.attributes.stopstatus == XPRESS_CTRL_C:
            raise KeyboardInterrupt
        claim = Claim.LIMIT
    elif solve_status != "COMPLETED" and claim is not Claim.FEASIBLE:
        claim = Claim.FAILED
    point = None
    if solution_status in ("OPTIMAL", "FEASIBLE"):
        point = np.array(problem.getSolution(), dtype=np.float64)
    bound = float(problem.attributes.bestbound)
    if claim is Claim.INFEASIBLE:
        bound = math.inf
    elif abs(bound) >= XPRESS_NO_BOUND:
        bound = -math.inf
    status = f"{solve_status} {solution_status}"
    return ProvenResult(
        point,
        claim,
        bound,
        nodes=int(problem.attributes.nodes),
        iterations=int(problem.attributes.simplexiter),
        status=status,
        message=status.lower(),
    )


def failed(status: str, message: str) -> ProvenResult:
    """The end of a run after a library's error."""
    return ProvenResult(None, Claim.FAILED, -math.inf, None, None, status, message)


ENGINES = {
    "gurobi": Engine("Gurobi", PROVEN, ("gurobipy",), gurobi),
    "xpress": Engine("Xpress", PROVEN, ("xpress",), xpress),
}
PACKAGES = ("gurobipy", "xpress")


@dataclass(frozen=True)
class GlobalNlp(global_nlp.GlobalNlp):
    """Model (4.12) by Gurobi or Xpress.

    The other settings are those of `global-nlp`.
    """

    engine: str = one_of("gurobi", ENGINES)

    name = "licensed-global-nlp"
    engines = ENGINES
    packages = ("casadi", *PACKAGES)
    summary = "the paper's model (4.12), proven by Gurobi or Xpress"
    variants = ()


@dataclass(frozen=True)
class Disjunctive(disjunctive.Disjunctive):
    """The disjunction of words by Gurobi or Xpress.

    The other settings are those of `disjunctive`.
    """

    engine: str = one_of("gurobi", ENGINES)

    name = "licensed-disjunctive"
    engines = ENGINES
    packages = ("pyomo", *PACKAGES)
    summary = "one disjunct per word in Pyomo.GDP, proven by Gurobi or Xpress"
    variants = ()


@dataclass(frozen=True)
class HeadingMilp(grid.HeadingMilp):
    """Headings on a grid by Gurobi or Xpress.

    The other settings are those of `heading-milp`.

    The licences in the wheels end at 2 000 and at 5 000 variables. 40 headings a point reach these
    limits with two legs, and 20 with six or thirteen.
    """

    engine: str = one_of("gurobi", ENGINES)

    name = "licensed-heading-milp"
    engines = ENGINES
    packages = PACKAGES
    summary = "headings on a grid, exact legs between them, by Gurobi or Xpress"
    variants = ()

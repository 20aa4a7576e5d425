"""Cases of the paper's model (4.12) in Pyomo.

They are for Ipopt and for KNITRO.
"""

from __future__ import annotations

from functools import cache, lru_cache
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.casadi_nlpsol import nlpsol
from dubins_study.solvers.nlp_engines.pyomo_program import PyomoProgram, asked
from dubins_study.solvers.one_leg.model import Case, end_point
from dubins_study.solvers.paper_nlp.case_program import Solve
from dubins_study.solvers.runs import EngineResult, no_point
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import DENIALS, Claim


def pyomo_model(units: str = "radius") -> Any:
    """Model (4.12) in Pyomo.

    Its variables are z[1..3] >= 0, and the target as variables X, Y to be fixed. In the scenario's
    unit, as in the paper, the radius R = 1 / b is one more variable.
    """
    from pyomo import environ

    m = environ.ConcreteModel(name="dubins-4.12")
    m.z = environ.Var((1, 2, 3), bounds=(0, None), initialize=1.0)
    m.X = environ.Var(initialize=1.0)
    m.Y = environ.Var(initialize=1.0)
    z1, z2, z3 = m.z.values()
    R: Any = 1.0
    if units == "scenario":
        R = m.R = environ.Var(initialize=1.0)
        z1 = z1 / R
        z2 = z2 / R
    x, y = end_point(z1, z1 - z2, z3, environ, R)
    m.x_end = environ.Constraint(expr=m.X - x == 0)
    m.y_end = environ.Constraint(expr=m.Y - y == 0)
    m.length = environ.Objective(expr=sum(m.z.values()))
    return m


@lru_cache(maxsize=64)
def ipopt_in_pyomo(options: tuple[tuple[str, Any], ...], units: str) -> Solve:
    """A function that solves cases by Ipopt in Pyomo.

    The model's NL file is written once. The target is two variables that each case fixes through
    their bounds. In the scenario's `units` the radius is one more.
    """
    model = pyomo_model(units)
    scaled = units == "scenario"
    data = [model.X, model.Y]
    if scaled:
        data.append(model.R)
    program = PyomoProgram(model, list(model.z.values()), data, [model.x_end, model.y_end])
    ask = asked(program, nlpsol(dict(options), "ipopt"), native=True)
    lower = np.zeros(3)

    def run(case: Case, guess: FloatArray, seconds: float) -> EngineResult:
        unit = case.unit
        data = [unit * case.target.X, unit * case.target.Y]
        if scaled:
            data.append(unit)
        result = ask(unit * guess, np.array(data), lower, unit * case.upper, seconds)
        return result._replace(x=result.x / unit)

    return run


# One model serves all subproblems: everything that differs between them is set anew.
_shared_model = cache(pyomo_model)


def posed(case: Case, guess: FloatArray) -> Any:
    """The shared Pyomo model, set to a case.

    Its free lengths are at `guess`, shape (3,).
    """
    model = _shared_model()
    for i, z in enumerate(model.z.values()):
        z.setub(case.upper[i])  # Pyomo takes an infinite bound for none
        z.set_value(guess[i], skip_validation=True)
        z.fixed = i not in case.subproblem.free
    model.X.fix(case.target.X)
    model.Y.fix(case.target.Y)
    return model


@cache  # a licence may be a seat at a server that takes its time to answer
def unlicensed() -> str | None:
    """The reason why KNITRO cannot solve here, or None.

    KNITRO is installed, but a licence may be missing.
    """
    if _interface("knitro_direct").available():
        return None
    return "knitro is installed, but no licence was found (its wheel installs without one)"


def _interface(name: str) -> Any:
    import pyomo.environ  # noqa: F401  (registers the interfaces)
    from pyomo.contrib.solver.common.factory import SolverFactory

    return SolverFactory(name)


def solve_in_pyomo(case: Case, guess: FloatArray, seconds: float, interface: str) -> EngineResult:
    """The point that one of Pyomo's interfaces reaches.

    The solver starts from `guess`, shape (3,).
    """
    from pyomo.common.errors import ApplicationError, PyomoException

    model = posed(case, guess)
    solver = _interface(interface)
    if "knitro_warm_start" in solver.config:
        solver.config.knitro_warm_start = True  # else KNITRO starts from a point of its own
        # Pyomo reads what KNITRO prints only after the solve: a full pipe would block both
        solver.config.solver_options = {"outlev": 0}
    try:
        results = solver.solve(
            model,
            load_solutions=False,
            raise_exception_on_nonoptimal_result=False,
            time_limit=max(seconds, 1e-3),
        )
    except (ApplicationError, PyomoException, RuntimeError) as error:  # the last from KNITRO
        return no_point(3, Claim.FAILED, type(error).__name__, str(error))
    condition = results.termination_condition.name
    iterations = None
    if "number_iters" in results.extra_info:
        iterations = int(results.extra_info.number_iters)
    return _ended(
        model,
        results.solution_loader,
        claim_of("pyomo", condition),
        status=condition,
        message=f"{results.solver_name}: {results.solution_status.name} solution",
        iterations=iterations,
    )


def _ended(
    model: Any, loader: Any, claim: Claim, status: str, message: str, iterations: int | None = None
) -> EngineResult:
    """The end of a run, by Pyomo's loader.

    The loader gives the point and the duals. Without a point the claim becomes `failed`, unless it
    needs no point. The duals are None if the loader has none.
    """
    from pyomo.common.errors import PyomoException

    free = [z for z in model.z.values() if not z.fixed]
    try:
        values = loader.get_vars(free)
    except (PyomoException, AssertionError, LookupError):
        # each loader reports a missing point in its own way; some claims need no point
        if claim not in (*DENIALS, Claim.LIMIT):
            claim = Claim.FAILED
        return no_point(3, claim, status, message)
    z = np.array([0.0 if z.fixed else values[z] for z in model.z.values()])
    try:
        of_row = loader.get_duals([model.x_end, model.y_end])
        # the dual is the objective's change per unit of right-hand side, the paper's minus that
        duals = -np.array([of_row[model.x_end], of_row[model.y_end]])
    except (PyomoException, NotImplementedError, LookupError):
        duals = None
    return EngineResult(z, claim, duals, iterations, status=status, message=message)

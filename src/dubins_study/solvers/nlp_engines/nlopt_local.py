"""NLopt's local algorithms that take equations: SLSQP, the augmented Lagrangian and COBYLA."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import EngineResult, NlpCall, Program
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

# NLopt's return codes by name. Its manual calls the positive ones a success; the two of the limits
# say nothing about the problem. SLSQP and the augmented Lagrangian stop at a tolerance only where
# the equations hold; COBYLA does wherever its steps become small, and so claims what is not true.
_CLAIMS = {
    "SUCCESS": Claim.LOCAL,
    "FTOL_REACHED": Claim.LOCAL,
    "XTOL_REACHED": Claim.LOCAL,
    "MAXEVAL_REACHED": Claim.LIMIT,
    "MAXTIME_REACHED": Claim.LIMIT,
}

_STATUSES = (
    *_CLAIMS,
    *("STOPVAL_REACHED", "FAILURE", "INVALID_ARGS", "OUT_OF_MEMORY", "ROUNDOFF_LIMITED"),
    "FORCED_STOP",
)

# NLopt limits evaluations, not iterations; a line search of SLSQP takes up to ten in an iteration
_EVALUATIONS_PER_ITERATION = 10

Objective = Callable[[FloatArray, FloatArray], float]
Equations = Callable[[FloatArray, FloatArray, FloatArray], None]


def nlopt(tol: float, max_iter: int, algorithm: str, inner: str = "") -> NlpCall:
    """An NLopt algorithm, with the algorithm `inner` for its subproblems if it needs one.

    `tol` is the violation of each equation, and the relative change of length and variables.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        search = _search(algorithm, guess.size, tol)
        if inner:
            search.set_local_optimizer(_search(inner, guess.size, tol))
        search.set_exceptions_enabled(False)  # an exception would lose the point
        search.set_maxeval(_EVALUATIONS_PER_ITERATION * max_iter)
        search.set_maxtime(max(seconds, 1e-6))  # NLopt takes 0 for no limit
        search.set_lower_bounds(program.lower)
        search.set_upper_bounds(program.upper)
        objective, equations, violation = _functions(program, guess, tol)
        search.set_min_objective(objective)
        search.add_equality_mconstraint(equations, violation)
        # NLopt refuses a guess outside the bounds
        x = np.asarray(search.optimize(np.clip(guess, program.lower, program.upper)))
        status = _status_names()[search.last_optimize_result()]
        message = status.replace("_", " ").lower()
        claim = _CLAIMS.get(status, Claim.FAILED)
        return EngineResult(x, claim, None, None, search.get_numevals(), status, message)

    return run


def _search(algorithm: str, n: int, tol: float) -> Any:
    import nlopt

    search = nlopt.opt(getattr(nlopt, algorithm), n)
    search.set_xtol_rel(tol)
    search.set_ftol_rel(tol)
    return search


def _functions(
    program: Program, guess: FloatArray, tol: float
) -> tuple[Objective, Equations, FloatArray]:
    """Objective, equations and their tolerances; derivatives go where NLopt wants them."""
    functions = program.functions

    def objective(x: FloatArray, gradient: FloatArray) -> float:
        if gradient.size:
            gradient[:] = functions.gradient(x)
        return float(functions.objective(x))

    def equations(values: FloatArray, x: FloatArray, jacobian: FloatArray) -> None:
        values[:] = functions.equations(x)
        if jacobian.size:
            jacobian[:] = functions.jacobian(x)

    violation = np.full(functions.equations(guess).size, program.attainable(tol))
    return objective, equations, violation


@cache
def _status_names() -> dict[int, str]:
    """Names of NLopt's return codes, by code."""
    import nlopt

    return {getattr(nlopt, name): name for name in _STATUSES}

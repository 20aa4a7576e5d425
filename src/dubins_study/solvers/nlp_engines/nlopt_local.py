"""NLopt's local algorithms that take equations.

They are SLSQP, the augmented Lagrangian and COBYLA.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import NlpCall, Program
from dubins_study.solvers.runs import EngineResult
from dubins_study.solvers.setting_checks import OptionValues
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import Claim

# the names of all its return codes
_STATUSES = (
    "SUCCESS",
    "FTOL_REACHED",
    "XTOL_REACHED",
    "MAXEVAL_REACHED",
    "MAXTIME_REACHED",
    "STOPVAL_REACHED",
    "FAILURE",
    "INVALID_ARGS",
    "OUT_OF_MEMORY",
    "ROUNDOFF_LIMITED",
    "FORCED_STOP",
)


def nlopt(options: OptionValues, algorithm: str, inner: str = "") -> NlpCall:
    """A call of an NLopt algorithm.

    An algorithm with subproblems solves them by the algorithm `inner`. The option `constraint_tol`
    is the violation that each equation may have. `maxeval` limits evaluations. The other options
    are tolerances by which both algorithms stop.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        import nlopt as library

        chosen = program.attainable(options, "constraint_tol")
        allowed = chosen.pop("constraint_tol")
        most = chosen.pop("maxeval", 0)
        search = _search(algorithm, guess.size, chosen)
        if inner:
            search.set_local_optimizer(_search(inner, guess.size, chosen))
        search.set_exceptions_enabled(False)  # an exception would lose the point
        search.set_maxeval(most)  # 0 for no limit
        search.set_maxtime(max(seconds, 1e-6))  # NLopt takes 0 for no limit
        search.set_lower_bounds(program.lower)
        search.set_upper_bounds(program.upper)
        functions = program.functions

        # NLopt passes empty arrays if it wants no derivatives, else arrays to fill
        def objective(x: FloatArray, gradient: FloatArray) -> float:
            if gradient.size:
                gradient[:] = functions.gradient(x)
            return float(functions.objective(x))

        def equations(values: FloatArray, x: FloatArray, jacobian: FloatArray) -> None:
            values[:] = functions.equations(x)
            if jacobian.size:
                jacobian[:] = functions.jacobian(x)

        search.set_min_objective(objective)
        m = functions.equations(guess).size
        search.add_equality_mconstraint(equations, np.full(m, allowed))
        # NLopt refuses a guess outside the bounds
        x = np.asarray(search.optimize(np.clip(guess, program.lower, program.upper)))
        names = {getattr(library, name): name for name in _STATUSES}
        status = names[search.last_optimize_result()]
        message = status.replace("_", " ").lower()
        claim = claim_of("nlopt", status)
        # a success is a claim only where the equations hold to the tolerance that NLopt was given
        if claim is Claim.LOCAL and not (np.abs(functions.equations(x)) <= allowed).all():
            claim = Claim.FAILED
        evaluations = search.get_numevals()
        return EngineResult(x, claim, evaluations=evaluations, status=status, message=message)

    return run


def _search(algorithm: str, n: int, tolerances: dict[str, float]) -> Any:
    import nlopt

    search = nlopt.opt(getattr(nlopt, algorithm), n)
    for name, value in tolerances.items():
        getattr(search, f"set_{name}")(value)
    return search

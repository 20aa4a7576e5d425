"""SciPy's SLSQP, COBYQA and trust-constr.

None of them has a test for infeasibility.
"""

from __future__ import annotations

import math
import warnings
from time import perf_counter
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import Functions, NlpCall, Program, needs_watch
from dubins_study.solvers.runs import EngineResult
from dubins_study.solvers.setting_checks import OptionValues
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import Claim

# The duals of two end-point equations whose path ends straight are a unit vector; up to this length
# they are passed on without a check.
_LONG_DUAL = 2.0
_AT_BOUND = 1e-6  # in the variables' unit: nearer to a bound, the bound's own dual counts
# Variables up to which trust-constr gets dense matrices: at 10 legs of a route both kinds take it
# 0.13 s, at 50 legs dense ones 2.9 s and sparse ones 0.4 s, in as many iterations.
_MOST_DENSE = 60
_STATIONARY = 1e-3  # where slopes are about 1: a point that is off by more is not stationary


def slsqp(options: OptionValues) -> NlpCall:
    """A call of SLSQP after Kraft.

    Its ftol is on the objective's change and the violations' sum.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        functions = program.functions
        limit = None
        if needs_watch(options.get("maxiter"), guess.size):
            limit = seconds
        equations = {"type": "eq", "fun": functions.equations, "jac": functions.jacobian}
        result = _minimized(
            "SLSQP",
            program,
            guess,
            limit,
            jac=functions.gradient,
            constraints=equations,
            options=program.attainable(options, "ftol"),
        )
        return _ended("SLSQP", result, _duals(result, program))

    return run


def cobyqa(options: OptionValues) -> NlpCall:
    """A call of COBYQA by Ragonneau and Zhang.

    It takes no derivatives.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        from scipy.optimize import NonlinearConstraint

        result = _minimized(
            "COBYQA",
            program,
            guess,
            seconds,
            constraints=NonlinearConstraint(program.functions.equations, 0.0, 0.0),
            options=program.attainable(options, "feasibility_tol"),
        )
        engine_result = _ended("COBYQA", result, None)
        # `success` is its own check of the violation
        if engine_result.claim is Claim.LOCAL and not result.success:
            return engine_result._replace(claim=Claim.FAILED)
        return engine_result

    return run


def trust_constr(options: OptionValues) -> NlpCall:
    """A call of trust-constr.

    Its gtol is on the Lagrangian's gradient and on the violation.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        from scipy.optimize import NonlinearConstraint
        from scipy.sparse import csr_array

        functions = program.functions
        if guess.size > _MOST_DENSE:
            functions = _sparse(program)
        constrained = functions.equations(guess).size > 0
        constraints: Any = ()
        if constrained:  # SciPy refuses an empty constraint
            constraints = NonlinearConstraint(
                functions.equations, 0.0, 0.0, jac=functions.jacobian, hess=functions.hessian
            )
        none = np.zeros(0)
        zeros = csr_array((guess.size, guess.size))

        def hessian(x: FloatArray) -> Any:
            if constrained:  # that of the equations has the objective's curvature in it
                return zeros
            return functions.hessian(x, none)

        with warnings.catch_warnings():
            # SciPy warns of a singular Jacobian, which it then factorizes in another way
            warnings.simplefilter("ignore", UserWarning)
            result = _minimized(
                "trust-constr",
                program,
                guess,
                seconds,
                jac=functions.gradient,
                hess=hessian,
                constraints=constraints,
                options=program.attainable(options, "gtol", "barrier_tol"),
            )
        duals = None
        if constrained:
            duals = np.asarray(result.v[0])
        return _ended("trust-constr", result, duals)

    return run


def _sparse(program: Program) -> Functions:
    """The program's functions with sparse derivatives.

    The Jacobian and the Hessian are `csr_array`s.
    """
    from scipy.sparse import csr_array

    functions = program.functions
    entries = functions.entries
    n = program.lower.size
    m = functions.equations(program.lower).size
    # SciPy wants the whole Hessian: the entries below the diagonal stand above it too
    rows, columns = entries.hessian_at
    below = rows != columns
    both_triangles = np.hstack((entries.hessian_at, entries.hessian_at[::-1, below]))

    def jacobian(x: FloatArray) -> Any:
        return csr_array((entries.jacobian(x), entries.jacobian_at), shape=(m, n))

    def hessian(x: FloatArray, weights: FloatArray) -> Any:
        lower = entries.hessian(x, 1.0, weights)
        return csr_array((np.append(lower, lower[below]), both_triangles), shape=(n, n))

    return functions._replace(jacobian=jacobian, hessian=hessian)


def _minimized(
    method: str, program: Program, guess: FloatArray, seconds: float | None, **arguments: Any
) -> Any:
    """Run `scipy.optimize.minimize`; return its result.

    With `seconds` a callback stops the run after this time. `arguments` are handed to SciPy too.
    """
    from scipy.optimize import Bounds, minimize

    if seconds is not None:
        until = perf_counter() + seconds

        def stop_late(*_: Any) -> None:  # its arguments depend on the method
            if perf_counter() > until:
                raise StopIteration

        arguments["callback"] = stop_late
    arguments["bounds"] = Bounds(program.lower, program.upper)
    return minimize(program.functions.objective, guess, method=method, **arguments)


def _ended(method: str, result: Any, duals: FloatArray | None) -> EngineResult:
    """SciPy's result as an `EngineResult`."""
    name = "status"
    if method == "SLSQP":
        name = "mode"
    native = f"{name} {result.status}"
    return EngineResult(
        result.x,
        claim_of(method.lower(), native),
        duals,
        iterations=int(result.nit),
        evaluations=int(result.nfev),
        status=native,
        message=str(result.message),
    )


def _duals(result: Any, program: Program) -> FloatArray | None:
    """Duals of the equations.

    SciPy's Lagrangian is f - m g; this package's is f + m g, so the sign changes. At some optima,
    status 0 included, SciPy returns 1e8 and more (seen with 1.17.1). Such duals are returned only
    if the Lagrangian is stationary in the variables between their bounds; otherwise the result is
    None.
    """
    duals = result.get("multipliers")
    if duals is None:
        return None
    if not math.hypot(*duals) < _LONG_DUAL:
        functions = program.functions
        x = result.x
        slope = functions.gradient(x) - duals @ functions.jacobian(x)
        between = (x > program.lower + _AT_BOUND) & (x < program.upper - _AT_BOUND)
        if not (np.abs(slope[between]) <= _STATIONARY).all():
            return None
    return -np.asarray(duals)

"""SciPy's SLSQP and COBYQA; its trust-constr has a module of its own."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import Engine, EngineResult, Program
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

# SLSQP's own exit modes (scipy/optimize, slsqp); 4, an infeasible linearisation, is no claim about
# the problem
_SLSQP_CLAIMS = {0: Claim.LOCAL, 9: Claim.LIMIT, 99: Claim.LIMIT}  # 99: stopped by the callback

# COBYQA's own exit statuses (scipy/_lib/cobyqa/settings.py): the least trust-region radius, a
# callback's stop, limits. -1 says that the bounds exclude each other, no more.
_COBYQA_CLAIMS = {0: Claim.LOCAL, 3: Claim.LIMIT, 5: Claim.LIMIT, 6: Claim.LIMIT}

# The duals of two end-point equations whose path ends straight are a unit vector; up to this length
# they are passed on without a check.
_LONG_DUAL = 2.0
_AT_BOUND = 1e-6  # in the variables' unit: nearer to a bound, its own dual has a say
_STATIONARY = 1e-3  # slopes of 1 in all: what is off by more is no stationary point

# A run of SLSQP of so many iterations on so few variables takes less than a tenth of a second and
# needs no look at the time, for which SciPy takes a tenth longer.
_QUICK_ITERATIONS = 1000
_FEW_VARIABLES = 10

# a tolerance times the equations' magnitude, at most so many times larger, since the path misses by
# what the engine leaves of the equations; but never below the rounding of the sums themselves
_LARGEST_FACTOR = 1e3
_ROUNDINGS = 64 * EPS


def slsqp(tol: float, max_iter: int) -> Engine:
    """SLSQP after Kraft: sequential quadratic programs.

    `tol` is SciPy's ftol, on the objective's change and the sum of violations; it grows with the
    equations' magnitude up to a thousandfold, since rounding grows with it.
    """
    long_run = max_iter > _QUICK_ITERATIONS

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        from scipy.optimize import minimize

        functions, magnitude = program.functions, program.magnitude
        larger = tol * min(max(1.0, magnitude), _LARGEST_FACTOR)
        result = minimize(
            functions.objective,
            guess,
            jac=functions.gradient,
            method="SLSQP",
            bounds=list(zip(program.lower.tolist(), program.upper.tolist(), strict=True)),
            constraints={"type": "eq", "fun": functions.equations, "jac": functions.jacobian},
            callback=_stop_after(seconds) if long_run or guess.size > _FEW_VARIABLES else None,
            options={"ftol": max(larger, _ROUNDINGS * magnitude), "maxiter": max_iter},
        )
        return EngineResult(
            result.x,
            _SLSQP_CLAIMS.get(int(result.status), Claim.FAILED),
            _duals(result, program),
            int(result.nit),
            int(result.nfev),
            f"mode {result.status}",
            str(result.message),
        )

    return run


def cobyqa(tol: float, max_iter: int) -> Engine:
    """COBYQA of Ragonneau and Zhang: quadratic models by interpolation; it takes no derivatives.

    `tol` is the violation of each equation, and the trust region's last radius.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        from scipy.optimize import Bounds, NonlinearConstraint, minimize

        functions = program.functions
        result = minimize(
            functions.objective,
            guess,
            method="COBYQA",
            bounds=Bounds(program.lower, program.upper),
            constraints=NonlinearConstraint(functions.equations, 0.0, 0.0),
            callback=_stop_after(seconds),
            options={
                "feasibility_tol": max(tol, _ROUNDINGS * program.magnitude),
                "final_tr_radius": tol,
                "maxiter": max_iter,
            },
        )
        claim = _COBYQA_CLAIMS.get(int(result.status), Claim.FAILED)
        if claim is Claim.LOCAL and not result.success:  # its own check of the violation
            claim = Claim.FAILED
        counts = int(result.nit), int(result.nfev)
        return EngineResult(
            result.x, claim, None, *counts, f"status {result.status}", str(result.message)
        )

    return run


def _stop_after(seconds: float) -> Callable[[FloatArray], None]:
    until = perf_counter() + seconds

    def stop_late(x: FloatArray) -> None:
        if perf_counter() > until:
            raise StopIteration

    return stop_late


def _duals(result: Any, program: Program) -> FloatArray | None:
    """Duals of the equations: SciPy's Lagrangian is f - m g, ours f + m g.

    At some optima, status 0 included, SciPy returns 1e8 and more (seen with 1.17.1). What is no
    derivative of the Lagrangian with respect to a variable between its bounds is not passed on.
    """
    duals = result.get("multipliers")
    if duals is None:
        return None
    if not math.hypot(*duals) < _LONG_DUAL:
        functions, x = program.functions, result.x
        slope = functions.gradient(x) - duals @ functions.jacobian(x)
        between = (x > program.lower + _AT_BOUND) & (x < program.upper - _AT_BOUND)
        if not (np.abs(slope[between]) <= _STATIONARY).all():
            return None
    return -np.asarray(duals)

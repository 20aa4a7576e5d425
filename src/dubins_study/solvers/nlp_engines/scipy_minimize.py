"""SciPy's SLSQP, COBYQA and trust-constr.

The last has no test for infeasibility; here a run of it ends where the constraint violation is
stationary, which is what Ipopt, too, calls locally infeasible, and where the violation does not
fall any more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import EngineResult, NlpCall, Program, needs_watch
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

# a tolerance times the equations' magnitude, at most so many times larger, since the path misses by
# what the engine leaves of the equations
_LARGEST_FACTOR = 1e3


def slsqp(tol: float, max_iter: int) -> NlpCall:
    """SLSQP after Kraft; `tol` is SciPy's ftol, on the objective's change and the violations' sum.

    It grows with the equations' magnitude, as rounding does.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        from scipy.optimize import minimize

        functions = program.functions
        larger = tol * min(max(1.0, program.magnitude), _LARGEST_FACTOR)
        result = minimize(
            functions.objective,
            guess,
            jac=functions.gradient,
            method="SLSQP",
            bounds=list(zip(program.lower.tolist(), program.upper.tolist(), strict=True)),
            constraints={"type": "eq", "fun": functions.equations, "jac": functions.jacobian},
            callback=_stop_after(seconds) if needs_watch(max_iter, guess.size) else None,
            options={"ftol": program.attainable(larger), "maxiter": max_iter},
        )
        claim = _SLSQP_CLAIMS.get(int(result.status), Claim.FAILED)
        return _ended(result, claim, _duals(result, program), "mode")

    return run


def cobyqa(tol: float, max_iter: int) -> NlpCall:
    """COBYQA of Ragonneau and Zhang, without derivatives.

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
                "feasibility_tol": program.attainable(tol),
                "final_tr_radius": tol,
                "maxiter": max_iter,
            },
        )
        claim = _COBYQA_CLAIMS.get(int(result.status), Claim.FAILED)
        if claim is Claim.LOCAL and not result.success:  # its own check of the violation
            claim = Claim.FAILED
        return _ended(result, claim, None)

    return run


def _ended(
    result: Any, claim: Claim, duals: FloatArray | None, status: str = "status"
) -> EngineResult:
    """SciPy's result as every engine gives it; `status` is what the method calls its number."""
    native, message = f"{status} {result.status}", str(result.message)
    return EngineResult(result.x, claim, duals, int(result.nit), int(result.nfev), native, message)


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


# SciPy's own statuses; 3 is a stop by `_Watch` and 4 a success that misses its constraints
_TRUST_CONSTR_CLAIMS = {0: Claim.LIMIT, 1: Claim.LOCAL, 2: Claim.LOCAL}

# A run is stopped when its least violation has not halved in so many iterations. Of 302 runs that
# reached a solution of (4.12), over all words and distances, none had needed more than 9.
_STALLED_ITERATIONS = 20

# The projected gradient of half the squared violation, in units of the violation, below which a
# point counts as stationary. None of those 302 runs passed such a point on its way.
_STATIONARY_VIOLATION = 1e-2

# radii: at a double root, such as LS to a target on the circle, a point d away has a gradient near
# d and a violation near d^2 / 2; a violation above this with a gradient below that is none.
_INFEASIBLE = 1e-3

# of the equations' rounding: trust-constr comes nearer than `Program.attainable`
_TRUST_CONSTR_ROUNDINGS = 16 * EPS


class _Watch:
    """Stops a run that is out of time, has found no way on, or makes too little of it."""

    def __init__(self, program: Program, deadline: float, tolerance: float) -> None:
        self.program, self.deadline, self.tolerance = program, deadline, tolerance
        self.least, self.since = math.inf, 0
        self.claim: Claim | None = None
        self.message = ""

    def __call__(self, intermediate_result: Any) -> None:
        violation = intermediate_result.constr_violation
        if violation < self.least / 2:
            self.least, self.since = violation, 0
        self.since += 1
        if perf_counter() > self.deadline:
            self._stop(Claim.LIMIT, "out of time")
        if violation > _INFEASIBLE and _stationary(self.program, intermediate_result.x):
            self._stop(Claim.INFEASIBLE, "the constraint violation is stationary")
        if violation > self.tolerance and self.since > _STALLED_ITERATIONS:
            self._stop(Claim.FAILED, "the constraint violation falls no more")

    def _stop(self, claim: Claim, message: str) -> None:
        self.claim, self.message = claim, message
        raise StopIteration


def _stationary(program: Program, x: FloatArray) -> bool:
    """Whether no small step within the bounds lessens the violation."""
    x = np.clip(x, program.lower, program.upper)
    violation = program.functions.equations(x)
    downhill = x - program.functions.jacobian(x).T @ violation
    step = x - np.clip(downhill, program.lower, program.upper)
    return bool(np.abs(step).max() <= _STATIONARY_VIOLATION * math.hypot(*violation))


def trust_constr(tol: float, max_iter: int) -> NlpCall:
    """trust-constr; `tol` is SciPy's gtol and barrier_tol, or what rounding leaves."""

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        from scipy.optimize import Bounds, NonlinearConstraint, minimize

        functions = program.functions
        tolerance = max(tol, _TRUST_CONSTR_ROUNDINGS * program.magnitude)
        watch = _Watch(program, perf_counter() + seconds, tolerance)
        none, zeros = np.zeros(0), np.zeros((guess.size, guess.size))
        constrained = functions.equations(guess).size > 0  # SciPy refuses an empty constraint
        equations = NonlinearConstraint(
            functions.equations, 0.0, 0.0, jac=functions.jacobian, hess=functions.hessian
        )
        result = minimize(
            functions.objective,
            guess,
            method="trust-constr",
            jac=functions.gradient,
            # that of the equations has the objective's curvature in it
            hess=lambda x: zeros if constrained else functions.hessian(x, none),
            bounds=Bounds(program.lower, program.upper),
            constraints=equations if constrained else (),
            callback=watch,
            options={
                "gtol": tolerance,
                "barrier_tol": tolerance,
                "xtol": 1e-12,  # so that gtol decides
                "maxiter": max_iter,
                # the default, QR, warns at every singular Jacobian and then does the same; it
                # does not take the sparse one that SciPy makes of no equations
                "factorization_method": "SVDFactorization" if constrained else None,
            },
        )
        if watch.claim is not None:
            result.message = watch.message
        claim = watch.claim or _TRUST_CONSTR_CLAIMS.get(result.status, Claim.FAILED)
        return _ended(result, claim, np.asarray(result.v[0]) if constrained else None)

    return run

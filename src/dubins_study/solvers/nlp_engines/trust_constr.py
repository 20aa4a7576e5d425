"""SciPy's trust-constr: a barrier and sequential quadratic programs in one.

It has no test for infeasibility of its own and goes on to its last iteration. Here a run ends where
the constraint violation is stationary, which is what Ipopt, too, calls locally infeasible, and
where the violation does not fall any more.
"""

from __future__ import annotations

import math
from time import perf_counter
from typing import Any

import numpy as np

from dubins_study.solvers.nlp_engines.program import Engine, EngineResult, Program
from dubins_study.study.body_coordinates import EPS
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

# SciPy's own statuses; 3 is a stop by `_Watch` and 4 a success that misses its constraints
_CLAIMS = {0: Claim.LIMIT, 1: Claim.LOCAL, 2: Claim.LOCAL}

# A run is stopped when its least violation has not halved in so many iterations. Of 302 runs that
# reached a solution of (4.12), over all words and distances, none had needed more than 9.
_STALLED_ITERATIONS = 20

# The projected gradient of half the squared violation, in units of the violation, below which a
# point counts as stationary. None of those 302 runs passed such a point on its way.
_STATIONARY = 1e-2

# radii: at a double root, such as LS to a target on the circle, a point d away has a gradient near
# d and a violation near d^2 / 2; a violation above this with a gradient below that is none.
_INFEASIBLE = 1e-3

# of the equations' rounding
_ROUNDINGS = 16 * EPS


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
    return bool(np.abs(step).max() <= _STATIONARY * math.hypot(*violation))


def trust_constr(tol: float, max_iter: int) -> Engine:
    """trust-constr; `tol` is SciPy's gtol and barrier_tol.

    It is more where the equations' magnitude is so large that rounding alone leaves more.
    """

    def run(program: Program, guess: FloatArray, seconds: float) -> EngineResult:
        from scipy.optimize import Bounds, NonlinearConstraint, minimize

        functions = program.functions
        tolerance = max(tol, _ROUNDINGS * program.magnitude)
        watch = _Watch(program, perf_counter() + seconds, tolerance)
        zeros = np.zeros((guess.size, guess.size))
        result = minimize(
            functions.objective,
            guess,
            method="trust-constr",
            jac=functions.gradient,
            hess=lambda x: zeros,  # that of the equations has the objective's curvature in it
            bounds=Bounds(program.lower, program.upper),
            constraints=NonlinearConstraint(
                functions.equations, 0.0, 0.0, jac=functions.jacobian, hess=functions.hessian
            ),
            callback=watch,
            options={
                "gtol": tolerance,
                "barrier_tol": tolerance,
                "xtol": 1e-12,  # so that gtol decides
                "maxiter": max_iter,
                # the default, QR, warns at every singular Jacobian and then does the same
                "factorization_method": "SVDFactorization",
            },
        )
        return EngineResult(
            result.x,
            watch.claim or _CLAIMS.get(result.status, Claim.FAILED),
            np.asarray(result.v[0]),
            int(result.nit),
            int(result.nfev),
            f"status {result.status}",
            watch.message or str(result.message),
        )

    return run

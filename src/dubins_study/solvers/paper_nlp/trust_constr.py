"""A subproblem by SciPy's trust-constr: a barrier and sequential quadratic programs in one.

It has no test for infeasibility of its own and goes on to its last iteration. Here a run ends where
the constraint violation is stationary, which is what Ipopt, too, calls locally infeasible, and
where the violation does not fall any more.
"""

from __future__ import annotations

import math
from time import perf_counter
from typing import Any

import numpy as np

from dubins_study.solvers.paper_nlp.best_point import Point
from dubins_study.solvers.paper_nlp.local_nlp import Case
from dubins_study.solvers.paper_nlp.model import equations, hessian, jacobian
from dubins_study.study.claim import Claim
from dubins_study.study.path import FloatArray
from dubins_study.study.vehicle_frame import EPS

# SciPy's own statuses; 3 is a stop by `_Watch` and 4 a success that misses its constraints
_CLAIMS = {0: Claim.LIMIT, 1: Claim.LOCAL, 2: Claim.LOCAL}

# A run is stopped when its least violation has not halved in so many iterations. Of 302 runs that
# reached a solution, over all words and distances, none had needed more than 9.
_STALLED_ITERATIONS = 20

# The projected gradient of half the squared violation, in units of the violation, below which a
# point counts as stationary. None of those 302 runs passed such a point on its way.
_STATIONARY = 1e-2

# radii: at a double root, such as LS to a target on the circle, a point d away has a gradient near
# d and a violation near d^2 / 2; a violation above this with a gradient below that is none.
_INFEASIBLE = 1e-3


class _Watch:
    """Stops a run that is out of time, has found no way on, or makes too little of it."""

    def __init__(self, case: Case, deadline: float, tolerance: float) -> None:
        self.case, self.deadline, self.tolerance = case, deadline, tolerance
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
        if violation > _INFEASIBLE and _stationary(self.case, intermediate_result.x):
            self._stop(Claim.INFEASIBLE, "the constraint violation is stationary")
        if violation > self.tolerance and self.since > _STALLED_ITERATIONS:
            self._stop(Claim.FAILED, "the constraint violation falls no more")

    def _stop(self, claim: Claim, message: str) -> None:
        self.claim, self.message = claim, message
        raise StopIteration


def _stationary(case: Case, free: FloatArray) -> bool:
    """Whether no small step within the bounds lessens the violation."""
    z = np.clip(_full(case, free), 0.0, case.upper)
    violation = equations(z, *case.target)
    step = z - np.clip(z - jacobian(z).T @ violation, 0.0, case.upper)
    return bool(np.abs(step).max() <= _STATIONARY * np.hypot(*violation))


def _full(case: Case, free: FloatArray) -> FloatArray:
    z = np.zeros(3)
    z[case.subproblem.mask] = free
    return z


def trust_constr(case: Case, guess: FloatArray, seconds: float, tol: float, max_iter: int) -> Point:
    """The point that trust-constr reaches from `guess`, shape (3,).

    Args:
        tol: SciPy's gtol and barrier_tol, in radii; more where the target is so far away that
            rounding alone leaves more.
    """
    from scipy.optimize import Bounds, NonlinearConstraint, minimize

    mask = case.subproblem.mask
    block = np.ix_(mask, mask)
    upper = case.upper[mask]
    ones, zeros = np.ones(upper.size), np.zeros((upper.size, upper.size))
    tolerance = max(tol, 16 * EPS * math.hypot(*case.target))
    watch = _Watch(case, perf_counter() + seconds, tolerance)
    result = minimize(
        np.sum,
        guess[mask],
        method="trust-constr",
        jac=lambda z: ones,
        hess=lambda z: zeros,
        bounds=Bounds(np.zeros(upper.size), upper),
        constraints=NonlinearConstraint(
            lambda z: equations(_full(case, z), *case.target),
            0.0,
            0.0,
            jac=lambda z: jacobian(_full(case, z))[:, mask],
            hess=lambda z, weights: hessian(_full(case, z), weights)[block],
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
    duals = result.v[0]
    return Point(
        case.subproblem,
        _full(case, result.x),
        watch.claim or _CLAIMS.get(result.status, Claim.FAILED),
        (float(duals[0]), float(duals[1])),
        int(result.nit),
        int(result.nfev),
        f"status {result.status}",
        watch.message or str(result.message),
    )

"""A subproblem by SciPy's trust-constr: a barrier and sequential quadratic programs in one.

It has no test for infeasibility, so where the constraint violation stops falling the run is
stopped and the place looked at: a stationary point of the violation is what Ipopt, too, calls
locally infeasible.
"""

from __future__ import annotations

import math
from time import perf_counter
from typing import Any

import numpy as np

from solvers.ipopt import Case
from solvers.model import Point, equations, hessian, jacobian
from study.path import FloatArray
from study.verify import Claim

# SciPy's own statuses; 3 is a stop by `_Watch` and 4 a success that misses its constraints
_CLAIMS = {0: Claim.LIMIT, 1: Claim.LOCAL, 2: Claim.LOCAL}

# A run is stopped when its least violation has not halved in so many iterations. Where a solution
# exists, runs took 10 to 40 iterations in all and had the violation fall through most of them.
_PATIENCE = 12

# The projected gradient of half the squared violation, in units of the violation, below which the
# point counts as stationary. At runs that fail with a solution elsewhere it is near 1.
_STATIONARY = 1e-2


class _Watch:
    """Stops a run that is out of time or makes no way towards the constraints."""

    def __init__(self, deadline: float, tolerance: float) -> None:
        self.deadline, self.tolerance = deadline, tolerance
        self.least, self.since, self.late = math.inf, 0, False

    def __call__(self, intermediate_result: Any) -> None:
        self.late = perf_counter() > self.deadline
        violation = intermediate_result.constr_violation
        if violation < self.least / 2:
            self.least, self.since = violation, 0
        self.since += 1
        if self.late or (self.since > _PATIENCE and violation > self.tolerance):
            raise StopIteration


def trust_constr(
    case: Case, start: FloatArray, seconds: float, tol: float, max_iter: int
) -> Point:
    """The point that trust-constr reaches from `start`, shape (3,).

    Args:
        tol: SciPy's gtol and barrier_tol, in radii; multiplied by the target's distance where that
            exceeds one radius, since rounding grows with it.
    """
    from scipy.optimize import NonlinearConstraint, minimize

    free = list(case.subproblem.free)
    block = np.ix_(free, free)
    ones, zeros = np.ones(len(free)), np.zeros((len(free), len(free)))
    X, Y = case.target
    tolerance = tol * max(1.0, math.hypot(X, Y))

    def full(z: FloatArray) -> FloatArray:
        whole = np.zeros(3)
        whole[free] = z
        return whole

    watch = _Watch(perf_counter() + seconds, tolerance)
    result = minimize(
        np.sum,
        start[free],
        method="trust-constr",
        jac=lambda z: ones,
        hess=lambda z: zeros,
        bounds=list(zip(case.lower[free], case.upper[free], strict=True)),
        constraints=NonlinearConstraint(
            lambda z: equations(full(z), X, Y),
            0.0,
            0.0,
            jac=lambda z: jacobian(full(z))[:, free],
            hess=lambda z, weights: hessian(full(z), weights)[block],
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
    z = full(result.x)
    claim, message = _CLAIMS.get(result.status, Claim.FAILED), str(result.message)
    if watch.late:
        claim, message = Claim.LIMIT, "out of time"
    elif claim is not Claim.LOCAL and _locally_infeasible(case, z, tolerance):
        claim, message = Claim.INFEASIBLE, "at a stationary point of the constraint violation"
    duals = result.v[0]
    return Point(
        case.subproblem,
        z,
        claim,
        (float(duals[0]), float(duals[1])),
        int(result.nit),
        int(result.nfev),
        f"status {result.status}",
        message,
    )


def _locally_infeasible(case: Case, z: FloatArray, tolerance: float) -> bool:
    """Whether no small step within the bounds lessens the violation, which is not small."""
    z = np.clip(z, case.lower, case.upper)
    violation = equations(z, *case.target)
    size = float(np.hypot(*violation))
    if not size > 1e3 * tolerance:
        return False
    step = z - np.clip(z - jacobian(z).T @ violation, case.lower, case.upper)
    return bool(np.abs(step).max() <= _STATIONARY * size)

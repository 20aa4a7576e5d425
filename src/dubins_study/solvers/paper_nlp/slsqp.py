"""The paper's model by sequential least squares quadratic programming (SciPy's SLSQP)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.paper_nlp.best_point import Point
from dubins_study.solvers.paper_nlp.local_nlp import Case, LocalNlp, Run
from dubins_study.solvers.paper_nlp.model import UNITS, equations, jacobian
from dubins_study.solvers.protocol import Method
from dubins_study.solvers.setting_checks import one_of, positive, within
from dubins_study.study.claim import Claim
from dubins_study.study.path import FloatArray
from dubins_study.study.scenario import Scenario
from dubins_study.study.vehicle_frame import EPS

_AT_BOUND = 1e-6  # radii or the scenario's unit: nearer to a bound, its own dual has a say
_STATIONARY = 1e-3  # slopes of 1 in all: what is off by more is no stationary point

# SLSQP's own exit modes (scipy/optimize, slsqp); 4, an infeasible linearisation, is no claim about
# the problem
_CLAIMS = {0: Claim.LOCAL, 9: Claim.LIMIT, 99: Claim.LIMIT}  # 99: stopped by `stop_late`

# a run of so many iterations, of some 50 microseconds each, needs no look at the time
_QUICK_ITERATIONS = 1000

Bounds = list[tuple[float, float]]


@dataclass(frozen=True)
class Slsqp(LocalNlp):
    """Model (4.12) by SLSQP; settings that are not explained here: `LocalNlp`.

    `ftol` is SLSQP's tolerance on the objective and the sum of constraint violations, in radii; it
    is multiplied by the target's distance where that exceeds one radius, up to a thousand, since
    rounding grows with it. `units` poses the model in turning radii, or as the paper does in the
    scenario's own unit; `ftol` is then in that unit too.
    """

    ftol: float = 1e-10
    maxiter: int = 40
    units: str = "radius"

    name: ClassVar[str] = "slsqp"
    packages: ClassVar[tuple[str, ...]] = ("scipy",)
    summary: ClassVar[str] = "the paper's model (4.12) by SciPy's SLSQP"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"ftol": 1e-8},
        "accurate": {"ftol": 1e-14},
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of(units=(self.units, UNITS))
        positive(maxiter=self.maxiter)
        within(ftol=(self.ftol, 1e-16, 1e-2))

    @property
    def method(self) -> Method:
        return Method(self.formulation, "SLSQP", self.initial_guess, self.ftol)

    @property
    def keeps_limit(self) -> bool:
        return True

    def unit(self, scenario: Scenario) -> float:
        return scenario.radius if self.units == "scenario" else 1.0

    def run(self) -> Run:
        return self._run

    def _run(self, case: Case, guess: FloatArray, seconds: float) -> Point:
        from scipy.optimize import minimize

        free, unit = list(case.subproblem.free), case.unit
        ones = np.ones(len(free))
        bounds = [(0.0, unit * float(case.upper[i])) for i in free]
        constraint = _constraint(case, free)
        until = perf_counter() + seconds

        def stop_late(z: FloatArray) -> None:
            if perf_counter() > until:
                raise StopIteration

        watched = self.maxiter > _QUICK_ITERATIONS
        result = minimize(
            _sum,
            unit * guess[free],
            jac=lambda z: ones,
            method="SLSQP",
            bounds=bounds,
            constraints=constraint,
            callback=stop_late if watched else None,
            options={"ftol": _tolerance(self.ftol, case), "maxiter": self.maxiter},
        )
        return Point(
            case.subproblem,
            _full(result.x, free) / unit,
            _CLAIMS.get(int(result.status), Claim.FAILED),
            _multipliers(result, constraint["jac"], bounds),
            int(result.nit),
            int(result.nfev),
            f"mode {result.status}",
            str(result.message),
        )


def _tolerance(ftol: float, case: Case) -> float:
    """SLSQP's tolerance for the case's target: larger by the rounding of the target's distance.

    At most a thousand times larger, since the path misses by what SLSQP leaves of the equations;
    but never below the rounding of the sums themselves.
    """
    distance = case.unit * math.hypot(*case.target)
    return max(ftol * min(max(1.0, distance), 1e3), 64 * EPS * distance)


def _constraint(case: Case, free: list[int]) -> dict[str, Any]:
    """The two equations of the free lengths and their Jacobian, in the model's unit."""
    (X, Y), unit = case.target, case.unit
    if unit == 1.0:
        return {
            "type": "eq",
            "fun": lambda z: equations(_full(z, free), X, Y),
            "jac": lambda z: jacobian(_full(z, free))[:, free],
        }
    return {
        "type": "eq",
        "fun": lambda z: unit * equations(_full(z, free) / unit, X, Y),
        "jac": lambda z: jacobian(_full(z, free) / unit)[:, free],
    }


def _multipliers(
    result: Any, jacobian: Callable[[FloatArray], FloatArray], bounds: Bounds
) -> tuple[float, float] | None:
    """Duals of the two equations: SciPy's Lagrangian is f - m c, the paper's f + m c.

    At some optima, status 0 included, SciPy returns 1e8 and more (seen with 1.17.1). What is no
    derivative of the Lagrangian with respect to a length between its bounds is not passed on.
    """
    duals = result.get("multipliers")
    if duals is None or len(duals) != 2:
        return None
    if not math.hypot(*duals) < 2:  # else nearly a unit vector, as where the path ends straight
        slope = 1.0 - duals @ jacobian(result.x)
        low, high = np.array(bounds).T
        between = (result.x > low + _AT_BOUND) & (result.x < high - _AT_BOUND)
        if not (np.abs(slope[between]) <= _STATIONARY).all():
            return None
    return -float(duals[0]), -float(duals[1])


_sum: Callable[[FloatArray], float] = np.sum


def _full(z: FloatArray, free: list[int]) -> FloatArray:
    full = np.zeros(3)
    full[free] = z
    return full

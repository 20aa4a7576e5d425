"""The paper's model by sequential least squares quadratic programming (SciPy's SLSQP)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.paper_nlp.best_point import Point, answer, attempts
from dubins_study.solvers.paper_nlp.initial_guesses import INITIAL_GUESSES
from dubins_study.solvers.paper_nlp.model import (
    FULL_TURN,
    MODELS,
    ORDERS,
    UNITS,
    Subproblem,
    equations,
    jacobian,
    subproblems,
    target,
)
from dubins_study.solvers.protocol import Question, Solution, Solver
from dubins_study.solvers.setting_checks import one_of, positive, within
from dubins_study.study.check.verdict import Claim
from dubins_study.study.closed_form.shortest import BRANCHES, EPS
from dubins_study.study.path import FloatArray

_AT_BOUND = 1e-6  # radii or the scenario's unit: nearer to a bound, its own dual has a say
_STATIONARY = 1e-3  # slopes of 1 in all: what is off by more is no stationary point

# SLSQP's own exit modes (scipy/optimize, slsqp); 4, an infeasible linearisation, is no claim about
# the problem
_CLAIMS = {0: Claim.LOCAL, 9: Claim.LIMIT}


class Case(NamedTuple):
    """A subproblem as SLSQP takes it: functions of the free lengths, a radius being `unit`."""

    subproblem: Subproblem
    constraint: dict[str, Any]
    bounds: list[tuple[float, float]]
    ftol: float
    unit: float


class Model(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    cases: list[Case]


@dataclass(frozen=True)
class Slsqp(Solver):
    """Model (4.12) by SLSQP.

    `model` and `order` choose the subproblems (`paper_nlp.model.subproblems`); `initial_guess`,
    `seed` and `count` choose where the search begins (`paper_nlp.initial_guesses`).
    `capped` bounds arcs by a full turn, which the paper does not. `ftol` is SLSQP's tolerance
    on the objective and the sum of constraint violations, in radii; it is multiplied by the
    target's distance where that exceeds one radius, up to a thousand, since rounding grows with
    it. `units` poses the model in turning radii, or as the paper does in the scenario's own unit;
    so is `ftol` then.
    """

    model: str = "words"
    order: str = "both"
    initial_guess: str = "bearing"
    seed: int = 0
    count: int = 10
    capped: bool = True
    ftol: float = 1e-10
    maxiter: int = 40
    units: str = "radius"

    name: ClassVar[str] = "slsqp"
    method: ClassVar[str] = "local NLP"
    branches: ClassVar[tuple[str, ...]] = BRANCHES
    warm: ClassVar[bool] = True
    packages: ClassVar[tuple[str, ...]] = ("scipy",)
    summary: ClassVar[str] = "the paper's model (4.12) by SciPy's SLSQP"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"ftol": 1e-8},
        "accurate": {"ftol": 1e-14},
    }

    def __post_init__(self) -> None:
        one_of(
            model=(self.model, MODELS),
            order=(self.order, ORDERS),
            initial_guess=(self.initial_guess, INITIAL_GUESSES),
        )
        one_of(units=(self.units, UNITS))
        positive(count=self.count, maxiter=self.maxiter)
        within(ftol=(self.ftol, 1e-16, 1e-2))

    def build(self, question: Question) -> Model:
        cases = [
            self._case(question, subproblem)
            for subproblem in subproblems(question, self.model, self.order)
        ]
        return Model(question, cases)

    def _case(self, question: Question, subproblem: Subproblem) -> Case:
        X, Y = target(question.scenario, subproblem.mirrored)
        free = list(subproblem.free)
        unit = question.scenario.radius if self.units == "scenario" else 1.0
        arc = unit * FULL_TURN if self.capped else math.inf
        return Case(
            subproblem,
            {
                "type": "eq",
                **_functions(X, Y, free, unit),
            },
            [(0.0, math.inf if i == 2 else arc) for i in free],
            _tolerance(self.ftol, unit * math.hypot(X, Y)),
            unit,
        )

    def solve(self, model: Model, limit: float) -> Solution:
        question = model.question
        tried = attempts(
            question, model.cases, self._from, self.initial_guess, self.seed, self.count
        )
        return answer(question, tried, limit)

    def _from(self, case: Case, guess: FloatArray) -> Point:
        from scipy.optimize import minimize

        ones = np.ones(len(case.subproblem.free))
        result = minimize(
            _sum,
            case.unit * guess[list(case.subproblem.free)],
            jac=lambda z: ones,
            method="SLSQP",
            bounds=case.bounds,
            constraints=case.constraint,
            options={"ftol": case.ftol, "maxiter": self.maxiter},
        )
        return Point(
            case.subproblem,
            _full(result.x, list(case.subproblem.free)) / case.unit,
            _CLAIMS.get(int(result.status), Claim.FAILED),
            _multipliers(result, case),
            int(result.nit),
            int(result.nfev),
            f"mode {result.status}",
            str(result.message),
        )


def _tolerance(ftol: float, distance: float) -> float:
    """SLSQP's tolerance for a target so far away: grown with the rounding of such a distance.

    By no more than a thousand times, since what it leaves of the equations is missed by; but
    never less than the rounding of the sums themselves.
    """
    return max(ftol * min(max(1.0, distance), 1e3), 64 * EPS * distance)


def _functions(X: float, Y: float, free: list[int], unit: float) -> dict[str, Any]:
    """The two equations of the free lengths and their Jacobian, a radius being `unit`."""
    if unit == 1.0:
        return {
            "fun": lambda z: equations(_full(z, free), X, Y),
            "jac": lambda z: jacobian(_full(z, free))[:, free],
        }
    return {
        "fun": lambda z: unit * equations(_full(z, free) / unit, X, Y),
        "jac": lambda z: jacobian(_full(z, free) / unit)[:, free],
    }


def _multipliers(result: Any, case: Case) -> tuple[float, float] | None:
    """Duals of the two equations: SciPy's Lagrangian is f - m c, the paper's f + m c.

    At some optima, status 0 included, SciPy returns 1e8 and more (seen with 1.17.1). What is no
    derivative of the Lagrangian with respect to a length between its bounds is not passed on.
    """
    duals = result.get("multipliers")
    if duals is None or len(duals) != 2:
        return None
    if math.hypot(*duals) < 2:  # a unit vector where the path ends straight: nothing to doubt
        return -float(duals[0]), -float(duals[1])
    slope = 1.0 - duals @ case.constraint["jac"](result.x)
    low, high = np.array(case.bounds).T
    between = (result.x > low + _AT_BOUND) & (result.x < high - _AT_BOUND)
    if not (np.abs(slope[between]) <= _STATIONARY).all():
        return None
    return -float(duals[0]), -float(duals[1])


_sum: Callable[[FloatArray], float] = np.sum


def _full(z: FloatArray, free: list[int]) -> FloatArray:
    full = np.zeros(3)
    full[free] = z
    return full

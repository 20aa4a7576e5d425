"""The paper's model written in Pyomo and solved by Ipopt, an interior-point method.

Pyomo writes the NL file once: the target is two variables that each scenario fixes through their
bounds. See `solvers.ipopt_library.engine` for the ways to reach Ipopt.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers import library_versions
from dubins_study.solvers.ipopt_library.engine import (
    CLAIMS,
    VIAS,
    Ask,
    Options,
    Program,
    by_executable,
    executable,
    library,
    unavailable,
)
from dubins_study.solvers.paper_nlp.best_point import Point, answer, attempts
from dubins_study.solvers.paper_nlp.initial_guesses import INITIAL_GUESSES
from dubins_study.solvers.paper_nlp.model import (
    FULL_TURN,
    MODELS,
    ORDERS,
    UNITS,
    Subproblem,
    subproblems,
    target,
)
from dubins_study.solvers.protocol import Question, Solution, Solver
from dubins_study.solvers.setting_checks import one_of, positive, within
from dubins_study.study.check.verdict import Claim
from dubins_study.study.closed_form.shortest import BRANCHES
from dubins_study.study.path import FloatArray


class Native(NamedTuple):
    """The result of one Ipopt run; z has shape (3,)."""

    z: FloatArray
    multipliers: tuple[float, float] | None
    status: str
    message: str
    iterations: int | None
    evaluations: int | None


class Case(NamedTuple):
    """A subproblem as Ipopt takes it: bounds of z and the target, in radii.

    `unit` is how long a radius is in what the model is posed in; None if that is the radius.
    """

    subproblem: Subproblem
    lower: FloatArray
    upper: FloatArray
    target: tuple[float, float]
    unit: float | None = None


# (the subproblem, its initial guess z) -> the result
Run = Callable[[Case, FloatArray], Native]


class Model(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    cases: list[Case]
    run: Run


@dataclass(frozen=True)
class Ipopt(Solver):
    """Model (4.12) by Ipopt.

    `model` and `order` choose the subproblems (`paper_nlp.model.subproblems`); `initial_guess`,
    `seed` and `count` choose where the search begins (`paper_nlp.initial_guesses`).
    `capped` bounds arcs by a full turn, which the paper does not. `tol`, `max_iter` and
    `bound_relax` (its bound_relax_factor) are Ipopt's own; the last is 1e-8 there, and Ipopt then
    returns arcs of -1e-8, which no vehicle drives: cut to zero they miss a target 1 000 radii away
    by 1e-5 radii. `mu_target` is Ipopt's too: the barrier parameter to stop at. `units` poses the
    model in turning radii, or as the paper does in the scenario's own unit. `via` is `executable`,
    `library` or `auto`: the executable if PATH has one.
    """

    model: str = "words"
    order: str = "both"
    initial_guess: str = "bearing"
    seed: int = 0
    count: int = 10
    capped: bool = True
    tol: float = 1e-8
    max_iter: int = 200
    bound_relax: float = 0.0
    mu_target: float = 0.0
    units: str = "radius"
    via: str = "auto"

    name: ClassVar[str] = "ipopt"
    method: ClassVar[str] = "local NLP"
    branches: ClassVar[tuple[str, ...]] = BRANCHES
    warm: ClassVar[bool] = True
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "casadi")
    summary: ClassVar[str] = "the paper's model (4.12) in Pyomo by Ipopt"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    def __post_init__(self) -> None:
        one_of(
            model=(self.model, MODELS),
            order=(self.order, ORDERS),
            initial_guess=(self.initial_guess, INITIAL_GUESSES),
        )
        one_of(via=(self.via, VIAS), units=(self.units, UNITS))
        positive(count=self.count, max_iter=self.max_iter)
        within(tol=(self.tol, 1e-14, 1e-2), bound_relax=(self.bound_relax, 0, 1e-2))
        within(mu_target=(self.mu_target, 0, 1))

    def unavailable(self) -> str | None:
        return unavailable(self.via)

    def library_versions(self) -> dict[str, str]:
        return library_versions.ipopt(by_executable(self.via))

    def build(self, question: Question) -> Model:
        template = executable_template if by_executable(self.via) else library_template
        unit = question.scenario.radius if self.units == "scenario" else None
        cases = cases_of(question, self.model, self.order, self.capped, unit)
        return Model(question, cases, template(self._options, self.units))

    @property
    def _options(self) -> Options:
        return (
            ("tol", self.tol),
            ("max_iter", self.max_iter),
            ("bound_relax_factor", self.bound_relax),
            ("mu_target", self.mu_target),
        )

    def solve(self, model: Model, limit: float) -> Solution:
        question = model.question
        tried = attempts(
            question,
            model.cases,
            partial(_attempt, model.run),
            self.initial_guess,
            self.seed,
            self.count,
        )
        return answer(question, tried, limit)


def cases_of(
    question: Question, model: str, order: str, capped: bool, unit: float | None = None
) -> list[Case]:
    """The subproblems of a question with their bounds; see `Case` and `model.subproblems`."""
    arc = FULL_TURN if capped else math.inf
    return [
        Case(
            subproblem,
            np.zeros(3),
            np.where(subproblem.mask, (arc, arc, math.inf), 0.0),
            target(question.scenario, subproblem.mirrored),
            unit,
        )
        for subproblem in subproblems(question, model, order)
    ]


def _attempt(run: Run, case: Case, guess: FloatArray) -> Point:
    native = run(case, guess)
    return Point(
        case.subproblem,
        native.z,
        CLAIMS.get(native.status, Claim.FAILED),
        native.multipliers,
        native.iterations,
        native.evaluations,
        native.status,
        native.message,
    )


def pyomo_model(units: str = "radius") -> Any:
    """Model (4.12) in Pyomo: z[1..3] >= 0 and the target as variables X, Y to be fixed.

    Args:
        units: lengths in turning radii, or as in the paper in the scenario's unit, with the
            radius R = 1 / b as one more variable to be fixed.
    """
    from pyomo.environ import ConcreteModel, Constraint, Objective, Var, cos, sin

    m = ConcreteModel(name="dubins-4.12")
    m.z = Var((1, 2, 3), bounds=(0, None), initialize=1.0)
    m.X = Var(initialize=1.0)
    m.Y = Var(initialize=1.0)
    z1, z2, z3 = m.z[1], m.z[2], m.z[3]
    R: Any = 1.0
    if units == "scenario":
        R = m.R = Var(initialize=1.0)
        z1, z2 = z1 / R, z2 / R
    m.x_end = Constraint(expr=m.X - R * (2 * sin(z1) - sin(z1 - z2)) - z3 * cos(z1 - z2) == 0)
    m.y_end = Constraint(expr=m.Y - R * (1 - 2 * cos(z1) + cos(z1 - z2)) - z3 * sin(z1 - z2) == 0)
    m.length = Objective(expr=m.z[1] + m.z[2] + z3)
    return m


def _program(units: str) -> Program:
    model = pyomo_model(units)
    data = [model.X, model.Y] if units == "radius" else [model.X, model.Y, model.R]
    return Program(model, [*model.z.values(), *data], [model.x_end, model.y_end])


@lru_cache(maxsize=32)
def library_template(options: Options, units: str = "radius") -> Run:
    """Ipopt from the casadi wheel on the model's NL file; compiled once per setting."""
    return _run(library(_program(units), options))


@lru_cache(maxsize=32)
def executable_template(options: Options, units: str = "radius") -> Run:
    """The `ipopt` executable on PATH, through Pyomo; the file is rewritten for every call."""
    return _run(executable(_program(units), options))


def _run(ask: Ask) -> Run:
    def run(case: Case, guess: FloatArray) -> Native:
        unit = 1.0 if case.unit is None else case.unit
        data = [unit * x for x in case.target] + ([] if case.unit is None else [case.unit])
        result = ask(*(np.concatenate((unit * z, data)) for z in (guess, case.lower, case.upper)))
        duals = None if result.duals is None else (float(result.duals[0]), float(result.duals[1]))
        counts = result.iterations, result.evaluations
        return Native(result.point[:3] / unit, duals, result.status, result.message, *counts)

    return run

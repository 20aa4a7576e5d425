"""The paper's model by any other NLP solver: SciPy's trust-constr, KNITRO, or one that AMPL calls.

An executable is looked up on PATH by its name and run as AMPL runs it (`solvers.paper_nlp.ampl`).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

from dubins_study.solvers.paper_nlp import ampl, pyomo_direct
from dubins_study.solvers.paper_nlp.best_point import Point, answer, attempts
from dubins_study.solvers.paper_nlp.initial_guesses import INITIAL_GUESSES
from dubins_study.solvers.paper_nlp.ipopt import Case, cases_of
from dubins_study.solvers.paper_nlp.model import (
    MODELS,
    ORDERS,
)
from dubins_study.solvers.paper_nlp.trust_constr import trust_constr
from dubins_study.solvers.protocol import Question, Solution, Solver
from dubins_study.solvers.setting_checks import one_of, positive, within
from dubins_study.study.closed_form.shortest import BRANCHES
from dubins_study.study.path import FloatArray

# A path would let whoever writes an experiment choose the file that is run.
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")

# (a subproblem, its initial guess, the seconds left) -> the point that the solver reaches
Route = Callable[[Case, FloatArray, float], Point]


class Model(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    cases: list[Case]
    route: Route


@dataclass(frozen=True)
class Nlp(Solver):
    """Model (4.12) by one of several NLP solvers.

    `model` and `order` choose the subproblems (`paper_nlp.model.subproblems`); `initial_guess`,
    `seed` and `count` choose where the search begins (`paper_nlp.initial_guesses`).
    `solver` is `trust-constr`, `knitro` or the name of an executable on PATH that reads NL files.
    `capped` bounds arcs by a full turn, which the paper does not. `tol` and `max_iter` are for
    trust-constr (`solvers.paper_nlp.trust_constr`); the other solvers run with their defaults, as
    in the paper.
    """

    solver: str = "trust-constr"
    model: str = "words"
    order: str = "both"
    initial_guess: str = "bearing"
    seed: int = 0
    count: int = 10
    capped: bool = True
    tol: float = 1e-9
    max_iter: int = 200

    name: ClassVar[str] = "nlp"
    method: ClassVar[str] = "local NLP"
    branches: ClassVar[tuple[str, ...]] = BRANCHES
    warm: ClassVar[bool] = True
    packages: ClassVar[tuple[str, ...]] = ("scipy", "pyomo", "knitro")
    summary: ClassVar[str] = "the paper's model (4.12) by trust-constr, KNITRO or any AMPL solver"
    variants: ClassVar[tuple[str, ...]] = ("nlp[solver=knitro]",)
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
        positive(count=self.count, max_iter=self.max_iter)
        within(tol=(self.tol, 1e-14, 1e-2))
        if not _NAME.fullmatch(self.solver):
            raise ValueError(
                f"solver is {self.solver!r}; expected trust-constr, knitro or the name of an "
                "executable on PATH: letters, digits, '_', '.' and '-', no folders"
            )

    @property
    def runs(self) -> str | None:
        """The program on PATH that is started, if any."""
        return None if self.solver in ("trust-constr", "knitro") else self.solver

    def unavailable(self) -> str | None:
        if self.solver == "trust-constr":
            return None
        if self.solver == "knitro":
            return pyomo_direct.knitro_unavailable()
        return ampl.unavailable(self.solver)

    def build(self, question: Question) -> Model:
        cases = cases_of(question, self.model, self.order, self.capped)
        return Model(question, cases, self._route())

    def _route(self) -> Route:
        if self.solver == "trust-constr":
            return partial(trust_constr, tol=self.tol, max_iter=self.max_iter)
        if self.solver == "knitro":
            return partial(pyomo_direct.solve, interface="knitro_direct")
        return partial(ampl.solve, executable=self.solver)

    def solve(self, model: Model, limit: float) -> Solution:
        question, deadline = model.question, perf_counter() + limit

        def run(case: Case, guess: FloatArray) -> Point:
            return model.route(case, guess, deadline - perf_counter())

        tried = attempts(question, model.cases, run, self.initial_guess, self.seed, self.count)
        return answer(question, tried, limit)

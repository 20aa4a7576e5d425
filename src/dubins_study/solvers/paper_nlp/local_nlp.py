"""The settings and the loop that all adapters of the paper's model (4.12) share."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.paper_nlp.best_point import Attempts, Point, answer
from dubins_study.solvers.paper_nlp.initial_guesses import (
    INITIAL_GUESSES,
    initial_guesses,
    suffices,
)
from dubins_study.solvers.paper_nlp.model import (
    FULL_TURN,
    MODELS,
    ORDERS,
    Subproblem,
    subproblems,
    target,
)
from dubins_study.solvers.protocol import Question, Solution, Solver
from dubins_study.solvers.setting_checks import one_of, whole
from dubins_study.study.path import FloatArray
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import BRANCHES


class Case(NamedTuple):
    """A subproblem of a question.

    Args:
        upper: upper bounds of z, shape (3,), radii; the lower bounds are 0.
        target: in the subproblem's frame, radii.
        unit: length of a radius in the unit in which the model is posed.
    """

    subproblem: Subproblem
    upper: FloatArray
    target: tuple[float, float]
    unit: float = 1.0


# (the case, an initial guess z of shape (3,) in radii, the seconds left) -> the point reached
Run = Callable[[Case, FloatArray, float], Point]


class Model(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    cases: list[Case]
    run: Run


@dataclass(frozen=True)
class LocalNlp(Solver):
    """Model (4.12) by a local NLP solver, which an adapter names in `run`.

    Args:
        model: `words` takes one two-variable problem per word, `joint` the paper's model unsplit.
        order: of the joint model: `LRS` (the paper's), `RLS` or `both`.
        initial_guess: where the search begins (`paper_nlp.initial_guesses`): `bearing`, `zero`,
            `random`, or `given`: only from the question's own guess.
        seed: of random guesses; the number of the repeat is added to it.
        count: number of random guesses.
        capped: whether arcs are bounded by a full turn, which the paper does not do.
        presolve: whether words that cannot exist are left out (`solvers.presolve`).
    """

    model: str = "words"
    order: str = "both"
    initial_guess: str = "bearing"
    seed: int = 0
    count: int = 10
    capped: bool = True
    presolve: bool = False

    branches: ClassVar[tuple[str, ...]] = BRANCHES
    warm: ClassVar[bool] = True

    def __post_init__(self) -> None:
        one_of(
            model=(self.model, MODELS),
            order=(self.order, ORDERS),
            initial_guess=(self.initial_guess, INITIAL_GUESSES),
        )
        whole(seed=(self.seed, 0, 2**32), count=(self.count, 1, 10**9))

    @property
    def formulation(self) -> str:
        """One of `study.words.FORMULATIONS`."""
        orders = "both orders" if self.order == "both" else self.order
        return f"joint NLP, {orders}" if self.model == "joint" else "one NLP a word"

    def run(self) -> Run:
        """The function that solves one case from one initial guess."""
        raise NotImplementedError

    def unit(self, scenario: Scenario) -> float:
        """Length of a radius in the unit in which the model is posed."""
        return 1.0

    def build(self, question: Question) -> Model:
        unit = self.unit(question.scenario)
        cases = [
            Case(
                subproblem,
                _upper(subproblem, self.capped),
                target(question.scenario, subproblem.mirrored),
                unit,
            )
            for subproblem in subproblems(question, self.model, self.order, self.presolve)
        ]
        return Model(question, cases, self.run())

    def solve(self, model: Model, limit: float) -> Solution:
        question, kind = model.question, self.initial_guess
        seed = self.seed + question.repeat
        attempts = [
            Attempts(
                partial(model.run, case),
                initial_guesses(question, case.subproblem, kind, seed, self.count),
                partial(suffices, question, case.subproblem, kind),
            )
            for case in model.cases
        ]
        return answer(question, attempts, limit)


@cache
def _upper(subproblem: Subproblem, capped: bool) -> FloatArray:
    arc = FULL_TURN if capped else math.inf
    return np.where(subproblem.mask, (arc, arc, math.inf), 0.0)

"""Local NLP solvers of the paper's model (4.12): their settings, and the best of several runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, partial
from time import perf_counter
from typing import ClassVar, NamedTuple

import numpy as np

from dubins_study.solvers.answers import Attempts, Run, at_start, costs, in_world, settled, tried
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.paper_nlp.initial_guesses import (
    INITIAL_GUESSES,
    initial_guesses,
    suffices,
)
from dubins_study.solvers.paper_nlp.model import (
    MODELS,
    ORDERS,
    SUBPROBLEMS,
    Subproblem,
    as_path,
    equations,
    formulation,
    subproblems,
    target,
)
from dubins_study.solvers.protocol import Question, Solution, Solver
from dubins_study.solvers.setting_checks import one_of, whole
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import BRANCHES, Claim


class Case(NamedTuple):
    """A subproblem of a question, with upper bounds of z, shape (3,), and its target, in radii.

    `unit` is the length of a radius in the unit in which the model is posed.
    """

    subproblem: Subproblem
    upper: FloatArray
    target: tuple[float, float]
    unit: float = 1.0


# (the case, an initial guess z of shape (3,) in radii, the seconds left) -> the end of the run,
# whose point is z and whose duals are those of the two equations
Adapter = Callable[[Case, FloatArray, float], EngineResult]


class PosedQuestion(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    cases: list[Case]
    adapter: Adapter


@dataclass(frozen=True)
class LocalNlp(Solver):
    """Model (4.12) by a local NLP solver, which an adapter names in `adapter`.

    Args:
        model: `words` takes one two-variable problem per word, `joint` the paper's model unsplit.
        order: of the joint model: `LRS` (the paper's), `RLS` or `both`.
        initial_guess: where the search begins (`paper_nlp.initial_guesses`): `bearing` (several
            guesses a word, one of the joint model), `words` (one for each word), `one`,
            `straight`, `zero`, `random`, or `given`: only from the question's own guess.
        seed: of random guesses; the number of the repeat is added to it.
        count: number of random guesses.
        capped: whether arcs are bounded by a full turn, which the paper does not do.
        presolve: whether words that cannot exist are left out (`solvers.presolve`).
    """

    model: str = one_of("words", MODELS)
    order: str = one_of("both", ORDERS)
    initial_guess: str = one_of("bearing", INITIAL_GUESSES)
    seed: int = whole(0, 0, 2**32)
    count: int = whole(10, 1, 10**9)
    capped: bool = True
    presolve: bool = False

    units = "radius"  # of the model's lengths (`UNITS`); some adapters make it a setting
    branches: ClassVar[tuple[str, ...]] = BRANCHES
    warm: ClassVar[bool] = True

    @property
    def formulation(self) -> str:
        return formulation(self.model, self.order)

    def adapter(self) -> Adapter:
        """The function that solves one case from one initial guess."""
        raise NotImplementedError

    def build(self, question: Question) -> PosedQuestion:
        scenario = question.scenario
        unit = scenario.radius if self.units == "scenario" else 1.0
        cases = [
            Case(one, _upper(one, self.capped), target(scenario, one.mirrored), unit)
            for one in subproblems(question, self.model, self.order, self.presolve)
        ]
        return PosedQuestion(question, cases, self.adapter())

    def solve(self, model: PosedQuestion, limit: float) -> Solution:
        question, kind = model.question, self.initial_guess
        # at z = 0 no constraint qualification holds, so that no NLP method can certify this point
        if there := at_start(question):
            return there
        until, seed = perf_counter() + limit, self.seed + question.repeat
        guesses = partial(initial_guesses, question, both=len(model.cases) > 1)
        each = (
            attempts(
                question,
                case.subproblem,
                kind,
                guesses(case.subproblem, kind, seed, self.count),
                partial(model.adapter, case),
            )
            for case in model.cases
        )
        return choose(question, tried(each, until))


@cache
def _upper(subproblem: Subproblem, capped: bool) -> FloatArray:
    # A path with a full turn in it is never shortest, so the cap, which the paper does not have,
    # removes local minima and no optimum (docs/derivation.md, section 7).
    arc = TWO_PI if capped else math.inf
    return np.where(subproblem.mask, (arc, arc, math.inf), 0.0)


def attempts(
    question: Question,
    subproblem: Subproblem,
    kind: str,
    guesses: Iterable[FloatArray],
    solve: Callable[[FloatArray, float], EngineResult],
) -> Attempts[FloatArray, FloatArray]:
    """Runs of `solve` from the guesses of a kind, until one `suffices`; a point is z."""

    def run(guess: FloatArray, until: float) -> Run[FloatArray]:
        began = perf_counter()
        result = solve(guess, until - began)
        seconds, length = perf_counter() - began, float(result.x.sum())
        return Run(subproblem.name, seconds, *result, length=length)

    return Attempts(guesses, run, lambda run: suffices(question, subproblem, kind, run.point))


def choose(question: Question, runs: list[Run[FloatArray]]) -> Solution:
    """The answer of all runs (`answers.settled`)."""
    if not runs:
        return Solution(Claim.LIMIT, message="no time to begin")
    scenario = question.scenario

    def residual(run: Run[FloatArray]) -> float:
        aim = target(scenario, SUBPROBLEMS[run.subproblem].mirrored)
        return float(np.abs(equations(run.point, *aim)).sum())

    best, claim = settled(runs, residual)
    subproblem = SUBPROBLEMS[best.subproblem]
    sides = (1, -1) if subproblem.mirrored else (1, 1)
    # a point that its engine calls infeasible is no path, and some engines return no numbers when
    # they fail
    pathless = claim is Claim.INFEASIBLE or bool(np.isnan(best.point).all())
    return Solution(
        claim,
        path=None if pathless else as_path(scenario, subproblem, best.point),
        claimed_length=best.length * scenario.radius if claim is Claim.LOCAL else None,
        multipliers=None
        if best.duals is None
        else in_world(scenario, np.multiply(sides, best.duals[:2])),
        native_status=best.status,
        message=f"{best.subproblem}: {best.message}",
        best_run=best.effort,
        **costs(runs),
    )

"""`penalty`: the model (4.12) as one function, searched.

While the least point misses the target, the miss's weight is multiplied and a new search begins
(Nocedal and Wright 2006, Numerical Optimization, Framework 17.2). No engine here checks a condition
of optimality, so the claim is `feasible` at most. The solver never claims that no path exists.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter
from typing import ClassVar

import numpy as np

from dubins_study.solvers.course import coordinate_rounding
from dubins_study.solvers.engines import SearchSolver, names, others, packages
from dubins_study.solvers.one_leg.initial_guesses import initial_guesses
from dubins_study.solvers.one_leg.model import (
    ORDERS,
    SUBPROBLEMS,
    Case,
    PosedLeg,
    as_path,
    equations,
    posed_leg,
)
from dubins_study.solvers.one_leg.polish import polish
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.runs import Run, at_start, no_solution, spent
from dubins_study.solvers.setting_checks import one_of, option_set, whole, within
from dubins_study.solvers.stochastic.penalty_function import (
    CountedFunction,
    PenaltyFunction,
    Task,
)
from dubins_study.study.arrays import FloatArray
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import ARRIVES
from dubins_study.study.words import BRANCHES, DERIVATIVE_FREE, SAMPLING, Claim

_ENGINES = names(SAMPLING, DERIVATIVE_FREE)
_GROWTH = 4.0
# Radii. A point that misses by more has stopped short of the target, and a larger weight helps. A
# point that misses by less has arrived, as exactly as the engine could.
_SHORT = 1e-2


@dataclass(frozen=True)
class Penalty(SearchSolver):
    """An exact penalty function of (4.12), minimised by sampling.

    Args:
        engine: a name in `solvers.engines` of a kind that searches.
        order: of the turns: `LRS`, `RLS` or `both`. A word as branch has its own.
        weight: of the miss in the first search; 1 is the norm of the multipliers of a path that
            ends straight, and 1.3 at a disc's centre.
        rounds: most searches from a guess, each with four times the weight of the one before.
        evaluations: most evaluations of the function in a search; 0 for the engine's default
            (`solvers.engines`), with which a target outside the discs takes some 0.15 s.
        polish: whether Newton's method moves the point until it arrives; without it the point is
            the engine's own.
        initial_guess, count: where an engine that needs a guess begins
            (`one_leg.initial_guesses`); engines that search the whole box take none.
        seed: of all random numbers, together with the question's repeat.
        presolve: whether a word as branch that cannot exist is answered without a search.
        options: the set of the engine's options: `equal`, `default` or `tuned` (docs/engines.md).
        restarts: whether a search that ends earlier begins anew until the evaluations are spent.
    """

    engine: str = one_of("differential-evolution", _ENGINES)
    order: str = one_of("both", ORDERS)
    weight: float = within(2.0, 1e-3, 1e9)
    rounds: int = whole(4, 1, 9)
    # DIRECT takes the memory for all of them at once; for more this takes seconds
    evaluations: int = whole(0, 0, 10**6)
    polish: bool = True
    initial_guess: str = one_of("bearing", ("bearing", "zero", "random"))
    count: int = whole(10, 1, 10**9)
    seed: int = whole(0, 0, 10**9)
    presolve: bool = False
    options: str = option_set()
    restarts: bool = False

    name = "penalty"
    guarantee = Guarantee.STOCHASTIC
    branches = BRANCHES
    packages = packages(_ENGINES)
    summary = "length plus weighted miss, searched without derivatives"
    variants = others("penalty", _ENGINES, _ENGINES[0])
    profiles: ClassVar = {
        "fast": {"rounds": 2},
        "accurate": {"evaluations": 20000},
    }

    @property
    def method(self) -> Method:
        return Method("penalty", self.library.label, self.guess)

    def build(self, question: Question) -> PosedLeg:
        return posed_leg(question, "joint", self.order)

    def solve(self, model: PosedLeg, limit: float) -> Solution:
        scenario = model.question.scenario
        if there := at_start(scenario, model.target):
            return there
        until = perf_counter() + limit
        runs: list[Run[FloatArray]] = []
        for number, case in enumerate(model.cases):
            runs += self._searches(model.question, case, number, until)
        return _answer(scenario, runs)

    def _searches(
        self, question: Question, case: Case, number: int, until: float
    ) -> Iterator[Run[FloatArray]]:
        """The searches of a case, guess by guess.

        From each guess the weight of the miss grows until a point does not stop short of the
        target, or until all rounds are made. The case's `number` among the cases is part of the
        seed.
        """
        seed = self.seed + question.repeat
        random = np.random.default_rng((seed, number))
        guesses: list[FloatArray | None] = [None]
        if self.guided:
            guesses = list(
                initial_guesses(question, case, self.initial_guess, seed=seed, count=self.count)
            )
        for guess in guesses:
            begin = guess
            weight = self.weight
            for _ in range(self.rounds):
                if perf_counter() > until:
                    return
                run = self._search(case, weight, begin, random, until)
                yield run
                z = run.result.x
                if _miss(case, z) <= _SHORT:
                    break
                weight *= _GROWTH
                if self.guided:
                    begin = z

    def _search(
        self,
        case: Case,
        weight: float,
        guess: FloatArray | None,
        random: np.random.Generator,
        until: float,
    ) -> Run[FloatArray]:
        """Run one search.

        The run's result has the engine's own z, shape (3,). The run's point is this z after the
        correction, if the setting `polish` is on.
        """
        began = perf_counter()
        penalised = PenaltyFunction(case, weight)
        budget = self.evaluations or self.library.evaluations
        function = CountedFunction(penalised, budget, until)
        begin = None
        if guess is not None:
            begin = np.clip(guess[list(case.subproblem.free)], 0.0, penalised.upper)
        result = Task(function, begin, random).search(self.engine, self.options, self.restarts)
        z = penalised.lengths(function.best)
        point = z
        missed = _miss(case, z)
        if self.polish and np.isfinite(z).all():
            point, missed = polish(case, z)
        seconds = perf_counter() - began
        length = float(point.sum())
        result = result._replace(x=z)
        return Run(case.subproblem.name, seconds, result, point, length=length, miss=missed)


def _miss(case: Case, z: FloatArray) -> float:
    return float(np.hypot(*equations(z, case.target.X, case.target.Y)))


def _answer(scenario: Scenario, runs: list[Run[FloatArray]]) -> Solution:
    """The answer of all runs.

    It is the shortest path that arrives. If none does, it is the one that ends nearest to the
    target.
    """
    runs_with_point = [run for run in runs if np.isfinite(run.point).all()]
    if not runs_with_point:
        return no_solution(runs)
    allowed = max(ARRIVES, coordinate_rounding(scenario))
    arriving = [run for run in runs_with_point if run.miss <= allowed]
    claim = Claim.FAILED
    if {run.claim for run in runs_with_point} == {Claim.LIMIT}:
        claim = Claim.LIMIT
    best = min(runs_with_point, key=lambda run: run.miss)
    claimed_length = None
    if arriving:
        claim = Claim.FEASIBLE
        best = min(arriving, key=lambda run: run.length)
        claimed_length = best.length * scenario.radius
    return Solution(
        claim,
        path=as_path(scenario, SUBPROBLEMS[best.subproblem], best.point),
        claimed_length=claimed_length,
        message=f"{best.subproblem}: {best.result.message}",
        **spent(runs, best),
    )

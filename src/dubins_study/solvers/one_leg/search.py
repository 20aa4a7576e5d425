"""Runs of an engine on a question's cases."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from time import perf_counter

import numpy as np

from dubins_study.solvers.course import in_world
from dubins_study.solvers.one_leg.initial_guesses import suffices
from dubins_study.solvers.one_leg.model import (
    SUBPROBLEMS,
    Case,
    PosedLeg,
    as_path,
    case_of,
    equations,
)
from dubins_study.solvers.protocol import Solution
from dubins_study.solvers.runs import (
    Attempts,
    EngineResult,
    Run,
    best_run_and_claim,
    no_solution,
    run_attempts,
    spent,
    timed,
)
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import DENIALS, Claim


def searched(
    posed: PosedLeg,
    kind: str,
    guesses: Callable[[Case], Iterable[FloatArray]],
    solve: Callable[[Case, FloatArray, float], EngineResult],
    limit: float,
) -> Solution:
    """Solve each case; answer with the best run.

    `guesses` returns a case's points z. A case is solved from them in turn until a solution
    `suffices` for guesses of this `kind`. `solve` takes a case, a point and the seconds that are
    left.
    """
    until = perf_counter() + limit

    def length(z: FloatArray) -> float:
        return float(z.sum())

    def attempts(case: Case) -> Attempts[FloatArray, FloatArray]:
        def enough(run: Run[FloatArray]) -> bool:
            return suffices(posed.question, case.subproblem, kind, run.point)

        run = timed(case.subproblem.name, partial(solve, case), length)
        return Attempts(guesses(case), run, enough)

    return _chosen(posed, run_attempts(map(attempts, posed.cases), until))


def _chosen(posed: PosedLeg, runs: list[Run[FloatArray]]) -> Solution:
    """The answer of all runs (`runs.best_run_and_claim`)."""
    if not runs:
        return no_solution(runs)
    scenario = posed.question.scenario

    def residual(run: Run[FloatArray]) -> float:
        X, Y, _ = case_of(run.subproblem, posed.target).target
        return float(np.abs(equations(run.point, X, Y)).sum())

    best, claim = best_run_and_claim(runs, residual)
    subproblem = SUBPROBLEMS[best.subproblem]
    duals = best.result.duals
    multipliers = None
    if duals is not None:
        sides = (1, 1)
        if subproblem.mirrored:  # the mirror turns y over, and with it the dual of y's equation
            sides = (1, -1)
        multipliers = in_world(scenario, np.multiply(sides, duals[:2]))
    # a point that its engine calls infeasible is no path, and some engines return no numbers when
    # they fail
    path = None
    if claim not in DENIALS and not np.isnan(best.point).all():
        path = as_path(scenario, subproblem, best.point)
    claimed_length = None
    if claim is Claim.LOCAL:
        claimed_length = best.length * scenario.radius
    return Solution(
        claim,
        path=path,
        claimed_length=claimed_length,
        multipliers=multipliers,
        message=f"{best.subproblem}: {best.result.message}",
        **spent(runs, best),
    )

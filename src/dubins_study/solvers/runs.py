"""Runs of engines, and one answer from several runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from time import perf_counter
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from dubins_study.solvers.protocol import Solution
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import Local
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Effort
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import ARRIVES
from dubins_study.study.words import Claim

Point = TypeVar("Point")
Guess = TypeVar("Guess")


class EngineResult(NamedTuple):
    """The end of one run of an engine.

    x, shape (n,), is NaN where the engine returns no point. With the duals, shape (m,), f + duals g
    is stationary in the free variables. Evaluations are those of the equations (or of the
    objective, if more), not of derivatives.
    """

    x: FloatArray
    claim: Claim
    duals: FloatArray | None = None
    iterations: int | None = None
    evaluations: int | None = None
    status: str = ""
    message: str = ""
    slope: Callable[[], float | None] | None = None  # of the violation (`nlp_engines.violation`)


def no_point(n: int, claim: Claim, status: str, message: str) -> EngineResult:
    """The end of a run that returned no point.

    x has n variables, all NaN. Iterations and evaluations are None.
    """
    return EngineResult(np.full(n, np.nan), claim, status=status, message=message)


class Run(NamedTuple, Generic[Point]):
    """One run of an engine on a subproblem.

    It holds how the run ended, its cost, and where its path leads.
    """

    subproblem: str
    seconds: float
    result: EngineResult  # its duals, if any, begin or end with those of the end point
    point: Point  # from which the formulation makes the path
    length: float = math.inf  # radii; infinite without a path
    miss: float = math.inf  # radii
    bound: float = -math.inf  # radii: the engine's lower bound on the length

    @property
    def claim(self) -> Claim:
        """The engine's claim."""
        return self.result.claim

    @property
    def effort(self) -> Effort:
        """The cost of the run."""
        return Effort(self.subproblem, 1, self.result.evaluations, self.seconds)


def timed(
    subproblem: str,
    solve: Callable[[Guess, float], EngineResult],
    length: Callable[[FloatArray], float],
) -> Callable[[Guess, float], Run[FloatArray]]:
    """A function that runs `solve` and times it.

    The function takes a guess and the time (s, on `perf_counter`) at which the run must end; it
    returns a `Run`. `solve` takes a guess and the seconds that are left. `length` takes the
    engine's point and returns the length (radii) of its path.
    """

    def run(guess: Guess, until: float) -> Run[FloatArray]:
        began = perf_counter()
        result = solve(guess, until - began)
        seconds = perf_counter() - began
        return Run(subproblem, seconds, result, result.x, length=length(result.x))

    return run


class Attempts(NamedTuple, Generic[Guess, Point]):
    """One subproblem and its initial guesses.

    The guesses are computed one by one and tried in turn.
    """

    guesses: Iterable[Guess]
    solve: Callable[[Guess, float], Run[Point]]  # until a time (s, on `perf_counter`)
    enough: Callable[[Run[Point]], bool]  # whether a solution makes further guesses needless


def run_attempts(attempts: Iterable[Attempts[Guess, Point]], until: float) -> list[Run[Point]]:
    """The runs on all subproblems.

    No run begins when the time is up. Each subproblem has an equal share of the time that is left:
    some engines never end on a word that has no path, and would leave nothing for the others.
    """
    runs: list[Run[Point]] = []
    subproblems = list(attempts)
    # `ended` counts the subproblems before this one
    for ended, (guesses, solve, enough) in enumerate(subproblems):
        began = perf_counter()
        end = began + (until - began) / (len(subproblems) - ended)
        for guess in guesses:
            if perf_counter() > end:
                break
            runs.append(solve(guess, end))
            if runs[-1].claim is Claim.LOCAL and enough(runs[-1]):
                break
    return runs


def best_run_and_claim(
    runs: Sequence[Run[Point]], miss: Callable[[Run[Point]], float]
) -> tuple[Run[Point], Claim]:
    """The best run, and the claim of the answer.

    The best run is the shortest one that its engine calls a solution. If there is none, it is the
    run that misses least. The claim is then the one that all runs share, else `failed`. A point
    that is feasible to the engine's tolerance but passes the points by is no path, and has failed
    too.
    """
    solved = [run for run in runs if run.claim is Claim.LOCAL]
    if solved:
        return min(solved, key=lambda run: run.length), Claim.LOCAL
    measured = [run._replace(miss=miss(run)) for run in runs]
    # some engines return no numbers when they fail: those runs go last
    best = min(measured, key=lambda run: (not math.isfinite(run.miss), run.miss))
    [claim, *others] = {run.claim for run in runs}
    if others or (claim is Claim.FEASIBLE and not best.miss <= ARRIVES):
        claim = Claim.FAILED
    return best, claim


# claims of an engine that ended by itself, without a path
_WITHOUT_PATH = (Claim.FAILED, Claim.LOCALLY_INFEASIBLE)


def spent(runs: Sequence[Run[Any]], best: Run[Any] | None = None) -> dict[str, Any]:
    """The fields of a `Solution` about its cost.

    The counts cover all runs of a question. With `best` there are also fields about the best run.
    """
    fields: dict[str, Any] = {
        "iterations": total(run.result.iterations for run in runs),
        "evaluations": total(run.result.evaluations for run in runs),
        "efforts": summed(run.effort for run in runs),
    }
    if best is not None:
        fields |= {"best_run": best.effort, "native_status": best.result.status}
        if best.claim in _WITHOUT_PATH and best.result.slope is not None:
            fields["violation_slope"] = best.result.slope()
    return fields


def no_solution(runs: Sequence[Run[Any]]) -> Solution:
    """The answer `limit`, for runs without a point."""
    message = "no time to begin"
    if runs:
        message = runs[0].result.message
    return Solution(Claim.LIMIT, message=message)


def at_start(scenario: Scenario, target: Local | None, tolerance: float = 0.0) -> Solution | None:
    """A path of no length, or None.

    The answer exists if the target is within `tolerance` radii of the start. `target` is None where
    a path of no length is no answer: in every case but one leg with a free final heading.
    """
    if target is None or not math.hypot(target.X, target.Y) <= tolerance:
        return None
    path = Path(scenario.start, [], [])
    return Solution(Claim.LOCAL, path=path, claimed_length=0.0, message="the target is the start")


def total(counts: Iterable[int | None]) -> int | None:
    """The sum, or None if a count is missing.

    An engine that does not count gives None.
    """
    numbers = list(counts)
    if None in numbers:
        return None
    return sum(count for count in numbers if count is not None)


def summed(efforts: Iterable[Effort]) -> tuple[Effort, ...]:
    """The efforts, added up by subproblem.

    The subproblems are in the order in which they were begun.
    """
    by_name: dict[str, list[Effort]] = {}
    for effort in efforts:
        by_name.setdefault(effort.subproblem, []).append(effort)
    return tuple(
        Effort(
            name,
            sum(effort.runs for effort in group),
            total(effort.evaluations for effort in group),
            sum(effort.seconds for effort in group),
        )
        for name, group in by_name.items()
    )

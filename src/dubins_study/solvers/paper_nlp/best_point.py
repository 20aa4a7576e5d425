"""The answer of a local NLP solver: the best point of several subproblems and initial guesses."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from time import perf_counter
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.paper_nlp.model import Subproblem, as_path, equations, target
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.solvers.vehicle_frame import at_start, in_world
from dubins_study.study.path import FloatArray
from dubins_study.study.rows.schema import Effort
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import ARRIVES
from dubins_study.study.words import Claim


class Point(NamedTuple):
    """The end of one run: an NLP solver on one subproblem from one guess; z has shape (3,)."""

    subproblem: Subproblem
    z: FloatArray
    claim: Claim
    multipliers: tuple[float, float] | None
    iterations: int | None
    evaluations: int | None
    status: str
    message: str


class Attempts(NamedTuple):
    """One subproblem and the initial guesses to solve it from.

    Args:
        solve: solves the subproblem from an initial guess in the seconds that are left.
        guesses: the initial guesses, computed one by one since mostly the first one succeeds.
        suffices: whether a solution z, shape (3,), leaves no reason to solve from another guess.
    """

    solve: Callable[[FloatArray, float], Point]
    guesses: Iterable[FloatArray]
    suffices: Callable[[FloatArray], bool]


def answer(question: Question, attempts: list[Attempts], limit: float) -> Solution:
    """The answer to a question: each subproblem attempted in turn, the best point chosen.

    No attempt begins after `limit` seconds. If the target is the start, nothing is attempted: at
    z = 0 no constraint qualification holds, so that no NLP method can certify this point.
    """
    return at_start(question) or choose(question, _runs(attempts, limit))


class TimedRun(NamedTuple):
    """A run's end, and how long it took (s)."""

    point: Point
    seconds: float


def _runs(attempts: list[Attempts], limit: float) -> list[TimedRun]:
    deadline = perf_counter() + limit
    runs: list[TimedRun] = []
    for solve, guesses, suffices in attempts:
        for guess in guesses:
            began = perf_counter()
            if began > deadline:
                return runs
            point = solve(guess, deadline - began)
            runs.append(TimedRun(point, perf_counter() - began))
            if point.claim is Claim.LOCAL and suffices(point.z):
                break
    return runs


def choose(question: Question, runs: list[TimedRun]) -> Solution:
    """The answer to a question from the runs of all its subproblems and initial guesses.

    It is the shortest point that the solver calls a solution. If there is none, it is the point
    that ends nearest to the target, with the claim that all points share, or `failed`.
    """
    scenario = question.scenario
    points = [run.point for run in runs]
    solved = [point for point in points if point.claim is Claim.LOCAL]
    if solved:
        best = min(solved, key=lambda point: float(point.z.sum()))
        claim = Claim.LOCAL
    elif points:
        best = min(points, key=lambda point: _residual(scenario, point))
        claims = {point.claim for point in points}
        claim = claims.pop() if len(claims) == 1 else Claim.FAILED
        if claim is Claim.FEASIBLE and not _residual(scenario, best) <= ARRIVES:
            claim = Claim.FAILED  # feasible to the solver's tolerance, but no path to the target
    else:
        return Solution(Claim.LIMIT, message="no time to begin")
    duals = best.multipliers
    left = 0.0 if duals is None else -duals[1] if best.subproblem.mirrored else duals[1]
    # a point that its solver calls infeasible is no path, and some solvers return no numbers when
    # they fail
    pathless = claim is Claim.INFEASIBLE or bool(np.isnan(best.z).all())
    return Solution(
        claim,
        path=None if pathless else as_path(scenario, best.subproblem, best.z),
        claimed_length=float(best.z.sum()) * scenario.radius if solved else None,
        multipliers=None if duals is None else in_world(scenario, duals[0], left),
        iterations=total([point.iterations for point in points]),
        evaluations=total([point.evaluations for point in points]),
        native_status=best.status,
        message=f"{best.subproblem.name}: {best.message}",
        efforts=efforts(runs),
        best_run=next(_effort([run]) for run in runs if run.point is best),
    )


def efforts(runs: Iterable[TimedRun]) -> tuple[Effort, ...]:
    """What each subproblem cost, in the order in which they were begun."""
    by_name: dict[str, list[TimedRun]] = {}
    for run in runs:
        by_name.setdefault(run.point.subproblem.name, []).append(run)
    return tuple(_effort(of_one) for of_one in by_name.values())


def _effort(runs: list[TimedRun]) -> Effort:
    evaluations = total(run.point.evaluations for run in runs)
    seconds = sum(run.seconds for run in runs)
    return Effort(runs[0].point.subproblem.name, len(runs), evaluations, seconds)


def total(counts: Iterable[int | None]) -> int | None:
    """The sum, or None if a backend does not count."""
    known = list(counts)
    return None if None in known else sum(count for count in known if count is not None)


def _residual(scenario: Scenario, point: Point) -> float:
    residual = np.abs(equations(point.z, *target(scenario, point.subproblem.mirrored))).sum()
    return float(residual) if np.isfinite(residual) else math.inf

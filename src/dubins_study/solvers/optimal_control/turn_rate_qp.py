"""`turn-rate-qp`: the optimal-control problem cut into turn rates, solved as a sequence of QPs."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.answers import coordinate_rounding, in_world, summed
from dubins_study.solvers.engines import ENGINES, EngineSolver, names
from dubins_study.solvers.optimal_control.arcs import (
    CLOSE,
    RATES,
    SHARINGS,
    Controls,
    Rates,
    step_shares,
)
from dubins_study.solvers.optimal_control.turn_rate_sequence import Limits, Run, Sequence
from dubins_study.solvers.optimal_control.turn_rate_template import Template, template
from dubins_study.solvers.paper_nlp.polish import one_sided_only
from dubins_study.solvers.presolve import words
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.setting_checks import one_of, whole
from dubins_study.study.path import FloatArray, Path, drivable
from dubins_study.study.rows.schema import Effort
from dubins_study.study.words import QP, Claim


@dataclass(frozen=True, eq=False)
class TurnRateModel:
    """A question in body coordinates, in units of the radius; shares of the steps (n,)."""

    question: Question
    target: FloatArray
    shares: FloatArray
    rates: Rates
    qp: Template


@dataclass(frozen=True)
class TurnRateQp(EngineSolver):
    """Problem (2.2) of the paper with n turn rates, each held for an equal part of a free duration.

    Every step is an exact arc, so the path can be driven; it is the best of its n steps, not of
    all paths. `LS` and `RS` forbid turning the other way. For `best`, a sequence of QPs starts from
    the shape of every word, and the shortest path is the answer.

    Args:
        n: number of steps.
        engine: QP engine, one of clarabel, osqp, piqp, highs.
        mesh: `equal` steps, or `graded`: for a far target half of the steps share about a full
            circle's length at the start, where the path turns.
        tolerance: a sequence has converged when a QP promises less than this times the length.
        max_qps: most QPs from one initial guess.
        presolve: whether no guess is shaped like a word that cannot exist (`solvers.presolve`).
    """

    n: int = 50
    engine: str = "piqp"
    mesh: str = "equal"
    tolerance: float = 1e-7
    max_qps: int = 60
    presolve: bool = False

    name: ClassVar[str] = "turn-rate-qp"
    guarantee: ClassVar[Guarantee] = Guarantee.DISCRETISED
    branches: ClassVar[tuple[str, ...]] = tuple(RATES)
    warm: ClassVar[bool] = True
    packages: ClassVar[tuple[str, ...]] = ("cvxpy", "clarabel", "highspy", "osqp", "piqp")
    summary: ClassVar[str] = "optimal control over n turn rates, a sequence of convex QPs in cvxpy"
    # gaps near 1e-9 outside the discs and 2e-6 inside, for ten times the time
    profiles: ClassVar[dict[str, dict[str, Any]]] = {"accurate": {"n": 640, "mesh": "graded"}}

    def __post_init__(self) -> None:
        # the QPs are dense: a larger one takes gigabytes
        whole(n=(self.n, 2, 2000), max_qps=(self.max_qps, 1, 10**6))
        one_of(engine=(self.engine, names(QP)), mesh=(self.mesh, SHARINGS))
        if not 0 < self.tolerance < 1:
            raise ValueError(f"tolerance is {self.tolerance!r}; expected a number from 0 to 1")

    @property
    def method(self) -> Method:
        return Method("turn rates", ENGINES[self.engine].label, "bearing", self.tolerance)

    @property
    def keeps_limit(self) -> bool:
        # compiling takes 0.4 s at 1000 steps and 1.6 s at 2000; PIQP has no limit of its own
        return self.n <= 1000

    def build(self, question: Question) -> TurnRateModel:
        target = np.array(question.scenario.local())
        shares = step_shares(self.n, self.mesh, math.hypot(*target))
        qp = template(self.n, self.engine)
        return TurnRateModel(question, target, shares, RATES[question.branch], qp)

    def solve(self, model: TurnRateModel, limit: float) -> Solution:
        deadline = time.perf_counter() + limit
        if math.hypot(*model.target) <= coordinate_rounding(model.question.scenario):
            stay = Controls(np.zeros(self.n), 0.0)
            run = Run(Claim.LOCAL, stay, 0.0, None, 0, 0, "the target is at the start")
            return _solution(model, [run], [])
        limits = Limits(self.tolerance, self.max_qps, deadline)
        sequence = Sequence(model.qp, model.target, model.shares, model.rates, limits)
        runs: list[Run] = []
        efforts: list[Effort] = []
        for subproblem, guess in _guesses(model, runs, self.presolve):
            began = time.perf_counter()
            runs.append(sequence.run(guess))
            seconds = time.perf_counter() - began
            efforts.append(Effort(subproblem, 1, runs[-1].rollouts, seconds))
            if runs[-1].claim is Claim.LIMIT:
                break
        return _solution(model, runs, efforts)


def _guesses(
    model: TurnRateModel, runs: list[Run], presolve: bool
) -> Iterator[tuple[str, Controls]]:
    """Initial guesses in the order to be tried, and whose shape they have; `runs` as far as known.

    The question's own guess comes first, then one guess shaped like each word: a turn to the
    target's bearing and a straight, or two arcs. `LS` and `RS` end with the first guess that
    succeeds.
    """
    question, ends = model.question, np.cumsum(model.shares)
    X, Y = model.target
    if (
        question.initial_guess is not None
        and (warm := _resampled(question.initial_guess, model)) is not None
    ):
        yield "warm", warm
    if question.branch != "best":
        if not (runs and runs[-1].claim is Claim.LOCAL):
            yield question.branch, _turn_then_straight(question.branch, X, Y, ends)
        return
    shapes = words(question, presolve)
    for word in ("LS", "RS", "RL", "LR") if Y >= 0 else ("RS", "LS", "LR", "RL"):
        if word not in shapes:
            continue
        if word[1] == "S":
            yield word, _turn_then_straight(word, X, Y, ends)
        else:
            yield word, _two_arcs(word[1], ends)


def _turn_then_straight(word: str, X: float, Y: float, ends: FloatArray) -> Controls:
    """Turn to the bearing of the target, then as far as the target is away.

    `ends` (n,) are the shares of the length driven at the ends of the steps.
    """
    sign = 1.0 if word[0] == "L" else -1.0
    bearing = (sign * math.atan2(Y, X)) % (2 * math.pi)
    if bearing > 2 * math.pi - 1e-9:  # straight ahead, up to rounding
        bearing = 0.0
    length = math.hypot(X, Y) + bearing
    return Controls(sign * np.minimum(ends * length, bearing), length)


def _two_arcs(last: str, ends: FloatArray) -> Controls:
    """A short arc away, then most of a circle back to the side `last`; `ends` as above."""
    first, second = 0.5, 4.5
    sign = 1.0 if last == "L" else -1.0
    driven = ends * (first + second)
    heading = np.maximum(driven - first, 0.0) - np.minimum(driven, first)
    return Controls(sign * heading, first + second)


def _resampled(path: Path, model: TurnRateModel) -> Controls | None:
    """A path cut into the model's steps; None if it cannot be driven or has no length."""
    if not drivable(path) or not path.total_length > 0:
        return None
    ends = np.cumsum(model.shares) * path.total_length
    heading = path.at(ends)[:, 2] - path.start.heading
    return Controls(heading, path.total_length / model.question.scenario.radius)


def _solution(model: TurnRateModel, runs: list[Run], efforts: list[Effort]) -> Solution:
    """The shortest path that arrives, or else the nearest to the target, and its claim.

    The efforts are those of the runs; none where no engine was needed.
    """
    scenario = model.question.scenario
    arrived = [run for run in runs if run.miss <= CLOSE]
    if arrived:
        best = min(arrived, key=lambda run: run.controls.length)
    else:
        best = min(runs, key=lambda run: run.miss)
    claim = best.claim
    if any(run.claim is Claim.LIMIT for run in runs):
        claim = Claim.LIMIT
    elif arrived and claim is Claim.FAILED:
        claim = Claim.FEASIBLE  # the engine failed, but its last point arrives
    steps = model.shares * best.controls.length
    with np.errstate(invalid="ignore"):
        rate = np.where(steps > 0, best.controls.turns / steps, 0.0)
    rate = np.clip(rate, model.rates.lower, model.rates.upper)
    path = Path(scenario.start, rate / scenario.radius, steps * scenario.radius)
    message = "; ".join(dict.fromkeys(run.status for run in runs))
    if claim in (Claim.LOCAL, Claim.FEASIBLE) and (reason := one_sided_only(model.question, path)):
        claim, message = Claim.FAILED, reason
    multipliers = None
    if best.duals is not None and claim is Claim.LOCAL:
        multipliers = in_world(scenario, *map(float, best.duals))
    return Solution(
        claim,
        path=path,
        claimed_length=best.controls.length * scenario.radius,
        multipliers=multipliers,
        iterations=sum(run.qps for run in runs),
        evaluations=sum(run.rollouts for run in runs),
        native_status=best.status,
        message=message,
        efforts=summed(efforts),
        best_run=efforts[runs.index(best)] if efforts else None,
    )

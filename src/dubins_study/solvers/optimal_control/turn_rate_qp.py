"""`turn-rate-qp`: the optimal-control problem cut into turn rates, solved as a sequence of QPs."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.answers import Run, best_of, coordinate_rounding, costs, in_world
from dubins_study.solvers.engines import ENGINES, EngineSolver, names
from dubins_study.solvers.optimal_control.arcs import (
    CLOSE,
    RATES,
    SHARINGS,
    Controls,
    Rates,
    clipped,
    corrected,
    rollout,
    step_shares,
)
from dubins_study.solvers.optimal_control.turn_rate_template import (
    Answer,
    EngineError,
    Template,
    template,
)
from dubins_study.solvers.paper_nlp.polish import one_sided_only
from dubins_study.solvers.presolve import nearer_first
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.setting_checks import one_of, whole, within
from dubins_study.study.path import FloatArray, Path, drivable
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

    n: int = whole(50, 2, 2000)  # the QPs are dense: a larger one takes gigabytes
    engine: str = one_of("piqp", names(QP))
    mesh: str = one_of("equal", SHARINGS)
    tolerance: float = within(1e-7, 0, 1, ends=False)
    max_qps: int = whole(60, 1, 10**6)
    presolve: bool = False

    name: ClassVar[str] = "turn-rate-qp"
    guarantee: ClassVar[Guarantee] = Guarantee.DISCRETISED
    branches: ClassVar[tuple[str, ...]] = tuple(RATES)
    warm: ClassVar[bool] = True
    packages: ClassVar[tuple[str, ...]] = ("cvxpy", "clarabel", "highspy", "osqp", "piqp")
    summary: ClassVar[str] = "optimal control over n turn rates, a sequence of convex QPs in cvxpy"
    # gaps near 1e-9 outside the discs and 2e-6 inside, for ten times the time
    profiles: ClassVar[dict[str, dict[str, Any]]] = {"accurate": {"n": 640, "mesh": "graded"}}

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
            none, reason = np.zeros(self.n), "the target is at the start"
            return Solution(
                Claim.LOCAL,
                path=Path(model.question.scenario.start, none, none),
                claimed_length=0.0,
                iterations=0,
                evaluations=0,
                native_status=reason,
                message=reason,
            )
        sequence = Sequence(model, self, deadline)
        runs: list[Run[Controls]] = []
        for subproblem, guess in _guesses(model, runs, self.presolve):
            runs.append(sequence.run(subproblem, guess))
            if runs[-1].claim is Claim.LIMIT:
                break
        return _solution(model, runs)


def _guesses(
    model: TurnRateModel, runs: list[Run[Controls]], presolve: bool
) -> Iterator[tuple[str, Controls]]:
    """Initial guesses in the order to be tried, and whose shape they have; `runs` as far as known.

    The question's own guess comes first, then one shaped like each word. `LS` and `RS` end with the
    first guess that succeeds.
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
    for word in nearer_first(question, presolve, Y):
        if word[1] == "S":
            yield word, _turn_then_straight(word, X, Y, ends)
        else:
            yield word, _two_arcs(word[1], ends)


def _turn_then_straight(word: str, X: float, Y: float, ends: FloatArray) -> Controls:
    """Turn to the bearing of the target, then as far as the target is away.

    `ends` (n,) are the shares of the length at the ends of the steps.
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


def _solution(model: TurnRateModel, runs: list[Run[Controls]]) -> Solution:
    """The shortest path that arrives, or else the nearest to the target, and its claim."""
    scenario = model.question.scenario
    arrived = [run for run in runs if run.miss <= CLOSE]
    best = best_of(arrived, runs)
    claim = best.claim
    if any(run.claim is Claim.LIMIT for run in runs):
        claim = Claim.LIMIT
    elif arrived and claim is Claim.FAILED:
        claim = Claim.FEASIBLE  # the engine failed, but its last point arrives
    steps = model.shares * best.length
    with np.errstate(invalid="ignore"):
        rate = np.where(steps > 0, best.point.turns / steps, 0.0)
    rate = np.clip(rate, model.rates.lower, model.rates.upper)
    path = Path(scenario.start, rate / scenario.radius, steps * scenario.radius)
    message = "; ".join(dict.fromkeys(run.status for run in runs))
    if claim in (Claim.LOCAL, Claim.FEASIBLE) and (reason := one_sided_only(model.question, path)):
        claim, message = Claim.FAILED, reason
    duals = best.duals if claim is Claim.LOCAL else None
    return Solution(
        claim,
        path=path,
        claimed_length=best.length * scenario.radius,
        multipliers=None if duals is None else in_world(scenario, duals),
        native_status=best.status,
        message=message,
        best_run=best.effort,
        **costs(runs),
    )


_RETRIES = 3  # with a smaller trust region each, after which a failing engine ends the sequence
_ARRIVED = 1e-6  # of the length; the last correction closes such a miss at no cost of length
_LARGEST_PENALTY = 1e4  # a larger one hides the length behind the engines' tolerances
_LEAST_CURVATURE = 1e-6  # makes the QP's answer unique where the Lagrangian is not convex


class Sequence:
    """Sl1QP with a trust region (Fletcher 1987, Practical Methods of Optimization, sec. 14.4).

    The QP's curvature c_k is the Lagrangian's second derivative by the headings, lumped on the
    diagonal: the part of step k's chord along the multiplier. A negative one (the chord leads
    backwards) is replaced by zero, which keeps every QP convex.
    """

    def __init__(self, model: TurnRateModel, solver: TurnRateQp, deadline: float) -> None:
        self.qp, self.target, self.shares = model.qp, model.target, model.shares
        self.rates, self.solver, self.deadline = model.rates, solver, deadline

    def run(self, subproblem: str, guess: Controls) -> Run[Controls]:
        """Solve from one initial guess; QPs count as iterations, rollouts as evaluations."""
        began = time.perf_counter()
        self.restored = False
        self.qp.forget()
        self._begin(clipped(guess, self.shares, self.rates))
        self.qps, self.rollouts, failures = 0, 1, 0
        claim, status = Claim.FEASIBLE, "QP limit"
        while self.qps < self.solver.max_qps:
            if time.perf_counter() > self.deadline:
                claim, status = Claim.LIMIT, "time limit"
                break
            self.qps += 1
            try:
                converged = self._advance(self._ask())
            except EngineError as error:
                failures += 1
                self.reach *= 0.3
                if failures > _RETRIES:
                    claim, status = Claim.FAILED, str(error)
                    break
                continue
            if converged:
                claim, status = Claim.LOCAL, "converged"
                break
        if claim is Claim.LOCAL and not self._arrived():
            claim, status = Claim.FEASIBLE, "a dead end off the target"
        controls, miss, used = corrected(self.now, self.shares, self.rates, self.target)
        self.rollouts += used
        if claim in (Claim.LOCAL, Claim.FEASIBLE) and miss > CLOSE:
            claim, status = Claim.FAILED, f"{status}, {miss:.1e} radii off the target"
        duals = self.duals if claim is Claim.LOCAL else None
        seconds, texts = time.perf_counter() - began, (status, status)
        counts = self.qps, self.rollouts
        return Run(
            subproblem, seconds, controls, claim, duals, *counts, *texts, controls.length, miss
        )

    def _begin(self, controls: Controls) -> None:
        self.penalty, self.reach, self.ease = 10.0, 1.0, 1.0
        self.now, self.rolled = controls, rollout(controls, self.shares)
        final = controls.heading[-1]
        self.duals = np.array([np.cos(final), np.sin(final)])

    def _ask(self) -> Answer:
        """Write the linearisation at the present point into the QP, and solve it."""
        qp, now, T = self.qp, self.now, self.now.length
        self.unit = unit = min(1.0, T)  # a short path's headings change by about its length
        steps = self.shares * (T / unit)
        along = np.maximum(self.duals @ self.rolled.chords, 0.0) / T
        curvature = along / 2
        curvature[:-1] += along[1:] / 2
        floor = _LEAST_CURVATURE / along.size
        turns = now.turns / unit
        upper, lower = self.rates.upper * steps, self.rates.lower * steps
        qp.G[:] = self.rolled.gradient * (unit / T)
        qp.q[:] = self.rolled.end / T
        qp.r[:] = (self.target - self.rolled.end) / T
        qp.upper[:], qp.above[:] = upper, upper - turns
        qp.lower[:], qp.below[:] = lower, turns - lower
        qp.c[:] = np.maximum(curvature * self.ease, floor) * unit**2
        qp.penalty[:] = self.penalty
        qp.reach[:], qp.stretch[:] = self.reach / unit, min(self.reach, 0.5)
        return qp.solve(max(self.deadline - time.perf_counter(), 1e-3))

    def _merit(self, length: float, end: FloatArray) -> float:
        return length + self.penalty * float(np.abs(end - self.target).sum())

    def _advance(self, answer: Answer) -> bool:
        """Take the QP's step if it lowers the merit function; True if there is nothing to gain."""
        T = self.now.length
        before = self._merit(T, self.rolled.end)
        promised = before - T * (1.0 + answer.value)
        moved = Controls(self.now.heading + self.unit * answer.z, T * (1.0 + answer.t))
        trial = clipped(moved, self.shares, self.rates)
        rolled = rollout(trial, self.shares)
        self.rollouts += 1
        gain = before - self._merit(trial.length, rolled.end)
        if answer.slack < 1e-6 and gain < 0.7 * promised:
            # second-order correction: a good step must not fail for the linearisation's error
            closer, _, used = corrected(trial, self.shares, self.rates, self.target)
            bent = rollout(closer, self.shares)
            self.rollouts += used + 1
            better = before - self._merit(closer.length, bent.end)
            if better > gain:
                trial, rolled, gain = closer, bent, better
        if promised < self.solver.tolerance * T:
            if not answer.solved:
                raise EngineError("the engine stopped at its limit, before any gain")
            return self._arrived() or not (self._raise_penalty() or self._restore())
        self._adapt(answer, gain / promised)
        if gain > 0.05 * promised:
            self.now, self.rolled, self.duals = trial, rolled, answer.duals
        return False

    def _arrived(self) -> bool:
        off = float(np.abs(self.rolled.end - self.target).sum())
        return off <= max(_ARRIVED * self.now.length, CLOSE)

    def _raise_penalty(self) -> bool:
        """Raise the penalty on missing the target; False if it is at its largest.

        It is exact only above the multipliers, which have no bound where the second arc of RL or LR
        nears pi.
        """
        if self.penalty >= _LARGEST_PENALTY:
            return False
        self.penalty *= 10.0
        self.reach = max(self.reach, 0.1)
        return True

    def _restore(self) -> bool:
        """Restart once from a path that arrives, where no small change comes nearer; else False."""
        if self.restored:
            return False
        self.restored = True
        controls, miss, used = corrected(self.now, self.shares, self.rates, self.target)
        self.rollouts += used + 1
        if miss > CLOSE:
            return False
        self._begin(controls)
        return True

    def _adapt(self, answer: Answer, ratio: float) -> None:
        """Adapt the trust region and the curvature to the ratio of gain to predicted gain."""
        turned, stretched = self.unit * float(np.abs(answer.z).max()), abs(answer.t)
        if ratio > 0.75 and max(turned, 2 * stretched) > 0.9 * self.reach:
            self.reach = min(2 * self.reach, 4.0)
        elif ratio < 0.25:
            self.reach = 0.3 * max(turned, stretched)
        if ratio > 1.0:  # the neglected negative curvature was real: step further
            self.ease = max(0.3 * self.ease, 1e-3)
        elif ratio < 0.75:
            self.ease = min(3 * self.ease, 1.0)

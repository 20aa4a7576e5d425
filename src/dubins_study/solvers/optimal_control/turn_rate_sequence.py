"""The sequence of QPs of `turn-rate-qp`: linearise, solve, judge the step, and again."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from dubins_study.solvers.optimal_control.arcs import (
    CLOSE,
    Controls,
    Rates,
    clipped,
    corrected,
    rollout,
)
from dubins_study.solvers.optimal_control.turn_rate_template import Answer, EngineError, Template
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim


@dataclass(frozen=True)
class Limits:
    """When a sequence stops.

    At a predicted gain relative to the length, after a number of QPs, or at a time (s, on
    `perf_counter`).
    """

    tolerance: float
    max_qps: int
    deadline: float


@dataclass(frozen=True, eq=False)
class Run:
    """The end of a sequence of QPs; `miss` in radii, `duals` (2,) in body coordinates."""

    claim: Claim
    controls: Controls
    miss: float
    duals: FloatArray | None
    qps: int
    rollouts: int
    status: str


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

    def __init__(
        self, qp: Template, target: FloatArray, shares: FloatArray, rates: Rates, limits: Limits
    ) -> None:
        self.qp, self.target, self.shares, self.rates = qp, target, shares, rates
        self.limits = limits

    def run(self, guess: Controls) -> Run:
        """Solve from one initial guess. A failing engine is a claim, not an exception."""
        self.restored = False
        self.qp.forget()
        self._begin(clipped(guess, self.shares, self.rates))
        self.qps, self.rollouts, failures = 0, 1, 0
        claim, status = Claim.FEASIBLE, "QP limit"
        while self.qps < self.limits.max_qps:
            if time.perf_counter() > self.limits.deadline:
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
        return self._finish(claim, status)

    def _begin(self, controls: Controls) -> None:
        self.penalty, self.reach, self.ease = 10.0, 1.0, 1.0
        self.now, self.rolled = controls, rollout(controls, self.shares)
        final = controls.heading[-1]
        self.duals = np.array([np.cos(final), np.sin(final)])

    def _finish(self, claim: Claim, status: str) -> Run:
        if claim is Claim.LOCAL and not self._arrived():
            claim, status = Claim.FEASIBLE, "a dead end off the target"
        controls, miss, used = corrected(self.now, self.shares, self.rates, self.target)
        self.rollouts += used
        if claim in (Claim.LOCAL, Claim.FEASIBLE) and miss > CLOSE:
            claim, status = Claim.FAILED, f"{status}, {miss:.1e} radii off the target"
        duals = self.duals if claim is Claim.LOCAL else None
        return Run(claim, controls, miss, duals, self.qps, self.rollouts, status)

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
        return qp.solve(max(self.limits.deadline - time.perf_counter(), 1e-3))

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
        if promised < self.limits.tolerance * T:
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

        The penalty is exact only above the multipliers, which grow without bound where the second
        arc of RL or LR nears pi (docs/derivation.md, section 9).
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

"""`turn-rate-qp`: optimal control by a sequence of QPs.

The unknowns are turn rates.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from dubins_study.solvers.arcs import (
    CLOSE,
    LEAST,
    SHARINGS,
    Elements,
    Rates,
    Rollout,
    corrected,
    missed,
    remaining_turn,
    rollout,
    step_shares,
)
from dubins_study.solvers.course import Course
from dubins_study.solvers.engines import names
from dubins_study.solvers.optimal_control.transcription import (
    Guess,
    Template,
    Transcribed,
    Transcription,
)
from dubins_study.solvers.optimal_control.turn_rate_template import (
    EngineError,
    Numbers,
    QpAnswer,
    QpTemplate,
    template,
)
from dubins_study.solvers.protocol import Method
from dubins_study.solvers.runs import EngineResult
from dubins_study.solvers.setting_checks import one_of, option_set, whole, within
from dubins_study.study.words import QP, Claim


@dataclass(frozen=True)
class TurnRateQp(Transcription):
    """Problem (2.2) with n turn rates a leg.

    Each rate is held for a given part of the leg's length.

    Every step is an exact arc, so the path can be driven. It is the best path of n steps, not of
    all paths. Other settings: `Transcription`.

    Args:
        n: number of steps of a leg.
        engine: QP engine, one of clarabel, osqp, piqp, highs.
        mesh: `equal` steps, or `graded`: for a far point half of the steps share about a full
            circle's length at the start of the leg, where the path turns.
        tolerance: a sequence has converged when a QP promises less than this times the length.
        max_qps: most QPs from one initial guess.
        options: the set of the QP engine's options: `equal`, `default` or `tuned`
            (docs/engines.md).
    """

    n: int = whole(50, 2, 2000)
    engine: str = one_of("piqp", names(QP))
    mesh: str = one_of("equal", SHARINGS)
    tolerance: float = within(1e-7, 0, 1, ends=False)
    max_qps: int = whole(60, 1, 10**6)
    options: str = option_set()

    name = "turn-rate-qp"
    packages = ("cvxpy", "clarabel", "highspy", "osqp", "piqp")
    summary = "optimal control over n turn rates, a sequence of convex QPs in cvxpy"
    # gaps near 1e-9 outside the discs and 2e-6 inside, for ten times the time
    profiles: ClassVar = {"accurate": {"n": 640, "mesh": "graded"}}

    @property
    def method(self) -> Method:
        return Method(
            formulation="turn rates",
            engine=self.library.label,
            guess=self.initial_guess,
            tolerance=self.tolerance,
        )

    def template(self, course: Course) -> Template:
        qp = template(self.n, course.legs, course.last is not None, self.engine)
        shares = step_shares(self.n, self.mesh, course)
        least = (LEAST * shares).ravel()  # a step of no length cannot grow by a part of itself

        def solve(guess: Guess, rates: Rates, until: float) -> Transcribed:
            turn, length = guess.elements
            begin = Elements(turn, np.maximum(length, least))
            return Sequence(self, qp, rates, course, until).run(begin)

        return Template(shares, solve)


_RETRIES = 3  # with a smaller trust region each, after which a failing engine ends the sequence
_ARRIVED = 1e-6  # of the length; the last correction closes such a miss at no cost of length
_LARGEST_PENALTY = 1e4  # a larger one hides the length behind the engines' tolerances
_LEAST_CURVATURE = 1e-6  # makes the QP's answer unique where the Lagrangian is not convex


class Sequence:
    """Sl1QP with a trust region.

    Fletcher 1987, Practical Methods of Optimization, sec. 14.4.

    The QP's curvature c_k is the Lagrangian's second derivative by the headings, lumped on the
    diagonal: the part of step k's chord along the multiplier. A negative one (the chord leads
    backwards) is replaced by zero, which keeps every QP convex.
    """

    def __init__(
        self, solver: TurnRateQp, qp: QpTemplate, rates: Rates, course: Course, deadline: float
    ) -> None:
        self.qp = qp
        self.solver = solver
        self.options = solver.library.options.of(solver.options)
        self.rates = rates
        self.course = course
        self.deadline = deadline

    def run(self, guess: Elements) -> Transcribed:
        """Solve from one initial guess.

        QPs count as iterations, rollouts as evaluations.
        """
        self.restored = False
        self.qp.memory.clear()  # no answer depends on an earlier question
        self._begin(guess.within(self.rates))
        self.qps = 0
        self.rollouts = 1
        failures = 0
        claim = Claim.FEASIBLE
        status = "QP limit"
        while self.qps < self.solver.max_qps:
            if time.perf_counter() > self.deadline:
                claim = Claim.LIMIT
                status = "time limit"
                break
            self.qps += 1
            try:
                converged = self._advance(self._ask())
            except EngineError as error:
                failures += 1
                self.reach *= 0.3
                if failures > _RETRIES:
                    claim = Claim.FAILED
                    status = str(error)
                    break
                continue
            if converged:
                claim = Claim.LOCAL
                status = "converged"
                break
        if claim is Claim.LOCAL and not self._arrived():
            claim = Claim.LOCALLY_INFEASIBLE
            status = "a dead end off the target"
        correction = corrected(self.now, self.rates, self.course)
        elements = correction.elements
        self.rollouts += correction.rollouts
        duals = None
        if claim is Claim.LOCAL:
            duals = self.duals[-1]
        result = EngineResult(
            np.append(elements.turn, elements.length),
            claim,
            duals=duals,
            iterations=self.qps,
            evaluations=self.rollouts,
            status=status,
            message=status,
        )
        return Transcribed(elements, result)

    def _begin(self, elements: Elements) -> None:
        """Begin the sequence at these elements.

        The penalty, the trust region and the curvature begin anew. The multipliers are those of a
        path whose legs end straight: unit vectors along the headings at the legs' ends.
        """
        self.penalty = 10.0  # on missing the points
        self.reach = 1.0  # largest step of the trust region: rad, and share of a length
        self.ease = 1.0  # factor of the QP's curvature; below 1 the steps get longer
        self.now = elements  # the present point: the last one that was accepted
        self.rolled = rollout(self.now)  # its chords and their derivatives
        ends = np.cumsum(elements.turn).reshape(self.course.legs, -1)[:, -1]
        self.duals = np.column_stack([np.cos(ends), np.sin(ends)])

    def _ask(self) -> QpAnswer:
        """Linearise at the present point and solve the QP."""
        now = self.now
        rolled = self.rolled
        legs = self.course.legs
        self.scale = scale = now.total / legs
        self.unit = unit = min(1.0, scale)  # a short path's headings change by about its length
        chords = rolled.chords.reshape(2, legs, -1)
        along = np.maximum(np.einsum("li,iln->ln", self.duals, chords), 0.0).ravel() / scale
        # a heading is in the chord before it and in the one after it
        curvature = (along + np.append(along[1:], 0.0)) / 2
        floor = _LEAST_CURVATURE / along.size
        by_before = rolled.by_before.reshape(2, legs, -1)
        G = rolled.by_after.reshape(2, legs, -1).copy()
        G[:, :, :-1] += by_before[:, :, 1:]
        lengths = now.length / unit
        turns = now.turn / unit
        upper = self.rates.upper * lengths
        lower = self.rates.lower * lengths
        numbers = Numbers(
            G=G * (unit / scale),
            P=by_before[:, :, 0] * (unit / scale),
            q=chords.sum(axis=2) / scale,
            r=rolled.gaps(now, self.course).T / scale,
            w=now.length.reshape(legs, -1).sum(axis=1) / scale,
            upper=upper,
            lower=lower,
            above=upper - turns,
            below=turns - lower,
            c=np.maximum(curvature * self.ease, floor) * unit**2,
            penalty=np.array([self.penalty]),
            reach=np.array([self.reach / unit]),
            stretch=np.array([min(self.reach, 0.5)]),
            h=np.array([unit / scale]),
            r_h=np.array([remaining_turn(now, self.course) / scale]),
        )
        seconds = max(self.deadline - time.perf_counter(), 1e-3)
        return self.qp.solve(numbers, self.options, seconds)

    def _merit(self, elements: Elements, rolled: Rollout) -> float:
        gaps = float(np.abs(rolled.gaps(elements, self.course)).sum())
        return elements.total + self.penalty * (gaps + abs(remaining_turn(elements, self.course)))

    def _advance(self, answer: QpAnswer) -> bool:
        """Take the QP's step if the merit function falls.

        Returns True if the sequence has ended: the QP promises no gain, and there is nothing else
        to try.
        """
        before = self._merit(self.now, self.rolled)
        promised = before - self.now.total - self.scale * answer.value
        growth = np.repeat(1.0 + answer.t, self.now.length.size // answer.t.size)
        turn = self.now.turn + self.unit * np.diff(answer.z, prepend=0.0)
        trial = Elements(turn, self.now.length * growth).within(self.rates)
        rolled = rollout(trial)
        self.rollouts += 1
        gain = before - self._merit(trial, rolled)
        if answer.slack < 1e-6 and gain < 0.7 * promised:
            # second-order correction, one step (Nocedal and Wright 2006, Numerical Optimization,
            # sec. 15.6): a good step must not fail for the linearisation's error
            correction = corrected(trial, self.rates, self.course, steps=1)
            self.rollouts += correction.rollouts
            better = before - self._merit(correction.elements, correction.rolled)
            if better > gain:
                trial = correction.elements
                rolled = correction.rolled
                gain = better
        if promised < self.solver.tolerance * self.now.total:
            if not answer.solved:
                raise EngineError("the engine stopped at its limit, before any gain")
            return self._arrived() or not (self._raise_penalty() or self._restore())
        self._adapt(answer, gain / promised)
        if gain > 0.05 * promised:
            self.now = trial
            self.rolled = rolled
            self.duals = answer.duals
        return False

    def _arrived(self) -> bool:
        off = float(np.abs(missed(self.now, self.course)).sum())
        return off <= max(_ARRIVED * self.now.total, CLOSE)

    def _raise_penalty(self) -> bool:
        """Raise the penalty on missing the target.

        Returns False if it is at its largest. The penalty is exact only above the multipliers,
        which have no bound where the second arc of RL or LR nears pi.
        """
        if self.penalty >= _LARGEST_PENALTY:
            return False
        self.penalty *= 10.0
        self.reach = max(self.reach, 0.1)
        return True

    def _restore(self) -> bool:
        """Restart once from a path that arrives.

        This helps where no small change comes nearer. Returns False if the sequence has restarted
        before, or if no such path is found.
        """
        if self.restored:
            return False
        self.restored = True
        correction = corrected(self.now, self.rates, self.course)
        self.rollouts += correction.rollouts + 1
        if correction.miss > CLOSE:
            return False
        self._begin(correction.elements)
        return True

    def _adapt(self, answer: QpAnswer, ratio: float) -> None:
        """Adapt the trust region and the curvature.

        `ratio` is the gain over the predicted gain.
        """
        turned = self.unit * float(np.abs(answer.z).max())
        stretched = float(np.abs(answer.t).max())
        if ratio > 0.75 and max(turned, 2 * stretched) > 0.9 * self.reach:
            self.reach = min(2 * self.reach, 4.0)
        elif ratio < 0.25:
            self.reach = 0.3 * max(turned, stretched)
        if ratio > 1.0:  # the neglected negative curvature was real: step further
            self.ease = max(0.3 * self.ease, 1e-3)
        elif ratio < 0.75:
            self.ease = min(3 * self.ease, 1.0)

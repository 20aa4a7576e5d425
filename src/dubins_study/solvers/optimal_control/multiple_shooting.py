"""`multiple-shooting`: the optimal-control problem with poses as variables.

These are the poses between the arcs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from time import perf_counter

import numpy as np

from dubins_study.solvers.arcs import (
    Elements,
    Rates,
    chord,
    most_turn,
    step_shares,
)
from dubins_study.solvers.course import Course, heading_gap
from dubins_study.solvers.nlp_engines.program import Expressions, NlpCall, Program, Stages
from dubins_study.solvers.optimal_control.transcription import (
    Guess,
    NlpTranscription,
    Template,
    Transcribed,
    transcribed,
)
from dubins_study.solvers.setting_checks import whole

_POSE = 3  # x, y, heading


@dataclass(frozen=True)
class MultipleShooting(NlpTranscription):
    """Problem (2.2) by multiple shooting (Bock and Plitt 1984).

    Other settings: `NlpTranscription`. The program: docs/formulations/multiple-shooting.md. F
    drives an arc (`arcs.chord`); segments of the mesh `equal` have equal h_k.
    """

    n: int = whole(4, 3, 1000)

    name = "multiple-shooting"
    formulation = "multiple shooting"
    packages = ("casadi",)
    summary = "optimal control by multiple shooting, arcs of free length"

    def template(self, course: Course) -> Template:
        engine: NlpCall = self.library.load()(self.tol, self.max_iter, self.options)
        shares = None
        if self.mesh == "equal":
            shares = step_shares(self.n, "equal", course)
        return Template(shares, partial(self._solved, engine, course))

    def _solved(
        self, engine: NlpCall, course: Course, guess: Guess, rates: Rates, until: float
    ) -> Transcribed:
        """Solve from a guess, as `transcription.Template.solve` does.

        The poses of the guess follow from its controls. The variables of a segment are in the order
        of `expressions`.
        """
        turn, length = guess.elements
        legs = course.legs
        equal = self.mesh == "equal"
        # LS and RS have no variable for a turn to the other side: engines do badly with a fixed one
        signs = tuple(sign for sign, rate in ((1, rates.upper), (-1, rates.lower)) if rate != 0)
        turns = [np.maximum(sign * turn, 0.0) for sign in signs]
        straight = np.maximum(length - np.abs(turn), 0.0)
        poses = guess.states(legs, np.zeros(1))
        most = most_turn(course, self.n, equal)
        lowest = [-np.inf] * _POSE + [0.0] * (len(signs) + 1)
        highest = [np.inf] * _POSE + [most] * len(signs) + [np.inf]
        begin = np.column_stack((poses, *turns, straight)).ravel()[_POSE:]
        lower = np.tile(lowest, turn.size)[_POSE:]
        upper = np.tile(highest, turn.size)[_POSE:]
        final = course.last is not None
        program = Program(
            expressions(self.n, signs, equal, legs, final),
            p=course.data,
            lower=lower,
            upper=upper,
            magnitude=course.magnitude,
        )
        result = engine(program, np.clip(begin, lower, upper), until - perf_counter())
        # one row a segment; zeros stand for the first segment's pose, which is no variable
        rows = np.append(np.zeros(_POSE), result.x).reshape(turn.size, -1)
        lengths = np.maximum(rows[:, _POSE:], 0.0)
        elements = Elements(lengths[:, :-1] @ np.array(signs, float), lengths.sum(axis=1))
        if equal:
            mean = elements.length.reshape(legs, -1).mean(axis=1)
            elements = Elements(elements.turn, np.repeat(mean, self.n)).within(rates)
        return transcribed(elements, result)


@lru_cache(maxsize=32)
def expressions(n: int, signs: tuple[int, ...], equal: bool, legs: int, final: bool) -> Expressions:
    """The program over n segments a leg.

    Its parameters are the points and, if `final`, the final heading. Each segment has these
    variables:

    - The pose (x, y, heading) where it starts, but not for the first segment.
    - For each of the signs 1 (left) and -1 (right), the length of its turn.
    - The length of its straight.

    The equations of a segment are:

    - It ends at the next pose.
    - It is as long as the one before it, if those of a leg are equally long.
    - The last segment of a leg ends at the point. The last two equations are those of the end.
    """
    import casadi as ca

    segments = n * legs
    pose = ca.SX.sym("pose", _POSE, segments)
    control = ca.SX.sym("control", len(signs) + 1, segments)
    data = ca.SX.sym("data", 2 * legs + final)
    length = ca.sum1(control)
    gaps = []
    state = [ca.SX(0)] * _POSE
    for k in range(segments):
        x, y, heading = state
        turn = sum(sign * control[i, k] for i, sign in enumerate(signs))
        along, across = chord(heading, turn, length[k])
        end = ca.vertcat(x + along, y + across, heading + turn)
        if k < segments - 1:
            gaps.append(pose[:, k + 1] - end)
            state = ca.vertsplit(pose[:, k + 1])
        elif final:
            gaps.append(heading_gap(end[2], data[2 * legs]))
        if equal and k % n > 0:
            gaps.append(length[k] - length[k - 1])
        if k % n == n - 1:
            leg = k // n
            gaps.append(data[2 * leg : 2 * leg + 2] - end[:2])
    variables = ca.vec(ca.vertcat(pose, control))[_POSE:]
    stages = None
    if not equal:
        ng = ([0] * (n - 1) + [2]) * legs  # the two equations of a point where a leg ends
        ng[-1] += final
        stages = Stages(
            nx=(0, *(_POSE,) * (segments - 1)), nu=(len(signs) + 1,) * segments, ng=tuple(ng)
        )
    return Expressions(variables, p=data, f=ca.sum2(length), g=ca.vertcat(*gaps), stages=stages)

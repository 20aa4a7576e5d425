"""`turn-rates`: optimal control over turn rates alone.

It is one nonlinear program.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import ClassVar

import numpy as np

from dubins_study.solvers.arcs import (
    MOST_TURN_EACH,
    SHARINGS,
    Elements,
    Rates,
    chord,
    step_shares,
)
from dubins_study.solvers.course import Course, heading_gap
from dubins_study.solvers.engines import NLP_ENGINES
from dubins_study.solvers.nlp_engines.program import Expressions, NlpCall, Program
from dubins_study.solvers.optimal_control.transcription import (
    Guess,
    NlpTranscription,
    Template,
    Transcribed,
    transcribed,
)
from dubins_study.solvers.setting_checks import one_of, whole

# radii; a shortest path is longer than the target's distance by less than two full turns
_DETOUR = 4 * math.pi


@dataclass(frozen=True)
class TurnRates(NlpTranscription):
    """Problem (2.2) over turn rates and legs' lengths.

    Each leg has n turn rates. Other settings: `NlpTranscription`.

    Single shooting: the path is driven from the start to its end (`arcs.chord`), so that the
    equations are those of the points and of a final heading only. A step that could turn by more
    than half a circle has a smaller bound.

    Args:
        engine: a name in `solvers.engines` of the kind `local NLP`; no executable, since the files
            of a program whose equations hold all steps take longer to write than to solve.
        mesh: `equal` steps, or `graded` ones (`arcs.step_shares`).
    """

    n: int = whole(50, 3, 1000)
    engine: str = one_of("ipopt", NLP_ENGINES)
    mesh: str = one_of("equal", SHARINGS)

    name = "turn-rates"
    formulation = "turn rates"
    packages = ("casadi",)
    summary = "optimal control over n turn rates and the length, one program"
    profiles: ClassVar = {
        "fast": {"tol": 1e-7},
        "accurate": {"n": 200, "mesh": "graded"},
    }

    def template(self, course: Course) -> Template:
        shares = step_shares(self.n, self.mesh, course)
        longest = np.hypot(*course.steps.T)[:, None] + _DETOUR
        most = np.minimum(1.0, MOST_TURN_EACH / (shares * longest))  # turn rates
        engine: NlpCall = self.library.load()(self.tol, self.max_iter, self.options)
        legs, n = shares.shape

        def solve(guess: Guess, rates: Rates, until: float) -> Transcribed:
            lower = rates.lower * most.ravel()
            upper = rates.upper * most.ravel()
            program = Program(
                expressions(n, legs, course.last is not None),
                p=np.concatenate((course.data, shares.ravel())),
                lower=np.append(lower, np.zeros(legs)),
                upper=np.append(upper, np.full(legs, np.inf)),
                magnitude=course.magnitude,
            )
            leg_lengths = guess.elements.length.reshape(legs, n).sum(axis=1)
            begin = np.append(np.clip(guess.elements.rate, lower, upper), leg_lengths)
            result = engine(program, begin, until - perf_counter())
            rate, leg_lengths = np.split(result.x, [-legs])
            length = (shares * np.maximum(leg_lengths, 0.0)[:, None]).ravel()
            elements = Elements(np.clip(rate, rates.lower, rates.upper) * length, length)
            return transcribed(elements, result)

        return Template(shares, solve)


@lru_cache(maxsize=32)
def expressions(n: int, legs: int, final: bool) -> Expressions:
    """The program over turn rates and legs' lengths.

    The turn rates have shape (N,), the lengths (legs,).

    Its parameters are the points (2 legs,), the `final` heading, and the steps' shares (N,) of
    their leg's length. The last two equations are those of the end point.
    """
    import casadi as ca

    rate = ca.SX.sym("rate", n * legs)
    leg_lengths = ca.SX.sym("whole", legs)
    points = ca.SX.sym("points", 2 * legs)
    share = ca.SX.sym("share", n * legs)
    final_heading = ca.SX.sym("given", int(final))
    gaps = []
    x = ca.SX(0)
    y = ca.SX(0)
    heading = ca.SX(0)
    for k in range(n * legs):
        leg = k // n
        length = share[k] * leg_lengths[leg]
        along, across = chord(heading, rate[k] * length, length)
        x = x + along
        y = y + across
        heading = heading + rate[k] * length
        if k % n == n - 1:
            gaps.append(points[2 * leg : 2 * leg + 2] - ca.vertcat(x, y))
    if final:
        gaps.insert(0, heading_gap(heading, final_heading))
    data = ca.vertcat(points, final_heading, share)
    return Expressions(
        ca.vertcat(rate, leg_lengths), p=data, f=ca.sum1(leg_lengths), g=ca.vertcat(*gaps)
    )

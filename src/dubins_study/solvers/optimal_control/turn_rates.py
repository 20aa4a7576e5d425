"""`turn-rates`: the optimal-control problem over turn rates alone, as one nonlinear program."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.nlp_engines.program import Expressions, NlpCall, Program
from dubins_study.solvers.optimal_control.arcs import (
    MOST_TURN_EACH,
    SHARINGS,
    Elements,
    Rates,
    chord,
    step_shares,
)
from dubins_study.solvers.optimal_control.transcription import Transcribed, Transcription
from dubins_study.solvers.setting_checks import one_of, whole
from dubins_study.study.path import FloatArray

# radii; a shortest path is longer than the target's distance by less than two full turns
_DETOUR = 4 * math.pi


@dataclass(frozen=True)
class TurnRates(Transcription):
    """Problem (2.2) with n turn rates and the whole length; other settings: `Transcription`.

    Single shooting: the path is driven from the start to its end (`arcs.chord`), so that the end
    point's two equations are the only ones. Steps so long that they could turn by more than half a
    circle get a smaller bound.

    Args:
        mesh: `equal` steps, or `graded` ones (`arcs.step_shares`).
    """

    n: int = whole(50, 3, 1000)
    mesh: str = one_of("equal", SHARINGS)

    name: ClassVar[str] = "turn-rates"
    formulation: ClassVar[str] = "turn rates"
    packages: ClassVar[tuple[str, ...]] = ("casadi",)
    summary: ClassVar[str] = "optimal control over n turn rates and the length, one program"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-7},
        "accurate": {"n": 200, "mesh": "graded"},
    }

    @property
    def keeps_limit(self) -> bool:
        # compiling takes 0.2 s at 50 steps and 5 s at 200, a dense engine's iteration as much
        return super().keeps_limit and self.n <= 50

    def template(self, distance: float) -> Steps:
        shares = step_shares(self.n, self.mesh, distance)
        most = np.minimum(1.0, MOST_TURN_EACH / (shares * (distance + _DETOUR)))
        engine = ENGINES[self.engine].load()(self.tol, self.max_iter)
        return Steps(self.n, shares, most, engine)


@dataclass(frozen=True, eq=False)
class Steps:
    """The program over n turn rates, and its engine."""

    n: int
    shares: FloatArray  # of the length, shape (n,), summing to 1
    most: FloatArray  # the largest turn rates, shape (n,), at most 1
    engine: NlpCall

    def solve(self, guess: Elements, rates: Rates, target: FloatArray, until: float) -> Transcribed:
        """As `transcription.Template.solve`."""
        lower, upper = rates.lower * self.most, rates.upper * self.most
        program = Program(
            expressions(self.n),
            np.concatenate((target, self.shares)),
            np.append(lower, 0.0),
            np.append(upper, np.inf),
            magnitude=1.0 + float(np.abs(target).sum()),
        )
        begin = np.append(np.clip(guess.rate, lower, upper), guess.total)
        result = self.engine(program, begin, until - perf_counter())
        length = self.shares * max(float(result.x[-1]), 0.0)
        elements = Elements(np.clip(result.x[:-1], rates.lower, rates.upper) * length, length)
        return Transcribed(elements, result)


@lru_cache(maxsize=32)
def expressions(n: int) -> Expressions:
    """The program over the turn rates (n,) and the whole length.

    Its parameters are the target (2,) and the steps' shares (n,) of the length.
    """
    import casadi as ca

    rate, whole = ca.SX.sym("rate", n), ca.SX.sym("whole")
    target, share = ca.SX.sym("target", 2), ca.SX.sym("share", n)
    x, y, heading = ca.SX(0), ca.SX(0), ca.SX(0)
    for k in range(n):
        length = share[k] * whole
        along, across = chord(heading, rate[k] * length, length)
        x, y, heading = x + along, y + across, heading + rate[k] * length
    gap = target - ca.vertcat(x, y)
    return Expressions(ca.vertcat(rate, whole), ca.vertcat(target, share), whole, gap)

"""`multiple-shooting`: the optimal-control problem with the poses between arcs as variables."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.nlp_engines.program import Expressions, NlpCall, Program
from dubins_study.solvers.optimal_control.arcs import (
    INTEGRATORS,
    MOST_TURN,
    MOST_TURN_EACH,
    Elements,
    Rates,
    chord,
)
from dubins_study.solvers.optimal_control.transcription import Transcribed, Transcription
from dubins_study.solvers.setting_checks import one_of, whole
from dubins_study.study.path import FloatArray


@dataclass(frozen=True)
class MultipleShooting(Transcription):
    """Problem (2.2) by multiple shooting (Bock and Plitt 1984); other settings: `Transcription`.

    The program: docs/formulations/multiple-shooting.md. F drives an arc (`arcs.chord`); segments of
    the mesh `equal` have h_k = T / n.

    Args:
        integrator: of F: `exact`, or `rk4`: one classical Runge-Kutta step a segment.
    """

    n: int = whole(4, 3, 1000)
    integrator: str = one_of("exact", INTEGRATORS)

    name: ClassVar[str] = "multiple-shooting"
    formulation: ClassVar[str] = "multiple shooting"
    packages: ClassVar[tuple[str, ...]] = ("casadi",)
    summary: ClassVar[str] = "optimal control by multiple shooting, arcs of free length"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-7},
        "accurate": {"tol": 1e-11},
    }

    @property
    def keeps_limit(self) -> bool:
        # a dense engine's iteration takes 0.1 s at 20 segments and 10 s at 50
        return super().keeps_limit and self.n <= 20

    def template(self, distance: float) -> Segments:
        engine = ENGINES[self.engine].load()(self.tol, self.max_iter)
        return Segments(self.n, self.mesh == "equal", self.integrator, engine)


@dataclass(frozen=True, eq=False)
class Segments:
    """The program over n segments, which are equally long or not, and its engine."""

    n: int
    equal: bool
    integrator: str
    engine: NlpCall

    @property
    def shares(self) -> FloatArray | None:
        """As `transcription.Template.shares`."""
        return np.full(self.n, 1 / self.n) if self.equal else None

    def solve(self, guess: Elements, rates: Rates, target: FloatArray, until: float) -> Transcribed:
        """As `transcription.Template.solve`; the poses of the guess follow its controls."""
        n = self.n
        signs = tuple(sign for sign, rate in ((1, rates.upper), (-1, rates.lower)) if rate != 0)
        turns = [np.maximum(sign * guess.turn, 0.0) for sign in signs]
        straight = np.maximum(guess.length - np.abs(guess.turn), 0.0)
        whole = [np.array([guess.total])] if self.equal else []
        poses = guess.path.at(np.cumsum(guess.length)[:-1]).ravel()
        begin = np.concatenate((*turns, straight, *whole, poses))
        lower, upper = np.full(begin.size, -np.inf), np.full(begin.size, np.inf)
        lower[: begin.size - poses.size] = 0.0
        upper[: n * len(signs)] = MOST_TURN_EACH if self.equal else MOST_TURN / n
        program = Program(
            expressions(n, signs, self.equal, self.integrator),
            target,
            lower,
            upper,
            magnitude=1.0 + float(np.abs(target).sum()),
        )
        result = self.engine(program, np.clip(begin, lower, upper), until - perf_counter())
        lengths = np.maximum(result.x[: n * (len(signs) + 1)], 0.0).reshape(-1, n)
        turn = np.array(signs, dtype=float) @ lengths[:-1]
        if self.equal:
            length = np.full(n, lengths.sum() / n)
            turn = np.clip(turn, rates.lower * length, rates.upper * length)
        else:
            length = lengths.sum(axis=0)
        duals = None if result.duals is None else result.duals[-2:]
        return Transcribed(Elements(turn, length), result._replace(duals=duals))


@lru_cache(maxsize=32)
def expressions(n: int, signs: tuple[int, ...], equal: bool, integrator: str) -> Expressions:
    """The program over n segments, with the target (2,) as its parameters.

    Its variables are, for each of the signs 1 (left) and -1 (right), the segments' lengths of
    turning (n,); their lengths of going straight (n,); the whole length (1,) if they are equally
    long; the pose (x, y, heading) at the start of each segment but the first. The last two
    equations are those of the end point.
    """
    import casadi as ca

    turning = [ca.SX.sym(f"turning{sign}", n) for sign in signs]
    straight, whole = ca.SX.sym("straight", n), ca.SX.sym("whole", 1 if equal else 0)
    target, pose = ca.SX.sym("target", 2), ca.SX.sym("pose", 3, n - 1)
    turn: Any = sum(sign * part for sign, part in zip(signs, turning, strict=True))
    length: Any = straight + sum(turning)
    gaps = [length - whole / n] if equal else []
    x, y, heading = ca.SX(0), ca.SX(0), ca.SX(0)
    for k in range(n):
        along, across = chord(heading, turn[k], length[k], integrator)
        x, y, heading = x + along, y + across, heading + turn[k]
        if k < n - 1:
            gaps.append(pose[:, k] - ca.vertcat(x, y, heading))
            x, y, heading = ca.vertsplit(pose[:, k])
    gaps.append(target - ca.vertcat(x, y))
    variables = ca.vertcat(*turning, straight, whole, ca.vec(pose))
    objective = whole if equal else ca.sum1(length)
    return Expressions(variables, target, objective, ca.vertcat(*gaps))

"""`turn-rates`: the optimal-control problem over turn rates alone, as one nonlinear program."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.nlp_engines import table
from dubins_study.solvers.optimal_control.shooting_program import Shooting
from dubins_study.solvers.optimal_control.transcription import Transcription
from dubins_study.study.path import FloatArray

MESHES = ("equal", "graded")
_TURNING = 2 * math.pi  # radii; a turn towards a target far away is shorter than a full circle


@dataclass(frozen=True)
class TurnRates(Transcription):
    """Problem (2.2) with n turn rates and the whole length; other settings: `Transcription`.

    minimise    T
    subject to  (x, y)(u_1 .. u_n, T) = (X, Y),   -1 <= u_k <= 1,  T >= 0

    Single shooting: the path is driven from the start to its end (`shooting_program`), so that
    the end point's two equations are the only ones. `turn-rate-qp` solves the same problem as a
    sequence of QPs.

    Args:
        mesh: `equal` steps, or `graded` ones (`graded_shares`).
    """

    n: int = 50
    mesh: str = "equal"

    name: ClassVar[str] = "turn-rates"
    formulation: ClassVar[str] = "turn rates"
    meshes: ClassVar[tuple[str, ...]] = MESHES
    packages: ClassVar[tuple[str, ...]] = ("casadi",)
    summary: ClassVar[str] = "optimal control over n turn rates and the length, one program"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-7},
        "accurate": {"n": 200, "mesh": "graded"},
    }

    def template(self, distance: float) -> Shooting:
        engine = table.engine(self.engine, self.tol, self.max_iter)
        shares = graded_shares(self.n, self.mesh, distance)
        return Shooting(self.n, shares, False, "exact", engine)


def graded_shares(n: int, mesh: str, distance: float) -> FloatArray:
    """The steps' shares (n,) of the length, summing to 1, for a target so many radii away.

    On the mesh `graded`, half of the steps share about a full circle's length at the start, where
    the path turns, if equal steps were longer.
    """
    turning, straight = (n + 1) // 2, n // 2
    share = _TURNING / (_TURNING + distance)
    if mesh == "equal" or share >= turning / n:
        return np.full(n, 1.0 / n)
    return np.repeat((share / turning, (1 - share) / straight), (turning, straight))

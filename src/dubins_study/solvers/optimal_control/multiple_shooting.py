"""`multiple-shooting`: the optimal-control problem with the poses between arcs as variables."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.nlp_engines import table
from dubins_study.solvers.optimal_control.shooting_program import INTEGRATORS, Shooting
from dubins_study.solvers.optimal_control.transcription import Transcription
from dubins_study.solvers.setting_checks import one_of


@dataclass(frozen=True)
class MultipleShooting(Transcription):
    """Problem (2.2) by multiple shooting (Bock and Plitt 1984); other settings: `Transcription`.

    minimise    sum_k h_k
    subject to  s_{k+1} = F(s_k, u_k, h_k),  s_0 = 0,  (x, y)(s_n) = (X, Y)
                -1 <= u_k <= 1,  h_k >= 0

    The pose s_k at the start of segment k is a variable, and F drives an arc of the turn rate u_k
    and the length h_k (`shooting_program`).

    Args:
        integrator: of F: `exact`, or `rk4`: one classical Runge-Kutta step a segment.
    """

    integrator: str = "exact"

    name: ClassVar[str] = "multiple-shooting"
    formulation: ClassVar[str] = "multiple shooting"
    packages: ClassVar[tuple[str, ...]] = ("casadi",)
    summary: ClassVar[str] = "optimal control by multiple shooting, arcs of free length"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-7},
        "accurate": {"tol": 1e-11},
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of(integrator=(self.integrator, INTEGRATORS))

    def template(self, distance: float) -> Shooting:
        engine = table.engine(self.engine, self.tol, self.max_iter)
        shares = None if self.mesh == "free" else np.full(self.n, 1 / self.n)
        return Shooting(self.n, shares, True, self.integrator, engine)

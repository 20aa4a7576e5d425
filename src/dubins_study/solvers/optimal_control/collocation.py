"""`collocation`: the optimal-control problem in `pyomo.dae`, solved as one program."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from dubins_study.solvers.engines import ipopt_executable, ipopt_in_casadi
from dubins_study.solvers.ipopt_library.engine import VIAS, by_executable, unavailable
from dubins_study.solvers.optimal_control.collocation_model import Template, template
from dubins_study.solvers.optimal_control.transcription import Transcription
from dubins_study.solvers.setting_checks import missing_package, one_of, whole


@dataclass(frozen=True)
class Collocation(Transcription):
    """Problem (2.2) collocated at Legendre-Gauss-Radau points; other settings: `Transcription`.

    Args:
        points: collocation points in each element.
        engine: Ipopt reads Pyomo's file as it is; the others read `collocation_program`.
        via: how Ipopt is reached: `executable`, `library` or `auto`: the executable if PATH has
            one.
    """

    points: int = 5
    via: str = "auto"

    name: ClassVar[str] = "collocation"
    formulation: ClassVar[str] = "Radau collocation"
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "casadi")
    summary: ClassVar[str] = "optimal control collocated in pyomo.dae, free elements"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-7},
        "accurate": {"n": 6, "points": 6, "tol": 1e-11},
    }

    def __post_init__(self) -> None:
        super().__post_init__()
        # more than ten Radau points are lost in rounding
        whole(points=(self.points, 1, 10))
        one_of(via=(self.via, VIAS))

    def unavailable(self) -> str | None:
        if self.engine == "ipopt":
            return unavailable(self.via)
        return missing_package("pyomo", "casadi") or super().unavailable()

    @property
    def keeps_limit(self) -> bool:
        # Pyomo lets the executable run; compiling takes 0.4 s at 500 points and 5 s at 5000
        quick = not by_executable(self.via) and self.n * self.points <= 250
        return self.engine == "ipopt" and quick

    def library_versions(self) -> dict[str, str]:
        if self.engine != "ipopt":
            return super().library_versions()
        return ipopt_executable() if by_executable(self.via) else ipopt_in_casadi()

    def template(self, distance: float) -> Template:
        equal, executable = self.mesh == "equal", by_executable(self.via)
        numbers = self.tol, self.max_iter
        return template(self.n, self.points, equal, self.engine, *numbers, executable)

"""`collocation`: the optimal-control problem in `pyomo.dae`, solved as one program by Ipopt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from dubins_study.solvers import library_versions
from dubins_study.solvers.ipopt_library.engine import VIAS, by_executable, unavailable
from dubins_study.solvers.optimal_control.collocation_model import Template, template
from dubins_study.solvers.optimal_control.transcription import Transcription
from dubins_study.solvers.setting_checks import one_of, whole


@dataclass(frozen=True)
class Collocation(Transcription):
    """Problem (2.2) collocated at Legendre-Gauss-Radau points; other settings: `Transcription`.

    Args:
        points: collocation points in each element.
        via: how Ipopt is reached: `executable`, `library` or `auto`: the executable if PATH has
            one.
    """

    points: int = 5
    via: str = "auto"

    name: ClassVar[str] = "collocation"
    formulation: ClassVar[str] = "Radau collocation"
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "casadi")
    summary: ClassVar[str] = "optimal control collocated in pyomo.dae, free elements, by Ipopt"
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
        return unavailable(self.via)

    @property
    def keeps_limit(self) -> bool:
        # Pyomo lets the executable run; compiling takes 0.4 s at 500 points and 5 s at 5000
        return not by_executable(self.via) and self.n * self.points <= 250

    def library_versions(self) -> dict[str, str]:
        return library_versions.ipopt(by_executable(self.via))

    def template(self, distance: float) -> Template:
        options = (("tol", self.tol), ("max_iter", self.max_iter), ("bound_relax_factor", 0.0))
        equal, executable = self.mesh == "equal", by_executable(self.via)
        return template(self.n, self.points, equal, options, executable)

"""The paper's model written in Pyomo and solved by Ipopt.

Pyomo writes the NL file once: the target is two variables that each scenario fixes through their
bounds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from time import perf_counter
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.engines import ipopt_executable, ipopt_in_casadi
from dubins_study.solvers.nlp_engines.program import EngineResult, needs_watch
from dubins_study.solvers.nlp_engines.pyomo_ipopt import (
    VIAS,
    Deadline,
    Options,
    PyomoProgram,
    by_executable,
    compiled,
    unavailable,
)
from dubins_study.solvers.paper_nlp.local_nlp import Adapter, Case, LocalNlp
from dubins_study.solvers.paper_nlp.model import UNITS
from dubins_study.solvers.paper_nlp.program import pyomo_model
from dubins_study.solvers.protocol import Method
from dubins_study.solvers.setting_checks import one_of, positive, within
from dubins_study.study.path import FloatArray


@dataclass(frozen=True)
class Ipopt(LocalNlp):
    """Model (4.12) by Ipopt; settings that are not explained here: `LocalNlp`.

    Args:
        tol: Ipopt's own tolerance.
        max_iter: largest number of iterations.
        bound_relax: Ipopt's bound_relax_factor. Its default, 1e-8, returns arcs of -1e-8, which no
            vehicle drives: cut to zero they miss a target 1 000 radii away by 1e-5 radii.
        mu_target: Ipopt's own: the barrier parameter to stop at.
        units: of the model: the turning `radius`, or as in the paper the `scenario`'s own unit.
        via: how Ipopt is reached: `executable`, `library` or `auto`: the executable if PATH has
            one.
    """

    tol: float = within(1e-8, 1e-14, 1e-2)
    max_iter: int = positive(200)
    bound_relax: float = within(0.0, 0, 1e-2)
    mu_target: float = within(0.0, 0, 1)
    units: str = one_of("radius", UNITS)
    via: str = one_of("auto", VIAS)

    name: ClassVar[str] = "ipopt"
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "casadi")
    summary: ClassVar[str] = "the paper's model (4.12) in Pyomo by Ipopt"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    @property
    def method(self) -> Method:
        return Method(self.formulation, "Ipopt", self.initial_guess, self.tol)

    def unavailable(self) -> str | None:
        return unavailable(self.via)

    def library_versions(self) -> dict[str, str]:
        return ipopt_executable() if by_executable(self.via) else ipopt_in_casadi()

    @property
    def keeps_limit(self) -> bool:
        return not by_executable(self.via)  # Pyomo lets it run

    def adapter(self) -> Adapter:
        options = (
            ("tol", self.tol),
            ("max_iter", self.max_iter),
            ("bound_relax_factor", self.bound_relax),
            ("mu_target", self.mu_target),
        )
        watched = needs_watch(self.max_iter, 3)
        return _compiled(options, self.units, by_executable(self.via), watched)


@lru_cache(maxsize=64)
def _compiled(options: Options, units: str, executable: bool, watched: bool) -> Adapter:
    """Ipopt on the paper's model; a `watched` library looks at the time in every iteration."""
    model = pyomo_model(units)
    data = [model.X, model.Y] if units == "radius" else [model.X, model.Y, model.R]
    program = PyomoProgram(model, [*model.z.values(), *data], [model.x_end, model.y_end])
    deadline = Deadline() if watched else None
    ask, lower = compiled(program, options, executable, deadline), np.zeros(3)

    def run(case: Case, guess: FloatArray, seconds: float) -> EngineResult:
        unit = case.unit
        if deadline is not None:
            deadline.at = perf_counter() + seconds
        data = [*(unit * x for x in case.target), *([] if units == "radius" else [unit])]
        result = ask(*(np.concatenate((unit * z, data)) for z in (guess, lower, case.upper)))
        return result._replace(x=result.x[:3] / unit)

    return run

"""The paper's model written in Pyomo and solved by Ipopt.

Pyomo writes the NL file once: the target is two variables that each scenario fixes through their
bounds.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from dubins_study.solvers.engines import ENGINES, EngineSolver
from dubins_study.solvers.nlp_engines.casadi_nlpsol import nlpsol
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.nlp_engines.pyomo_program import PyomoProgram, asked
from dubins_study.solvers.paper_nlp.local_nlp import Adapter, Case, LocalNlp
from dubins_study.solvers.paper_nlp.model import UNITS
from dubins_study.solvers.paper_nlp.program import pyomo_model
from dubins_study.solvers.protocol import Method
from dubins_study.solvers.setting_checks import (
    iterations,
    one_of,
    option_set,
    tolerance,
    within,
)
from dubins_study.study.arrays import FloatArray


@dataclass(frozen=True)
class Ipopt(LocalNlp, EngineSolver):
    """Model (4.12) by Ipopt; settings that are not explained here: `LocalNlp`.

    Args:
        options: whose choice Ipopt's options are, `equal`, `default` or `tuned` (docs/engines.md).
        tol: Ipopt's tolerances; 0 for those of `options`.
        max_iter: largest number of iterations; 0 for that of `options`.
        mu_target: Ipopt's own: the barrier parameter to stop at.
        units: of the model: the turning `radius`, or as in the paper the `scenario`'s own unit.
    """

    options: str = option_set()
    tol: float = tolerance()
    max_iter: int = iterations()
    mu_target: float = within(0.0, 0, 1)
    units: str = one_of("radius", UNITS)

    name: ClassVar[str] = "ipopt"
    packages: ClassVar[tuple[str, ...]] = ("pyomo", "casadi")
    summary: ClassVar[str] = "the paper's model (4.12) in Pyomo by Ipopt"
    engine = "ipopt"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"tol": 1e-6},
        "accurate": {"tol": 1e-11},
    }

    @property
    def method(self) -> Method:
        posed = self.formulation, self.initial_guess
        return ENGINES["ipopt"].method(*posed, self.options, self.tol)

    def adapter(self) -> Adapter:
        chosen = ENGINES["ipopt"].options.of(self.options, self.tol, self.max_iter)
        if self.mu_target:
            chosen["ipopt.mu_target"] = self.mu_target
        return _compiled(tuple(chosen.items()), self.units)


@lru_cache(maxsize=64)
def _compiled(options: tuple[tuple[str, Any], ...], units: str) -> Adapter:
    """Ipopt on the paper's model."""
    model = pyomo_model(units)
    data = [model.X, model.Y] if units == "radius" else [model.X, model.Y, model.R]
    program = PyomoProgram(model, list(model.z.values()), data, [model.x_end, model.y_end])
    ask, lower = asked(program, nlpsol(dict(options), "ipopt"), native=True), np.zeros(3)

    def run(case: Case, guess: FloatArray, seconds: float) -> EngineResult:
        unit, scaled = case.unit, () if units == "radius" else (case.unit,)
        data = np.array((unit * case.target[0], unit * case.target[1], *scaled))
        result = ask(unit * guess, data, lower, unit * case.upper, seconds)
        return result._replace(x=result.x / unit)

    return run

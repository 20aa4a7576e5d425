"""The paper's model by sequential least squares quadratic programming (SciPy's SLSQP)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.paper_nlp.local_nlp import Adapter, LocalNlp
from dubins_study.solvers.paper_nlp.model import UNITS
from dubins_study.solvers.paper_nlp.program import solve
from dubins_study.solvers.protocol import Method
from dubins_study.solvers.setting_checks import iterations, one_of, option_set, tolerance


@dataclass(frozen=True)
class Slsqp(LocalNlp):
    """Model (4.12) by SLSQP; settings that are not explained here: `LocalNlp`.

    Args:
        options: whose choice SLSQP's options are, `equal`, `default` or `tuned` (docs/engines.md).
        ftol: SLSQP's tolerance on the objective and the sum of constraint violations, in radii; 0
            for that of `options`.
        maxiter: largest number of iterations; 0 for that of `options`.
        units: of the model: the turning `radius`, or as in the paper the `scenario`'s own unit;
            `ftol` is then in that unit too.
    """

    options: str = option_set()
    ftol: float = tolerance()
    maxiter: int = iterations()
    units: str = one_of("radius", UNITS)

    name: ClassVar[str] = "slsqp"
    packages: ClassVar[tuple[str, ...]] = ("scipy",)
    summary: ClassVar[str] = "the paper's model (4.12) by SciPy's SLSQP"
    keeps_limit = True
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"ftol": 1e-8},
        "accurate": {"ftol": 1e-14},
    }

    @property
    def method(self) -> Method:
        posed = self.formulation, self.initial_guess
        return ENGINES["slsqp"].method(*posed, self.options, self.ftol)

    def adapter(self) -> Adapter:
        call = ENGINES["slsqp"].load()(self.ftol, self.maxiter, self.options)
        return partial(solve, engine=call)

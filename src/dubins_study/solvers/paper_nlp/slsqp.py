"""The paper's model by sequential least squares quadratic programming (SciPy's SLSQP)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from dubins_study.solvers.nlp_engines import scipy_minimize
from dubins_study.solvers.paper_nlp.local_nlp import Adapter, LocalNlp
from dubins_study.solvers.paper_nlp.model import UNITS
from dubins_study.solvers.paper_nlp.program import solve
from dubins_study.solvers.protocol import Method
from dubins_study.solvers.setting_checks import one_of, positive, within


@dataclass(frozen=True)
class Slsqp(LocalNlp):
    """Model (4.12) by SLSQP; settings that are not explained here: `LocalNlp`.

    Args:
        ftol: SLSQP's tolerance on the objective and the sum of constraint violations, in radii. It
            is multiplied by the target's distance where that exceeds one radius, up to a thousand,
            since rounding grows with it.
        maxiter: largest number of iterations.
        units: of the model: the turning `radius`, or as in the paper the `scenario`'s own unit;
            `ftol` is then in that unit too.
    """

    ftol: float = within(1e-10, 1e-16, 1e-2)
    maxiter: int = positive(40)
    units: str = one_of("radius", UNITS)

    name: ClassVar[str] = "slsqp"
    packages: ClassVar[tuple[str, ...]] = ("scipy",)
    summary: ClassVar[str] = "the paper's model (4.12) by SciPy's SLSQP"
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"ftol": 1e-8},
        "accurate": {"ftol": 1e-14},
    }

    @property
    def method(self) -> Method:
        return Method(self.formulation, "SLSQP", self.initial_guess, self.ftol)

    @property
    def keeps_limit(self) -> bool:
        return True

    def adapter(self) -> Adapter:
        return partial(solve, engine=scipy_minimize.slsqp(self.ftol, self.maxiter))

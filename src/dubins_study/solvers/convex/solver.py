"""`convex`: one frozen QP or SOCP of a route.

It is put to one engine through one interface.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from dubins_study.solvers.convex.adapters import ENGINES, Ask, prepare
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution, Solver
from dubins_study.solvers.setting_checks import missing_package, one_of, within
from dubins_study.study.convex.problem import posed
from dubins_study.study.words import FREE_FINAL_HEADING, FROZEN, VIA_POINTS

INTERFACES = ("own", "cvxpy")
OPTIONS = ("equal", "tuned")


@dataclass(frozen=True)
class Convex(Solver):
    """The frozen convex problem of a route.

    The route's label names the problem, such as `qp-50-random-6-0`. The problem was frozen from
    this route. The check judges the engine's primal and dual point, not a path
    (`study.convex.proof`).

    Args:
        engine: piqp, clarabel, osqp, scs, highs, proxqp, qpalm, ecos or daqp.
        interface: `own`, the library's own, or `cvxpy`.
        tolerance: absolute tolerance that the engine is asked for; the relative one is zero.
        options: `equal`, or `tuned`, as the makers of osqp and proxqp advise (docs/convex.md).
    """

    engine: str = one_of("piqp", tuple(ENGINES))
    interface: str = one_of("own", INTERFACES)
    tolerance: float = within(1e-6, 0, 1, ends=False)
    options: str = one_of("equal", OPTIONS)

    name = "convex"
    guarantee = Guarantee.GLOBAL
    branches = (FROZEN,)
    takes = frozenset({FREE_FINAL_HEADING, VIA_POINTS})
    packages = ("cvxpy", *(each.package for each in ENGINES.values()))
    summary = "a frozen QP or SOCP of a route, by an engine's own interface or cvxpy"

    @property
    def method(self) -> Method:
        return Method("frozen convex problem", ENGINES[self.engine].label, "none", self.tolerance)

    def unavailable(self) -> str | None:
        if self.options == "tuned" and not ENGINES[self.engine].tuned:
            tuned = ", ".join(name for name, engine in ENGINES.items() if engine.tuned)
            return f"{self.engine} has no tuned options; expected one of: {tuned}"
        package = ENGINES[self.engine].package
        if self.interface == "cvxpy":
            return missing_package(package, "cvxpy")
        return missing_package(package)

    def build(self, question: Question) -> Any:
        _load(self.engine, self.interface)
        return prepare(self.engine, self.interface, posed(question.scenario.label))

    def solve(self, model: Any, limit: float) -> Solution:
        reply = model(Ask(self.tolerance, limit, tuned=self.options == "tuned"))
        point = None
        if reply.point is not None:
            point = np.concatenate(reply.point)
        return Solution(
            reply.claim,
            point=point,
            iterations=reply.iterations,
            native_status=reply.status,
            message=reply.status,
        )


@cache
def _load(engine: str, interface: str) -> None:
    """Import the libraries and solve a trivial problem.

    No question then pays for the imports.
    """
    prepare(engine, interface, posed("trivial"))(Ask(1e-3, 10.0))

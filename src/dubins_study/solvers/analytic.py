"""`analytic`: the closed form, exact for every branch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from dubins_study.solvers.protocol import (
    FrameSolution,
    Guarantee,
    Method,
    Question,
    Solution,
    Solver,
)
from dubins_study.study.closed_form.shortest import as_path, shortest
from dubins_study.study.scenario import NUMBERS
from dubins_study.study.words import BRANCHES, Claim

if TYPE_CHECKING:
    import pandas as pd

_NONE = "no {} path exists"


@dataclass(frozen=True)
class Analytic(Solver):
    """The closed form: `study.closed_form.shortest`; for frames `study.closed_form.kernel`."""

    name: ClassVar[str] = "analytic"
    guarantee: ClassVar[Guarantee] = Guarantee.EXACT
    branches: ClassVar[tuple[str, ...]] = BRANCHES
    summary: ClassVar[str] = "the closed form: exact, every branch, no iteration"

    @property
    def method(self) -> Method:
        return Method("closed form", "closed form")

    @property
    def keeps_limit(self) -> bool:
        return True

    def solve(self, model: Question, limit: float) -> Solution:
        scenario = model.scenario
        optimum = shortest(scenario, model.branch)
        if optimum is None:
            return Solution(Claim.INFEASIBLE, message=_NONE.format(model.branch))
        path = as_path(scenario, optimum.word, optimum.segments)
        length = path.total_length
        return Solution(Claim.OPTIMAL, path, claimed_length=length, lower_bound=length)

    def solve_frame(self, frame: pd.DataFrame, branch: str) -> FrameSolution:
        import numpy as np  # these only here: a single question needs none of them

        from dubins_study.study.closed_form.kernel import NO_PATH, Rows, curvatures, shortest_rows
        from dubins_study.study.path import CLAIMS, Paths

        n = len(frame)
        curvature, length = np.empty((2, n)), np.empty((2, n))
        rows = Rows(np.empty(n), length[0], length[1], np.empty(n, np.uint8))
        x, y, heading, tx, ty, radius = (
            np.ascontiguousarray(frame[name], np.float64) for name in NUMBERS if name != "speed"
        )
        shortest_rows(x, y, heading, tx, ty, radius, branch=branch, out=rows)
        curvatures(rows.word, radius, curvature)
        paths = Paths(curvature, length)
        absent = rows.word == NO_PATH
        if not absent.any():
            return FrameSolution(Claim.OPTIMAL, paths, rows.length, rows.length.copy())
        claim = np.where(absent, CLAIMS.index(Claim.INFEASIBLE), CLAIMS.index(Claim.OPTIMAL))
        message = np.where(absent, _NONE.format(branch), "").tolist()
        length[:, absent] = 0.0
        paths = Paths(curvature, length, ~absent)
        return FrameSolution(claim, paths, rows.length, rows.length.copy(), message=message)

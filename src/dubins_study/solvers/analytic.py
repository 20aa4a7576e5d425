"""`analytic`: the closed form, exact for every branch.

It solves one leg by formula, and routes by a search with a proof.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from dubins_study.solvers.protocol import (
    FrameSolution,
    Guarantee,
    Method,
    Question,
    Solution,
    Solver,
)
from dubins_study.study.kinds.table import PATH_BRANCHES, kind_of
from dubins_study.study.tolerances import PROFILES
from dubins_study.study.words import NEEDS, Claim

if TYPE_CHECKING:
    import pandas as pd

_NONE = "no {} path exists"
_OPEN = "the search ended before it had proved the path to be shortest"
# a search whose relative gap is smaller has proved its path to be shortest
_CLOSED = min(tolerances.gap for tolerances in PROFILES.values())


@dataclass(frozen=True)
class Analytic(Solver):
    """The closed form; for routes a proven search.

    Each kind of question has its own method in `study.kinds`. For frames of legs these are
    `study.closed_form.kernel` and, with final headings, `pose_kernel`.
    """

    name = "analytic"
    guarantee = Guarantee.EXACT
    branches = PATH_BRANCHES
    takes = frozenset(NEEDS)
    summary = "the closed form: exact, every branch, no iteration; routes: search"
    keeps_limit = True

    @property
    def method(self) -> Method:
        return Method("closed form", "closed form")

    def build(self, question: Question) -> Question:
        kind_of(question.scenario, question.branch).prepare()  # no part of the search
        return question

    def solve(self, model: Question, limit: float) -> Solution:
        """Solve by the method of the question's kind.

        The claim is optimal if the proven gap is within every profile's tolerance.
        """
        scenario = model.scenario
        path, low, high = kind_of(scenario, model.branch).exact(scenario, model.branch, limit)
        if path is None:
            return Solution(Claim.INFEASIBLE, message=_NONE.format(model.branch))
        claim = Claim.FEASIBLE
        message = _OPEN
        if high - low <= _CLOSED * max(low, scenario.radius):
            claim = Claim.OPTIMAL
            message = ""
        return Solution(
            claim,
            path,
            claimed_length=path.length,
            lower_bound=low,
            message=message,
        )

    def solve_frame(self, frame: pd.DataFrame, branch: str) -> FrameSolution:
        import numpy as np  # these only here: a single question needs none of them

        from dubins_study.study.closed_form.kernel import NO_PATH, RATES, shortest_rows
        from dubins_study.study.closed_form.pose_kernel import SIDES, PoseArrays, pose_rows
        from dubins_study.study.path import CLAIMS, Paths
        from dubins_study.study.scenario_frame import with_final_headings

        columns = [frame[name] for name in PoseArrays._fields]
        if with_final_headings(frame):
            rates = SIDES
            rows = pose_rows(*columns, branch=branch)
        else:
            rates = RATES
            rows = shortest_rows(*columns[:-1], branch=branch)
        length = rows.segments
        absent = rows.word == NO_PATH
        # a word has no rate where it has no letter
        # one row a letter, one column a word; NaN where a word has no such letter
        letter_rates = np.nan_to_num(rates.T[: len(length)], nan=0.0)
        # a row without a path reads word 0 here; its lengths become 0 below
        curvature = np.take(letter_rates, np.where(absent, 0, rows.word), axis=1)
        curvature /= frame["radius"].to_numpy(np.float64)
        paths = Paths(curvature, length)
        if not absent.any():
            return FrameSolution(
                Claim.OPTIMAL, paths, claimed_length=rows.length, lower_bound=rows.length.copy()
            )
        claim = np.where(absent, CLAIMS.index(Claim.INFEASIBLE), CLAIMS.index(Claim.OPTIMAL))
        length[:, absent] = 0.0
        paths = Paths(curvature, length, ~absent)
        return FrameSolution(
            claim,
            paths,
            claimed_length=rows.length,
            lower_bound=rows.length.copy(),
            message=np.where(absent, _NONE.format(branch), "").tolist(),
        )

"""Costs of right answers, means and ranks, and the best method of each formulation."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.statistics.compared import Compared, once
from dubins_study.report.statistics.costs import (
    SHIFT_FACTORS,
    chosen_shift,
    cost_table,
    penalised,
    ranking,
    ranks_of,
    shared_questions,
    shifted_geometric_mean,
    solved_by_all,
)
from dubins_study.report.statistics.intervals import (
    averages,
    bootstrap,
    geometric_means,
    scenario_shares,
)

# A method that was put to fewer of the questions would shrink what all have in common.
ENOUGH_ASKED = 0.9
# A method that is right on fewer of the questions would empty what all answer.
_ENOUGH_RIGHT = 0.9


@once
def times(compared: Compared) -> pd.DataFrame:
    """The cost table of whole attempts (s); see `_costs`."""
    return _costs(compared, "wall_s")


@once
def evaluations(compared: Compared) -> pd.DataFrame:
    """The cost table of function evaluations; see `_costs`."""
    return _costs(compared, "evaluations")


def _costs(compared: Compared, cost: str) -> pd.DataFrame:
    """The cost table of the engines at questions with a path, the closed form left out.

    Methods that met fewer than nine tenths of the questions, or of which no right answer says its
    cost, are left out. Columns in the order of tables.
    """
    rows = compared.answerable
    rows = rows[rows["solver"] != EXACT]
    if rows.empty:
        return pd.DataFrame(index=pd.Index([], name="question"))
    table = cost_table(rows, cost=cost, right="right", question=["question"])
    met = table.notna().mean()
    kept = [s for s in compared.engines.index if s in table and met[s] >= ENOUGH_ASKED]
    return table[kept]


@once
def mean_ranks(compared: Compared) -> tuple[pd.DataFrame, float, int]:
    """Shares right, means of `times` with failures counted three ways, and ranks.

    Returns:
        A frame indexed by solver in the order of the ranks: the method's columns; questions,
        right, right_low, right_high (share); mean, mean_low, mean_high (shifted geometric mean
        with failures at the limit, s); par2, par2_low, par2_high (s); common (shifted geometric
        mean over what all methods answer that are right on nine tenths, s); rank (missing if it
        changes with the shift or the penalty), best, worst, rank_tenth and rank_tenfold (at that
        multiple of the shift). Then the shift (s), and the number of questions behind `common`.
    """
    shared = shared_questions(times(compared))
    shift = chosen_shift(shared)
    at_limit = penalised(shared, compared.limit_s)
    rows = compared.answerable
    rows = rows[rows["question"].isin(shared.index)]
    shares = scenario_shares(rows, by=["solver"], success="right", scenario=["question"])
    right = shares[["trials", "share", "low", "high"]]
    right = right.set_axis(["questions", "right", "right_low", "right_high"], axis=1)
    means = bootstrap(compared.by_scenario(at_limit), geometric_means(shift))
    twice = penalised(shared, compared.limit_s, 2.0)
    par2 = bootstrap(compared.by_scenario(twice), averages)
    usual = right.index[right["right"] >= _ENOUGH_RIGHT].intersection(shared.columns)
    common = solved_by_all(shared[usual])
    frame = compared.methods.join(right, how="inner").reindex(shared.columns)
    frame = frame.join(_named(means, "mean")).join(_named(par2, "par2"))
    frame["common"] = common.apply(lambda column: shifted_geometric_mean(column, shift))
    frame = frame.join(ranking(shared, compared.limit_s, shift)[["rank", "best", "worst"]])
    for name, factor in zip(("rank_tenth", "", "rank_tenfold"), SHIFT_FACTORS, strict=True):
        if name:
            shifted = at_limit.apply(lambda t, s=factor * shift: shifted_geometric_mean(t, s))
            frame[name] = ranks_of(shifted)
    return frame.sort_values("mean", kind="stable"), shift, len(common)


def _named(intervals: pd.DataFrame, name: str) -> pd.DataFrame:
    names = {"estimate": name, "low": f"{name}_low", "high": f"{name}_high"}
    return intervals.rename(columns=names)


def best_of_formulations(ranked: pd.DataFrame) -> pd.DataFrame:
    """The first method of each formulation of `mean_ranks`, in the order of the ranks."""
    return ranked.drop_duplicates("formulation")

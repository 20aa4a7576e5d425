"""The solvers that a figure with few curves shows: the best of each formulation."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT, TRIAL
from dubins_study.report.statistics.intervals import scenario_shares
from dubins_study.report.statistics.methods import best_methods, methods_of
from dubins_study.report.statistics.metrics import success

MOST_CURVES = 10  # more lines in one panel cannot be told apart


def best_solvers(rows: pd.DataFrame, most: int = MOST_CURVES) -> list[str]:
    """The closed form, then of each formulation the solver that is most surely right.

    Several that are as sure: the fastest. Of more formulations than `most` the surest are kept;
    the order is that of tables.

    Args:
        rows: attempts at questions that have a path.
        most: number of solvers, at most.
    """
    judged = rows.assign(right=success(rows))
    shares = scenario_shares(judged, by=["solver"], success="right", scenario=TRIAL)
    frame = methods_of(rows)[["formulation"]].join(shares["low"].rename("right_low"))
    frame = frame.join(rows.groupby("solver", observed=True)["wall_s"].median())
    best = best_methods(frame.reset_index(names="solver"), ["formulation"])
    surest = best.assign(other=best["solver"] != EXACT).sort_values(
        ["other", "right_low", "wall_s"], ascending=[True, False, True], kind="stable"
    )
    kept = set(surest["solver"].head(most))
    return [str(solver) for solver in best["solver"] if solver in kept]

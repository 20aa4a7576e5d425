"""Times of solvers on the questions that they have in common."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.statistics.costs import (
    SHIFT_FACTORS,
    chosen_shift,
    cost_table,
    performance_ratios,
    ranks_of,
    shifted_geometric_mean,
    solved_by_all,
)
from dubins_study.report.statistics.intervals import bootstrap, geometric_means
from dubins_study.report.statistics.metrics import QUESTION, solver_order, success


def mean_times(rows: pd.DataFrame, shift: float | None = None) -> tuple[pd.DataFrame, float]:
    """Shifted geometric means over the questions that every solver answered correctly.

    The default shift is `means.chosen_shift` of all times used.

    Returns:
        Columns solver, questions, mean_s, its 95 % bootstrap interval over scenarios (mean_low_s,
        mean_high_s), rank, and the rank at a tenth and at ten times the shift (rank_tenth,
        rank_tenfold); and the shift (s).
    """
    table = solved_by_all(right_times(rows))
    if table.empty:
        return pd.DataFrame(), 0.0
    chosen = chosen_shift(table) if shift is None else shift
    means = table.apply(lambda times: shifted_geometric_mean(times, chosen))
    frame = pd.DataFrame({"questions": len(table), "mean_s": means})
    by_scenario = table.set_axis(table.index.get_level_values("scenario_id"))
    ends = bootstrap(by_scenario, geometric_means(chosen))
    frame["mean_low_s"], frame["mean_high_s"] = ends["low"], ends["high"]
    for name, factor in zip(("rank_tenth", "rank", "rank_tenfold"), SHIFT_FACTORS, strict=True):
        shifted = table.apply(lambda t, s=chosen * factor: shifted_geometric_mean(t, s))
        frame[name] = ranks_of(shifted)
    return frame.rename_axis("solver").reset_index(), chosen


def right_times(rows: pd.DataFrame) -> pd.DataFrame:
    """Cost table of median total times (s): questions by solvers in the order of the report."""
    right = rows.assign(right=success(rows))
    table = cost_table(right, cost="wall_s", right="right", question=QUESTION)
    return table[solver_order(list(table.columns))]


def time_ratios(rows: pd.DataFrame) -> pd.DataFrame:
    """Time divided by that of the fastest right answer; rows are questions, columns solvers.

    Only questions put to every solver. The ratio is infinite if this solver's answer is wrong, or
    if all answers are wrong.
    """
    return performance_ratios(right_times(rows))

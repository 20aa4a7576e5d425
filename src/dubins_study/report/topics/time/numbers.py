"""Times of solvers on the questions that they have in common."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.statistics.metrics import QUESTION, solver_order, success
from dubins_study.report.statistics.timing import shifted_geometric_mean


def mean_times(rows: pd.DataFrame, shift: float | None = None) -> tuple[pd.DataFrame, float]:
    """Shifted geometric means over the questions that every solver answered correctly.

    The default shift is the lower quartile of all times used. It is small compared with most times,
    so it does not dominate a mean, and large compared with timer noise.

    Returns:
        Columns solver, questions, mean_s, rank, and the rank at a tenth and at ten times the
        shift (rank_tenth, rank_tenfold); and the shift (s).
    """
    table = common_times(rows)
    if table.empty:
        return pd.DataFrame(), 0.0
    chosen = float(np.quantile(table.to_numpy(), 0.25)) if shift is None else shift
    means = table.apply(lambda times: shifted_geometric_mean(times, chosen))
    frame = pd.DataFrame({"questions": len(table), "mean_s": means})
    for name, factor in (("rank", 1.0), ("rank_tenth", 0.1), ("rank_tenfold", 10.0)):
        shifted = table.apply(lambda t, s=chosen * factor: shifted_geometric_mean(t, s))
        frame[name] = shifted.rank().astype(int)
    return frame.rename_axis("solver").reset_index(), chosen


def _right_times(rows: pd.DataFrame, otherwise: float) -> pd.DataFrame:
    """Median total time (s); one row per question, one column per solver.

    A wrong answer has the value `otherwise`, a question that a solver was not asked NaN.
    """
    right = rows.assign(right=success(rows))
    timed = right.groupby([*QUESTION, "solver"]).agg(wall=("wall_s", "median"), ok=("right", "all"))
    wide = pd.DataFrame(timed["wall"].where(timed["ok"], otherwise).unstack("solver"))
    return wide[solver_order(list(wide.columns))]


def common_times(rows: pd.DataFrame) -> pd.DataFrame:
    """Median total time (s); one row per question that all solvers answered correctly."""
    return _right_times(rows, np.nan).dropna()


def time_ratios(rows: pd.DataFrame) -> pd.DataFrame:
    """Time divided by that of the fastest right answer; rows are questions, columns solvers.

    Only questions put to every solver. The ratio is infinite if this solver's answer is wrong, or
    if all answers are wrong.
    """
    everyone = _right_times(rows, np.inf).dropna()
    return everyone.div(everyone.min(axis=1), axis=0).fillna(np.inf)

"""Cold against warm starts, from rows."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.statistics.metrics import QUESTION, solver_order, success


def warm_starts(rows: pd.DataFrame) -> pd.DataFrame:
    """Cold against warm, one row a solver that was asked both on the same questions.

    Columns: solver, questions, cold_s, warm_s (median, s), ratio (of warm / cold time, question by
    question: the median; quartiles in ratio_q1 and ratio_q3), work, work_q1, work_q3 (the same of
    the solver's own iterations, NaN if it counts none), cold_success, warm_success (shares of all
    attempts).
    """
    key = [name for name in QUESTION if name != "initial_guess"]
    right = rows.assign(right=success(rows).astype(float))
    wide = right.groupby(["solver", *key, "initial_guess"]).agg(
        s=("wall_s", "median"), ok=("right", "mean"), work=("iterations", "median")
    )
    table = pd.DataFrame(wide.unstack("initial_guess"))
    if not {"cold", "warm"} <= set(rows["initial_guess"]):
        return pd.DataFrame()
    both = table.dropna(subset=[("ok", "cold"), ("ok", "warm")])
    records = []
    for solver in solver_order(both.index.get_level_values("solver").tolist()):
        group = both.loc[solver]
        cold, warm = group["s", "cold"], group["s", "warm"]
        records.append(
            {
                "solver": solver,
                "questions": len(group),
                "cold_s": cold.median(),
                "warm_s": warm.median(),
                **_ratio("ratio", warm, cold),
                **_ratio("work", group["work", "warm"], group["work", "cold"]),
                "cold_success": group["ok", "cold"].mean(),
                "warm_success": group["ok", "warm"].mean(),
            }
        )
    return pd.DataFrame.from_records(records)


def _ratio(name: str, warm: pd.Series, cold: pd.Series) -> dict[str, float]:
    """Median and quartiles of warm / cold, where cold is something."""
    low, middle, high = (warm / cold.where(cold > 0)).astype(float).quantile([0.25, 0.5, 0.75])
    return {f"{name}_q1": low, name: middle, f"{name}_q3": high}

"""Cold against warm starts, from rows."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.statistics.metrics import QUESTION, by_solver, success


def warm_starts(rows: pd.DataFrame) -> pd.DataFrame:
    """Cold against warm starts: one row per solver that has both for the same questions.

    Columns: solver, questions, cold_s, warm_s (medians, s), ratio (median over questions of
    warm / cold time; quartiles in ratio_q1 and ratio_q3), work, work_q1, work_q3 (the same for the
    solver's iterations, NaN if they are not counted), cold_success, warm_success (shares of all
    attempts).
    """
    key = [name for name in QUESTION if name != "initial_guess"]
    right = rows.assign(right=success(rows).astype(float))
    wide = right.groupby(["solver", *key, "initial_guess"]).agg(
        s=("wall_s", "median"), ok=("right", "mean"), work=("iterations", "median")
    )
    if not {"cold", "warm"} <= set(rows["initial_guess"]):
        return pd.DataFrame()
    table = pd.DataFrame(wide.unstack("initial_guess"))
    both = table.dropna(subset=[("ok", "cold"), ("ok", "warm")])
    frame = pd.DataFrame({"questions": both.groupby(level="solver").size()})
    seconds, shares = (both[name].groupby(level="solver") for name in ("s", "ok"))
    frame = frame.join(seconds.median().add_suffix("_s"))
    frame = frame.join(shares.mean().add_suffix("_success"))
    for name, column in (("ratio", "s"), ("work", "work")):
        cold = both[column, "cold"]
        ratio = (both[column, "warm"] / cold.where(cold > 0)).astype(float).groupby(level="solver")
        for end, q in (("_q1", 0.25), ("", 0.5), ("_q3", 0.75)):
            frame[f"{name}{end}"] = ratio.quantile(q)
    return by_solver(frame.reset_index())

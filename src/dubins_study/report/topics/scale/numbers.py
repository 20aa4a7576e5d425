"""The same scenario at many radii, with the same lengths in radii.

The problem has no scale: (x, y, R) -> k (x, y, R) multiplies every length by k. A solver that keeps
this gives the same path in radii, and its iterations do not change.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.statistics import metrics

# Spreads of length / R up to this are rounding: of the scenario's numbers, of the sum of up to a
# hundred pieces, and of the division. Gaps up to this count as zero.
ROUNDING = 1e-13


def spreads(rows: pd.DataFrame) -> pd.DataFrame:
    """One row per solver and scenario (label), over its radii.

    Columns: solver, label, radii, success (share), spread (of length / R over the radii at which
    the answer arrives, relative to its median; NaN if it never does), words (distinct ones,
    `/` between), iterations_low, iterations_high (NaN if not counted), invariant (all radii alike:
    every answer arrives, same verdict and word, spread within `ROUNDING`).
    """
    arrived = (rows["length"] / rows["radius"]).where(rows["gap"].notna())
    measured = rows.assign(success=metrics.success(rows), relative=arrived)
    groups = measured.groupby(["label", "solver"])
    relative, iterations = groups["relative"], groups["iterations"]
    frame = pd.DataFrame({"radii": groups["radius"].nunique(), "success": groups["success"].mean()})
    frame["spread"] = (relative.max() - relative.min()) / relative.median()
    frame["words"] = groups["word"].agg(lambda words: "/".join(sorted(words.dropna().unique())))
    frame["iterations_low"], frame["iterations_high"] = iterations.min(), iterations.max()
    alike = (groups["verdict"].nunique() == 1) & (groups["word"].nunique() <= 1)
    arrive = relative.count() == groups.size()
    frame["invariant"] = alike & arrive & ~(frame["spread"] > ROUNDING)
    return frame.reset_index()


def by_solver(table: pd.DataFrame) -> pd.DataFrame:
    """One row per solver, from `spreads`.

    Columns: solver, scenarios, invariant (in how many of them the answer is the same at every
    radius), success (mean share), spread (the largest), words (whether the same word at every
    radius of each scenario), iterations (largest ratio of most to least over one scenario's radii;
    NaN if not counted or zero).
    """
    low = table["iterations_low"]
    ratio = table["iterations_high"] / low.where(low > 0)
    measured = table.assign(words=~table["words"].str.contains("/"), iterations=ratio)
    groups = measured.groupby("solver")
    frame = pd.DataFrame({"scenarios": groups.size(), "invariant": groups["invariant"].sum()})
    frame = frame.assign(success=groups["success"].mean(), spread=groups["spread"].max())
    frame = frame.assign(words=groups["words"].all(), iterations=groups["iterations"].max())
    return metrics.by_solver(frame.reset_index())

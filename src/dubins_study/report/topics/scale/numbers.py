"""The same scenario at many radii, lengths in radii kept.

The problem has no scale: (x, y, R) -> k (x, y, R) multiplies every length by k. A solver that keeps
this gives the same path in radii, and its iterations do not change.
"""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from dubins_study.report.statistics import metrics

# spreads of length / R up to this are rounding: of the scenario's own numbers, of the sum of up to
# a hundred pieces, and of the division; and gaps up to it are none
ROUNDING = 1e-13


def spreads(rows: pd.DataFrame) -> pd.DataFrame:
    """One row a solver and scenario (label), over its radii.

    Columns: solver, label, radii, success (share), spread (of length / R over the radii at which
    the answer arrives, relative to its median; NaN if it never does), words (distinct ones,
    `/` between), iterations_low, iterations_high (NaN if not counted), invariant (all radii alike:
    every answer arrives, same verdict and word, spread within `ROUNDING`).
    """
    records = []
    for (label, solver), group in rows.groupby(["label", "solver"], sort=True):
        arrived = group[group["gap"].notna()]
        relative = (arrived["length"] / arrived["radius"]).to_numpy(dtype=np.float64)
        spread = float(np.ptp(relative) / np.median(relative)) if relative.size else math.nan
        words = sorted(set(group["word"].dropna()))
        alike = len(arrived) == len(group) and group["verdict"].nunique() == 1 and len(words) <= 1
        records.append(
            {
                "solver": solver,
                "label": label,
                "radii": int(group["radius"].nunique()),
                "success": float(metrics.success(group).mean()),
                "spread": spread,
                "words": "/".join(words),
                "iterations_low": float(group["iterations"].min()),
                "iterations_high": float(group["iterations"].max()),
                "invariant": bool(alike and not spread > ROUNDING),
            }
        )
    return pd.DataFrame.from_records(records)


def by_solver(table: pd.DataFrame) -> pd.DataFrame:
    """One row a solver, from `spreads`.

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

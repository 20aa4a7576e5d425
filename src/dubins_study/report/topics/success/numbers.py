"""Gaps, solver by solver."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.statistics.metrics import by_solver

REGIONS = ("all", "outside", "left disc", "right disc", "circle")


def gap_quantiles(frame: pd.DataFrame) -> pd.DataFrame:
    """Gap quantiles per solver and region.

    Args:
        frame: from `report.data.attempts.Attempts.gap_quantiles`.

    Returns:
        The columns of `frame`, with arrived as a share of the attempts. A region that holds all of
        a solver's attempts is left out.
    """
    order = {region: place for place, region in enumerate(REGIONS)}
    known = frame[frame["region"].isin(REGIONS)].sort_values("region", key=lambda r: r.map(order))
    every = known.groupby("solver")["attempts"].transform("max")
    news = (known["region"] == "all") | (known["attempts"] < every)
    return by_solver(known[news].assign(arrived=known["arrived"] / known["attempts"]))


def gap_shares(profile: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """For each solver the share of attempts within each finite gap.

    Args:
        profile: from `report.data.attempts.Attempts.gap_profile`.

    Returns:
        Solver -> columns gap (ascending) and share.
    """
    shares = {}
    for solver, rows in profile.groupby("solver"):
        reached = rows["attempts"].cumsum() / rows["attempts"].sum()
        finite = np.isfinite(rows["gap"])
        shares[str(solver)] = pd.DataFrame({"gap": rows["gap"], "share": reached})[finite]
    return shares

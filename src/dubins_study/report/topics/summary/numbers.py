"""How often each solver is right."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import SUCCESSES
from dubins_study.report.statistics.metrics import by_solver


def summary(verdicts: pd.DataFrame) -> pd.DataFrame:
    """One row per solver: attempts, counts of each verdict, false claims, wrong basins, times.

    Args:
        verdicts: from `report.data.attempts.Attempts.verdicts`.

    Returns:
        The columns of `verdicts`, and success (share of all attempts).
    """
    right = verdicts[list(SUCCESSES)].sum(axis="columns")
    return by_solver(verdicts.assign(success=right / verdicts["attempts"]))

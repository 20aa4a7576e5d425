"""What became of each solver, in a word or two."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.two_runs.comparison import Comparison
from dubins_study.report.two_runs.regressions import ALPHA

NO_CHANGE, SAME_CODE = "no change", "same code"


def with_verdicts(comparison: Comparison) -> pd.DataFrame:
    """`comparison.solvers` with a column verdict: what is worse, else what is better."""
    worse = comparison.regressions.groupby("solver")["kind"].agg(
        lambda kinds: list(dict.fromkeys(kinds))
    )
    frame = comparison.solvers
    verdicts = [
        "worse: " + ", ".join(worse[row["solver"]])
        if row["solver"] in worse.index
        else _better(row, comparison.slower)
        for _, row in frame.iterrows()
    ]
    return frame.assign(verdict=verdicts)


def _better(row: pd.Series, slower: float) -> str:
    """A solver is faster, and right more often, by the mirror images of what makes it worse."""
    better = {
        f"{row['gained']} more right": row["gained"] > 0,
        "right more often": row["right_change_low"] > 0 and row["right_p"] < ALPHA,
        "faster": row["time_ratio_high"] < 1 / slower and row["time_p"] < ALPHA,
    }
    texts = [text for text, applies in better.items() if applies]
    if texts:
        return "better: " + ", ".join(texts)
    return SAME_CODE if row["same_code"] else NO_CHANGE

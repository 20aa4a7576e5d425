"""Shares of questions: a question that is answered right in two of three repeats counts 2/3."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from dubins_study.report.statistics.intervals import wilson_intervals


def question_shares(
    rows: pd.DataFrame, column: str, keys: Sequence[str], level: float = 0.95
) -> pd.DataFrame:
    """The share of questions at which a column is true, by groups.

    Repeats of a question are not independent, so that the question is the unit: the share is the
    mean over questions of the share of their repeats, the interval Wilson's for as many trials as
    there are questions (see `intervals.wilson_intervals` on fractional successes).

    Args:
        rows: one row per attempt; column `question`.
        column: name of a column of truth values.
        keys: names of the columns that tell groups apart.
        level: confidence level, in (0, 1).
    Returns:
        Indexed by group; columns questions, share, low, high.
    """
    names = list(keys)
    values = rows[column].astype(np.float64)
    each = values.groupby([*(rows[key] for key in names), rows["question"]], observed=True).mean()
    groups = each.groupby(level=list(range(len(names))), observed=True)
    sums, sizes = groups.sum(), groups.size()
    # Sums of thirds may exceed their number by rounding.
    ends = wilson_intervals(np.minimum(sums, sizes), sizes, level)
    frame = pd.DataFrame({"questions": sizes, "share": sums / sizes})
    return frame.assign(low=ends[..., 0], high=ends[..., 1])

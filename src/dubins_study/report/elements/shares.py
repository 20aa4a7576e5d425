"""Shares with their intervals: as numbers in a frame, and as text in a table."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.elements.formats import ABSENT, count, digits
from dubins_study.report.statistics.intervals import wilson_intervals

INTERVAL_TEXT = (
    "Below each share its 95 % interval (Wilson). A trial is a scenario with a branch: all "
    "attempts of a solver at it, in repeats and from cold and warm starts, are parts of one trial, "
    "and two right answers of three count 2/3."
)


def with_share(
    frame: pd.DataFrame, name: str, successes: pd.Series, trials: pd.Series
) -> pd.DataFrame:
    """The frame with a share of trials and its interval.

    Returns:
        With the columns `name`_of (the trials), `name`_share (NaN of no trials), `name`_low and
        `name`_high (95 %), and `name`_text, in which all of them are written out.
    """
    n = trials.astype(np.float64).to_numpy()
    k = np.minimum(successes.astype(np.float64).to_numpy(), n)
    ends = wilson_intervals(k, n)
    shares = np.where(n > 0, k / np.where(n > 0, n, 1.0), np.nan)
    numbers = {"of": n, "share": shares, "low": ends[:, 0], "high": ends[:, 1]}
    columns = {f"{name}_{key}": values for key, values in numbers.items()}
    texts = [
        share_text(*each) for each in zip(shares, ends[:, 0], ends[:, 1], n.tolist(), strict=True)
    ]
    return frame.assign(**columns, **{f"{name}_text": texts})


def share_text(share: float, low: float, high: float, of: float) -> str:
    """`98.4 % of 64` and below it `91.7 to 99.7 %`; a dash if there is nothing to divide by."""
    if not of > 0:
        return ABSENT
    return f"{percent(share)} % of {questions(of)},\n{percent(low)} to {percent(high)} %"


def percent(share: float) -> str:
    """A share in percent with one decimal, rounded to 100 only for 1 and to 0 only for 0."""
    value = 100 * share
    if value in (0, 100):
        return f"{value:.0f}"
    return f"{min(max(value, 0.1), 99.9):.1f}"


def questions(number: float) -> str:
    """A number of questions, of which repeats are parts."""
    return count(number) if float(number).is_integer() else digits(3)(number)

"""Columns and texts that tables share.

Columns name a method. Texts are numbers and shares with their intervals.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.elements.columns import Column, columns
from dubins_study.report.elements.formats import ABSENT, Format, count, digits, share
from dubins_study.report.statistics.intervals import wilson_intervals

METHOD = columns(
    kind="text",
    formulation="formulation",
    engine="engine",
    guess="initial guess",
    settings="settings",
)


def method_columns(frame: pd.DataFrame) -> tuple[Column, ...]:
    """The columns that name a method.

    The column of settings is left out if no method of the table has settings.
    """
    if frame["settings"].astype(bool).any():
        return METHOD
    return METHOD[:-1]


def interval_column(key: str, title: str) -> Column:
    """A column that shows a number above its interval.

    Its cells are the texts `key`_text, which `with_interval_texts` adds to the frame.
    """
    return Column(f"{key}_text", title, kind="cell")


def interval_keys(*keys: str) -> tuple[str, ...]:
    """Names of columns: each number and its interval's ends.

    `interval_keys("gap") -> ("gap", "gap_low", "gap_high")`. The CSV file gets these columns.
    """
    names: list[str] = []
    for key in keys:
        names += [key, f"{key}_low", f"{key}_high"]
    return tuple(names)


def with_interval_texts(frame: pd.DataFrame, **shows: Format) -> pd.DataFrame:
    """The frame with texts of numbers and their intervals.

    `shows` maps a key to the format of its numbers. Each key adds a column `key`_text, made from
    `key`, `key`_low and `key`_high. The interval is on a second line.
    """
    texts = {}
    for key, show in shows.items():
        lines = []
        for numbers in frame[[*interval_keys(key)]].itertuples(index=False):
            text = with_interval(show, *numbers).replace(" (", "\n(", 1)  # interval on line 2
            lines.append(text.replace(" ", "\u00a0"))  # no other line breaks
        texts[f"{key}_text"] = lines
    return frame.assign(**texts)


def with_interval(show: Format, value: float, low: float, high: float) -> str:
    """A number and its interval as text.

    `2.5 (2.1 to 3.4)`, or for a share `25.0 % (21.0 to 34.2)`. An unknown number gives a dash, and
    an unknown interval leaves the number alone.
    """
    if value != value:
        return ABSENT
    if low != low:
        return show(value)
    ends = show
    if show is share:
        ends = percent
    return f"{show(value)} ({ends(low)} to {ends(high)})"


INTERVAL_TEXT = (
    "Below each share: its 95 % interval (Wilson). A trial is a scenario with a branch. All "
    "attempts of a solver at it, repeats and cold and warm starts, are parts of one trial: two "
    "right answers of three count 2/3."
)


def with_share(
    frame: pd.DataFrame, name: str, successes: pd.Series, trials: pd.Series
) -> pd.DataFrame:
    """The frame with a share and its interval.

    The new columns are `name`_of (the trials), `name`_share (NaN without trials), `name`_low and
    `name`_high (95 %), and `name`_text, which shows all of them.
    """
    n = trials.astype(np.float64).to_numpy()
    k = np.minimum(successes.astype(np.float64).to_numpy(), n)
    low, high = wilson_intervals(k, n).T
    shares = np.divide(k, n, out=np.full_like(n, np.nan), where=n > 0)
    texts = [*map(share_text, shares, low, high, n.tolist())]
    added: dict[str, Any] = {"of": n, "share": shares, "low": low, "high": high, "text": texts}
    return frame.assign(**{f"{name}_{key}": values for key, values in added.items()})


def share_text(share: float, low: float, high: float, of: float) -> str:
    """A share with its trials and its interval.

    `98.4 % of 64`, and on the next line `91.7 to 99.7 %`; a dash if there are no trials.
    """
    if not of > 0:
        return ABSENT
    return f"{percent(share)} % of {questions(of)},\n{percent(low)} to {percent(high)} %"


def percent(share: float, places: int = 1) -> str:
    """A share as a percentage without the sign.

    It has `places` decimals. Only 1 itself is written as 100, and only 0 as 0.
    """
    if share in (0, 1):
        return f"{100 * share:.0f}"
    least = 10.0**-places
    return f"{min(max(100 * share, least), 100 - least):.{places}f}"


def questions(number: float) -> str:
    """A number of questions, perhaps a fraction.

    A repeat is a part of a question, so a number that is not whole is shown with three digits.
    """
    if float(number).is_integer():
        return count(number)
    return digits(3)(number)

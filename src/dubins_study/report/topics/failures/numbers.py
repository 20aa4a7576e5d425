"""What failed, what was said, and where: numbers made of the counts of `report.data.failures`."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from dubins_study.report.data.command import solve_command
from dubins_study.report.data.failures import KINDS, OUTCOMES, PLACES, REACH

_SAID = ["solver", "outcome", "claim", "verdict", "message"]
# (region, near or None for both) -> its line in the table.
_REGIONS = {
    ("outside", False): f"outside, beyond {REACH:g} R of the start",
    ("outside", True): f"outside, within {REACH:g} R of the start",
    ("circle", None): "on a turning circle",
    ("left disc", None): "in the left disc",
    ("right disc", None): "in the right disc",
}
_UNKNOWN = "not known: no answer was judged"


def gist(message: str) -> str:
    """A message without numbers and repetitions, so that similar messages count as one."""
    parts = [re.sub(r"\d[\d.]*(?:[eE][+-]?\d+)?", "#", part) for part in message.split("; ")]
    return "; ".join(dict.fromkeys(parts))[:160]


def unreturned(outcomes: pd.DataFrame) -> pd.DataFrame:
    """The solvers of which an attempt did not return, the most often stopped first.

    Args:
        outcomes: from `report.data.failures.outcomes`.
    Returns:
        The columns of `outcomes`, and `unreturned`: the number of attempts.
    """
    counted = outcomes.assign(unreturned=outcomes[list(OUTCOMES)].sum(axis="columns"))
    stopped = counted[counted["unreturned"] > 0]
    return stopped.sort_values(["unreturned", "solver"], ascending=[False, True], ignore_index=True)


def failures(frame: pd.DataFrame) -> pd.DataFrame:
    """Failures counted by outcome, claim, verdict and the gist of the message, largest first.

    Args:
        frame: from `report.data.failures.failures`.
    Returns:
        The columns of `frame`; of several messages with one gist, the plainest example.
    """
    ascending = [False] + [True] * len(_SAID)
    counted = frame.assign(message=frame["message"].map(gist))
    example = [name for name in frame.columns if name not in {*_SAID, "attempts"}]
    plainest = counted.sort_values(example, kind="stable").drop_duplicates(_SAID)
    sums = counted.groupby(_SAID, dropna=False)["attempts"].sum().reset_index()
    joined = sums.merge(plainest.drop(columns="attempts"), on=_SAID, how="left")
    return joined.sort_values(["attempts", *_SAID], ascending=ascending)


def with_commands(table: pd.DataFrame, limits: Mapping[str, float | None]) -> pd.DataFrame:
    """The table of `failures` with `command`: what repeats the example, under its run's limit.

    Args:
        table: from `failures`.
        limits: experiment -> time limit (s), None if it is not known.
    """
    lines = [
        row | {"time_limit_s": limits.get(row["experiment"])} for row in table.to_dict("records")
    ]
    return table.assign(command=[solve_command(line) for line in lines])


def by_region(frame: pd.DataFrame) -> pd.DataFrame:
    """The share of failures of each kind where the target lies, in a fixed order.

    Args:
        frame: from `report.data.failures.regions`.
    Returns:
        place, attempts, failed (a number), failed_share, and for each of `KINDS` its share.
    """
    lines = []
    region, near = frame["region"], frame["near"].fillna(False).astype(bool)
    for (name, close), title in _REGIONS.items():
        lines.append((title, frame[(region == name) & ((near == close) | (close is None))]))
    lines.append((_UNKNOWN, frame[~region.isin([name for name, _ in _REGIONS])]))
    sums = {title: rows[["attempts", *KINDS]].sum() for title, rows in lines if len(rows)}
    table = pd.DataFrame.from_dict(sums, orient="index", columns=["attempts", *KINDS])
    table["failed"] = table[list(KINDS)].sum(axis="columns")
    shares = table[list(KINDS)].div(table["attempts"], axis=0)
    table = table.assign(failed_share=table["failed"] / table["attempts"], **shares)
    return table.reset_index(names="place")


class FailureMap(NamedTuple):
    """Shares of failed attempts in square cells around the start; seen from the vehicle, in radii.

    Args:
        shares: kind -> share of the cell's attempts, NaN in an empty cell; shape (cells, cells),
            rows along Y. Kinds of which the map has none are left out.
        attempts: number of attempts within the map.
    """

    shares: Mapping[str, NDArray[np.float64]]
    attempts: int


def failure_map(frame: pd.DataFrame) -> FailureMap:
    """The map of the counts of `report.data.failures.places`."""
    place = frame["left"].to_numpy(), frame["ahead"].to_numpy()
    attempts = np.zeros((PLACES, PLACES))
    np.add.at(attempts, place, frame["attempts"].to_numpy())
    shares = {}
    for kind in KINDS:
        counts = np.zeros((PLACES, PLACES))
        np.add.at(counts, place, frame[kind].to_numpy())
        if counts.any():
            shares[kind] = np.divide(
                counts, attempts, where=attempts > 0, out=np.full(counts.shape, np.nan)
            )
    return FailureMap(shares, int(attempts.sum()))

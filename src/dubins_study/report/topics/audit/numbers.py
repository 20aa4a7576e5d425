"""The committed audit of the paper as frames and counts."""

from __future__ import annotations

from typing import Any

import pandas as pd

Record = dict[str, Any]


def wrong_verdicts(summary: Record) -> dict[str, int]:
    """Verdict -> number of cells, for all verdicts except the first, which is `correct`."""
    return {verdict: n for verdict, n in list(summary["verdicts"].items())[1:] if n}


def distinct_times(times: list[Record]) -> list[str]:
    """The distinct solve times (s) that the paper prints."""
    return sorted({time["printed"] for time in times})


def printed_paths(paths: list[Record]) -> pd.DataFrame:
    """The printed paths, and whether their misses and sums can be explained by rounding.

    Columns: those of the audit's paths, `beyond` (the miss is larger than correct rounding allows)
    and `wrong_sum` (the parts do not add up to the printed total).
    """
    frame = pd.DataFrame(paths)
    return frame.assign(
        beyond=frame["miss"] > frame["rounding_allows"], wrong_sum=~frame["adds_up"].astype(bool)
    )


def excused_sums(paths: list[Record]) -> int:
    """Number of rows that do not add up and whose correctly rounded parts would not either."""
    return sum(not path["adds_up"] and not path["correct_parts_add_up"] for path in paths)


def circle_crossings(algorithm: list[Record]) -> pd.DataFrame:
    """The radii at which a turning circle reaches a target; `where` names the circle and half."""
    frame = pd.DataFrame(algorithm)
    return frame.assign(where=frame["circle"] + ", " + frame["half"])

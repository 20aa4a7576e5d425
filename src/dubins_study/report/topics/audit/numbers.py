"""The committed audit of the paper as frames and counts."""

from __future__ import annotations

from typing import Any

import pandas as pd

Record = dict[str, Any]


def wrong_verdicts(summary: Record) -> dict[str, int]:
    """Verdict -> number of cells, for all verdicts but the first one, which is `correct`."""
    return {verdict: n for verdict, n in list(summary["verdicts"].items())[1:] if n}


def distinct_times(times: list[Record]) -> list[str]:
    """The solve times (s) that the paper prints, each once."""
    return sorted({time["printed"] for time in times})


def printed_paths(paths: list[Record]) -> pd.DataFrame:
    """The printed paths, and whether each misses and adds up as rounding allows.

    Columns: those of the audit's paths, `beyond` (the miss is larger than correct roundings can
    make it) and `wrong_sum` (the parts do not add up to the printed total).
    """
    frame = pd.DataFrame(paths)
    return frame.assign(
        beyond=frame["miss"] > frame["rounding_allows"], wrong_sum=~frame["adds_up"].astype(bool)
    )


def excused_sums(paths: list[Record]) -> int:
    """How many rows do not add up, though correctly rounded parts would not either."""
    return sum(not path["adds_up"] and not path["correct_parts_add_up"] for path in paths)


def circle_crossings(algorithm: list[Record]) -> pd.DataFrame:
    """Where a turning circle reaches a target, with the column `where`: which circle and half."""
    frame = pd.DataFrame(algorithm)
    return frame.assign(where=frame["circle"] + ", " + frame["half"])

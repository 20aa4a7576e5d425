"""Columns of tables: which ones, under which titles, and how their values are shown."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pandas as pd

from dubins_study.report.elements.formats import ABSENT, Format


@dataclass(frozen=True)
class Column:
    """How one column of a frame is shown.

    Args:
        key: its name in the frame; the CSV file keeps it.
        title: its heading, with the unit.
        show: value to text; missing values never reach it: they are shown as a dash.
        kind: `number` (aligned right), `text`, `prose` (long text), or `code` (a name that a
            program knows).
    """

    key: str
    title: str
    show: Format = str
    kind: str = "number"

    def text(self, value: Any) -> str:
        """The value as it is shown."""
        missing = value is None or value is pd.NA or (isinstance(value, float) and value != value)
        return ABSENT if missing else self.show(value)


def columns(show: Format = str, /, kind: str = "number", **titles: str) -> tuple[Column, ...]:
    """Columns that are shown alike: a title for each key, in order."""
    return tuple(Column(key, title, show, kind) for key, title in titles.items())


SOLVER = Column("solver", "solver", kind="code")


def marks(frame: pd.DataFrame, *keys: str) -> dict[tuple[int, str], str]:
    """Mark the cells of these columns that are true or above zero as `bad`."""
    return {(row, key): "bad" for key in keys for row, bad in enumerate(frame[key]) if bad}

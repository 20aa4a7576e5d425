"""Columns of tables: their keys, titles and formats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pandas as pd

from dubins_study.report.elements.formats import ABSENT, Format
from dubins_study.study.scenario_frame import is_missing


@dataclass(frozen=True)
class Column:
    """How one column of a frame is shown.

    Its kind is `number` (aligned right), `text`, `prose` (long text), `code` (such as a spec),
    `command` (a long line for a shell, which the page shows when asked), `section` (the title of a
    section, perhaps with a colon and a part of it; the page links it), `cell` (a number with its
    interval, over several lines), `pick` (a name and numbers below it; `pick spec`: a spec),
    or `solver` (a spec, of which the page shows the short name).
    """

    key: str  # name of the column in the frame and in the CSV file
    title: str  # its heading, with the unit
    show: Format = str  # converts a value to text; a missing value is shown as a dash instead
    kind: str = "number"

    def text(self, value: Any) -> str:
        """The value as it is shown."""
        if is_missing(value):
            return ABSENT
        return self.show(value)


def columns(show: Format = str, /, kind: str = "number", **titles: str) -> tuple[Column, ...]:
    """Columns with the same format: key=title, in order.

    `columns(share, right="right, base")` is one column: key `right`, heading "right, base".
    """
    return tuple(Column(key, title, show, kind) for key, title in titles.items())


SOLVER = Column("solver", "solver", kind="solver")


def marks(frame: pd.DataFrame, *keys: str) -> dict[tuple[int, str], str]:
    """Mark the cells of columns `keys` that are true.

    A positive number counts as true. The result maps (row position, key) to `bad`, as `Table.marks`
    needs it.
    """
    marked: dict[tuple[int, str], str] = {}
    for key in keys:
        marked |= {(row, key): "bad" for row, bad in enumerate(frame[key]) if bad}
    return marked

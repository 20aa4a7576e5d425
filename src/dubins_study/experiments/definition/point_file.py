"""Points of a route from a CSV file."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import NamedTuple

from dubins_study.experiments.definition.table_file import (
    TableFileError,
    note_passed_over,
    read_table,
)
from dubins_study.study.values import number_of_text

_COLUMNS = ("x", "y", "name")
_NO_HEADINGS = (
    "headings at points are not taken yet; expected none, and that of the last point as "
    "--final-heading"
)


class NamedPoint(NamedTuple):
    """A point and its name, which may be empty."""

    x: float
    y: float
    name: str


def read_points(file: FilePath) -> list[NamedPoint]:
    """The points of a file, one of each line.

    The columns `x`, `y` and, if there is one, `name` are read; all others are passed over and
    named in a warning. Refused: what is no number, and a heading, in any column of such a name.
    """
    table = read_table(file)
    names = [name.lower() for name in table.names]
    if names.count("x") != 1 or names.count("y") != 1:
        expected = "expected the column names x and y, once each, with commas between names"
        raise TableFileError(f"{file}: line 1 is {','.join(names)!r:.60}; {expected}")
    if table.problems:
        raise TableFileError(f"{file}: {table.problems[0]}")
    points = []
    for place, values in table.rows:
        row = {name.lower(): text.strip() for name, text in values.items()}
        headings = [text for name, text in row.items() if "heading" in name and text]
        if headings:
            raise TableFileError(f"{file}: {place}: heading is {headings[0]!r:.60}: {_NO_HEADINGS}")
        try:
            x = number_of_text(row["x"])
            y = number_of_text(row["y"])
        except ValueError:
            written = f"{row['x']},{row['y']}"
            message = f"{place}: x,y is {written!r:.60}; expected two numbers"
            raise TableFileError(f"{file}: {message}") from None
        points.append(NamedPoint(x, y, row.get("name", "")))
    if not points:
        raise TableFileError(f"{file}: no points; expected a line each")
    others = [name for name in names if name not in _COLUMNS and "heading" not in name]
    note_passed_over(file, others)
    return points

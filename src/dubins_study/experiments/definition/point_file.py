"""Points of a route from a CSV file."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import NamedTuple

from dubins_study.experiments.definition.table_file import (
    TableFileError,
    note_passed_over,
    read_table,
)
from dubins_study.study.angle import AngleError, parse_angle
from dubins_study.study.scenario import FREE
from dubins_study.study.values import number_of_text

_COLUMNS = ("x", "y", "name", "heading")


class NamedPoint(NamedTuple):
    """A point, its name, which may be empty, and the heading there (rad); None is free."""

    x: float
    y: float
    name: str = ""
    heading: float | None = None


def read_points(file: FilePath) -> list[NamedPoint]:
    """The points of a file, one of each line.

    The columns `x`, `y` and, if there are any, `name` and `heading` are read; all others are passed
    over and named in a warning. A heading is an angle, or free: an empty cell, or `free`. Refused:
    what is no number or angle, and a column whose name has more about a heading, such as its unit.
    """
    table = read_table(file)
    names = [name.lower() for name in table.names]
    if names.count("x") != 1 or names.count("y") != 1:
        expected = "expected the column names x and y, once each, with commas between names"
        raise TableFileError(f"{file}: line 1 is {','.join(names)!r:.60}; {expected}")
    if table.problems:
        raise TableFileError(f"{file}: {table.problems[0]}")
    odd = [name for name in names if "heading" in name and name != "heading"]
    if odd or names.count("heading") > 1:
        expected = "expected one column heading, of angles such as 90deg, or radians"
        raise TableFileError(f"{file}: column {(odd or ['heading'])[0]!r:.60}: {expected}")
    points = []
    for place, values in table.rows:
        row = {name.lower(): text.strip() for name, text in values.items()}
        try:
            x = number_of_text(row["x"])
            y = number_of_text(row["y"])
        except ValueError:
            written = f"{row['x']},{row['y']}"
            message = f"{place}: x,y is {written!r:.60}; expected two numbers"
            raise TableFileError(f"{file}: {message}") from None
        text = row.get("heading", "")
        try:
            heading = None if text in ("", FREE) else parse_angle(text)
        except AngleError as error:
            raise TableFileError(f"{file}: {place}: heading: {error}") from None
        points.append(NamedPoint(x, y, row.get("name", ""), heading))
    if not points:
        raise TableFileError(f"{file}: no points; expected a line each")
    others = [name for name in names if name not in _COLUMNS]
    note_passed_over(file, others)
    return points

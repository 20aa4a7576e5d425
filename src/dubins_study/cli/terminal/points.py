"""Points of a route from a CSV file."""

from __future__ import annotations

import csv
import logging
from pathlib import Path as FilePath

import typer

from dubins_study.cli.terminal.arguments import CommandError, Point, number
from dubins_study.cli.terminal.output import plain

_LOG = logging.getLogger(__name__)
_COLUMNS = ("x", "y", "name")
_OPEN = "expected a point on each line: is a quotation mark left open?"
_NO_HEADINGS = (
    "headings at points are not taken yet; expected none, and that of the last point as "
    "--final-heading"
)


def read_points(file: FilePath) -> tuple[list[Point], list[str]]:
    """Points and their names, by the lines of a CSV file: UTF-8, commas, a line of column names.

    The columns `x`, `y` and, if there is one, `name` are read; all others are passed over and
    named in a warning. Empty lines are passed over too. Refused: what is no finite number, a point
    equal to the one before it, and a heading, in any column of such a name.
    """
    points: list[Point] = []
    names: list[str] = []
    line_before = 0  # the line of the last point
    try:
        with file.open(encoding="utf-8-sig", newline="") as text:
            reader = csv.DictReader(text, skipinitialspace=True, restval="", strict=True)
            reader.fieldnames = head = [name.strip().lower() for name in reader.fieldnames or ()]
            if head.count("x") != 1 or head.count("y") != 1 or head.count("name") > 1:
                found = f"{','.join(head)!r:.60}; expected the column names x and y, once each"
                raise CommandError(f"{file}: line 1 is {found}, with commas between names")
            headings = [name for name in head if "heading" in name]
            unread = [name for name in head if name not in (*_COLUMNS, *headings)]
            for row in reader:
                place = f"{file}: line {reader.line_num}"
                if any("\n" in cell for cell in row.values() if isinstance(cell, str)):
                    raise CommandError(f"{place} ends a text that began in an earlier one; {_OPEN}")
                if None in row:  # as of numbers with a decimal comma
                    raise CommandError(f"{place} has more cells than the first line")
                x, y = (_coordinate(place, name, row[name].strip()) for name in ("x", "y"))
                for name in headings:
                    if heading := row[name].strip():
                        raise CommandError(f"{place}: {name} is {heading!r:.60}: {_NO_HEADINGS}")
                if points[-1:] == [(x, y)]:
                    again = f"x,y is {x},{y}, the same point as in line {line_before}"
                    raise CommandError(f"{place}: {again}; expected a point apart from it")
                points.append(Point(x, y))
                names.append(row.get("name", "").strip())
                line_before = reader.line_num
    except UnicodeError:
        raise CommandError(f"{file}: cannot be read: it is not UTF-8 text") from None
    except (OSError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or f"line {reader.line_num}: {error}; {_OPEN}"
        raise CommandError(f"{file}: cannot be read: {reason}") from None
    if not points:
        raise CommandError(f"{file}: no points; expected a line each")
    if others := [name or "one without a name" for name in unread]:
        shown = f"{file}: passed over, since points have no such column: {', '.join(others)}"
        _LOG.warning("dubins-study: %s", plain(shown))
    return points, names


def _coordinate(place: str, name: str, text: str) -> float:
    from dubins_study.study.scenario import checked_number  # numpy, which no help waits for

    try:
        return checked_number(f"{place}: {name}", number(text))
    except typer.BadParameter as error:
        raise CommandError(f"{place}: {name} is {error.message}") from None

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
_NO_HEADINGS = (
    "headings at points are not taken yet; expected none, and that of the last point as "
    "--final-heading"
)


def read_points(file: FilePath) -> tuple[list[Point], list[str]]:
    """Points and their names, by the lines of a CSV file: UTF-8, commas, a line of column names.

    The columns `x`, `y` and, if there is one, `name` are read; all others are passed over and
    named in a warning. Empty lines are passed over too. Refused: what is no number, and a heading,
    in any column of such a name; `Scenario` refuses points that no route has.
    """
    try:
        with file.open(encoding="utf-8-sig", newline="") as text:
            reader = csv.DictReader(text, skipinitialspace=True, restval="")
            head = [name.strip().lower() for name in reader.fieldnames or ()]
            reader.fieldnames = head
            rows = [(reader.line_num, row) for row in reader]
    except UnicodeError:
        raise CommandError(f"{file}: cannot be read: it is not UTF-8 text") from None
    except (OSError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise CommandError(f"{file}: cannot be read: {reason}") from None
    if head.count("x") != 1 or head.count("y") != 1 or head.count("name") > 1:
        found = f"{','.join(head)!r:.60}; expected the column names x and y, once each"
        raise CommandError(f"{file}: line 1 is {found}, with commas between names")
    if not rows:
        raise CommandError(f"{file}: no points; expected a line each")
    points = [_point(f"{file}: line {line}", row) for line, row in rows]
    names = [row.get("name", "").strip() for _, row in rows]
    others = [name for name in head if name not in _COLUMNS and "heading" not in name]
    if others:
        listed = ", ".join(name or "one without a name" for name in others)
        shown = f"{file}: passed over, since points have no such column: {listed}"
        _LOG.warning("dubins-study: %s", plain(shown))
    return points, names


def _point(place: str, row: dict[str, str]) -> Point:
    """The point of a line."""
    for name, value in row.items():
        if name is None:  # as of numbers with a decimal comma
            raise CommandError(f"{place} has more cells than the first line")
        if "heading" in name and value.strip():
            raise CommandError(f"{place}: {name} is {value.strip()!r:.60}: {_NO_HEADINGS}")
    return Point(_coordinate(place, "x", row), _coordinate(place, "y", row))


def _coordinate(place: str, name: str, row: dict[str, str]) -> float:
    try:
        return number(row[name].strip())
    except typer.BadParameter as error:
        raise CommandError(f"{place}: {name} is {error.message}") from None

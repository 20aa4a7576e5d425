"""Points of a route from a CSV file."""

from __future__ import annotations

import csv
from pathlib import Path as FilePath

import typer

from dubins_study.cli.terminal.arguments import CommandError, Point, number


def read_points(file: FilePath) -> list[Point]:
    """The points of a CSV file in the order of its lines: UTF-8, commas, a line of column names.

    The columns `x` and `y` are read; all others are passed over, and so are empty lines.
    """
    try:
        with file.open(encoding="utf-8-sig", newline="") as text:
            reader = csv.reader(text)
            head = [name.strip() for name in next(reader, [])]
            for name in ("x", "y"):
                if head.count(name) != 1:
                    times = head.count(name)
                    named = (
                        f"{times} columns called {name}" if times else f"no column called {name}"
                    )
                    found = f"has {named} ({_shown(head)})"
                    expected = "expected column names such as x,y, with a comma between them"
                    raise CommandError(f"{file}: line 1 {found}; {expected}")
            places = [(name, head.index(name)) for name in ("x", "y")]
            points = []
            for row in reader:
                line = reader.line_num
                if len(row) > len(head):  # as of numbers with a decimal comma
                    cells = f"{len(row)} cells; expected {len(head)}, as in the first line"
                    raise CommandError(f"{file}: line {line} has {cells}")
                if any(cell.strip() for cell in row):
                    x, y = (_coordinate(file, line, name, row[i:]) for name, i in places)
                    points.append(Point(x, y))
    except UnicodeError:
        raise CommandError(f"{file}: cannot be read: it is not UTF-8 text") from None
    except (OSError, csv.Error) as error:
        reason = getattr(error, "strerror", None) or error
        raise CommandError(f"{file}: cannot be read: {reason}") from None
    if not points:
        raise CommandError(f"{file}: no points; expected a line each")
    return points


def _shown(head: list[str]) -> str:
    """The names of columns in a message."""
    from dubins_study.study.values import short  # numpy, which no help waits for

    return f"it is {short(','.join(head))}" if head else "it is empty"


def _coordinate(file: FilePath, line: int, name: str, cells: list[str]) -> float:
    """The number in the first of the cells."""
    text = cells[0].strip() if cells else ""
    try:
        return number(text)
    except typer.BadParameter:
        from dubins_study.study.values import short  # numpy, which no help waits for

        found = f"{name} is {short(text)}" if text else f"{name} is empty"
        raise CommandError(f"{file}: line {line}: {found}; expected a number") from None

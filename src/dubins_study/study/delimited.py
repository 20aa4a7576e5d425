"""Read rows of text, with each row's place.

Commas or other delimiters stand between the cells.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from dubins_study.study.values import did_you_mean, short

_OPEN_QUOTE = "expected each row on a line of its own: is a quotation mark left open?"


csv.field_size_limit(sys.maxsize)  # a path of many arcs is a long cell


class Row(NamedTuple):
    """Cells of a row, and its place."""

    place: str  # such as `line 7`
    cells: list[str]


class Rows(NamedTuple):
    """Rows of a text; the first is the header."""

    rows: list[Row]
    problems: list[str]  # a sentence for each line that is no row


def read_rows(lines: Iterable[str], delimiter: str = ",") -> Rows:
    """Read the rows of some lines.

    Each line holds one row. Empty lines are skipped. A row that spans several lines or has more
    cells than the header is left out, and `problems` has a sentence about it.
    """
    rows: list[Row] = []
    problems: list[str] = []
    line = 0
    reader = csv.reader(lines, strict=True, delimiter=delimiter)
    try:
        for cells in reader:
            place = f"line {line + 1}"
            is_long = reader.line_num > line + 1
            line = reader.line_num
            if is_long:
                problems.append(f"{place}: a text goes on to line {line}; {_OPEN_QUOTE}")
            elif rows and len(cells) > len(rows[0].cells):
                expected = f"expected {len(rows[0].cells)}, as in {rows[0].place}"
                problems.append(f"{place}: {len(cells)} cells; {expected}")
            elif any(cells):
                rows.append(Row(place, cells))
    except csv.Error as error:
        problems.append(f"line {line + 1}: {error}; {_OPEN_QUOTE}")
    return Rows(rows, problems)


def column_problems(
    names: Sequence[Any], required: Sequence[str], optional: Sequence[str]
) -> list[str]:
    """Problems of a table's column names, a sentence each.

    A name that is missing, unknown or repeated is a problem. The list is empty if all are right.
    """
    expected = f"expected the columns {', '.join(required)} and, if wanted, {', '.join(optional)}"
    columns = (*required, *optional)
    problems = []
    if missing := [name for name in required if name not in names]:
        noun = "column"
        if len(missing) > 1:
            noun = "columns"
        problems.append(f"missing {noun} {', '.join(map(repr, missing))}; {expected}")
    for name in dict.fromkeys(names):
        if name not in columns:
            near = did_you_mean(name, [column for column in columns if column not in names])
            problems.append(f"unknown column {short(name)}; {near}{expected}")
        elif names.count(name) > 1:
            problems.append(f"column {name!r} appears twice")
    return problems

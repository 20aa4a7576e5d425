"""The rows of a CSV or Parquet file, each with its place in the file."""

from __future__ import annotations

import csv
import logging
from collections.abc import Iterable
from itertools import zip_longest
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.study.scenario import ScenarioError
from dubins_study.study.values import plain

_LOG = logging.getLogger(__name__)
_OPEN_QUOTE = "expected each row on a line of its own: is a quotation mark left open?"


class TableFileError(ScenarioError):
    """A table of scenarios or points that cannot be used; names file, line, column and rule."""


class TableRow(NamedTuple):
    """A row and its place in the file."""

    place: str  # such as `line 7`
    values: dict[str, Any]  # by the names of the columns; texts in a CSV file


class Table(NamedTuple):
    """The columns and rows of a file."""

    names: list[str]
    rows: list[TableRow]
    problems: list[str]  # a sentence for each line that is no row


def read_table(file: FilePath) -> Table:
    """The rows of a file; Parquet where its name says so, otherwise CSV in UTF-8 with commas."""
    try:
        return _parquet_table(file) if file.suffix == ".parquet" else _csv_table(file)
    except OSError as error:
        reason = error.strerror or str(error)
    except UnicodeError:
        reason = "it is not UTF-8 text"
    except ValueError as error:  # the Parquet reader's own words
        reason = plain(str(error).partition("\n")[0])
    raise TableFileError(f"{file}: cannot be read: {reason}")


def _csv_table(file: FilePath) -> Table:
    """The rows as texts, one a line; empty lines are passed over."""
    rows: list[TableRow] = []
    problems: list[str] = []
    line = 1
    with file.open(encoding="utf-8-sig", newline="") as text:
        reader = csv.reader(text, strict=True)
        try:
            names = [name.strip() for name in next(reader, [])]
            for cells in reader:
                place = f"line {line + 1}"
                is_long = reader.line_num > line + 1
                line = reader.line_num
                if is_long:
                    problems.append(f"{place}: a text goes on to line {line}; {_OPEN_QUOTE}")
                elif len(cells) > len(names):
                    expected = f"expected {len(names)}, as in line 1"
                    problems.append(f"{place}: {len(cells)} cells; {expected}")
                elif any(cells):
                    values = dict(zip_longest(names, cells, fillvalue=""))
                    rows.append(TableRow(place, values))
        except csv.Error as error:
            problems.append(f"line {line + 1}: {error}; {_OPEN_QUOTE}")
    return Table(names, rows, problems)


def _parquet_table(file: FilePath) -> Table:
    import pyarrow.parquet as pq

    with pq.ParquetFile(file) as content:
        names = content.schema_arrow.names
        rows = content.read().to_pylist()
    return Table(names, [TableRow(f"row {n}", row) for n, row in enumerate(rows, 1)], [])


def note_passed_over(file: FilePath, columns: Iterable[str]) -> None:
    """Warn of columns that are not read."""
    named = ", ".join(name or "one without a name" for name in columns)
    if named:
        _LOG.warning("dubins-study: %s", plain(f"{file}: columns that are passed over: {named}"))

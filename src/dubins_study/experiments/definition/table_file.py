"""The rows of a CSV or Parquet file.

Each row has its place in the file.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable
from itertools import zip_longest
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.study.delimited import read_rows
from dubins_study.study.scenario import ScenarioError
from dubins_study.study.values import plain

_LOG = logging.getLogger(__name__)


class TableFileError(ScenarioError):
    """A table of scenarios or points is not usable.

    The message names file, line, column and rule.
    """


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
    """Read the columns and rows of a file.

    A name ending in `.parquet` is read as Parquet, any other as CSV in UTF-8 with commas.
    """
    try:
        if file.suffix == ".parquet":
            return _parquet_table(file)
        return _csv_table(file)
    except OSError as error:
        reason = error.strerror or str(error)
    except UnicodeError:
        reason = "it is not UTF-8 text"
    except ValueError as error:  # the Parquet reader's own words
        reason = plain(str(error).partition("\n")[0])
    raise TableFileError(f"{file}: cannot be read: {reason}")


def _csv_table(file: FilePath) -> Table:
    """The table of a CSV file; values are texts.

    Cells that are missing at the end of a row are empty.
    """
    with file.open(encoding="utf-8-sig", newline="") as text:
        rows, problems = read_rows(text)
    if not rows:
        return Table([], [], problems)
    names = [name.strip() for name in rows[0].cells]
    table_rows = [
        TableRow(place, dict(zip_longest(names, cells, fillvalue=""))) for place, cells in rows[1:]
    ]
    return Table(names, table_rows, problems)


def _parquet_table(file: FilePath) -> Table:
    import pyarrow.parquet as pq

    with pq.ParquetFile(file) as content:
        names = content.schema_arrow.names
        rows = content.read().to_pylist()
    return Table(names, [TableRow(f"row {n}", row) for n, row in enumerate(rows, 1)], [])


def note_passed_over(file: FilePath, columns: Iterable[str]) -> None:
    """Log a warning of columns that are not read."""
    names = ", ".join(name or "one without a name" for name in columns)
    if names:
        _LOG.warning("dubins-study: %s", plain(f"{file}: columns that are passed over: {names}"))

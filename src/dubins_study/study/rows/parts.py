"""Rows as tables, and their Parquet files.

A results folder's parts are immutable Parquet files of rows. Only this module reads them. The
metadata at a part's end name its schema and its run.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from dubins_study.errors import DubinsStudyError
from dubins_study.study.rows.schema import KEY, VERSION, VERSION_KEY, Key, arrow_schema, names
from dubins_study.study.scenario import Pose
from dubins_study.study.scenario_frame import is_missing
from dubins_study.study.values import printable_text, short

Row = dict[str, Any]

ARROW_SCHEMA = arrow_schema()


def rows_table(rows: Iterable[Mapping[str, Any]]) -> pa.Table:
    """Rows as a table of the schema.

    Each row has a value for every column, of the schema's type: `Solution` has refused other types.
    Numbers that are not finite become null. Characters that UTF-8 cannot hold become question
    marks.
    """
    rows = list(rows)
    columns = [_column([row[field.name] for row in rows], field.type) for field in ARROW_SCHEMA]
    return pa.Table.from_arrays(columns, schema=ARROW_SCHEMA)


def _column(values: list[Any], kind: pa.DataType) -> Any:
    """Arrow array of a column's values; None is null."""
    if pa.types.is_string(kind):  # lone surrogates cannot be encoded as UTF-8
        values = [text and text.encode("utf-8", "replace").decode() for text in values]
    elif pa.types.is_floating(kind):
        values = _finite(values)
    elif pa.types.is_list(kind):
        values = [numbers and _finite(numbers) for numbers in values]
    return pa.array(values, type=kind)


def _finite(numbers: list[Any]) -> list[Any]:
    return [x if x is None or math.isfinite(x) else None for x in numbers]


def row_key(row: Mapping[str, Any]) -> Key:
    """Values of a row's key columns, as in `KEY`."""
    key: Any = tuple(row[name] for name in names(KEY))
    return key  # type: ignore[no-any-return]


def start_of(row: Mapping[str, Any]) -> Pose:
    """Start pose of a row's path.

    A heading that the scenario leaves free is the path's own.
    """
    name = "start_heading"
    if is_missing(row.get(name)):
        name = "heading"
    return Pose(row["x"], row["y"], row[name])


PARTS = "parts"
BATCH_ROWS = 2**17
# Threads take longer to start than such a part takes to read.
_SMALL_PART_ROWS = 2**12
_MOVE = "it is none of this folder's parts, move it elsewhere"


class ResultsError(DubinsStudyError, ValueError):
    """A results folder cannot be read or written.

    The message says which one and why.
    """


class DamagedPartError(ResultsError):
    """A part was cut off or changed after writing."""


def reason(error: OSError) -> str:
    """Cause of a system error, for a message.

    It is in the words of the system or of the library that raised the error.
    """
    if error.errno is not None:
        return os.strerror(error.errno)
    return error.strerror or str(error).partition("\n")[0] or type(error).__name__


@contextmanager
def os_errors_as(problem: str) -> Iterator[None]:
    """Raise operating system errors as `ResultsError`.

    The message states the problem and the system's reason.
    """
    try:
        yield
    except OSError as error:
        raise ResultsError(f"{problem}: {reason(error)}") from None


def folder_paths(folders: Any) -> list[FilePath]:
    """Paths of one results folder or of several."""
    several = folders
    if isinstance(folders, str) or not isinstance(folders, Iterable):
        several = [folders]
    try:
        return [FilePath(folder) for folder in several]
    except TypeError:
        expected = "expected the path of a results folder"
        raise ResultsError(f"folder is {short(folders)}; {expected}") from None


def part_files(folder: FilePath) -> list[FilePath]:
    """Files of a folder's parts, by name.

    None is opened.
    """
    return sorted((folder / PARTS).glob("*.parquet"))


def read_batches(file: FilePath, columns: Sequence[str] | None = None) -> Iterator[pa.Table]:
    """Read a part in tables of `BATCH_ROWS` rows.

    The last table may have fewer. Columns are as the schema has them; one that was declared after
    the part was written is null.

    Raises:
        DamagedPartError: if the file was cut off or changed.
        ResultsError: if it is of another schema, or cannot be read.
    """
    empty = _empty(columns)
    with _reading(file), pq.ParquetFile(file, page_checksum_verification=True) as content:
        _check_schema(file, content)
        stored = [name for name in empty.column_names if name in content.schema_arrow.names]
        expected = content.metadata.num_rows
        rows = 0
        threads = expected > _SMALL_PART_ROWS
        for batch in content.iter_batches(BATCH_ROWS, columns=stored, use_threads=threads):
            batch.validate(full=True)  # nothing else notices texts that are not UTF-8
            rows += len(batch)
            yield _as_stated(pa.Table.from_batches([batch]), empty.schema)
        if rows != expected:  # no checksum covers the number of rows
            raise _damaged(file, f"it holds {rows} rows and says {expected}")


def _empty(columns: Sequence[str] | None) -> pa.Table:
    return ARROW_SCHEMA.empty_table().select(list(columns or ARROW_SCHEMA.names))


def _as_stated(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """Table with the columns of a schema.

    A column that the table lacks is null; one of another type is cast.
    """
    for field in schema:
        if field.name not in table.column_names:
            table = table.append_column(field, pa.nulls(len(table), field.type))
    return table.select(schema.names).cast(schema)


def read_part(file: FilePath, columns: Sequence[str] | None = None) -> pa.Table:
    """Read a part's columns as one table.

    All columns are read by default. Errors are those of `read_batches`.
    """
    return pa.concat_tables([_empty(columns), *read_batches(file, columns)])


def check_part(file: FilePath) -> None:
    """Read a whole part to check it.

    One batch is read at a time, and nothing is kept. Errors are those of `read_batches`.
    """
    for _ in read_batches(file):
        pass


@contextmanager
def _reading(file: FilePath) -> Iterator[None]:
    """Raise all errors of reading as `ResultsError`.

    An error of Arrow becomes a `DamagedPartError`.
    """
    try:
        yield
    except ResultsError:
        raise
    except Exception as error:  # a flipped bit may make Arrow raise anything
        if isinstance(error, OSError) and error.errno is not None:
            raise ResultsError(f"{file} cannot be read: {reason(error)}") from None
        raise _damaged(file, "it is no Parquet file, or damaged") from None


def _damaged(file: FilePath, problem: str) -> DamagedPartError:
    return DamagedPartError(f"{file} cannot be read: {problem}; run again for its rows")


def _check_schema(file: FilePath, content: pq.ParquetFile) -> None:
    """Refuse a file of another schema.

    A file that states no version is judged by its columns.
    """
    texts = content.metadata.metadata or {}
    version = texts.get(VERSION_KEY.encode(), b"%d" % VERSION).decode("utf-8", "replace")
    columns = content.schema_arrow.names
    problems = [
        *(f"it has no column {name!r}" for name in names(KEY) if name not in columns),
        *(f"it has a column {name!r:.60}" for name in columns if name not in ARROW_SCHEMA.names),
    ]
    if version != str(VERSION):
        problems.insert(0, f"it is of schema {version!r:.60}")
    if problems:
        raise ResultsError(
            f"{file} cannot be read: {problems[0]}; expected schema {VERSION}: {_MOVE}"
        )


def printable_batches(file: FilePath, columns: Sequence[str]) -> Iterator[pa.Table]:
    """Read a part with unprintable characters written out.

    Tables are those of `read_batches`. Texts of engines and plug-ins may hold any character.
    """
    for table in read_batches(file, columns):
        arrays = [_printable(column) for column in table.columns]
        yield pa.Table.from_arrays(arrays, names=table.column_names)


def _printable(column: Any) -> Any:
    """Column with unprintable characters written out.

    A column without any is returned as it is.
    """
    if not pa.types.is_string(column.type):
        return column
    all_printable = pc.all(pc.utf8_is_printable(column)).as_py()
    if all_printable or all_printable is None:  # None where the column holds no text
        return column
    texts = [text and printable_text(text) for text in column.to_pylist()]
    return pa.chunked_array([texts], column.type)

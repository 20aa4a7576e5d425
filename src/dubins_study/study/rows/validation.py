"""Rows of a stranger's folder, checked before numbers are made of them or texts are shown."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path as FilePath
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from dubins_study.study.rows.files import ResultsError
from dubins_study.study.rows.parts import BATCH_ROWS, read_batches
from dubins_study.study.rows.schema import KEY, names
from dubins_study.study.scenario import NUMBERS
from dubins_study.study.values import printable_text

_POSITIVE = ("radius", "speed")
_REQUIRED = (*names(KEY), *NUMBERS)
_CONTROLS = ("curvatures", "lengths")
# The largest number that a column may hold; no number in these columns is negative.
_LARGEST = dict.fromkeys(("build_s", "solve_s", "wall_s"), 1e9) | dict.fromkeys(  # thirty years
    ("repeat", "threads", "jobs", "iterations", "evaluations"), 2.0**53
)


def checked_batches(file: FilePath, columns: Sequence[str] | None = None) -> Iterator[pa.Table]:
    """A part's rows as `read_batches` gives them, checked, and with texts that can be printed.

    Texts (`scenario_id` excepted) are dictionaries.

    Raises:
        ResultsError: if the part cannot be read, or holds a row that no run writes.
    """
    for number, table in enumerate(read_batches(file, columns, dictionaries=True)):
        if problem := row_problem(table):
            raise ResultsError(f"{file}, rows from {number * BATCH_ROWS} on: {problem}")
        yield printable_rows(table)


def printable_rows(table: pa.Table) -> pa.Table:
    """The same rows, with what cannot be printed in their texts written out as Python does."""
    columns = [_printable(chunks) for chunks in table.columns]
    return pa.Table.from_arrays(columns, names=table.column_names)


def _printable(column: Any) -> Any:
    if isinstance(column, pa.ChunkedArray):
        return pa.chunked_array([_printable(chunk) for chunk in column.chunks], column.type)
    if pa.types.is_dictionary(column.type):
        return pa.DictionaryArray.from_arrays(column.indices, _printable(column.dictionary))
    is_text = pa.types.is_string(column.type)
    if not is_text or pc.all(pc.utf8_is_printable(column)).as_py() is not False:
        return column
    texts = [None if text is None else printable_text(text) for text in column.to_pylist()]
    return pa.array(texts, column.type)


def row_problem(table: pa.Table) -> str | None:
    """The first thing wrong with rows of the schema, or None.

    Args:
        table: columns of the schema's types; any column may be absent.
    """
    for name in table.column_names:
        column = table[name]
        if name in _REQUIRED and column.null_count:
            return f"{name} is missing in a row; expected a value in every row"
        if name in _CONTROLS:
            values = pc.list_flatten(column)
            if values.null_count or not _are_finite(values):
                return f"{name} holds what is no finite number; expected the controls of a path"
        elif pa.types.is_floating(column.type) and not _are_finite(column, name not in NUMBERS):
            return f"{name} is not finite in a row; expected a number or nothing"
        if problem := _range_problem(name, column):
            return problem
    if all(name in table.column_names for name in _CONTROLS):
        sizes = [pc.fill_null(pc.list_value_length(table[name]), -1) for name in _CONTROLS]
        if not pc.all(pc.equal(*sizes), min_count=0).as_py():
            return "curvatures and lengths of a row differ in number; expected a length for each"
    return None


def _are_finite(column: Any, nan_allowed: bool = False) -> bool:
    """Whether no number is infinite, nor NaN unless that counts as a missing value."""
    infinite = pc.any(pc.is_inf(column)).as_py()
    return not (infinite or (not nan_allowed and pc.any(pc.is_nan(column)).as_py()))


def _range_problem(name: str, column: pa.ChunkedArray[Any]) -> str | None:
    if name in _POSITIVE:
        least = pc.min(column).as_py()
        return None if least is None or least > 0 else f"{name} is {least}; expected above 0"
    if name not in _LARGEST:
        return None
    bounds: Any = pc.min_max(column)
    low, high = bounds.as_py().values()
    if low is None or (low >= 0 and high <= _LARGEST[name]):
        return None
    return f"{name} is {low if low < 0 else high}; expected a number from 0 to {_LARGEST[name]:g}"

"""Rows with texts that can be shown: engines and plug-ins may say anything."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path as FilePath
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from dubins_study.study.rows.parts import read_batches
from dubins_study.study.values import printable_text


def printable_batches(file: FilePath, columns: Sequence[str] | None = None) -> Iterator[pa.Table]:
    """A part's rows as `read_batches` gives them, with texts that can be printed.

    Texts (`scenario_id` excepted) are dictionaries.
    """
    return map(printable_rows, read_batches(file, columns, dictionaries=True))


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

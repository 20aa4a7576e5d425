"""The parts of results folders, read piece by piece, each attempt once."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from dubins_study.errors import DubinsStudyError
from dubins_study.report.data.row_check import impossible
from dubins_study.report.data.visible import visible_column
from dubins_study.study.rows.schema import (
    CELL,
    CHUNK,
    ROW,
    VERSION,
    VERSION_KEY,
    arrow_schema,
    names,
)

CONTROLS = ["curvatures", "lengths"]
# what a run writes beside its rows; the page shows it from the manifest, so the rows need not
_UNREAD = {"versions", "machine", "run_id"}
LIGHT = [name for name in names(ROW) if name not in _UNREAD and name not in CONTROLS]
# what two attempts at a cell, made by the same code, contradict each other in
_FINDING = ["outcome", "claim", "verdict", "word"]
# rows are kept whole up to so many attempts; of more, so many are drawn by their scenarios' names
MOST_ROWS, SAMPLE = 500_000, 100_000
_PIECE = 2**17  # rows
_SCHEMA = arrow_schema()


class ReportError(DubinsStudyError, ValueError):
    """A results folder that cannot be read, or a place that cannot be written."""


def refuse_link(place: FilePath) -> None:
    """Nothing outside a results folder is read.

    Raises:
        ReportError: if a file or folder in it is a link.
    """
    if place.is_symlink():
        raise ReportError(
            f"{place} is a link; expected a file or folder of its own, since nothing outside a "
            "results folder is read: put a copy in its place"
        )


def parts_of(folder: FilePath) -> list[FilePath]:
    """The parts of a folder.

    Raises:
        ReportError: if there are none, they hold no row, or one is a link.
    """
    refuse_link(folder / "parts")
    parts = sorted((folder / "parts").glob("*.parquet"))
    if not parts:
        raise ReportError(f"{folder} has no rows: expected Parquet files in {folder / 'parts'}")
    if not sum(map(count, parts)):
        raise ReportError(f"{folder} has no rows: its parts are empty")
    return parts


def count(part: FilePath) -> int:
    """How many rows a part holds, from its metadata.

    Raises:
        ReportError: if it cannot be read, or is a link.
    """
    refuse_link(part)
    if not part.is_file():  # a pipe would be waited for
        raise ReportError(f"{part} cannot be read: it is no file")
    try:
        return int(pq.read_metadata(part).num_rows)
    except Exception as error:  # as for `pieces`
        raise _unreadable(part, error) from None


def pieces(part: FilePath) -> Iterator[pa.Table]:
    """A part's rows in tables of bounded size; texts are dictionaries, ids excepted.

    Raises:
        ReportError: if it cannot be read, or is of another schema.
    """
    texts = [field.name for field in _SCHEMA if field.type == pa.string()]
    form = {"read_dictionary": [text for text in texts if text != "scenario_id"]}
    columns = [*LIGHT, *CONTROLS]
    fields = pa.schema([_SCHEMA.field(name) for name in columns])
    try:
        # a file object, or Arrow would read hive-style column names out of the folder's name
        with part.open("rb") as stream:
            footer = pq.read_metadata(stream)
            # before the file is opened for good, which fails on a column that is not there
            if problem := _stranger(footer):
                raise ReportError(f"{part}: {problem}; expected the columns of schema {VERSION}")
            file = pq.ParquetFile(stream, metadata=footer, page_checksum_verification=True, **form)
            for number, batch in enumerate(file.iter_batches(_PIECE, columns=columns)):
                table = _typed(batch.select(columns), fields)
                if wrong := impossible(table):
                    raise ReportError(f"{part}, rows from {number * _PIECE} on: {wrong}")
                yield table
    except ReportError:
        raise
    except Exception as error:  # types of other makers are read by code that raises what it likes
        raise _unreadable(part, error) from None


def _stranger(footer: pq.FileMetaData) -> str | None:
    """What makes a file none of this schema's, if anything does."""
    version = str(VERSION).encode()
    said = (footer.metadata or {}).get(VERSION_KEY.encode(), version)
    if said != version:
        return f"schema is {said!r:.60}"
    return _difference(footer.schema.to_arrow_schema().names)


def _typed(batch: pa.RecordBatch, fields: pa.Schema) -> pa.Table:
    columns = [
        column if _is_text(column.type) and field.type == pa.string() else column.cast(field.type)
        for column, field in zip(batch.columns, fields, strict=True)
    ]
    table = pa.Table.from_arrays(columns, names=fields.names)
    table.validate(full=True)  # texts that are no UTF-8 are found nowhere else
    texts = [field.type == pa.string() for field in fields]
    shown = [visible_column(c) if text else c for c, text in zip(columns, texts, strict=True)]
    return pa.Table.from_arrays(shown, names=fields.names)


def _is_text(kind: pa.DataType) -> bool:
    return bool(pa.types.is_dictionary(kind) and kind.value_type == pa.string())


def plain(table: pa.Table) -> pa.Table:
    """The same with texts as texts."""
    return table.cast(pa.schema([_field(field) for field in table.schema]))


def _field(field: pa.Field) -> pa.Field:
    return field.with_type(pa.string()) if _is_text(field.type) else field


def _unreadable(part: FilePath, error: Exception) -> ReportError:
    reason = str(error).splitlines()[0] if str(error) else type(error).__name__
    if not isinstance(error, OSError) or error.errno is None:
        reason += (
            "; if it is damaged, run it again into this folder for its rows (a part of a stream: "
            "delete it before)"
        )
    return ReportError(f"{part} cannot be read: {reason}")


def _difference(found: Sequence[str]) -> str | None:
    wanted = set(_SCHEMA.names)
    if missing := [name for name in _SCHEMA.names if name not in found]:
        return f"missing column {missing[0]!r}"
    if unknown := [name for name in found if name not in wanted]:
        return f"unknown column {unknown[0]!r}"
    return None if len(found) == len(wanted) else "a column twice"


def drawn(table: pa.Table, attempts: int) -> pa.Table:
    """The rows of a sample of about `SAMPLE` of so many attempts.

    They are all those at scenarios whose name, a hash, is below a bound: the same ones whatever
    the order of the parts, and of a scenario all attempts or none.
    """
    bound = min(2**32 - 1, round(2**32 * SAMPLE / attempts))
    return table.filter(pc.less(table["scenario_id"], f"{bound:08x}"))


class New(NamedTuple):
    """The rows of a table that are of cells not seen before, and what the others were.

    Args:
        other_code: how many of the others are of another code than those seen.
        contradicting: how many are of the same code and find something else.
    """

    table: pa.Table
    other_code: int
    contradicting: int


class Seen:
    """Attempts seen so far, by hashes of their cells: nothing that grows with streamed rows."""

    def __init__(self) -> None:
        self._cells, self._keys, self._found = (np.empty(0, np.uint64) for _ in range(3))
        self._gaps = np.empty(0)  # of the same rows as the keys
        self._chunks: dict[tuple[str, ...], str] = {}

    def new(self, experiment: str, table: pa.Table, tolerance: float) -> New:
        """The rows of cells that were not seen, each once.

        Args:
            experiment: its name.
            table: rows of one of its folders.
            tolerance: gaps that differ by more contradict each other.
        """
        frame = table.select([*names(CELL), "code_digest", *_FINDING, "gap"]).to_pandas()
        frame["experiment"] = experiment
        cell = ["experiment", *names(CELL)]
        cells, keys = _hashes(frame, cell), _hashes(frame, [*cell, "code_digest"])
        found = _hashes(frame, [*cell, "code_digest", *_FINDING])
        first = ~(np.isin(cells, self._cells) | pd.Series(cells).duplicated().to_numpy())
        other = ~first & ~np.isin(keys, self._keys) & ~np.isin(keys, keys[first])
        gaps = frame["gap"].to_numpy(np.float64)
        self._cells = np.concatenate([self._cells, cells[first]])
        self._keys = np.concatenate([self._keys, keys[first]])
        self._found = np.concatenate([self._found, found[first]])
        self._gaps = np.concatenate([self._gaps, gaps[first]])
        again = ~first & ~other
        contradicting = again & ~np.isin(found, self._found)
        if again.any():
            kept = self._gaps[pd.Index(self._keys).get_indexer_for(keys[again])]
            # where one has none, the words differ
            contradicting[again] |= np.abs(gaps[again] - kept) > tolerance
        return New(table.filter(pa.array(first)), int(other.sum()), int(contradicting.sum()))

    def is_new(
        self, experiment: str, part: FilePath, codes: Mapping[str, str]
    ) -> tuple[bool | None, bool]:
        """Whether a streamed part's chunk was not seen, and whether one seen is of another code.

        None of a part that is no chunk. A chunk of another code than its folder's own (`codes`, by
        solver) holds no row that is shown, and does not count as seen.
        """
        try:
            told = json.loads((pq.read_metadata(part).metadata or {})[CHUNK.encode()])
            chunk = (experiment, *(str(told[key]) for key in ("question", "first", "count")))
            solver, code = str(told["solver"]), str(told["code_digest"])
        except (KeyError, ValueError, TypeError, RecursionError):
            return None, False
        if codes.get(solver, code) != code:
            return True, False
        earlier = self._chunks.get(chunk)
        self._chunks.setdefault(chunk, code)
        return earlier is None, earlier not in (None, code)


def _hashes(frame: pd.DataFrame, columns: list[str]) -> Any:
    return pd.util.hash_pandas_object(frame[columns], index=False).to_numpy()

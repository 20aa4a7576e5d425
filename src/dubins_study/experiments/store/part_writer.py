"""Parts are written here: rows of single cells as they come, and chunks of streams."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path as FilePath
from time import monotonic

import pyarrow as pa
import pyarrow.parquet as pq

from dubins_study.experiments.store.whole_file import write_whole
from dubins_study.study.rows.chunk import Chunk
from dubins_study.study.rows.files import ResultsError, reason, refuse_link
from dubins_study.study.rows.parts import PARTS
from dubins_study.study.rows.row_table import Row, rows_table
from dubins_study.study.rows.schema import CHUNK, RUN_ID, VERSION, VERSION_KEY

# Rows are written after so many seconds, so that a killed run loses few.
_FLUSH_INTERVAL_S = 0.8

# Called with (cells done, cells in all) after every step.
Progress = Callable[[int, int], None]


def write_part(
    folder: FilePath, name: str, table: pa.Table, metadata: Mapping[str, str] | None = None
) -> FilePath:
    """Write a part that appears whole or not at all, and return the file.

    Args:
        folder: the results folder.
        name: of the part, without suffix.
        table: its rows; texts may be dictionaries.
        metadata: besides the schema's version: the run under `RUN_ID`.

    Raises:
        ResultsError: if the folder cannot be written, for example because the disk is full.
    """
    final = folder / PARTS / f"{name}.parquet"

    def write(file: FilePath) -> None:
        # Without Arrow's own schema in the file, a dictionary of texts is read as texts.
        with pq.ParquetWriter(
            file, table.schema, compression="zstd", write_page_checksum=True, store_schema=False
        ) as writer:
            writer.write_table(table)
            # metadata of the table's own schema would be lost, since that is not stored
            writer.add_key_value_metadata({VERSION_KEY: str(VERSION), **(metadata or {})})

    refuse_link(final.parent)
    try:
        write_whole(final, write)
    except OSError as error:
        raise ResultsError(
            f"cannot write {final}: {reason(error)}; {len(table)} rows not written yet are lost, "
            "all others are kept: make room, and run again to go on"
        ) from None
    return final


def write_chunk(folder: FilePath, chunk: Chunk, table: pa.Table, run_id: str) -> FilePath:
    """Write the part of one chunk of a stream; errors as `write_part`."""
    metadata = {RUN_ID: run_id, CHUNK: chunk.model_dump_json()}
    return write_part(folder, chunk.part_name, table, metadata)


class PartWriter:
    """Collects the rows of a run, writes a part about every second, and reports progress.

    The parts are named after the run; `total` counts its cells, those done before included.
    """

    def __init__(self, folder: FilePath, run_id: str, total: int, progress: Progress | None):
        self._folder, self._run_id, self._total, self._progress = folder, run_id, total, progress
        self._rows: list[Row] = []
        self._parts = self._cells_done = 0
        self._flushed = monotonic()
        self.after_step: Callable[[], None] | None = None

    def skip(self, cells: int) -> None:
        """Count cells as done whose rows are in the folder already."""
        self._cells_done += cells
        self._report()

    def add(self, rows: list[Row]) -> None:
        """Take rows, and write all that were collected if it is time."""
        self._rows += rows
        self._cells_done += len(rows)
        if monotonic() - self._flushed > _FLUSH_INTERVAL_S:
            self.flush()
        self._report()

    def flush(self) -> None:
        """Write the collected rows as a part.

        If an interruption comes before they are forgotten, the next call writes them again: a
        reader takes each row once.
        """
        if self._rows:
            name = f"{self._run_id}-{self._parts:06d}"
            write_part(self._folder, name, rows_table(self._rows), {RUN_ID: self._run_id})
            self._parts += 1
            self._rows = []
        self._flushed = monotonic()

    def _report(self) -> None:
        if self.after_step is not None:
            self.after_step()
        if self._progress is not None:
            self._progress(self._cells_done, self._total)

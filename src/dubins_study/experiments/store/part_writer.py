"""Write files completely or not at all.

Written files survive a power failure.

The rows of a run are such files: a part about every second.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path as FilePath
from time import monotonic

import pyarrow as pa
import pyarrow.parquet as pq

from dubins_study.study.rows.parts import PARTS, ResultsError, Row, reason, row_key, rows_table
from dubins_study.study.rows.schema import RUN_ID, VERSION, VERSION_KEY, Key

# The end of the names of temporary files, which a killed run may leave.
TEMPORARY = ".dubins-study.tmp"


def write_whole(final: FilePath, write: Callable[[FilePath], object]) -> None:
    """Write a file completely or not at all.

    `write` is called with a temporary path and writes the content there. That file is then synced
    and renamed to `final`. After an error it is removed.
    """
    temporary = final.with_name(f".{final.name}{TEMPORARY}")
    try:
        write(temporary)
        with temporary.open("rb") as stream:
            os.fsync(stream.fileno())
        temporary.replace(final)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    sync_folder(final.parent)


def sync_folder(folder: FilePath) -> None:
    """Make a folder's names survive a power failure."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


# Seconds between two parts, so that a killed run loses few rows.
_FLUSH_INTERVAL_S = 0.8

# Called with (number of cells done, number of all cells) after every step.
Progress = Callable[[int, int], None]


def write_part(
    folder: FilePath, name: str, table: pa.Table, metadata: Mapping[str, str] | None = None
) -> FilePath:
    """Write a part completely or not at all.

    Returns the part's path. `metadata` are stored in the file, beside the schema's version.
    """
    final = folder / PARTS / f"{name}.parquet"

    def write(file: FilePath) -> None:
        # If Arrow's own schema is not stored, a dictionary array is read as a plain text column.
        with pq.ParquetWriter(
            file, table.schema, compression="zstd", write_page_checksum=True, store_schema=False
        ) as writer:
            writer.write_table(table)
            # Added here, because metadata of the table's schema are not stored.
            writer.add_key_value_metadata({VERSION_KEY: str(VERSION), **(metadata or {})})

    try:
        write_whole(final, write)
    except OSError as error:
        raise ResultsError(
            f"cannot write {final}: {reason(error)}; {len(table)} rows not written yet are lost, "
            "all others are kept: make room, and run again to go on"
        ) from None
    return final


class PartWriter:
    """Collects the rows of a run in parts.

    A part is written about every second; progress is reported.
    """

    def __init__(self, folder: FilePath, run_id: str, total: int, progress: Progress | None):
        self._folder = folder
        self._run_id = run_id
        self._total = total
        self._progress = progress
        self._rows: list[Row] = []
        self._skipped: set[Key] = set()
        self._parts = self._cells_done = 0
        self._flushed = monotonic()

    def skip(self, cells: set[Key]) -> None:
        """Count cells as done that have a row.

        Some of them are solved again, as parts of a sweep; `add` then ignores their new rows.
        """
        self._skipped = cells
        self._cells_done += len(cells)
        self._report()

    def add(self, rows: list[Row]) -> None:
        """Collect rows; write them if it is time."""
        new = [row for row in rows if row_key(row) not in self._skipped]
        self._rows += new
        self._cells_done += len(new)
        if monotonic() - self._flushed > _FLUSH_INTERVAL_S:
            self.flush()
        self._report()

    def flush(self) -> None:
        """Write the collected rows as a part.

        After an interruption this may be called once more.
        """
        if self._rows:
            name = f"{self._run_id}-{self._parts:06d}"
            write_part(self._folder, name, rows_table(self._rows), {RUN_ID: self._run_id})
            self._parts += 1
            self._rows = []
        self._flushed = monotonic()

    def _report(self) -> None:
        if self._progress is not None:
            self._progress(self._cells_done, self._total)

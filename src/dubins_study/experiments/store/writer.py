"""Rows of a run as they come: written every second, counted, told."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path as FilePath
from time import monotonic
from typing import Any

from dubins_study.experiments.store.parts import RUN_ID, write_part
from dubins_study.study.rows.row_table import Row, rows_table

# rows are written when this many seconds have passed, so that a killed run loses little
_FLUSH = 0.8

# called with (cells done, cells in all) after every step
Progress = Callable[[int, int], None]


class Writer:
    """Collects rows, writes a part every second, and tells the progress."""

    def __init__(self, folder: FilePath, run_id: str, total: int, progress: Progress | None):
        self.folder, self.run_id, self.total, self.progress = folder, run_id, total, progress
        self.rows: list[Row] = []
        self.parts = 0
        self.done = 0
        self.flushed = monotonic()
        self.beat: Callable[[], None] | None = None  # called after every step

    def skip(self, cells: int) -> None:
        self.done += cells
        self._tell()

    def add(self, rows: list[Row]) -> None:
        self.rows += rows
        self.done += len(rows)
        if monotonic() - self.flushed > _FLUSH:
            self.flush()
        self._tell()

    def flush(self) -> None:
        # Interrupted in the middle, it writes the same rows again: a folder is read without copies.
        if self.rows:
            self._write(rows_table(self.rows))
            self.rows = []
        self.flushed = monotonic()

    def _write(self, table: Any) -> None:
        name = f"{self.run_id}-{self.parts:06d}"
        write_part(self.folder, name, table, {RUN_ID: self.run_id})
        self.parts += 1

    def _tell(self) -> None:
        if self.beat is not None:
            self.beat()
        if self.progress is not None:
            self.progress(self.done, self.total)

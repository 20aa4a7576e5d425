"""Lock, open and repair a results folder.

Its rows are read, counted and united here too.
"""

from __future__ import annotations

import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath

import pyarrow as pa
from filelock import FileLock, Timeout

from dubins_study.experiments.provenance import now
from dubins_study.experiments.store.part_writer import TEMPORARY, write_part
from dubins_study.study.rows.manifest import MANIFEST, Manifest, read_manifest
from dubins_study.study.rows.parts import (
    ARROW_SCHEMA,
    PARTS,
    DamagedPartError,
    ResultsError,
    check_part,
    os_errors_as,
    part_files,
    read_part,
    reason,
)
from dubins_study.study.rows.schema import KEY, RUN_ID, Key, names
from dubins_study.study.values import plain

# Name of the folder for damaged parts.
DAMAGED = "damaged"
LOCK = ".lock"
# Seconds to wait for the lock, since a call of `is_locked` in another process also holds it for
# microseconds. If the lock is still held after that, a run holds it.
_WAIT_S = 0.3
_POLL_INTERVAL_S = 0.02


@contextmanager
def locked(folder: FilePath) -> Iterator[None]:
    """Lock a folder inside the `with` block.

    If another process holds the lock, ResultsError is raised. The lock ends with this process, even
    after a crash.
    """
    file = folder / LOCK
    lock = FileLock(file, timeout=_WAIT_S, poll_interval=_POLL_INTERVAL_S, fallback_to_soft=False)
    try:
        lock.acquire()
    except Timeout:
        holder = lock_holder(folder)
        pid = str(holder.get("pid", "unknown"))
        since = str(holder.get("started", "unknown"))
        raise ResultsError(
            f"{folder} is in use: process {pid:.20} has been at work there since {since:.40}; wait "
            "for it or end it, or choose another --out"
        ) from None
    except OSError as error:
        raise ResultsError(f"cannot lock {file}: {reason(error)}") from None
    try:
        with suppress(OSError):  # on a full disk, messages name the process "unknown"
            file.write_text(json.dumps({"pid": os.getpid(), "started": now()}), encoding="utf-8")
        yield
    finally:
        lock.release()


def lock_holder(folder: FilePath) -> dict[str, object]:
    """`pid` and `started` of a folder's last lock.

    `pid` is the process that locked the folder. Empty if nothing is recorded.
    """
    try:
        content = json.loads((folder / LOCK).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    if not isinstance(content, dict):
        return {}
    return content


def is_locked(folder: FilePath) -> bool:
    """Whether a run holds a folder's lock.

    The check writes nothing.
    """
    try:
        handle = os.open(folder / LOCK, os.O_RDONLY)
    except OSError:
        return False
    try:
        # a shared lock: two concurrent calls must not report each other
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(handle)
    return False


def prepare_folder(folder: FilePath) -> None:
    """Create a folder that can be locked.

    A folder that holds anything else than results is refused.
    """
    with os_errors_as(f"cannot write to {folder}"):
        if folder.exists() and not (folder / MANIFEST).exists():
            # A run that is killed before its first manifest may leave a lock and an empty folder.
            others = [
                file
                for file in folder.iterdir()
                if file.name not in (LOCK, PARTS) and not file.name.endswith(TEMPORARY)
            ]
            if others or part_files(folder):
                raise ResultsError(f"{folder} holds other files and no {MANIFEST}; choose another")
        folder.mkdir(parents=True, exist_ok=True)


def open_folder(folder: FilePath, manifest: Manifest, restart: bool) -> tuple[Manifest, list[str]]:
    """Check a locked folder's experiment, and repair it.

    This process must hold the lock. Returns the manifest, joined with that of earlier runs, and a
    sentence for each repair. A folder of another experiment or schema is refused and stays as it
    is. With `restart` all rows are deleted, and earlier runs are forgotten.
    """
    with os_errors_as(f"cannot write to {folder}"):
        if (folder / MANIFEST).exists() and not restart:
            earlier = read_manifest(folder)
            for field, title in (("name", "experiment"), ("text", "text of experiment")):
                value = getattr(earlier.experiment, field)
                if value != getattr(manifest.experiment, field):
                    raise ResultsError(
                        f"{folder} holds results of another {title} ({value!r:.60}), not of "
                        f"{manifest.experiment.name!r:.60} as it is now; choose another --out, or "
                        "--restart to throw them away"
                    )
            # The user may have deleted the folder of parts to start again; rows need it.
            (folder / PARTS).mkdir(exist_ok=True)
            # The new entries of solvers replace earlier ones: each row names its own versions.
            joined = manifest.with_changes(
                created=earlier.created,
                finished=earlier.finished,
                solvers={**earlier.solvers, **manifest.solvers},
                runs=earlier.runs,
            )
            return joined, _mend(folder)
        (folder / PARTS).mkdir(parents=True, exist_ok=True)
        for part in part_files(folder):
            part.unlink()
    return manifest, []


def _mend(folder: FilePath) -> list[str]:
    """Move damaged parts to the folder `DAMAGED`.

    Returns a sentence for each. Every part is checked. Temporary files that a killed run has left
    are deleted.
    """
    damaged = []
    place = folder / DAMAGED
    for part in part_files(folder):
        try:
            check_part(part)
        except DamagedPartError:
            damaged.append(part)
    for parent in (folder, folder / PARTS):
        for file in [*parent.glob(f".*{TEMPORARY}")]:
            file.unlink()
    for part in damaged:
        with os_errors_as(f"cannot move {part} to {place}"):
            place.mkdir(exist_ok=True)
            part.rename(place / part.name)
    return [
        f"{plain(str(part))} is damaged: moved to {plain(str(place / part.name))}, its cells are "
        "solved again"
        for part in damaged
    ]


def done(folder: FilePath) -> set[Key]:
    """The keys of all cells with a row."""
    columns = read_rows(folder, names(KEY)).columns
    return set(zip(*(column.to_pylist() for column in columns), strict=True))


def read_rows(
    folder: FilePath, columns: list[str] | None = None, damaged: list[FilePath] | None = None
) -> pa.Table:
    """The rows of a folder, one row per cell.

    The table has the key columns and then those of `columns`; None stands for all columns.

    Damaged parts are passed over and appended to `damaged`; without that list they are refused.
    """
    columns = list(dict.fromkeys((*names(KEY), *(columns or ARROW_SCHEMA.names))))
    tables = [ARROW_SCHEMA.empty_table().select(columns)]
    for part in part_files(folder):
        try:
            tables.append(read_part(part, columns))
        except DamagedPartError:
            if damaged is None:
                raise
            damaged.append(part)
    table = pa.concat_tables(tables)
    # The first row per key: a run that is killed while it unites parts leaves duplicates.
    numbered = table.select(names(KEY)).append_column("row", pa.array(range(len(table))))
    first = numbered.group_by(names(KEY)).aggregate([("row", "min")])["row_min"]
    if len(first) == len(table):
        return table
    return table.take(first.combine_chunks().sort())


def compact(folder: FilePath, run_id: str) -> None:
    """Unite all parts into one.

    A crash in between leaves duplicate rows, which readers ignore.
    """
    parts = part_files(folder)
    if len(parts) < 2:
        return
    rows = read_rows(folder)
    try:
        united = write_part(folder, f"{run_id}-all", rows, {RUN_ID: run_id})
    except ResultsError:  # the disk is full: the separate parts hold the same rows
        return
    for part in parts:
        if part != united:
            part.unlink()

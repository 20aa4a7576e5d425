"""A results folder: opened for a run and mended; its rows read, counted and united."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import NamedTuple

import pyarrow as pa

from dubins_study.experiments.store.lock import LOCK
from dubins_study.experiments.store.part_writer import write_part
from dubins_study.experiments.store.whole_file import is_temporary, remove_temporaries
from dubins_study.study.printable import plain
from dubins_study.study.rows.files import DamagedPartError, ResultsError, os_errors_as, refuse_link
from dubins_study.study.rows.manifest import MANIFEST, Definition, Manifest, read_manifest
from dubins_study.study.rows.parts import (
    PARTS,
    Part,
    check_part,
    is_stream,
    part_files,
    read_footer,
    read_part,
)
from dubins_study.study.rows.row_table import ARROW_SCHEMA
from dubins_study.study.rows.schema import KEY, RUN_ID, Key, names

# where damaged parts are moved
DAMAGED = "damaged"
_KIND = ["solver", "code_digest", "outcome", "verdict", "run_id"]


class RowCount(NamedTuple):
    """The rows of one kind: how many, and the seconds that their solves took together."""

    solver: str
    code_digest: str
    outcome: str
    verdict: str
    run_id: str
    rows: int
    wall_s: float


def prepare_folder(folder: FilePath) -> None:
    """Make a folder that can be locked; a folder that is there stays as it is.

    Raises:
        ResultsError: if it cannot be made, or holds something else than results.
    """
    with os_errors_as(f"cannot write to {folder}"):
        if folder.exists() and not (folder / MANIFEST).exists():
            names_there = [entry.name for entry in folder.iterdir()]
            # what a run leaves that is killed before its first manifest
            if not all(name in (LOCK, PARTS) or is_temporary(name) for name in names_there):
                raise ResultsError(
                    f"{folder} holds something else and no {MANIFEST}; choose another"
                )
            if any(part_files(folder)):
                raise ResultsError(f"{folder} holds parts and no {MANIFEST}; choose another")
        folder.mkdir(parents=True, exist_ok=True)


def open_folder(folder: FilePath, manifest: Manifest, restart: bool) -> tuple[Manifest, list[str]]:
    """Make a folder ready for a run: mended, and of the same experiment.

    Args:
        folder: exists, and is locked by this process.
        manifest: of the run; what the folder holds already must be of the same experiment.
        restart: throw away the rows that the folder holds.

    Returns:
        The manifest joined with that of earlier runs, and a sentence for each repair.

    Raises:
        ResultsError: if the folder cannot be written, or holds another experiment, another schema
            or a part that is none of its own. The folder is then as it was.
    """
    refuse_link(folder / PARTS)
    with os_errors_as(f"cannot write to {folder}"):
        if (folder / MANIFEST).exists() and not restart:
            earlier = read_manifest(folder)
            _check_same_experiment(folder, earlier.experiment, manifest.experiment)
            # somebody may have deleted it to begin anew; no row could be written without it
            (folder / PARTS).mkdir(exist_ok=True)
            joined = manifest.with_changes(  # whose rows name their own versions
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


def _check_same_experiment(folder: FilePath, earlier: Definition, now: Definition) -> None:
    """Refuse a folder that holds another experiment: by its name, or by its text."""
    for key, what in (("name", "experiment"), ("text", "text of experiment")):
        value = getattr(earlier, key)
        if value != getattr(now, key):
            raise ResultsError(
                f"{folder} holds results of another {what} ({value!r:.60}), not of "
                f"{now.name!r:.60} as it is now; choose another --out, or --restart to throw them "
                "away"
            )


def _mend(folder: FilePath) -> list[str]:
    """Move damaged parts away and remove what a killed run left, once every part was looked at."""
    damaged = []
    for part in part_files(folder):
        try:
            # of a chunk of a stream, only the metadata at its end
            read_footer(part) if is_stream(part) else check_part(part)
        except DamagedPartError:
            damaged.append(part)
    for place in (folder, folder / PARTS):
        remove_temporaries(place)
    return [
        f"{plain(str(part))} is damaged: moved to {plain(str(_move_away(folder, part)))}, its "
        "cells are solved again"
        for part in damaged
    ]


def _move_away(folder: FilePath, part: FilePath) -> FilePath:
    """Move a damaged part to the folder of damaged parts; it is never deleted."""
    place = folder / DAMAGED
    refuse_link(place)
    with os_errors_as(f"cannot move {part} to {place}"):
        place.mkdir(exist_ok=True)
        target, number = place / part.name, 1
        while target.exists() or target.is_symlink():
            number += 1
            target = place / f"{part.stem}-{number}{part.suffix}"
        part.rename(target)
    return target


def done(folder: FilePath) -> set[Key]:
    """The keys of all single cells that a folder holds a row of; streams are not read."""
    keys: set[Key] = set()
    for part in part_files(folder, streams=False):
        table = read_part(part, names(KEY))
        keys.update(zip(*(column.to_pylist() for column in table.columns), strict=True))
    return keys


def read_rows(folder: FilePath, columns: list[str] | None = None) -> pa.Table:
    """The rows of all single cells of a folder, each cell once.

    Args:
        folder: a results folder.
        columns: names of the schema; those of the key come first, wanted or not. All by default.
    """
    columns = _with_key(columns or ARROW_SCHEMA.names)
    parts = part_files(folder, streams=False)
    return _unique_rows([read_part(part, columns) for part in parts], columns)


def _with_key(columns: list[str]) -> list[str]:
    return list(dict.fromkeys((*names(KEY), *columns)))


def _unique_rows(tables: list[pa.Table], columns: list[str]) -> pa.Table:
    """The first row of every key: a run that ends while it unites parts leaves rows twice."""
    table = pa.concat_tables([ARROW_SCHEMA.empty_table().select(columns), *tables])
    numbered = table.select(names(KEY)).append_column("row", pa.array(range(len(table))))
    first = numbered.group_by(names(KEY)).aggregate([("row", "min")])["row_min"]
    return table if len(first) == len(table) else table.take(first.combine_chunks().sort())


def compact(folder: FilePath, run_id: str) -> None:
    """Unite the parts of all single cells into one, if there is room for it.

    A crash in the middle leaves rows twice, which a reader takes once.
    """
    parts = part_files(folder, streams=False)
    if len(parts) < 2:
        return
    rows = read_rows(folder)
    try:
        united = write_part(folder, f"{run_id}-all", rows, {RUN_ID: run_id})
    except ResultsError:  # the disk is full, and the many parts hold all that the one would
        return
    for part in parts:
        if part != united:
            part.unlink()


def count_rows(folder: FilePath) -> tuple[list[RowCount], int]:
    """Count a folder's rows by kind, each cell once; of streams only metadata are read.

    Returns:
        The counts, and how many parts are damaged and therefore not counted.

    Raises:
        ResultsError: if a part is of another schema, or cannot be read.
    """
    columns = _with_key([*_KIND, "wall_s"])
    tables: list[pa.Table] = []
    counts: list[RowCount] = []
    damaged = 0
    for file in part_files(folder):
        try:
            if is_stream(file):
                counts += _chunk_counts(read_footer(file))
            else:
                tables.append(read_part(file, columns))
        except DamagedPartError:
            damaged += 1
    grouped = _unique_rows(tables, columns).group_by(_KIND)
    kinds = grouped.aggregate([([], "count_all"), ("wall_s", "sum")])
    for *made_by, rows, wall_s in zip(*(c.to_pylist() for c in kinds.columns), strict=True):
        solver, code_digest, outcome, verdict, run_id = made_by
        counts.append(RowCount(solver, code_digest, outcome, verdict, run_id, rows, wall_s or 0.0))
    return counts, damaged


def _chunk_counts(part: Part) -> Iterator[RowCount]:
    if (chunk := part.chunk) is not None:
        for outcome, verdict, rows, wall_s in chunk.kinds:
            made_by = (chunk.solver, chunk.code_digest)
            yield RowCount(*made_by, outcome, verdict, part.run_id, rows, wall_s)

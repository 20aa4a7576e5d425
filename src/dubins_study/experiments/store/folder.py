"""A results folder: opened for a run and mended, its single cells read, its parts united."""

from __future__ import annotations

from pathlib import Path as FilePath

import pyarrow as pa

from dubins_study.experiments.store.lock import LOCK
from dubins_study.experiments.store.manifest_changes import check_same_experiment, continued
from dubins_study.experiments.store.part_writer import write_part
from dubins_study.experiments.store.whole_file import is_temporary, remove_temporaries
from dubins_study.study.printable import plain
from dubins_study.study.rows.files import DamagedPartError, ResultsError, os_errors_as, refuse_link
from dubins_study.study.rows.manifest import MANIFEST, Manifest, read_manifest
from dubins_study.study.rows.parts import (
    PARTS,
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
        The manifest with what earlier runs in the folder left in theirs, and what was mended: one
        sentence each.

    Raises:
        ResultsError: if the folder cannot be written, or holds another experiment, another schema
            or a part that is none of its own. The folder is then as it was.
    """
    refuse_link(folder / PARTS)
    with os_errors_as(f"cannot write to {folder}"):
        if (folder / MANIFEST).exists() and not restart:
            earlier = read_manifest(folder)
            check_same_experiment(folder, earlier.experiment, manifest.experiment)
            # somebody may have deleted it to begin anew; no row could be written without it
            (folder / PARTS).mkdir(exist_ok=True)
            return continued(manifest, earlier), _mend(folder)
        (folder / PARTS).mkdir(parents=True, exist_ok=True)
        for part in part_files(folder):
            part.unlink()
    return manifest, []


def _mend(folder: FilePath) -> list[str]:
    """Move damaged parts away and remove what a killed run left, once every part was looked at."""
    damaged = _damaged_parts(folder)
    for place in (folder, folder / PARTS):
        remove_temporaries(place)
    return [
        f"{plain(str(part))} is damaged: moved to {plain(str(_move_away(folder, part)))}, its "
        "cells are solved again"
        for part in damaged
    ]


def _damaged_parts(folder: FilePath) -> list[FilePath]:
    """The damaged parts. Of a chunk of a stream only the metadata are read, at its end."""
    damaged = []
    for part in part_files(folder):
        try:
            if is_stream(part):
                read_footer(part)
            else:
                check_part(part)
        except DamagedPartError:
            damaged.append(part)
    return damaged


def _move_away(folder: FilePath, part: FilePath) -> FilePath:
    """Move a damaged part to the folder of damaged parts; it is never deleted.

    Raises:
        ResultsError: if it cannot be moved.
    """
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
    wanted = list(dict.fromkeys((*names(KEY), *(columns or ARROW_SCHEMA.names))))
    tables = [read_part(part, wanted) for part in part_files(folder, streams=False)]
    return unique_rows(pa.concat_tables([ARROW_SCHEMA.empty_table().select(wanted), *tables]))


def unique_rows(table: pa.Table) -> pa.Table:
    """The first row of every key: a run that ends while it unites parts leaves rows twice."""
    numbered = table.select(names(KEY)).append_column("row", pa.array(range(len(table))))
    first = numbered.group_by(names(KEY)).aggregate([("row", "min")])["row_min"]
    return table if len(first) == len(table) else table.take(first.combine_chunks().sort())


def compact(folder: FilePath, run_id: str) -> None:
    """Unite the parts of all single cells into one, if there is room for it.

    A crash in the middle leaves rows twice, which `unique_rows` takes once.
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

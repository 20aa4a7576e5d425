"""The results folder: a manifest and immutable Parquet parts, written so that nothing is lost."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

import pyarrow as pa

from dubins_study.experiments.store.disk import StoreError, is_temporary, reason, refuse_link, tidy
from dubins_study.experiments.store.lock import LOCK
from dubins_study.experiments.store.manifest import (
    MANIFEST,
    check_same,
    read_manifest,
    write_manifest,
)
from dubins_study.experiments.store.parts import (
    PARTS,
    RUN_ID,
    damaged_parts,
    is_stream,
    part_files,
    read_part,
    set_aside,
    write_part,
)
from dubins_study.experiments.store.stream_parts import streamed_part
from dubins_study.study.printable import plain
from dubins_study.study.rows.row_table import ARROW_SCHEMA
from dubins_study.study.rows.schema import KEY, Key, names

__all__ = [
    "StoreError",
    "compact",
    "counted",
    "done",
    "open_folder",
    "place",
    "read_manifest",
    "read_rows",
    "write_manifest",
    "write_part",
]


def place(folder: FilePath) -> None:
    """Make a folder that can be locked, or leave the one that there is as it is.

    Raises:
        StoreError: if it cannot be made, or holds something else than results.
    """
    try:
        if folder.exists() and not (folder / MANIFEST).exists():
            if any(not _begun(entry.name) for entry in folder.iterdir()):
                raise StoreError(f"{folder} holds something else and no {MANIFEST}; choose another")
            if any(part_files(folder)):
                raise StoreError(f"{folder} holds parts and no {MANIFEST}; choose another")
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise StoreError(f"cannot write to {folder}: {reason(error)}") from None


def _begun(name: str) -> bool:
    """Whether a file is what a run leaves that is killed before its first manifest."""
    return name in (LOCK, PARTS) or is_temporary(name)


def open_folder(
    folder: FilePath, experiment: Mapping[str, str], fresh: bool
) -> tuple[dict[str, Any] | None, list[str]]:
    """Make a folder ready for a run: mended, and of the same experiment.

    Args:
        folder: there, and locked by this process.
        experiment: name and text; what the folder holds already must be of the same.
        fresh: throw away the rows that the folder holds.

    Returns:
        The manifest of the run that it takes up, if any, and what was mended: a sentence each.

    Raises:
        StoreError: if the folder cannot be written, is of another schema, or a part is not ours.
    """
    refuse_link(folder / PARTS)
    try:
        if (folder / MANIFEST).exists() and not fresh:
            earlier = read_manifest(folder)
            check_same(folder, earlier["experiment"], experiment)
            # someone may have deleted it to begin anew; without it no row could be written
            (folder / PARTS).mkdir(exist_ok=True)
            return earlier, _mended(folder)
        (folder / PARTS).mkdir(parents=True, exist_ok=True)
        for part in part_files(folder):
            part.unlink()
    except OSError as error:
        raise StoreError(f"cannot write to {folder}: {reason(error)}") from None
    return None, []


def _mended(folder: FilePath) -> list[str]:
    """Put aside what is damaged and remove what a killed run left; all is read before."""
    damaged = [error.part for error in damaged_parts(folder)]
    # those that are under another's name, too: their rows are not known by it
    damaged += [
        part
        for part in filter(is_stream, part_files(folder))
        if part not in damaged and streamed_part(part) is None
    ]
    for place_of in (folder, folder / PARTS):
        tidy(place_of)
    return [
        f"{plain(str(part))} is damaged: moved to {plain(str(set_aside(folder, part)))}, its cells "
        "are solved again"
        for part in damaged
    ]


def done(folder: FilePath) -> set[Key]:
    """The keys of all single cells that a folder holds; those of streams are never read."""
    keys: set[Key] = set()
    for part in part_files(folder, streams=False):
        table = read_part(part, names(KEY))
        keys.update(zip(*(column.to_pylist() for column in table.columns), strict=True))
    return keys


def read_rows(folder: FilePath, columns: list[str] | None = None) -> pa.Table:
    """The rows of all single cells of a folder, each key once."""
    wanted = None if columns is None else list(dict.fromkeys((*names(KEY), *columns)))
    tables = [read_part(part, wanted) for part in part_files(folder, streams=False)]
    empty = ARROW_SCHEMA.empty_table()
    tables.append(empty if wanted is None else empty.select(wanted))
    return unique(pa.concat_tables(tables))


def counted(rows: pa.Table) -> Counter[tuple[str, str]]:
    """How many rows there are by solver and code."""
    found = rows.group_by(["solver", "code_digest"]).aggregate([([], "count_all")]).to_pylist()
    return Counter({(row["solver"], row["code_digest"]): row["count_all"] for row in found})


def unique(table: pa.Table) -> pa.Table:
    """The first row of every key: a run cut off while compacting leaves rows in two parts."""
    numbered = table.select(names(KEY)).append_column("row", pa.array(range(len(table))))
    first = numbered.group_by(names(KEY)).aggregate([("row", "min")])["row_min"]
    return table if len(first) == len(table) else table.take(first.combine_chunks().sort())


def compact(folder: FilePath, run_id: str) -> None:
    """Make one part of all single cells' parts, if there is room for it.

    A crash in the middle leaves rows twice.
    """
    parts = part_files(folder, streams=False)
    if len(parts) < 2:
        return
    rows = read_rows(folder)
    try:
        kept = write_part(folder, f"{run_id}-all", rows, {RUN_ID: run_id})
    except StoreError:  # a full disk: the many parts hold all that the one would
        return
    for part in parts:
        if part != kept:
            part.unlink()

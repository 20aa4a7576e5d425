"""The results folder: a manifest and immutable Parquet parts, written so that nothing is lost."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path as FilePath
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from experiments.rows import ARROW_SCHEMA
from study.schema import KEY, VERSION, Key, names

MANIFEST = "manifest.json"
PARTS = "parts"


class StoreError(ValueError):
    """A results folder that cannot be read or written; the message says which and why."""


def open_folder(
    folder: FilePath, experiment: Mapping[str, str], fresh: bool
) -> dict[str, Any] | None:
    """Make a folder ready for a run, and return the manifest of the run that it takes up, if any.

    Args:
        folder: made if it does not exist.
        experiment: name and text; what the folder holds already must be of the same.
        fresh: throw away the rows that the folder holds.

    Raises:
        StoreError: if the folder cannot be written, is of another schema, or holds something else.
    """
    try:
        if (folder / MANIFEST).exists() and not fresh:
            earlier = read_manifest(folder)
            _check_same(folder, earlier["experiment"], experiment)
            # someone may have deleted it to begin anew; without it no row could be written
            (folder / PARTS).mkdir(exist_ok=True)
            return earlier
        if folder.exists() and not (folder / MANIFEST).exists() and any(folder.iterdir()):
            raise StoreError(f"{folder} holds something else and no {MANIFEST}; choose another")
        (folder / PARTS).mkdir(parents=True, exist_ok=True)
        for part in _parts(folder):
            part.unlink()
    except OSError as error:
        raise StoreError(f"cannot write to {folder}: {error.strerror}") from None
    return None


def _check_same(folder: FilePath, old: Mapping[str, str], new: Mapping[str, str]) -> None:
    for key, what in (("name", "experiment"), ("text", "text of experiment")):
        if new[key] != old.get(key):
            raise StoreError(
                f"{folder} holds results of another {what} ({old.get(key)!r:.60}), not of "
                f"{new['name']!r} as it is now; choose another --out, or --fresh to throw them away"
            )


def read_manifest(folder: FilePath) -> dict[str, Any]:
    """The manifest of a results folder.

    Raises:
        StoreError: if there is none, or it is of another schema.
    """
    try:
        manifest = json.loads((folder / MANIFEST).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise StoreError(f"{folder} is no results folder: it has no {MANIFEST}") from None
    except OSError as error:
        raise StoreError(f"{folder / MANIFEST} cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise StoreError(f"{folder / MANIFEST} cannot be read: not JSON: {error}") from None
    _check_manifest(folder / MANIFEST, manifest)
    return dict(manifest)


def _check_manifest(file: FilePath, manifest: Any) -> None:
    """Refuse what a run or a status would stumble over."""
    if not isinstance(manifest, dict):
        raise StoreError(f"{file} holds {manifest!r:.60}; expected a JSON object")
    schema = manifest.get("schema")
    if schema != VERSION or isinstance(schema, bool):
        raise StoreError(f"{file} has schema {schema!r:.60}; expected {VERSION}")
    experiment, cells = manifest.get("experiment"), manifest.get("cells")
    if not (isinstance(experiment, dict) and {"name", "text"} <= experiment.keys()):
        raise StoreError(
            f"{file}: experiment is {experiment!r:.60}; expected an object with name and text"
        )
    if not isinstance(cells, int) or isinstance(cells, bool) or cells < 0:
        raise StoreError(f"{file}: cells is {cells!r:.60}; expected a whole number of at least 0")
    if not isinstance(manifest.get("solvers", {}), dict):
        raise StoreError(f"{file}: solvers is {manifest['solvers']!r:.60}; expected an object")
    for key in ("created", "finished"):
        if not isinstance(manifest.get(key), str | None):
            raise StoreError(f"{file}: {key} is {manifest[key]!r:.60}; expected a time or null")


def write_manifest(folder: FilePath, manifest: Mapping[str, Any]) -> None:
    """Replace the manifest in one step.

    Raises:
        StoreError: if the folder cannot be written.
    """
    text = json.dumps(manifest, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    try:
        _replace(folder / MANIFEST, text.encode("utf-8", "replace"))
    except OSError as error:
        raise StoreError(f"cannot write to {folder}: {error.strerror}") from None


def _replace(file: FilePath, content: bytes) -> None:
    temporary = file.with_name(f".{file.name}.{os.getpid()}")
    with temporary.open("wb") as stream:
        stream.write(content)
        stream.flush()
        os.fsync(stream.fileno())
    temporary.replace(file)


def _parts(folder: FilePath) -> list[FilePath]:
    return sorted((folder / PARTS).glob("*.parquet"))


def done(folder: FilePath) -> set[Key]:
    """The keys of all rows that a folder holds."""
    keys: set[Key] = set()
    for part in _parts(folder):
        table = _read(part, names(KEY))
        keys.update(zip(*(column.to_pylist() for column in table.columns), strict=True))
    return keys


def read_rows(folder: FilePath, columns: list[str] | None = None) -> pa.Table:
    """All rows of a folder, each key once."""
    wanted = None if columns is None else list(dict.fromkeys((*names(KEY), *columns)))
    tables = [_read(part, wanted) for part in _parts(folder)]
    empty = ARROW_SCHEMA.empty_table()
    tables.append(empty if wanted is None else empty.select(wanted))
    return _unique(pa.concat_tables(tables))


def by_code(rows: pa.Table, manifest: Mapping[str, Any]) -> tuple[pa.Table, int]:
    """The rows made by the code that the manifest names, and how many there are of other code."""
    solvers = manifest["solvers"]
    current = pa.array(
        [
            solvers.get(spec, {}).get("code") == code
            for spec, code in zip(rows["solver"].to_pylist(), rows["code"].to_pylist(), strict=True)
        ],
        pa.bool_(),
    )
    return rows.filter(current), len(rows) - (current.true_count or 0)


def _unique(table: pa.Table) -> pa.Table:
    """The first row of every key: a run cut off while compacting leaves rows in two parts."""
    numbered = table.select(names(KEY)).append_column("row", pa.array(range(len(table))))
    first = numbered.group_by(names(KEY)).aggregate([("row", "min")])["row_min"]
    return table if len(first) == len(table) else table.take(first.combine_chunks().sort())


def _read(part: FilePath, columns: list[str] | None) -> pa.Table:
    """A part's columns, all by default, as the schema has them."""
    wanted = columns or ARROW_SCHEMA.names
    try:
        held = pq.read_schema(part)
        missing = [name for name in wanted if name not in held.names]
        if missing:
            raise StoreError(
                f"{part} cannot be read: it has no column {missing[0]!r}; expected the columns of "
                "a results folder"
            )
        table = pq.read_table(part, columns=wanted)
    except OSError as error:
        reason = error.strerror or "it is damaged; delete it, and run again for its rows"
        raise StoreError(f"{part} cannot be read: {reason}") from None
    except pa.ArrowException:
        raise StoreError(
            f"{part} cannot be read: it is no Parquet file, or damaged; delete it, and run again "
            "for its rows"
        ) from None
    fields = [ARROW_SCHEMA.field(name) for name in wanted]
    return pa.table([_as(part, table, field) for field in fields], schema=pa.schema(fields))


def _as(part: FilePath, table: pa.Table, field: pa.Field) -> pa.ChunkedArray:
    column = table[field.name]
    if column.type == field.type:
        return column
    try:
        return column.cast(field.type)
    except pa.ArrowException:
        raise StoreError(
            f"{part} cannot be read: column {field.name!r} holds {column.type}; "
            f"expected {field.type}"
        ) from None


def write_part(folder: FilePath, name: str, table: pa.Table) -> FilePath:
    """Write a part that appears whole or not at all.

    Raises:
        StoreError: if the folder cannot be written, a full disk included.
    """
    final = folder / PARTS / f"{name}.parquet"
    temporary = final.with_name(f".{final.name}.{os.getpid()}")
    try:
        pq.write_table(table, temporary, compression="zstd")
        with temporary.open("rb") as stream:
            os.fsync(stream.fileno())
        temporary.replace(final)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        raise StoreError(f"cannot write {final}: {error.strerror or error}") from None
    return final


def compact(folder: FilePath, name: str) -> None:
    """Make one part of all parts. A crash in the middle leaves rows twice, never none."""
    parts = _parts(folder)
    if len(parts) < 2:
        return
    kept = write_part(folder, name, read_rows(folder))
    for part in parts:
        if part != kept:
            part.unlink()

"""The results folder: a manifest and immutable Parquet parts, written so that nothing is lost."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path as FilePath
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from study.schema import KEY, ROW, VERSION, Key, names

MANIFEST = "manifest.json"
PARTS = "parts"


class StoreError(ValueError):
    """A results folder that cannot be read or written; the message says which and why."""


_TYPES = {
    "string": pa.string(),
    "float64": pa.float64(),
    "int64": pa.int64(),
    "bool": pa.bool_(),
    "list<float64>": pa.list_(pa.float64()),
}
ARROW_SCHEMA = pa.schema([pa.field(column.name, _TYPES[column.type]) for column in ROW])


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
            _check_same(folder, earlier.get("experiment", {}), experiment)
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
    except (OSError, ValueError) as error:
        raise StoreError(f"{folder / MANIFEST} cannot be read: {error}") from None
    schema = manifest.get("schema") if isinstance(manifest, dict) else None
    if schema != VERSION:
        raise StoreError(f"{folder} has schema {schema!r}; expected {VERSION}")
    return dict(manifest)


def write_manifest(folder: FilePath, manifest: Mapping[str, Any]) -> None:
    """Replace the manifest in one step.

    Raises:
        StoreError: if the folder cannot be written.
    """
    text = json.dumps(manifest, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    try:
        _replace(folder / MANIFEST, text.encode())
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


def _unique(table: pa.Table) -> pa.Table:
    """The first row of every key: a run cut off while compacting leaves rows in two parts."""
    numbered = table.select(names(KEY)).append_column("row", pa.array(range(len(table))))
    first = numbered.group_by(names(KEY)).aggregate([("row", "min")])["row_min"]
    return table if len(first) == len(table) else table.take(first.combine_chunks().sort())


def _read(part: FilePath, columns: list[str] | None) -> pa.Table:
    try:
        return pq.read_table(part, columns=columns or ARROW_SCHEMA.names)
    except (OSError, pa.ArrowException) as error:
        raise StoreError(f"{part} cannot be read: {error}") from None


def rows_table(rows: Iterable[Mapping[str, Any]]) -> pa.Table:
    """Rows as a table of the schema; numbers that are not finite become null."""
    collected = list(rows)
    columns = [
        pa.array([_clean(row[field.name]) for row in collected], type=field.type)
        for field in ARROW_SCHEMA
    ]
    return pa.Table.from_arrays(columns, schema=ARROW_SCHEMA)


def _clean(value: Any) -> Any:
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, list):
        return [_clean(item) for item in value]
    return str(value) if isinstance(value, str) else value


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

"""Parts: immutable Parquet files of rows, each of which says what schema and run it is of."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import NoReturn

import pyarrow as pa
import pyarrow.parquet as pq

from dubins_study.experiments.store.disk import StoreError, put, reason, refuse_link
from dubins_study.study.rows.row_table import ARROW_SCHEMA
from dubins_study.study.rows.schema import CHUNK, VERSION, VERSION_KEY

PARTS, DAMAGED = "parts", "damaged"
# how parts of streams are named, of which no run reads more than the ends
STREAM = "stream-"
# key of the Parquet metadata, beside that of the schema's version
RUN_ID = "dubins-study run"

# what reading a file may raise: columns of types of other makers are read by these makers' code
_ANY = Exception
_ELSEWHERE = "it is none of this folder's parts, move it elsewhere"


class DamagedPartError(StoreError):
    """A part that was cut off or changed since it was written."""

    def __init__(self, part: FilePath, message: str) -> None:
        super().__init__(message)
        self.part = part


def part_files(folder: FilePath, *, streams: bool = True) -> list[FilePath]:
    """The parts of a folder, in the order of their names.

    Raises:
        StoreError: if one is a link, or the folder of parts is.
    """
    refuse_link(folder / PARTS)
    found = sorted((folder / PARTS).glob("*.parquet"))
    for part in found:
        refuse_link(part)
    return [part for part in found if streams or not is_stream(part)]


def is_stream(part: FilePath) -> bool:
    """Whether a part is of a stream, by its name."""
    return part.name.startswith(STREAM)


def write_part(
    folder: FilePath, name: str, table: pa.Table, metadata: Mapping[str, str] | None = None
) -> FilePath:
    """Write a part that appears whole or not at all.

    Args:
        folder: the results folder.
        name: the part's, without suffix.
        table: its rows; texts may be dictionaries.
        metadata: what the file says of itself besides its schema, such as the run under `RUN_ID`.

    Raises:
        StoreError: if the folder cannot be written, a full disk included.
    """
    final = folder / PARTS / f"{name}.parquet"
    # without Arrow's own schema a dictionary of texts is read as texts
    form = {"compression": "zstd", "write_page_checksum": True, "store_schema": False}

    def write(file: FilePath) -> None:
        with pq.ParquetWriter(file, table.schema, **form) as writer:
            writer.write_table(table)
            # which are lost from the table's own schema, if that is not stored
            writer.add_key_value_metadata({VERSION_KEY: str(VERSION), **(metadata or {})})

    refuse_link(final.parent)
    try:
        put(final, write)
    except OSError as error:
        raise StoreError(
            f"cannot write {final}: {reason(error)}; {len(table)} rows not written yet are lost, "
            "all others are kept: make room, and run again to go on"
        ) from None
    return final


def about_part(part: FilePath) -> dict[str, str]:
    """What a part says of itself: its schema, its run and whatever else it was written with.

    Raises:
        StoreError: if it cannot be read.
    """
    return footer(part)[0]


def footer(part: FilePath) -> tuple[dict[str, str], int]:
    """The same, and how many rows the part holds.

    Raises:
        StoreError: if it cannot be read.
    """
    file = _opened(part)
    return _about(file), int(file.metadata.num_rows)


def _about(file: pq.ParquetFile) -> dict[str, str]:
    return {
        key.decode("utf-8", "replace"): value.decode("utf-8", "replace")
        for key, value in (file.metadata.metadata or {}).items()
    }


def read_part(part: FilePath, columns: list[str] | None = None) -> pa.Table:
    """A part's columns, all by default, as the schema has them.

    Raises:
        DamagedPartError: if the file was cut off or changed.
        StoreError: if it is no part of this schema, or cannot be read at all.
    """
    wanted = columns or ARROW_SCHEMA.names
    file = _opened(part)
    _check_columns(part, file)
    try:
        table = file.read(columns=wanted)
        table.validate(full=True)  # texts that are no UTF-8 are found nowhere else
    except _ANY as error:
        _unreadable(part, error)
    fields = [ARROW_SCHEMA.field(name) for name in wanted]
    return pa.table([_as(part, table, field) for field in fields], schema=pa.schema(fields))


def check_part(part: FilePath) -> None:
    """Read a part whole, a piece at a time, and keep nothing of it.

    Raises:
        DamagedPartError, StoreError: as `read_part`.
    """
    file = _opened(part)
    _check_columns(part, file)
    try:
        for batch in file.iter_batches():
            piece = pa.Table.from_batches([batch])
            piece.validate(full=True)
            for field in ARROW_SCHEMA:
                _as(part, piece, field)
    except StoreError:
        raise
    except _ANY as error:
        _unreadable(part, error)


def damaged_parts(folder: FilePath) -> Iterator[DamagedPartError]:
    """Every part that is damaged; the streamed ones are only looked at from their ends.

    Raises:
        StoreError: if there is one that is no part of this schema.
    """
    for part in part_files(folder):
        try:
            if is_stream(part):
                _check_columns(part, _opened(part))
            else:
                check_part(part)
        except DamagedPartError as error:
            yield error


def set_aside(folder: FilePath, part: FilePath) -> FilePath:
    """Move a damaged part out of the way; it is never deleted.

    Raises:
        StoreError: if it cannot be moved.
    """
    place = folder / DAMAGED
    refuse_link(place)
    try:
        place.mkdir(exist_ok=True)
        target, number = place / part.name, 1
        while target.exists() or target.is_symlink():
            number += 1
            target = place / f"{part.stem}-{number}{part.suffix}"
        part.rename(target)
    except OSError as error:
        raise StoreError(f"cannot move {part} to {place}: {reason(error)}") from None
    return target


def _opened(part: FilePath) -> pq.ParquetFile:
    refuse_link(part)
    if not part.is_file():
        raise StoreError(f"{part} cannot be read: it is no file")
    try:
        return pq.ParquetFile(part, page_checksum_verification=True)
    except _ANY as error:
        _unreadable(part, error)


def _unreadable(part: FilePath, error: Exception) -> NoReturn:
    if isinstance(error, OSError) and error.errno is not None:
        raise StoreError(f"{part} cannot be read: {reason(error)}") from None
    remedy = "delete it, and run again" if is_stream(part) else "run again"
    raise DamagedPartError(
        part, f"{part} cannot be read: it is no Parquet file, or damaged; {remedy} for its rows"
    ) from None


def _check_columns(part: FilePath, file: pq.ParquetFile) -> None:
    columns, about = file.schema_arrow.names, _about(file)
    version = about.get(VERSION_KEY, str(VERSION))
    if CHUNK in about and not is_stream(part):  # its rows would count twice, beside the original
        raise StoreError(
            f"{part} holds a chunk of a stream under a name that is not its own: name it as it "
            f"was ({STREAM}...), or move it elsewhere"
        )
    if version != str(VERSION):
        raise StoreError(f"{part} is of schema {version!r:.60}; expected {VERSION}: {_ELSEWHERE}")
    problem = None
    if missing := [name for name in ARROW_SCHEMA.names if name not in columns]:
        problem = f"it has no column {missing[0]!r}"
    elif len(columns) != len(ARROW_SCHEMA.names):
        other = next((n for n in columns if n not in ARROW_SCHEMA.names), None)
        problem = "it has a column twice" if other is None else f"it has a column {other!r:.60}"
    if problem:
        raise StoreError(
            f"{part} cannot be read: {problem}; expected the columns of schema {VERSION}: "
            f"{_ELSEWHERE}"
        )


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

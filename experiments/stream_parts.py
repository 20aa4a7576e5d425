"""The parts of streams in a results folder: known by their names, counted by their metadata.

A streamed part holds one chunk of one stream. No key of its rows is ever looked at: which chunk it
is stands in the file's name and in its metadata, and a file whose metadata can be read and agrees
with its name is whole, since it was written to another name and renamed, and Parquet's metadata
come last.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import pyarrow as pa
import pyarrow.parquet as pq

from experiments.columns import Window

_NAME = re.compile(r"stream-([0-9a-f]{12})-(\d{11})-(\d{6})\.parquet")
_KEY = "dubins-study stream"


class Part(NamedTuple):
    """A chunk that is done.

    Args:
        stream: its `Stream.id`.
        window: which of the stream's rows it holds.
        solver, code: of all its rows.
        said: how many of its rows have each verdict.
    """

    file: FilePath
    stream: str
    window: Window
    solver: str
    code: str
    said: Mapping[str, int]


def part_name(stream: str, window: Window) -> str:
    """The stem of a chunk's file: names sort as the rows do."""
    first, count = window
    return f"stream-{stream}-{first:011d}-{count:06d}"


def is_streamed(part: FilePath) -> bool:
    """Whether a part's name is that of a stream's chunk."""
    return _NAME.fullmatch(part.name) is not None


def metadata(
    stream: str, window: Window, solver: str, code: str, said: Mapping[str, int]
) -> dict[str, str]:
    """What the file of a chunk says of itself."""
    first, count = window
    held = {"stream": stream, "first": first, "count": count, "solver": solver, "code": code}
    return {_KEY: json.dumps(held | {"said": dict(said)})}


def streamed_parts(folder: FilePath) -> Iterator[Part]:
    """The chunks that a folder holds whole, in the order of their names; no row is read."""
    for file in sorted((folder / "parts").glob("stream-*.parquet")):
        part = _read(file)
        if part is not None:
            yield part


def _read(file: FilePath) -> Part | None:
    """A chunk, or None where the file is damaged or another's: its rows are then solved again."""
    named = _NAME.fullmatch(file.name)
    try:
        footer = pq.read_metadata(file)
        held = json.loads((footer.metadata or {})[_KEY.encode()])
        part = _part(file, held)
        count = footer.num_rows
    except (OSError, pa.ArrowException, KeyError, ValueError, TypeError, RecursionError):
        return None
    agrees = part_name(part.stream, part.window) == file.stem and part.window[1] == count
    return part if named and agrees and sum(part.said.values()) == count else None


def _part(file: FilePath, held: Mapping[str, Any]) -> Part:
    said = {str(verdict): int(n) for verdict, n in held["said"].items()}
    window = int(held["first"]), int(held["count"])
    return Part(file, str(held["stream"]), window, str(held["solver"]), str(held["code"]), said)


def streamed_counts(folder: FilePath) -> dict[tuple[str, str], Counter[str]]:
    """Streamed rows of a folder by solver and code, and among them by verdict."""
    counts: dict[tuple[str, str], Counter[str]] = {}
    for part in streamed_parts(folder):
        counts.setdefault((part.solver, part.code), Counter()).update(part.said)
    return counts

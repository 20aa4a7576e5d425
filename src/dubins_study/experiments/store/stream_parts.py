"""The parts of streams in a results folder: known by their names, counted by their metadata.

A streamed part holds one chunk of one stream. No row of it is read again by a run: which chunk it
is, and how many rows of which kind it holds, stand in its name and in its metadata. A file whose
metadata can be read and agrees with its name is whole, since it was put in its place in one step,
and Parquet's metadata come last.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path as FilePath
from typing import Any, NamedTuple

import pyarrow as pa

from dubins_study.experiments.plan.scenario_columns import Window
from dubins_study.experiments.store.disk import StoreError
from dubins_study.experiments.store.manifest import is_count
from dubins_study.experiments.store.parts import RUN_ID, STREAM, footer, is_stream, part_files
from dubins_study.study.rows.schema import CHUNK

_KINDS = ("outcome", "verdict")


class Kind(NamedTuple):
    """So many rows of one outcome and verdict, and the seconds that they took in all."""

    outcome: str
    verdict: str
    rows: int
    wall: float


class Part(NamedTuple):
    """A chunk that is done.

    Args:
        stream: its `Stream.id`.
        window: which of the stream's rows it holds.
        solver, code, run_id: of all its rows.
        kinds: what its rows are.
    """

    file: FilePath
    stream: str
    window: Window
    solver: str
    code_digest: str
    run_id: str
    kinds: tuple[Kind, ...]


def part_name(stream: str, window: Window) -> str:
    """The stem of a chunk's file: names sort as the rows do."""
    first, count = window
    return f"{STREAM}{stream}-{first:011d}-{count:06d}"


def metadata(
    table: pa.Table, stream: str, window: Window, about: Mapping[str, str], run_id: str
) -> dict[str, str]:
    """What the file of a chunk says of itself.

    Args:
        table: its rows.
        stream: `Stream.id`.
        window: which of the stream's rows they are.
        about: the stream's `question`, `solver` and `code`.
        run_id: of the run that writes them.
    """
    first, count = window
    held = {"stream": stream, **about, "first": first, "count": count, "kinds": _kinds(table)}
    return {RUN_ID: run_id, CHUNK: json.dumps(held)}


def _kinds(table: pa.Table) -> list[Kind]:
    grouped = table.group_by(_KINDS).aggregate([([], "count_all"), ("wall_s", "sum")])
    return [
        Kind(row["outcome"], row["verdict"], row["count_all"], row["wall_s_sum"] or 0.0)
        for row in grouped.to_pylist()
    ]


def streamed_parts(folder: FilePath) -> Iterator[Part]:
    """The chunks that a folder holds whole, in the order of their names; no row is read.

    Raises:
        StoreError: if one is a link.
    """
    for file in filter(is_stream, part_files(folder)):
        part = streamed_part(file)
        if part is not None:
            yield part


def streamed_part(file: FilePath) -> Part | None:
    """A chunk, or None where the file is damaged or another's: its rows are then solved again."""
    try:
        about, count = footer(file)
        part = _part(file, json.loads(about[CHUNK]), about.get(RUN_ID, ""))
    except (StoreError, KeyError, ValueError, TypeError, OverflowError, RecursionError):
        return None
    agrees = part_name(part.stream, part.window) == file.stem and part.window[1] == count
    return part if agrees and sum(kind.rows for kind in part.kinds) == count else None


def _part(file: FilePath, held: Mapping[str, Any], run_id: str) -> Part:
    kinds = tuple(_kind(*given) for given in held["kinds"])
    window = int(held["first"]), int(held["count"])
    solver, code = str(held["solver"]), str(held["code_digest"])
    return Part(file, str(held["stream"]), window, solver, code, run_id, kinds)


def _kind(outcome: Any, verdict: Any, rows: Any, wall: Any) -> Kind:
    """A kind as a file tells it, whoever wrote that."""
    if not is_count(rows) or not math.isfinite(wall):
        raise ValueError
    return Kind(str(outcome), str(verdict), rows, float(wall))


def streamed_counts(folder: FilePath) -> Counter[tuple[str, str]]:
    """Streamed rows of a folder by solver and code."""
    counts = Counter[tuple[str, str]]()
    for part in streamed_parts(folder):
        counts[part.solver, part.code_digest] += part.window[1]
    return counts

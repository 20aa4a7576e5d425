"""Rows counted by kind, part by part, whatever their number."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import NamedTuple

import pyarrow as pa

from dubins_study.experiments.store.folder import unique
from dubins_study.experiments.store.parts import DamagedPartError, is_stream, part_files, read_part
from dubins_study.experiments.store.stream_parts import streamed_part
from dubins_study.study.rows.row_table import ARROW_SCHEMA
from dubins_study.study.rows.schema import KEY, names

_TOLD = ("solver", "code_digest", "outcome", "verdict", "run_id")


class Tally(NamedTuple):
    """So many rows of one kind, and the seconds that their solves took in all."""

    solver: str
    code_digest: str
    outcome: str
    verdict: str
    run_id: str
    rows: int
    wall: float


def counted(folder: FilePath) -> tuple[list[Tally], int]:
    """All rows of a folder by kind, and how many parts cannot be read."""
    single: list[pa.Table] = []
    found: list[Tally] = []
    damaged = 0
    columns = list(dict.fromkeys((*names(KEY), *_TOLD, "wall_s")))
    for part in part_files(folder):
        if is_stream(part):
            told = _streamed(part)
            found += told
            damaged += not told
            continue
        try:
            single.append(read_part(part, columns))
        except DamagedPartError:
            damaged += 1
    empty = pa.schema([ARROW_SCHEMA.field(name) for name in columns]).empty_table()
    found += _counted(unique(pa.concat_tables([*single, empty])))
    return found, damaged


def _streamed(part: FilePath) -> list[Tally]:
    """What a streamed part says of its rows, however many; nothing if it is damaged."""
    held = streamed_part(part)
    if held is None:
        return []
    made = (held.solver, held.code_digest)
    return [Tally(*made, k.outcome, k.verdict, held.run_id, k.rows, k.wall) for k in held.kinds]


def _counted(table: pa.Table) -> Iterator[Tally]:
    grouped = table.group_by(list(_TOLD)).aggregate([([], "count_all"), ("wall_s", "sum")])
    for row in grouped.to_pylist():
        solver, code_digest, outcome, verdict, run_id = (str(row[name]) for name in _TOLD)
        rows, wall = int(row["count_all"]), float(row["wall_s_sum"] or 0.0)
        yield Tally(solver, code_digest, outcome, verdict, run_id, rows, wall)

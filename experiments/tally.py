"""Rows counted by kind, part by part, whatever their number."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import NamedTuple

import pyarrow as pa

from experiments.parts import DamagedPartError, is_stream, part_files, read_part
from experiments.rows import ARROW_SCHEMA
from experiments.store import unique
from study.schema import KEY, names

_TOLD = ("solver", "code", "outcome", "verdict", "run_id")


class Tally(NamedTuple):
    """So many rows of one kind, and the seconds that their solves took in all."""

    solver: str
    code: str
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
    for part in part_files(folder):
        own = _TOLD if is_stream(part) else (*names(KEY), *_TOLD)
        try:
            table = read_part(part, list(dict.fromkeys((*own, "wall_s"))))
        except DamagedPartError:
            damaged += 1
            continue
        if is_stream(part):
            found += _counted(table)
        else:
            single.append(table)
    columns = list(dict.fromkeys((*names(KEY), *_TOLD, "wall_s")))
    empty = pa.schema([ARROW_SCHEMA.field(name) for name in columns]).empty_table()
    found += _counted(unique(pa.concat_tables([*single, empty])))
    return found, damaged


def _counted(table: pa.Table) -> Iterator[Tally]:
    grouped = table.group_by(list(_TOLD)).aggregate([([], "count_all"), ("wall_s", "sum")])
    for row in grouped.to_pylist():
        solver, code, outcome, verdict, run_id = (str(row[name]) for name in _TOLD)
        rows, wall = int(row["count_all"]), float(row["wall_s_sum"] or 0.0)
        yield Tally(solver, code, outcome, verdict, run_id, rows, wall)

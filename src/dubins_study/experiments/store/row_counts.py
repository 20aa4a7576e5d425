"""How many rows of which kind a results folder holds, whatever their number."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path as FilePath
from typing import NamedTuple

import pyarrow as pa

from dubins_study.experiments.store.folder import unique_rows
from dubins_study.study.rows.files import DamagedPartError
from dubins_study.study.rows.parts import Part, is_stream, part_files, read_footer, read_part
from dubins_study.study.rows.row_table import ARROW_SCHEMA
from dubins_study.study.rows.schema import KEY, names

_KIND = ("solver", "code_digest", "outcome", "verdict", "run_id")


class RowCount(NamedTuple):
    """The rows of one kind: how many, and the seconds that their solves took together."""

    solver: str
    code_digest: str
    outcome: str
    verdict: str
    run_id: str
    rows: int
    wall_s: float


def count_rows(folder: FilePath) -> tuple[list[RowCount], int]:
    """Count a folder's rows by kind, each cell once; of streams only metadata are read.

    Returns:
        The counts, and how many parts are damaged and therefore not counted.

    Raises:
        ResultsError: if a part is of another schema, or cannot be read.
    """
    columns = list(dict.fromkeys((*names(KEY), *_KIND, "wall_s")))
    tables = [ARROW_SCHEMA.empty_table().select(columns)]
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
    counts += _table_counts(unique_rows(pa.concat_tables(tables)))
    return counts, damaged


def _chunk_counts(part: Part) -> Iterator[RowCount]:
    if (chunk := part.chunk) is not None:
        for kind in chunk.kinds:
            made_by = (chunk.solver, chunk.code_digest)
            yield RowCount(
                *made_by, kind.outcome, kind.verdict, part.run_id, kind.rows, kind.wall_s
            )


def _table_counts(table: pa.Table) -> Iterator[RowCount]:
    grouped = table.group_by(list(_KIND)).aggregate([([], "count_all"), ("wall_s", "sum")])
    for row in grouped.to_pylist():
        solver, code_digest, outcome, verdict, run_id = (str(row[name]) for name in _KIND)
        rows, wall_s = int(row["count_all"]), float(row["wall_s_sum"] or 0.0)
        yield RowCount(solver, code_digest, outcome, verdict, run_id, rows, wall_s)

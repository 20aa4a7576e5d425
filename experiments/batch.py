"""Many cells at once, where a solver answers whole frames."""

from __future__ import annotations

import json
from collections import defaultdict
from typing import Any

import pyarrow as pa

from experiments.grid import Cell, Chain
from experiments.isolation import THREADS
from experiments.judging import Run, shared
from experiments.provenance import now, versions
from experiments.rows import ARROW_SCHEMA
from solvers.registry import load
from study.scenario import scenario_frame
from study.schema import KEY, names

# below this many cells of a kind one row at a time is quick enough, and each has its own time
SMALLEST = 2000


def batched(groups: list[Chain]) -> tuple[list[list[Cell]], list[Chain]]:
    """Chains parted into batches (cells of one solver and branch) and those solved one by one."""
    kinds: dict[tuple[Any, ...], list[Chain]] = defaultdict(list)
    for group in groups:
        kinds[group[0].key[1:]].append(group)
    batches, single = [], []
    for alike in kinds.values():
        first = alike[0][0]
        if len(alike) >= SMALLEST and first.start == "cold" and _takes_frames(first):
            batches.append([cell for group in alike for cell in group])
        else:
            single += alike
    return batches, single


def _takes_frames(cell: Cell) -> bool:
    return hasattr(load(cell.solver, cell.profile), "solve_frame")


def solve_batch(cells: list[Cell], run: Run) -> pa.Table:
    """The rows of a batch; every row's times are the batch's divided by its size."""
    import numba

    from solvers.frame import solve_frame

    first, started = cells[0], now()
    threads = numba.get_num_threads()
    numba.set_num_threads(THREADS)
    try:
        answers = solve_frame(
            scenario_frame(cell.scenario for cell in cells),
            solver=first.solver,
            branch=first.branch,
            profile=first.profile,
            limit=run.limit,
            certified=True,
        )
    finally:
        numba.set_num_threads(threads)
    table = pa.Table.from_pandas(answers, preserve_index=False)
    by_name: dict[str, pa.Array] = {name: table[name] for name in table.column_names}
    for position, name in enumerate(names(KEY)):
        by_name[name] = pa.array([cell[position] for cell in cells])
    for name, value in shared(run, started, _versions(first.solver)).items():
        by_name[name] = pa.repeat(value, len(cells))
    arrays = [_cast(by_name[field.name], field.type) for field in ARROW_SCHEMA]
    return pa.Table.from_arrays(arrays, schema=ARROW_SCHEMA)


def _cast(column: Any, kind: pa.DataType) -> Any:
    chunked = column if isinstance(column, pa.ChunkedArray) else pa.chunked_array([column])
    return chunked.cast(kind)


def _versions(spec: str) -> str:
    return json.dumps(versions(tuple(load(spec).packages)))

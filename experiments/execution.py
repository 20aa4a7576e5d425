"""Solve the cells that are left: chain by chain, by the run's engine."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path as FilePath

from experiments.engine import Engine, Probed
from experiments.grid import Chain, shuffled
from experiments.interruption import Interruption
from experiments.isolation import pinned_threads
from experiments.judging import Run
from experiments.rows import row_key, row_path
from experiments.store import read_rows
from experiments.watch import Bounds
from experiments.writer import Writer
from study.path import Path
from study.schema import Key


def solve_left(
    folder: FilePath,
    groups: list[Chain],
    finished: set[Key],
    seed: int,
    shared: Run,
    bounds: Bounds,
    writer: Writer,
    stop: Interruption,
    engine: Engine,
    probed: Probed | None = None,
) -> None:
    """Attempt every cell whose key is not finished; the writer gets the rows as they come.

    Raises:
        KeyboardInterrupt: if the run is interrupted.
        RunError: if the engine cannot go on.
    """
    left = [_left(group, finished) for group in groups]
    writer.skip(sum(map(len, groups)) - sum(map(len, left)))
    single = [group for group in left if group]
    before = _paths_before(folder, single, groups)
    ordered = shuffled(single, seed)
    if ordered:
        with pinned_threads(), engine.crew(shared, bounds, probed) as crew:
            for rows in crew.solve(ordered, before, stop):
                writer.add(rows)
    stop.check()


def _left(group: Chain, finished: set[Key]) -> Chain:
    return tuple(cell for cell in group if cell.key not in finished)


def _paths_before(folder: FilePath, left: list[Chain], groups: list[Chain]) -> dict[Key, Path]:
    """For every chain cut short: the path of the last cell done before the first one left."""
    cut = {group[0].key for group in left if group[0].start == "warm"}
    before = {
        cell.key: previous.key
        for group in groups
        for previous, cell in pairwise(group)
        if cell.key in cut
    }
    if not before:
        return {}
    columns = ["x", "y", "heading", "gap", "curvatures", "lengths"]
    rows = read_rows(folder, columns).to_pylist()
    paths = {row_key(row): row_path(row) for row in rows}
    found = {key: paths.get(previous) for key, previous in before.items()}
    return {key: path for key, path in found.items() if path is not None}

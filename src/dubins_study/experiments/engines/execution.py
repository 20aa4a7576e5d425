"""Solve the cells that are left: chain by chain, by the run's engine."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from pathlib import Path as FilePath

from dubins_study.experiments.engines.chains import remaining_chains
from dubins_study.experiments.engines.engine import Engine
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.sandbox import pinned_threads
from dubins_study.experiments.plan.cells import Chain, shuffled
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.experiments.store.folder import read_rows
from dubins_study.experiments.store.part_writer import PartWriter
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import row_key, row_path
from dubins_study.study.rows.schema import Key


def solve_left(
    folder: FilePath,
    chains: list[Chain],
    finished: set[Key],
    settings: RunSettings,
    writer: PartWriter,
    stop: Interruption,
    engine: Engine,
    probed: Callable[[float, int], None] | None = None,
) -> None:
    """Attempt every cell whose key is not finished; the writer gets the rows as they come.

    Raises:
        KeyboardInterrupt: if the run is interrupted.
        RunError: if the engine cannot go on.
    """
    left, before = _unfinished(folder, chains, finished)
    writer.skip(sum(map(len, chains)) - sum(map(len, left)))
    ordered = shuffled(left, settings.seed)
    if ordered:
        batches = engine.solve(ordered, before, settings, stop, probed)
        with pinned_threads(), closing(batches):
            for rows in batches:
                writer.add(rows)
    stop.check()


def _unfinished(
    folder: FilePath, chains: list[Chain], finished: set[Key]
) -> tuple[list[Chain], dict[Key, Path]]:
    """What the folder lacks of every chain, and the paths before; see `remaining_chains`."""
    done: dict[Key, Path | None] = dict.fromkeys(finished)
    if any(cell.initial_guess == "warm" and cell.key in done for chain in chains for cell in chain):
        columns = ["x", "y", "heading", "gap", "curvatures", "lengths"]
        rows = read_rows(folder, columns).to_pylist()
        done |= {row_key(row): row_path(row) for row in rows}
    return remaining_chains(chains, {}, done)

"""Solve the cells that are left: chain by chain, by the run's engine."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path as FilePath

from dubins_study.experiments.engines.engine import Engine, Probed
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
    groups: list[Chain],
    finished: set[Key],
    settings: RunSettings,
    writer: PartWriter,
    stop: Interruption,
    engine: Engine,
    probed: Probed | None = None,
) -> None:
    """Attempt every cell whose key is not finished; the writer gets the rows as they come.

    Raises:
        KeyboardInterrupt: if the run is interrupted.
        RunError: if the engine cannot go on.
    """
    single, before = _unfinished(folder, groups, finished)
    writer.skip(sum(map(len, groups)) - sum(map(len, single)))
    ordered = shuffled(single, settings.seed)
    if ordered:
        with pinned_threads(), engine.crew(settings, probed) as crew:
            for rows in crew.solve(ordered, before, stop):
                writer.add(rows)
    stop.check()


def _unfinished(
    folder: FilePath, groups: list[Chain], finished: set[Key]
) -> tuple[list[Chain], dict[Key, Path]]:
    """What is left of every chain, in pieces where cells between are done, and the paths before.

    After a failure the last path that was found serves on, as in a run that is not interrupted.
    """
    begun = any(
        cell.initial_guess == "warm" and cell.key in finished for group in groups for cell in group
    )
    columns = ["x", "y", "heading", "gap", "curvatures", "lengths"]
    rows = read_rows(folder, columns).to_pylist() if begun else []
    found = {row_key(row): row_path(row) for row in rows}
    left: list[Chain] = []
    before: dict[Key, Path] = {}
    for group in groups:
        path: Path | None = None
        for done, cells in groupby(group, lambda cell: cell.key in finished):
            piece = tuple(cells)
            if done:
                path = next(filter(None, (found.get(cell.key) for cell in piece[::-1])), path)
                continue
            left.append(piece)
            if path is not None:
                before[piece[0].key] = path
    return left, before

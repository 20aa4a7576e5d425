"""Who solves the cells of a run, and which cells the results folder still lacks."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import closing
from pathlib import Path as FilePath
from typing import Any, Protocol, Self

from dubins_study.experiments.engines.work_unit import WorkUnit
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.sandbox import pinned_threads
from dubins_study.experiments.plan.cells import Chain, shuffled
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.experiments.store.folder import read_rows
from dubins_study.experiments.store.part_writer import PartWriter
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row, row_key, row_path
from dubins_study.study.rows.schema import Key

# called with the seconds that a fixed piece of work took, and the number of the machine that did it
# (0 for this one)
Probe = Callable[[float, int], None]


class Engine(Protocol):
    """Where a run's cells are solved, for as long as it is entered.

    Attributes:
        jobs: how many cells are solved side by side.
        run_entry: what the run's entry in the manifest holds of it.
    """

    jobs: int
    run_entry: dict[str, Any]

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...

    def solve(
        self, unit: WorkUnit, stop: Interruption, probed: Probe | None
    ) -> Generator[list[Row], None, None]:
        """The rows of all cells as they come; see `local.solve_chains`.

        Args:
            probed: called every few seconds, if it is given.
        """


def solve_unfinished(
    engine: Engine, unit: WorkUnit, writer: PartWriter, stop: Interruption, probed: Probe
) -> None:
    """Solve a unit's cells in the run's order; the writer gets the rows as they come.

    Raises:
        KeyboardInterrupt: if the run is interrupted.
        RunError: if the engine cannot go on.
    """
    if unit.chains:
        ordered = unit._replace(chains=shuffled(unit.chains, unit.settings.seed))
        with pinned_threads(), closing(engine.solve(ordered, stop, probed)) as row_blocks:
            for rows in row_blocks:
                writer.add(rows)
    stop.check()


def unfinished(
    folder: FilePath, chains: list[Chain], finished: set[Key], settings: RunSettings
) -> WorkUnit:
    """What a results folder lacks of every chain, and the paths before.

    Args:
        finished: the keys of the cells that the folder holds.
    """
    done: dict[Key, Path | None] = dict.fromkeys(finished)
    if any(cell.initial_guess == "warm" and cell.key in done for chain in chains for cell in chain):
        columns = ["x", "y", "heading", "gap", "curvatures", "lengths"]
        rows = read_rows(folder, columns).to_pylist()
        done |= {row_key(row): row_path(row) for row in rows}
    return WorkUnit(settings, chains, {}).remaining(done)

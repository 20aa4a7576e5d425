"""Who solves the cells of a run, and which cells the results folder still lacks."""

from __future__ import annotations

from collections.abc import Callable, Generator
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.experiments.engines.work_unit import WorkUnit
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.plan.cells import Chain, shuffled
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.experiments.store.folder import read_rows
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row, row_key, row_path
from dubins_study.study.rows.schema import Key

# called with the seconds that a fixed piece of work took, and the number of the machine that did it
# (0 for this one)
Probe = Callable[[float, int], None]


class Engine(NamedTuple):
    """Where a run's cells are solved, as long as the context that yields it is entered.

    Args:
        jobs: how many cells are solved side by side.
        run_entry: what the run's entry in the manifest holds of it.
        solve: the rows of all cells of a unit as they come; see `local.solve_chains`. The probe is
            called every few seconds, if it is given.
    """

    jobs: int
    run_entry: dict[str, Any]
    solve: Callable[[WorkUnit, Interruption, Probe | None], Generator[list[Row], None, None]]


def unfinished(
    folder: FilePath, chains: list[Chain], finished: set[Key], settings: RunSettings
) -> WorkUnit:
    """What a results folder lacks of every chain, in the order of the run, and the paths before.

    Args:
        finished: the keys of the cells that the folder holds.
    """
    done: dict[Key, Path | None] = dict.fromkeys(finished)
    if any(cell.initial_guess == "warm" and cell.key in done for chain in chains for cell in chain):
        columns = ["x", "y", "heading", "gap", "curvatures", "lengths"]
        rows = read_rows(folder, columns).to_pylist()
        done |= {row_key(row): row_path(row) for row in rows}
    left = WorkUnit(settings, chains, {}).remaining(done)
    return left._replace(chains=shuffled(left.chains, settings.seed))

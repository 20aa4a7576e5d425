"""What an executor is, and what it solves: work units, which hold chains of cells."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from itertools import groupby
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.plan.cells import Chain, shuffled
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.experiments.store.folder import read_rows
from dubins_study.study.path import Path
from dubins_study.study.rows.parts import Row, row_key, row_path
from dubins_study.study.rows.schema import Key


class WorkUnit(NamedTuple):
    """Cells of one run: all unsolved cells, or as many as one Dask task gets."""

    settings: RunSettings
    # Single cells, and sweeps, in which each warm cell starts from the previous path.
    chains: list[Chain]
    # Key of a chain's first cell -> last path earlier in its sweep, if there is one.
    before: Mapping[Key, Path]

    def remaining(self, done: Mapping[Key, Path | None]) -> WorkUnit:
        """The cells that are not done. A chain with done cells in between is cut into pieces.

        The path of a done cell is None if it did not arrive. After such a failure the earlier path
        stays the initial guess, as in an uninterrupted run.
        """
        pieces: list[Chain] = []
        before: dict[Key, Path] = {}
        for chain in self.chains:
            path = self.before.get(chain[0].key)
            for is_done, cells in groupby(chain, lambda cell: cell.key in done):
                piece = tuple(cells)
                if is_done:
                    path = next(filter(None, (done[cell.key] for cell in reversed(piece))), path)
                    continue
                pieces.append(piece)
                if path is not None:
                    before[piece[0].key] = path
        return WorkUnit(self.settings, pieces, before)


# Called with the duration (s) of a calibration probe and the number of its machine (0: this one).
Probed = Callable[[float, int], None]


class Executor(NamedTuple):
    """What solves a run's cells; usable until the `with` block that provides it ends."""

    # How many cells are solved at the same time.
    jobs: int
    # Fields about the executor for the run's entry in the manifest.
    run_entry: dict[str, Any]
    # Yields the rows of a unit's cells as they come; calls the probe every few seconds.
    solve: Callable[[WorkUnit, Interruption, Probed], Generator[list[Row], None, None]]


def unfinished(
    folder: FilePath, chains: list[Chain], finished: set[Key], settings: RunSettings
) -> WorkUnit:
    """The cells that a results folder lacks, in the order of the run, with their initial paths."""
    done: dict[Key, Path | None] = dict.fromkeys(finished)
    if any(cell.initial_guess == "warm" and cell.key in done for chain in chains for cell in chain):
        columns = ["x", "y", "heading", "gap", "curvatures", "lengths"]
        rows = read_rows(folder, columns).to_pylist()
        done |= {row_key(row): row_path(row) for row in rows}
    left = WorkUnit(settings, chains, {}).remaining(done)
    return left._replace(chains=shuffled(left.chains, settings.seed))

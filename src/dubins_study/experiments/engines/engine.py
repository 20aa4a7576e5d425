"""What an engine is, and what it solves: chains of cells, and what is left of them."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from itertools import groupby
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.plan.cells import Cell, Chain, given_guess, shuffled
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.experiments.store.folder import read_rows
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row, row_key, row_path
from dubins_study.study.rows.schema import Key


class WorkUnit(NamedTuple):
    """Cells of one run: all that are left, or as many as one Dask task solves.

    Args:
        settings: of the run.
        chains: single cells, and sweeps whose warm cells each start from the path before.
        before: the path before the first cell of a chain, by that cell's key, where there is one.
    """

    settings: RunSettings
    chains: list[Chain]
    before: Mapping[Key, Path]

    @property
    def cells(self) -> int:
        """How many cells there are."""
        return sum(map(len, self.chains))

    def remaining(self, done: Mapping[Key, Path | None]) -> WorkUnit:
        """What is left of the chains, in pieces where cells between are done.

        Args:
            done: the cells that are done, by their keys, with their paths if they arrived. After
                a failure the last path that arrived serves on, as in a run without interruption.
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


class ChainState(NamedTuple):
    """The place of a chain's next cell, and the last path that arrived before it."""

    chain: Chain
    place: int
    path: Path | None

    @property
    def cell(self) -> Cell:
        return self.chain[self.place]

    def initial_guess(self) -> Path | None:
        return self.path if self.cell.initial_guess == "warm" else given_guess(self.cell)

    def after(self, path: Path | None) -> ChainState | None:
        """The state once the cell is attempted, if another one follows.

        Args:
            path: the cell's, if it arrived; after a failure the last path before serves on.
        """
        if self.place + 1 == len(self.chain):
            return None
        return ChainState(self.chain, self.place + 1, path or self.path)


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

"""Executors, and the work units that they solve.

A unit holds chains of cells.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator
from typing import Any, NamedTuple

from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.plan.cells import Chain
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.study.rows.parts import Row
from dubins_study.study.rows.schema import Key


class WorkUnit(NamedTuple):
    """Cells of one run that are handed over together.

    The local executor gets all unsolved cells, a Dask task some of them.
    """

    settings: RunSettings
    # Single cells, and sweeps, in which each warm cell starts from the previous path.
    chains: list[Chain]

    def remaining(self, done: Collection[Key]) -> WorkUnit:
        """The chains with a cell that is not done.

        A sweep is solved again as a whole.
        """
        unsolved = [chain for chain in self.chains if any(cell.key not in done for cell in chain)]
        return self._replace(chains=unsolved)


# Called with the duration (s) of a calibration probe and the number of its machine (0: this one).
Probed = Callable[[float, int], None]


class Executor(NamedTuple):
    """A way to solve a run's cells.

    An executor is provided by a `with` block, and usable until the block ends.
    """

    # How many cells are solved at the same time.
    jobs: int
    # Fields about the executor for the run's entry in the manifest.
    run_entry: dict[str, Any]
    # Yields the rows of a unit's cells as they come; calls the probe every few seconds.
    solve: Callable[[WorkUnit, Interruption, Probed], Generator[list[Row], None, None]]

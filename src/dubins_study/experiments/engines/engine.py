"""Who solves the cells of a run: worker processes of this machine, or a Dask cluster's."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import Any, NamedTuple, Protocol

from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.supervisor import Supervisor
from dubins_study.experiments.isolation.watch import Bounds
from dubins_study.experiments.plan.cells import Chain
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row
from dubins_study.study.rows.schema import Key


class Probed(Protocol):
    """Told that a fixed piece of work took so many seconds, on which of several machines."""

    def __call__(self, seconds: float, machine: int = 0) -> None: ...


class Crew(Protocol):
    """What solves the cells of one run; `experiments.isolation.supervisor.Supervisor` is one."""

    def solve(
        self, chains: list[Chain], before: Mapping[Key, Path], stop: Interruption
    ) -> Iterator[list[Row]]:
        """The rows of all cells as they come; see `Supervisor.solve`."""


class Engine(Protocol):
    """Where a run's cells are solved, for as long as it is entered."""

    @property
    def jobs(self) -> int:
        """How many cells are solved side by side."""

    @property
    def said(self) -> dict[str, Any]:
        """What the run's entry in the manifest tells of it beside."""

    def crew(self, run: RunSettings, probed: Probed | None) -> AbstractContextManager[Crew]:
        """Get ready to solve cells; until then nothing is started that takes long.

        Args:
            run: the settings of the run.
            probed: called now and then.

        Raises:
            RunError: if nobody can be made ready.
        """


class _Local(NamedTuple):
    jobs: int
    said: dict[str, Any]

    def crew(self, run: RunSettings, probed: Probed | None) -> AbstractContextManager[Crew]:
        bounds = Bounds(run.time_limit_s, run.memory_limit_bytes)
        return Supervisor(run, bounds, self.jobs, probed)


def _local(jobs: int, scheduler: str | None) -> AbstractContextManager[Engine]:
    return nullcontext(_Local(jobs, {}))


def _dask(jobs: int, scheduler: str | None) -> AbstractContextManager[Engine]:
    # only here: `distributed` is an extra, and takes half a second to import
    from dubins_study.experiments.engines.dask_engine import DaskEngine

    return DaskEngine(jobs, scheduler)


# by name: made of the number of jobs and the address of a scheduler
ENGINES: dict[str, Callable[[int, str | None], AbstractContextManager[Engine]]] = {
    "local": _local,
    "dask": _dask,
}

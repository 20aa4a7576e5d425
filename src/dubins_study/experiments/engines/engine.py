"""Who solves the cells of a run: worker processes of this machine, or a Dask cluster's."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Protocol, Self

from dubins_study.experiments.engines.judging import Run
from dubins_study.experiments.engines.rows import Row
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.monitor import Limits
from dubins_study.experiments.plan.cells import Chain
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Key

ENGINES = ("local", "dask")


class Probed(Protocol):
    """Told that a fixed piece of work took so many seconds, on which of several machines."""

    def __call__(self, seconds: float, machine: int = 0) -> None: ...


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
        self,
        chains: list[Chain],
        before: Mapping[Key, Path],
        run: Run,
        limits: Limits,
        stop: Interruption,
        probed: Probed | None,
    ) -> Iterator[list[Row]]:
        """The rows of all cells as they come; see `local.solve_chains`.

        Args:
            limits: of every solve.
            probed: called now and then.
        """


def make_engine(name: str, jobs: int, scheduler: str | None) -> Engine:
    """An engine by its name; it is started when it is entered.

    Args:
        name: one of `ENGINES`.
        jobs: processes that solve side by side.
        scheduler: the address of Dask's scheduler.
    """
    if name == "local":
        from dubins_study.experiments.engines.local import LocalEngine

        return LocalEngine(jobs)
    # only here: `distributed` is an extra, and takes half a second to import
    from dubins_study.experiments.engines.dask_engine import DaskEngine

    return DaskEngine(jobs, scheduler)

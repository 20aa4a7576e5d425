"""Who solves the cells of a run: worker processes of this machine, or a Dask cluster's."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from typing import Any, Protocol, Self

from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.plan.cells import Chain
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row
from dubins_study.study.rows.schema import Key


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
        settings: RunSettings,
        stop: Interruption,
        probed: Callable[[float, int], None] | None,
    ) -> Generator[list[Row], None, None]:
        """The rows of all cells as they come; see `local.solve_chains`.

        Args:
            probed: called every few seconds with the seconds that a fixed piece of work took,
                and the number of the machine that did it (0 for this one).
        """


def make_engine(name: str, jobs: int, scheduler: str | None) -> Engine:
    """An engine by its name; it is started when it is entered.

    Args:
        name: one of `run_settings.ENGINE_NAMES`.
        jobs: processes that solve side by side.
        scheduler: the address of Dask's scheduler.
    """
    if name == "local":
        from dubins_study.experiments.engines.local import LocalEngine

        return LocalEngine(jobs)
    # only here: `distributed` is an extra, and takes half a second to import
    from dubins_study.experiments.engines.dask_engine import DaskEngine

    return DaskEngine(jobs, scheduler)

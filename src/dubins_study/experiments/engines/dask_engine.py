"""A Dask cluster as the engine of a run: one that is there, or one started for it here."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack
from typing import Any, Self

from dubins_study.experiments.engines.dask_client import connected, installed, quiet
from dubins_study.experiments.engines.dask_crew import DaskCrew
from dubins_study.experiments.engines.dask_host import local_cluster
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.plan.cells import Chain
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row
from dubins_study.study.rows.schema import Key

_LOG = logging.getLogger(__name__)


class DaskEngine:
    """A Dask cluster for as long as it is entered: that of an address, or one of this machine.

    Args:
        jobs: worker processes of this machine, where no address is given.
        scheduler: the address of a scheduler.

    Raises:
        RunError: if `distributed` is not installed or the scheduler does not answer; on entering.
    """

    def __init__(self, jobs: int, scheduler: str | None):
        self.jobs, self._scheduler = jobs, scheduler
        self.run_entry: dict[str, Any] = {}
        self._client: Any = None
        self._leaving = ExitStack()

    def __enter__(self) -> Self:
        with ExitStack() as entered:
            version = installed()
            entered.enter_context(quiet())
            workers = self.jobs
            if self._scheduler is not None:
                self._client = entered.enter_context(connected(self._scheduler))
                threads = self._client.nthreads()
                workers, self.jobs = len(threads), max(1, sum(threads.values()))
            self.run_entry = {"workers": workers, "distributed": version}
            self._leaving = entered.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._leaving.close()

    def solve(
        self,
        chains: list[Chain],
        before: Mapping[Key, Path],
        settings: RunSettings,
        stop: Interruption,
        probed: Callable[[float, int], None] | None,
    ) -> Generator[list[Row], None, None]:
        """See `Engine.solve`; workers of this machine are started first."""
        with ExitStack() as entered:
            client = self._client
            if client is None:
                host = entered.enter_context(local_cluster(self.jobs))
                client = entered.enter_context(connected(host.address))
                _LOG.warning("dubins-study: Dask's dashboard is at %s", host.dashboard)
            crew = DaskCrew(client, settings, probed)
            entered.callback(crew.close)
            yield from crew.solve(chains, before, stop)

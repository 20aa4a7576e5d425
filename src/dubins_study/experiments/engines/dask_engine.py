"""A Dask cluster as the engine of a run: one that is there, or one started for it here."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from typing import Any, Self

from dubins_study.experiments.engines.dask_client import connected, installed, quiet
from dubins_study.experiments.engines.dask_crew import DaskCrew
from dubins_study.experiments.engines.dask_host import local_cluster
from dubins_study.experiments.engines.engine import Probed
from dubins_study.experiments.run_settings import RunSettings

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
        self.said: dict[str, Any] = {}
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
            self.said = {"workers": workers, "distributed": version}
            self._leaving = entered.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._leaving.close()

    @contextmanager
    def crew(self, run: RunSettings, probed: Probed | None) -> Iterator[DaskCrew]:
        """Workers that are there; those of this machine are started."""
        with ExitStack() as entered:
            client = self._client
            if client is None:
                host = entered.enter_context(local_cluster(self.jobs))
                client = entered.enter_context(connected(host.address))
                _LOG.warning("dubins-study: Dask's dashboard is at %s", host.dashboard)
            crew = DaskCrew(client, run, probed)
            try:
                yield crew
            finally:
                crew.close()

"""The cells of one run solved by a Dask cluster: chunks out, rows back."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from itertools import count
from queue import Empty, SimpleQueue
from threading import Thread
from time import monotonic
from typing import Any, NamedTuple

from dubins_study.experiments.engines.chains import remaining_chains
from dubins_study.experiments.engines.dask_call import LOST, everywhere, returned, there
from dubins_study.experiments.engines.work_unit import Chunk, encoded, rows_received
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import RunError
from dubins_study.experiments.plan.cells import Chain
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row, row_key, row_path
from dubins_study.study.rows.schema import Key

_LOG = logging.getLogger(__name__)

# The most cells in a chunk. A worker hands a chunk back after a second with what is left of it, so
# this only has to keep it busy for that long where cells take a few milliseconds; less would send
# more messages (some milliseconds each), more would send cells to and fro where solves are slow.
_MOST = 256
# Towards the end a chunk is this share of what each thread has left, so that all end together.
_SHARE = 4
# chunks in flight for every thread: one that is solved, one that waits beside it
_FLYING = 2
# of a chunk whose solving raised; a worker that dies is Dask's own to count (allowed-failures)
_RETRIES = 1
# s without news after which whoever writes the rows is given a turn
_TURN = 0.2
# s between two looks at how many workers there are, which may come and go
_LOOK = 1.0
# s for workers to be told something
_TELL = 10.0


class _Flight(NamedTuple):
    """A chunk that somebody is solving."""

    future: Any
    chunk: Chunk


class DaskCrew:
    """The workers of a cluster, as far as one run is concerned."""

    def __init__(self, client: Any, run: RunSettings, probed: Callable[[float, int], None] | None):
        self._client, self._run, self._probed = client, run, probed
        # whose names are recorded nowhere: they are numbered as their first probes arrive
        self._machines: dict[str, int] = {}
        self._ended: SimpleQueue[Any] = SimpleQueue()
        self._numbers = count()
        self._flights: dict[str, _Flight] = {}
        self._waiting: deque[Chain] = deque()
        self._before: dict[Key, Path] = {}
        self._left = 0
        self._threads, self._looked = 0, float("-inf")
        self._told_waiting = False

    def solve(
        self, chains: list[Chain], before: Mapping[Key, Path], stop: Interruption
    ) -> Iterator[list[Row]]:
        """The rows of all cells as they come; an empty list now and then where none do.

        Once the run is interrupted, only what is being solved is finished.

        Raises:
            RunError: if a worker's code is not that of the cells, a chunk ends every worker that
                takes it, or the scheduler has gone.
        """
        self._waiting, self._before = deque(chains), dict(before)
        self._left = sum(map(len, chains))
        halting = False
        while self._waiting or self._flights:
            if stop.asked and not halting:
                halting = True
                self._halt()
                continue
            if not halting:
                self._feed()
            yield from self._news(halting)

    def _feed(self) -> None:
        if monotonic() - self._looked > _LOOK:
            self._look()
        while self._waiting and len(self._flights) < _FLYING * max(1, self._threads):
            chunk = self._next()
            name = f"dubins-study-{self._run.run_id}-{next(self._numbers)}"
            future = self._client.submit(
                there("solve_chunk"), encoded(chunk), key=name, pure=False, retries=_RETRIES
            )
            self._flights[name] = _Flight(future, chunk)
            future.add_done_callback(self._ended.put)

    def _look(self) -> None:
        """How many threads there are now."""
        if self._client.status not in ("running", "connecting"):
            raise RunError(LOST)
        with suppress(OSError, TimeoutError):  # lost, perhaps for a moment: seen again next time
            self._threads = sum(self._client.nthreads().values())
        self._looked = monotonic()
        if self._threads == 0 and not self._told_waiting:
            self._told_waiting = True
            _LOG.warning("dubins-study: the Dask scheduler has no workers; waiting for the first")

    def _next(self) -> Chunk:
        most = max(1, min(_MOST, self._left // (_SHARE * max(1, self._threads))))
        taken: list[Chain] = []
        paths: dict[Key, Path] = {}
        while self._waiting and most > 0:
            chain = self._waiting.popleft()
            taken.append(chain)
            most -= len(chain)
            self._left -= len(chain)
            if chain[0].key in self._before:
                paths[chain[0].key] = self._before.pop(chain[0].key)
        return Chunk(self._run, taken, paths)

    def _news(self, halting: bool) -> Iterator[list[Row]]:
        try:
            future = self._ended.get(timeout=_TURN)
        except Empty:
            yield []
            return
        flight = self._flights.get(future.key)
        if flight is None:
            return
        if future.status != "cancelled" and not future.done():
            self._later(future)  # the worker that held the rows has died: they are made again
            return
        try:
            sent = returned(future, flight.chunk)
        except TimeoutError:
            self._later(future)
            return
        del self._flights[future.key]
        rows = self._checked(flight.chunk, sent.rows)
        if self._probed is not None:
            for seconds in sent.probes:
                number = self._machines.setdefault(sent.machine, len(self._machines) + 1)
                self._probed(seconds, number)
        yield rows
        if sent.refusal:
            raise RunError(f"{sent.refusal}; the rows written so far are kept")
        if not halting:
            self._take_back(flight.chunk, rows)

    def _later(self, future: Any) -> None:
        future.add_done_callback(self._ended.put)

    def _checked(self, chunk: Chunk, sent: bytes) -> list[Row]:
        """The rows of a chunk: of its own cells, each once."""
        rows = rows_received(sent) if sent else []
        asked = {cell.key for chain in chunk.chains for cell in chain}
        found = {row_key(row) for row in rows}
        if len(found) < len(rows) or not found <= asked:
            raise RunError("a Dask worker returned rows that it was not asked for; none was kept")
        return rows

    def _take_back(self, chunk: Chunk, rows: list[Row]) -> None:
        """What a worker has handed back is the next to be solved."""
        left, before = remaining_chains(
            chunk.chains, chunk.before, {row_key(row): row_path(row) for row in rows}
        )
        if left and not rows:
            raise RunError("a Dask worker solved nothing of what it was asked")
        self._waiting.extendleft(reversed(left))
        self._before |= before
        self._left += sum(map(len, left))

    def _halt(self) -> None:
        """Workers finish what they are at; what nobody is at is forgotten."""
        self._waiting.clear()
        self._tell("halt")
        with suppress(OSError, TimeoutError):
            held = {str(key) for keys in self._client.processing().values() for key in keys}
            for name in self._flights.keys() - held:
                if not self._flights[name].future.done():
                    self._flights.pop(name).future.cancel()

    def _tell(self, what: str) -> None:
        """Call a function of `experiments.engines.dask_worker` with the run's id in every worker.

        From a thread, since a worker that does not answer is not waited for.
        """
        asked = (self._client, what, self._run.run_id)
        telling = Thread(target=everywhere, args=asked, daemon=True)
        telling.start()
        telling.join(_TELL)

    def close(self) -> None:
        """Nothing is solved any more for this run."""
        if self._flights:
            with suppress(Exception):
                self._client.cancel([flight.future for flight in self._flights.values()])
            self._flights.clear()
        self._tell("end")

"""The code in a Dask worker: solve work units.

The worker keeps its own pools between units. A unit travels as bytes, which a worker without this
package can receive, and rows travel as an Arrow table. No object of a plug-in's classes travels.
"""

from __future__ import annotations

import pickle
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import chain
from pathlib import Path as FilePath
from time import monotonic
from typing import Any, NamedTuple

import pyarrow as pa

from dubins_study.experiments.executors.executor import WorkUnit
from dubins_study.experiments.executors.local import solve_chains
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import RunError, WorkerPool
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.study.rows.parts import Row, rows_table

# Seconds after which a unit is returned, even if cells are left. Rows are written every second, and
# near the end of a run no worker must wait for a unit of slow solvers.
_UNIT_S = 1.0
_PACKAGE = FilePath(__file__).parents[2]


def in_worker(name: str) -> Callable[[Any], Any]:
    """A function that calls one of this module's functions.

    Dask sends the returned function as code, so that a worker without this package raises
    ImportError. A module's function is sent by its name: this would end the connection of such a
    worker, and the run would wait forever.
    """

    def call(argument: Any) -> Any:
        from importlib import import_module

        module = import_module("dubins_study.experiments.executors.dask_worker")
        return getattr(module, name)(argument)

    return call


class UnitReply(NamedTuple):
    """A Dask worker's reply to a work unit."""

    rows: pa.Table  # of the cells that were solved
    refusal: str  # why this worker must not solve the rest of the unit; empty if it may
    machine: str  # the name of the worker's machine
    probes_s: list[float]  # seconds that each calibration probe took on that machine


def _source_files() -> frozenset[tuple[str, int, int]]:
    """The files that answers depend on.

    A file is a tuple of its name, modification time (ns) and size (bytes).
    """
    rooms = ("study", "solvers", "experiments")
    files = chain.from_iterable((_PACKAGE / room).rglob("*.py") for room in rooms)
    return frozenset((f.name, f.stat().st_mtime_ns, f.stat().st_size) for f in files)


# The files as this process imported them: they may change while a Dask worker lives for weeks.
_IMPORTED = _source_files()


class _Run:
    """The pools of one run in this process.

    There are as many pools as units that are solved at the same time.
    """

    def __init__(self) -> None:
        self.stop = Interruption()
        self.probes_s: list[float] = []
        self._busy: list[WorkerPool] = []
        self._idle: list[WorkerPool] = []

    @contextmanager
    def pool(self, settings: RunSettings) -> Iterator[WorkerPool]:
        """Yield a pool of one worker process.

        An idle pool is taken, or a new one is made. After the block the pool is idle again; it is
        closed if the block failed or the run is stopped.
        """
        try:
            pool = self._idle.pop()
        except IndexError:
            pool = WorkerPool(1, settings.memory_limit_gib, probed=self.probes_s.append)
        self._busy.append(pool)
        usable = False
        try:
            yield pool
            usable = not self.stop.requested
        finally:
            self._busy.remove(pool)
            if usable:
                self._idle.append(pool)
            else:
                pool.__exit__()

    def end(self) -> None:
        """End all idle processes.

        Once the run is stopped, processes that are solving are ended too.
        """
        while self._idle:
            self._idle.pop().__exit__()
        if self.stop.requested:
            for pool in [*self._busy]:
                pool.kill_workers()  # the thread that uses the pool closes it


_runs: dict[str, _Run] = {}


def _run(run_id: str) -> _Run:
    """The pools of a run, made at first call.

    That call also ends the idle processes of other runs.
    """
    if run_id not in _runs:
        for other in list(_runs.values()):  # the client of an earlier run may have been killed
            other.end()
    return _runs.setdefault(run_id, _Run())


def stop_run(run_id: str) -> None:
    """Let current solves finish; start no further cell."""
    _run(run_id).stop.requested = True


def end_run(run_id: str) -> None:
    """Kill a run's solves and end its processes."""
    stop_run(run_id)
    _run(run_id).end()


def solve_unit(message: bytes) -> UnitReply:
    """Solve cells of a pickled unit for a second.

    At least one cell is solved. The reply has the rows so far; the caller sends the rest again.
    """
    unit: WorkUnit = pickle.loads(message)
    run = _run(unit.settings.run_id)
    machine = socket.gethostname()
    rows: list[Row] = []
    refusal = ""
    end_s = monotonic() + _UNIT_S
    try:
        if _source_files() != _IMPORTED:
            raise RunError("dubins-study was changed since the worker started; restart it")
        with run.pool(unit.settings) as pool:
            for row_block in solve_chains(pool, unit, run.stop):
                rows += row_block
                if rows and monotonic() > end_s:
                    pool.begin_no_more()
    except RunError as error:
        refusal = f"on the Dask worker on {machine}, {error}"
    probes_s = [*run.probes_s]
    run.probes_s.clear()
    return UnitReply(rows_table(rows), refusal, machine, probes_s)

"""What a Dask worker does: solve work units by pools of its own, kept from one unit to the next.

The functions that a run calls in a worker: `solve_unit`, `stop_run` and `end_run`.
"""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path as FilePath
from queue import Empty, SimpleQueue
from time import monotonic
from typing import NamedTuple

from dubins_study.experiments.engines.chains import remaining_chains
from dubins_study.experiments.engines.local import limits, solve_chains
from dubins_study.experiments.engines.work_unit import (
    UnitReply,
    WorkUnit,
    decoded,
    encoded_rows,
    first_cells,
)
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import RunError, WorkerPool
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.rows.row_table import Row, row_key, row_path

# After this a unit is returned with what is left of it: rows are written every second, and a unit
# of slow solvers must not keep other workers waiting at the end.
_UNIT_S = 1.0
# cells that are solved before the clock is read again: twice as many each time that they were quick
_FIRST_CELLS, _QUICK_S = 8, 0.2

_PACKAGE = FilePath(__file__).parents[2]


def _source_files() -> frozenset[tuple[str, int, int]]:
    """Name, time and size of the files that answers depend on, as they are on disk."""
    rooms = ("study", "solvers", "experiments")
    files = [file for room in rooms for file in (_PACKAGE / room).rglob("*.py")]
    return frozenset((f.name, f.stat().st_mtime_ns, f.stat().st_size) for f in files)


# as this process imported them; a Dask worker may live for weeks
_IMPORTED = _source_files()


class _Pool(NamedTuple):
    """One worker process, and the probes that were not returned yet."""

    workers: WorkerPool
    probes_s: list[float]


class _Run:
    """The pools of one run in this process: one for every unit that is solved at the same time."""

    def __init__(self) -> None:
        self.stop = Interruption()
        self._pools: list[_Pool] = []
        self._idle: SimpleQueue[_Pool] = SimpleQueue()

    @contextmanager
    def pool(self, settings: RunSettings) -> Iterator[_Pool]:
        """A pool that is idle, or a new one."""
        try:
            pool = self._idle.get_nowait()
        except Empty:
            probes_s: list[float] = []
            workers = WorkerPool(1, limits(settings), probed=probes_s.append)
            pool = _Pool(workers.__enter__(), probes_s)
            self._pools.append(pool)
        usable = False
        try:
            yield pool
            usable = not self.stop.requested
        finally:
            if usable:
                self._idle.put(pool)
            else:
                pool.workers.__exit__()
                self._pools.remove(pool)

    def close_idle(self) -> None:
        """End the processes that solve nothing."""
        with suppress(Empty):
            while True:
                pool = self._idle.get_nowait()
                pool.workers.__exit__()
                self._pools.remove(pool)

    def kill(self) -> None:
        """End all processes; those that solve something are closed by their own threads."""
        for pool in list(self._pools):
            pool.workers.kill_workers()


_runs: dict[str, _Run] = {}


def _run(run_id: str) -> _Run:
    if run_id not in _runs:
        for other in list(_runs.values()):  # whose client may have been killed
            other.close_idle()
    return _runs.setdefault(run_id, _Run())


def solve_unit(message: bytes) -> UnitReply:
    """Solve the cells of an encoded work unit for about a second, at least one of them."""
    unit, machine = decoded(message), socket.gethostname()
    run = _run(unit.settings.run_id)
    rows: list[Row] = []
    probes_s: list[float] = []
    refusal = _refusal(unit)
    try:
        if not refusal:
            with run.pool(unit.settings) as pool:
                for row_block in _solved(unit, pool.workers, run.stop):
                    rows += row_block
                probes_s += pool.probes_s
                pool.probes_s.clear()
    except RunError as error:
        refusal = str(error)
    if refusal:
        refusal = f"on the Dask worker on {machine}, {refusal}"
    return UnitReply(encoded_rows(rows) if rows else b"", refusal, machine, probes_s)


def stop_run(run_id: str) -> None:
    """Finish the cells that are being solved for a run; start no other."""
    _run(run_id).stop.requested = True


def end_run(run_id: str) -> None:
    """End what is being solved for a run, and its idle processes."""
    run = _run(run_id)
    run.stop.requested = True
    run.close_idle()
    run.kill()


def _solved(unit: WorkUnit, workers: WorkerPool, stop: Interruption) -> Iterator[list[Row]]:
    """Rows of a unit's first cells, piece by piece until its time is over."""
    end_s = monotonic() + _UNIT_S
    left, before, cells = unit.chains, dict(unit.before), _FIRST_CELLS
    while left and not stop.requested and monotonic() < end_s:
        began_s = monotonic()
        rows: list[Row] = []
        for row_block in solve_chains(
            workers, first_cells(left, cells), before, unit.settings, stop
        ):
            rows += row_block
        yield rows
        done = {row_key(row): row_path(row) for row in rows}
        left, before = remaining_chains(left, before, done)
        cells *= 2 if monotonic() - began_s < _QUICK_S else 1


def _refusal(unit: WorkUnit) -> str:
    """Why this process must not solve a unit; empty if it may."""
    if _source_files() != _IMPORTED:
        return "dubins-study was changed since the worker started; restart it"
    for spec in dict.fromkeys(chain[0].solver for chain in unit.chains):
        file, colon, _ = spec.partition("[")[0].strip().rpartition(":")
        if colon and file.endswith(".py") and not FilePath(file).is_file():
            return (
                f"there is no file {file!r} for the solver {spec!r}; expected it at the same path "
                "on every machine (see docs/scaling.md)"
            )
    return ""

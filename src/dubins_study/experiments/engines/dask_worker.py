"""What a Dask worker does: solve work units by pools of its own, kept from one unit to the next.

The functions that a run calls in a worker: `solve_unit`, `stop_run` and `end_run`. Cells travel
there as JSON and rows back as Arrow tables, so that no object of a plug-in travels.
"""

from __future__ import annotations

import json
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath
from time import monotonic
from typing import NamedTuple

import pyarrow as pa

from dubins_study.experiments.engines.local import limits, solve_chains
from dubins_study.experiments.engines.work_unit import WorkUnit
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import RunError, WorkerPool
from dubins_study.experiments.plan.cells import Cell
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.path import Path
from dubins_study.study.rows.row_table import Row, rows_table
from dubins_study.study.rows.schema import SCENARIO, names
from dubins_study.study.scenario import Pose, Scenario

# After this a unit is returned with what is left of it: rows are written every second, and a unit
# of slow solvers must not keep other workers waiting at the end.
_UNIT_S = 1.0
_SCENARIO = names(SCENARIO)
_PACKAGE = FilePath(__file__).parents[2]


class UnitReply(NamedTuple):
    """What a Dask worker returns of a work unit.

    Args:
        rows: of some of the unit's cells.
        refusal: why this worker solves no more of the unit; empty if it does.
        machine: the name of the worker's machine.
        probes_s: seconds that the calibration's piece of work took there.
    """

    rows: pa.Table
    refusal: str
    machine: str
    probes_s: list[float]


def encoded(unit: WorkUnit) -> bytes:
    """A work unit as JSON, which keeps every double to the last bit."""
    chains = [
        [[*cell.key, [getattr(cell.scenario, name) for name in _SCENARIO]] for cell in chain]
        for chain in unit.chains
    ]
    firsts = [unit.before.get(chain[0].key) for chain in unit.chains]
    paths = [p and [[*p.start], p.curvature.tolist(), p.length.tolist()] for p in firsts]
    return json.dumps([[*unit.settings], chains, paths]).encode()


def decoded(message: bytes) -> WorkUnit:
    """The work unit that `encoded` made a message of."""
    settings, encoded_chains, paths = json.loads(message)
    chains = [
        tuple(
            Cell._make([*key, Scenario(**dict(zip(_SCENARIO, values, strict=True)))])
            for *key, values in cells
        )
        for cells in encoded_chains
    ]
    before = {
        chain[0].key: Path(Pose(*path[0]), path[1], path[2])
        for chain, path in zip(chains, paths, strict=True)
        if path is not None
    }
    return WorkUnit(RunSettings(*settings), chains, before)


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
        self.stopped = False
        self._busy: list[_Pool] = []
        self._idle: list[_Pool] = []

    @contextmanager
    def pool(self, settings: RunSettings) -> Iterator[_Pool]:
        """A pool that is idle, or a new one."""
        try:
            pool = self._idle.pop()
        except IndexError:
            probes_s: list[float] = []
            workers = WorkerPool(1, limits(settings), probed=probes_s.append)
            pool = _Pool(workers.__enter__(), probes_s)
        self._busy.append(pool)
        usable = False
        try:
            yield pool
            usable = not self.stopped
        finally:
            self._busy.remove(pool)
            if usable:
                self._idle.append(pool)
            else:
                pool.workers.__exit__()

    def end(self) -> None:
        """End all processes; a pool that solves something is closed by its own thread."""
        while self._idle:
            self._idle.pop().workers.__exit__()
        for pool in [*self._busy] if self.stopped else ():
            pool.workers.kill_workers()


_runs: dict[str, _Run] = {}


def _run(run_id: str) -> _Run:
    if run_id not in _runs:
        for other in list(_runs.values()):  # whose client may have been killed
            other.end()
    return _runs.setdefault(run_id, _Run())


def stop_run(run_id: str) -> None:
    """Finish the cells that are being solved for a run; start no other."""
    _run(run_id).stopped = True


def end_run(run_id: str) -> None:
    """End what is being solved for a run, and its idle processes."""
    stop_run(run_id)
    _run(run_id).end()


def solve_unit(message: bytes) -> UnitReply:
    """Solve the cells of an encoded work unit for about a second, at least one of them."""
    unit, machine = decoded(message), socket.gethostname()
    run, stop = _run(unit.settings.run_id), Interruption()
    rows: list[Row] = []
    probes_s: list[float] = []
    refusal = _refusal(unit)
    end_s = monotonic() + _UNIT_S
    try:
        if not refusal:
            with run.pool(unit.settings) as pool:
                stop.requested = run.stopped
                for row_block in solve_chains(pool.workers, unit, stop):
                    rows += row_block
                    stop.requested = run.stopped or (bool(rows) and monotonic() > end_s)
                probes_s += pool.probes_s
                pool.probes_s.clear()
    except RunError as error:
        refusal = str(error)
    if refusal:
        refusal = f"on the Dask worker on {machine}, {refusal}"
    return UnitReply(rows_table(rows), refusal, machine, probes_s)


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

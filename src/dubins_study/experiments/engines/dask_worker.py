"""What a Dask worker does: solve chunks by worker processes of its own, kept between chunks."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.util import Finalize
from pathlib import Path as FilePath
from time import monotonic

from dubins_study.experiments.engines.chains import remaining_chains
from dubins_study.experiments.engines.local import limits, solve_chains
from dubins_study.experiments.engines.work_unit import (
    Chunk,
    Returned,
    decoded,
    first_cells,
    rows_sent,
)
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import RunError, WorkerPool
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.study.rows.row_table import Row, row_key, row_path

# s after which a chunk is handed back, with what is left of it: rows are written every second, and
# a chunk of solvers that take their time must not keep other workers waiting at the end
_TURN = 1.0
# cells between two looks at the time, at first; twice as many each time that they took so little
_PIECE, _QUICK = 8, 0.2

_ROOT = FilePath(__file__).parents[2]


def _sources() -> frozenset[tuple[str, int, int]]:
    """Our own files as they are on disk."""
    files = [file for part in ("study", "solvers", "experiments") for file in _py(_ROOT / part)]
    return frozenset((f.name, f.stat().st_mtime_ns, f.stat().st_size) for f in files)


def _py(folder: FilePath) -> Iterator[FilePath]:
    return folder.rglob("*.py")


# as this process imported them; a Dask worker may live for weeks
_IMPORTED = _sources()


class _Bench:
    """The worker pools of this process: one for every chunk that is solved at the same time."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._idle: list[tuple[RunSettings, WorkerPool]] = []
        self._busy: list[tuple[RunSettings, WorkerPool]] = []
        self._stops: dict[str, Interruption] = {}
        self._probes: dict[str, list[float]] = {}  # by run, those that were not sent yet
        # a Dask worker that is told to close; one that is killed takes its processes with it
        Finalize(None, self.clear, exitpriority=100)

    def stop(self, run_id: str) -> Interruption:
        """What the chunks of a run ask whether to go on."""
        with self._lock:
            return self._stops.setdefault(run_id, Interruption())

    @contextmanager
    def pool(self, settings: RunSettings) -> Iterator[WorkerPool]:
        """A pool of this run; those of other runs that nobody uses are closed."""
        with self._lock:
            others = [one for one in self._idle if one[0] != settings]
            self._idle = [one for one in self._idle if one[0] == settings]
            entry = self._idle.pop() if self._idle else None
        _close(others)
        if entry is None:
            pool = WorkerPool(1, limits(settings), probed=self._probed(settings.run_id))
            entry = settings, pool
        with self._lock:
            self._busy.append(entry)
        sound = False
        try:
            yield entry[1]
            sound = not self.stop(settings.run_id).asked
        finally:
            with self._lock:
                self._busy.remove(entry)
                self._idle += [entry] if sound else []
            _close([] if sound else [entry])

    def _probed(self, run_id: str) -> Callable[[float], None]:
        def note(seconds: float) -> None:
            with self._lock:
                self._probes.setdefault(run_id, []).append(seconds)

        return note

    def probes(self, run_id: str) -> list[float]:
        """How fast this machine was lately; forgotten by this."""
        with self._lock:
            return self._probes.pop(run_id, [])

    def end(self, run_id: str) -> None:
        """What is being solved for a run is ended; its pools are closed."""
        self.stop(run_id).asked = True
        with self._lock:
            mine = [one for one in self._idle if one[0].run_id == run_id]
            self._idle = [one for one in self._idle if one not in mine]
            self._probes.pop(run_id, None)
            busy = [one for one in self._busy if one[0].run_id == run_id]
        _close(mine)
        for _, pool in busy:
            pool.kill_workers()

    def clear(self) -> None:
        with self._lock:
            mine, self._idle = self._idle, []
        _close(mine)


def _close(entries: list[tuple[RunSettings, WorkerPool]]) -> None:
    for _, pool in entries:
        pool.__exit__()


_bench = _Bench()


def solve_chunk(sent: bytes) -> Returned:
    """Solve the cells of a chunk for about a second, at least one of them."""
    chunk, machine = decoded(sent), socket.gethostname()
    refusal = _refusal(chunk)
    if refusal:
        return Returned(b"", f"on the Dask worker on {machine}, {refusal}", machine, [])
    rows: list[Row] = []
    try:
        with _bench.pool(chunk.run) as pool:
            for some in _solved(chunk, pool, _bench.stop(chunk.run.run_id)):
                rows += some
    except RunError as error:
        refusal = f"on the Dask worker on {machine}, {error}"
    return Returned(rows_sent(rows), refusal, machine, _bench.probes(chunk.run.run_id))


def _solved(chunk: Chunk, pool: WorkerPool, stop: Interruption) -> Iterator[list[Row]]:
    began = monotonic()
    left, before, most = chunk.chains, dict(chunk.before), _PIECE
    while left and not stop.asked and monotonic() - began < _TURN:
        piece = monotonic()
        found: list[Row] = []
        for rows in solve_chains(pool, first_cells(left, most), before, chunk.run, stop):
            found += rows
        yield found
        done = {row_key(row): row_path(row) for row in found}
        left, before = remaining_chains(left, before, done)
        most *= 2 if monotonic() - piece < _QUICK else 1


def _refusal(chunk: Chunk) -> str:
    """Why this process must not solve a chunk, or nothing."""
    if _sources() != _IMPORTED:
        return "dubins-study was changed since the worker started; restart it"
    for spec in dict.fromkeys(chain[0].solver for chain in chunk.chains):
        file, colon, _ = spec.partition("[")[0].strip().rpartition(":")
        if colon and file.endswith(".py") and not FilePath(file).is_file():
            return (
                f"there is no file {file!r} for the solver {spec!r}; expected it at the same path "
                "on every machine (see docs/scaling.md)"
            )
    return ""


def halt(run_id: str) -> None:
    """The chunks of a run finish what is being solved and start nothing more."""
    _bench.stop(run_id).asked = True


def end(run_id: str) -> None:
    """Nothing more is solved for a run, nor finished."""
    _bench.end(run_id)

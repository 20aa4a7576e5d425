"""The monitor of a pool: it finds workers that take too long or use too much memory."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from time import monotonic, process_time, sleep
from typing import NamedTuple

import psutil

from dubins_study.experiments.isolation.worker_process import WorkerProcess
from dubins_study.experiments.isolation.worker_status import Phase, Reading
from dubins_study.solvers.reply import Reply, Times, no_answer
from dubins_study.study.words import Outcome

# Seconds between two looks at the workers.
POLL_INTERVAL_S = 0.02
# Seconds beyond the time limit: a solver that respects the limit needs a moment to send its answer.
# With the poll interval and the kill itself, a solve ends within 0.3 s of its limit.
GRACE_S = 0.1
# Seconds that a process may take to start, or a solver to load.
_START_UP_S = 60.0
# Seconds that a warm-up may take beyond the time limit: it loads what later solves find loaded.
_WARM_UP_S = 10.0
# Seconds within which an idle worker must begin its next job.
_STALL_S = 10.0
# The memory of a worker's children is read at every tenth look only: listing them takes
# milliseconds if many processes run.
_LOOKS_PER_CHILDREN_CHECK = 10
# A pause between two looks longer than this means that the whole process was suspended.
_SUSPENDED_S = 1.0
# Seconds by which a look may be late on a busy machine.
_LATE_S = 10.0
_GIB = 2**30

_ACTIVITY = {
    Phase.STARTING: "starting a worker",
    Phase.IDLE: "waiting for its answer to arrive",
    Phase.LOADING: "loading the solver",
    Phase.WARMING_UP: "warming up",
}


class Limits(NamedTuple):
    """Seconds that a solve may take, and bytes that a worker and its children may use."""

    time_s: float
    memory_bytes: int


class _Observation(NamedTuple):
    """A worker's status, when it was first seen, and the total suspended time until then."""

    reading: Reading
    seen_s: float
    suspended_s: float


class Monitor:
    """Looks at workers and reports which of them break a limit."""

    def __init__(self, limits: Limits):
        self._limits = limits
        # Phase -> seconds that a worker with a job may stay in it.
        self._allowed_s = {
            Phase.STARTING: _START_UP_S,
            Phase.IDLE: _STALL_S,
            Phase.LOADING: _START_UP_S,
            Phase.WARMING_UP: limits.time_s + _WARM_UP_S,
            Phase.SOLVING: limits.time_s + GRACE_S,
        }
        self._observations: dict[WorkerProcess, _Observation] = {}
        self._look_count, self._suspended_s = 0, 0.0  # totals
        self.begin()

    def begin(self) -> None:
        """Restart the measurement of pauses: time before this call does not count as suspended."""
        self._last_look_s, self._cpu_s = monotonic(), process_time()

    def due(self) -> bool:
        """Whether it is time for another look."""
        return monotonic() - self._last_look_s >= POLL_INTERVAL_S

    def look(self, workers: list[WorkerProcess]) -> dict[WorkerProcess, Reply]:
        """Halt the workers that break a limit; return them with the replies to their jobs."""
        self._look_count += 1
        cpu_s, pause_s = process_time() - self._cpu_s, monotonic() - self._last_look_s
        # A long pause with little CPU time: the whole run was suspended, and no worker could solve.
        # With much CPU time, this process judged or wrote rows while the workers were solving.
        if pause_s > _SUSPENDED_S and cpu_s < pause_s / 2:
            self._suspended_s += pause_s
        self.begin()
        earlier_observations, self._observations = self._observations, {}
        killed = {}
        for worker in workers:
            reading = worker.status.read()
            earlier = earlier_observations.get(worker)
            # Only a status that was read twice counts: the worker may write it during a reading.
            if earlier is None or earlier.reading != reading:
                self._observations[worker] = _Observation(
                    reading, self._last_look_s, self._suspended_s
                )
                continue
            self._observations[worker] = earlier
            reply = self._limit_reply(worker, earlier)
            if reply is not None:
                _send(worker, signal.SIGSTOP)
                sleep(0.001)  # the signal takes effect at the process's next step
                if worker.status.read() == reading:
                    killed[worker] = reply
                else:  # the worker has just answered: its next job must not be killed
                    _send(worker, signal.SIGCONT)
        return killed

    def _limit_reply(self, worker: WorkerProcess, observed: _Observation) -> Reply | None:
        """The reply to the job of a worker that breaks a limit; None if it keeps all limits."""
        (_, phase, since_s), seen_s, suspended_s = observed
        if phase is Phase.LOST:
            return no_answer(
                Outcome.CRASHED, "stopped: it overwrote its status, which the run reads"
            )
        # `since_s` is plausible unless a solver has overwritten it.
        if not seen_s - _LATE_S <= since_s <= seen_s:
            since_s = seen_s
        seconds = monotonic() - since_s - (self._suspended_s - suspended_s)
        idle = phase is Phase.IDLE and not worker.pending
        if seconds > self._allowed_s[phase] and not idle:
            message = f"stopped after {seconds:.2f} s; the limit is {self._limits.time_s:g} s"
            if phase is not Phase.SOLVING:
                message = f"stopped after {seconds:.0f} s of {_ACTIVITY[phase]}"
            return no_answer(Outcome.TIMEOUT, message, Times(wall=seconds))
        limit = self._limits.memory_bytes
        used = _used_bytes(
            worker.process.pid,
            limit,
            with_children=self._look_count % _LOOKS_PER_CHILDREN_CHECK == 0,
        )
        if used <= limit:
            return None
        message = f"stopped holding {used / _GIB:.2f} GiB; the limit is {limit / _GIB:g} GiB"
        return no_answer(Outcome.OUT_OF_MEMORY, message, Times(wall=seconds))


def _send(worker: WorkerProcess, number: signal.Signals) -> None:
    with suppress(OSError):
        os.kill(worker.process.pid, number)


def _used_bytes(pid: int, limit: float, *, with_children: bool) -> int:
    """Bytes of memory that a process uses, optionally with its descendants; 0 if it has ended.

    If the sum is above the limit, memory that several processes share is counted only once (Linux).
    This count is slower.
    """
    try:
        process = psutil.Process(pid)
        family = [process, *process.children(recursive=True)] if with_children else [process]
    except psutil.Error:
        return 0
    used = _sum_bytes(family, "memory_info", "rss")
    if with_children and used > limit:
        used = _sum_bytes(family, "memory_full_info", "pss")
    return used


def _sum_bytes(family: list[psutil.Process], method: str, column: str) -> int:
    total = 0
    for process in family:
        with suppress(psutil.Error):
            memory = getattr(process, method)()
            total += getattr(memory, column, memory.rss)
    return total

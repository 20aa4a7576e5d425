"""The monitor of a pool: which worker takes too long or holds too much memory, and is killed."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from time import monotonic, process_time, sleep
from typing import NamedTuple

import psutil

from dubins_study.experiments.isolation.job_clock import Phase, Reading
from dubins_study.experiments.isolation.worker_process import WorkerProcess
from dubins_study.solvers.protocol import Outcome
from dubins_study.solvers.reply import Reply, Times, no_answer

POLL_INTERVAL_S = 0.02
# A solver that keeps to its limit needs a moment to hand its answer over. With the interval and
# the kill itself, a solve ends within 0.3 s of its limit.
_GRACE_S = 0.1
# for a process to start, or a solver to be loaded
_START_UP_S = 60.0
# that a first solve may take beyond the limit: it loads what the others find loaded
_WARM_UP_S = 10.0
# in which an idle worker must take up its next job
_STALL_S = 10.0
# looks between two at a worker's children, which cost milliseconds where many processes run
_FAMILY_EVERY = 10
# between two looks, from which on nothing was looked at because everything was suspended
_SUSPENDED_S = 1.0
# by which a look may be late on a busy machine
_LATE_S = 10.0
_GIB = 2**30

_ACTIVITY = {
    Phase.STARTING: "starting a worker",
    Phase.IDLE: "waiting for its answer to arrive",
    Phase.LOADING: "loading the solver",
    Phase.WARMING_UP: "warming up",
}


class Limits(NamedTuple):
    """Seconds that a solve may take, and bytes that a worker and its children may hold."""

    time_s: float
    memory_bytes: int


class _Observation(NamedTuple):
    """A clock's reading, when it was first seen, and the suspended time up to then."""

    reading: Reading
    seen_s: float
    suspended_s: float


class Monitor:
    """Looks at workers, and tells which of them is to be killed, and why."""

    def __init__(self, limits: Limits):
        self._limits = limits
        # seconds that a worker with a job may be in each phase
        self._allowed_s = {
            Phase.STARTING: _START_UP_S,
            Phase.IDLE: _STALL_S,
            Phase.LOADING: _START_UP_S,
            Phase.WARMING_UP: limits.time_s + _WARM_UP_S,
            Phase.SOLVING: limits.time_s + _GRACE_S,
        }
        self._before: dict[WorkerProcess, _Observation] = {}
        self._looks, self._suspended_s = 0, 0.0  # in all
        self.begin()

    def begin(self) -> None:
        """Time in which nobody looked does not count as suspended."""
        self._looked_s, self._cpu_s = monotonic(), process_time()

    def due(self) -> bool:
        """Whether it is time for another look."""
        return monotonic() - self._looked_s >= POLL_INTERVAL_S

    def look(self, workers: list[WorkerProcess]) -> dict[WorkerProcess, Reply]:
        """The workers to be killed, halted by now, and the replies to what they are at."""
        self._looks += 1
        cpu_s, pause_s = process_time() - self._cpu_s, monotonic() - self._looked_s
        # A job that is suspended as a whole solves nothing meanwhile; one whose results are being
        # judged or written does.
        if pause_s > _SUSPENDED_S and cpu_s < pause_s / 2:
            self._suspended_s += pause_s
        self.begin()
        before, self._before = self._before, {}
        killed = {}
        for worker in workers:
            reading = worker.clock.read()
            earlier = before.get(worker)
            # a clock that was being written while it was read does not read the same again
            if earlier is None or earlier.reading != reading:
                self._before[worker] = _Observation(reading, self._looked_s, self._suspended_s)
                continue
            self._before[worker] = earlier
            reply = self._complaint(worker, earlier)
            if reply is not None:
                _send(worker, signal.SIGSTOP)
                sleep(0.001)  # it is delivered at the process's next step
                if worker.clock.read() == reading:
                    killed[worker] = reply
                else:  # it answered just now: its next job is not to blame
                    _send(worker, signal.SIGCONT)
        return killed

    def _complaint(self, worker: WorkerProcess, observed: _Observation) -> Reply | None:
        """The reply to the job of a worker that breaks a limit."""
        (_, phase, since_s), seen_s, suspended_s = observed
        if phase is Phase.LOST:
            return no_answer(
                Outcome.CRASHED, "stopped: it wrote over its clock, which the run reads"
            )
        # the moment that the clock tells, unless a solver has set it
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
        used = _held_bytes(
            worker.process.pid, limit, with_children=self._looks % _FAMILY_EVERY == 0
        )
        if used <= limit:
            return None
        message = f"stopped holding {used / _GIB:.2f} GiB; the limit is {limit / _GIB:g} GiB"
        return no_answer(Outcome.OUT_OF_MEMORY, message, Times(wall=seconds))


def _send(worker: WorkerProcess, number: signal.Signals) -> None:
    with suppress(OSError):
        os.kill(worker.process.pid, number)


def _held_bytes(pid: int, limit: float, *, with_children: bool) -> int:
    """Bytes that a process holds, with its descendants if asked for; 0 if it is gone.

    What several share is counted once where the sum is above the limit (Linux), which is slower.
    """
    try:
        process = psutil.Process(pid)
        family = [process, *process.children(recursive=True)] if with_children else [process]
    except psutil.Error:
        return 0
    held = _sum_bytes(family, "memory_info", "rss")
    if with_children and held > limit:
        held = _sum_bytes(family, "memory_full_info", "pss")
    return held


def _sum_bytes(family: list[psutil.Process], reading: str, column: str) -> int:
    total = 0
    for process in family:
        with suppress(psutil.Error):
            memory = getattr(process, reading)()
            total += getattr(memory, column, memory.rss)
    return total

"""A pool of worker processes with hard limits: takes jobs, yields (job, reply) pairs.

One loop waits for the replies, output and exits of all workers, and checks their run times and
memory every 20 ms. If a solver crashes or blocks its worker, the job gets a reply too. The pool
judges no answer.
"""

from __future__ import annotations

import select
from collections.abc import Callable, Iterable, Iterator
from time import monotonic
from typing import Self

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.fork_server import ForkServerError
from dubins_study.experiments.isolation.job_queue import Job, JobQueue, SolverKey, worker_group
from dubins_study.experiments.isolation.messages import MessageError, WorkerReply
from dubins_study.experiments.isolation.monitor import POLL_INTERVAL_S, Limits, Monitor
from dubins_study.experiments.isolation.worker_process import WorkerProcess
from dubins_study.experiments.isolation.worker_status import Phase
from dubins_study.solvers.reply import Reply, no_answer
from dubins_study.study.words import Outcome

# Jobs that a worker may get in advance, so that it never waits for the pool.
_AHEAD_JOBS = 64
# A worker gets jobs in advance only after a solve shorter than `_QUICK_S`. If a solve takes longer
# than `_SLOW_S`, its waiting jobs go to other workers.
_QUICK_S, _SLOW_S = 0.005, 0.1
# After this many seconds without a reply, yield an empty list, so that the caller can write rows.
_YIELD_INTERVAL_S = 0.2
# Seconds between two calibration probes.
_PROBE_INTERVAL_S = 2.0
# Number of replies to jobs of unloadable solvers that are yielded together.
_MAX_RESULTS = 8
# Number of workers in a row that may end before they begin a job.
_MAX_FALSE_STARTS = 3


class RunError(DubinsStudyError, RuntimeError):
    """No more questions can be asked; in a run the rows written so far are kept."""


# Jobs and the replies to them.
Results = list[tuple[Job, WorkerReply]]


class WorkerPool:
    """Worker processes, started when there are jobs and kept until the `with` block ends.

    Args:
        workers: number of processes.
        limits: the limits of every solve.
        warm_up: whether solvers are asked an easy question before their first job.
        probed: called every two seconds with the duration (s) of a calibration probe.
    """

    def __init__(
        self,
        workers: int,
        limits: Limits,
        *,
        warm_up: bool = True,
        probed: Callable[[float], None] | None = None,
    ):
        self.limits = limits
        self._probed = probed
        self._workers: list[WorkerProcess | None] = [None] * workers
        self._monitor = Monitor(limits)
        self._warm_up = warm_up
        # Solvers whose warm-up ended a worker: they are loaded without it.
        self._without_warm_up: set[SolverKey] = set()
        self._answered: set[SolverKey] = set()
        # Solver that ended its worker while it was loaded -> the reply to its other jobs.
        self._unloadable: dict[SolverKey, Reply] = {}
        self._queue = JobQueue()
        self._false_starts = 0
        self._next_probe_s = monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill_workers()
        for worker in self._live_workers():
            self._remove(worker)

    def kill_workers(self) -> None:
        """Kill all workers; may be called from any thread."""
        for worker in self._live_workers():
            worker.process.kill()

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Put jobs at the front of the queue; allowed while `solve` runs."""
        self._queue.put_first(jobs)

    def solve(self, jobs: Iterable[Job], stop: Interruption) -> Iterator[Results]:
        """Yield the replies to all jobs as they come, and an empty list if none come for a while.

        After an interruption only the current solves are finished.

        Args:
            jobs: read when a worker is free; solved in this order, except after `put_first`.
            stop: checked after every result.

        Raises:
            RunError: if worker processes end before they begin a job.
        """
        self._queue = JobQueue(jobs)
        self._monitor.begin()
        yielded_s = monotonic()
        while True:
            if stop.requested:
                self._queue = JobQueue()
                for worker in self._live_workers():
                    worker.withdraw()
            results = self._feed()
            busy = any(worker.pending for worker in self._live_workers())
            if not (results or busy or self._queue.waiting(1)):
                return
            results += self._wait(0.0 if results else POLL_INTERVAL_S)
            if results or monotonic() - yielded_s > _YIELD_INTERVAL_S:
                yield results
                yielded_s = monotonic()

    def _live_workers(self) -> list[WorkerProcess]:
        return [worker for worker in self._workers if worker is not None]

    def _feed(self) -> Results:
        """Give jobs to workers; return a few replies to jobs of unloadable solvers."""
        results: Results = []
        places = len(self._workers)
        share = min(_AHEAD_JOBS, -(-self._queue.waiting(_AHEAD_JOBS * places) // places))
        for place, worker in enumerate(self._workers):
            if worker is not None and len(worker.pending) > share // 2:
                continue
            while (job := self._queue.next()) and len(results) < _MAX_RESULTS:
                reply = self._unloadable.get(job.solver_key)
                if reply is not None:
                    results.append((self._queue.take(), WorkerReply(reply)))
                    continue
                free = self._worker_for(job, place, share)
                if free is None:
                    break
                warm_up = self._warm_up and job.solver_key not in self._without_warm_up
                free.put(self._queue.take(), self.limits.time_s, warm_up)
        first = self._workers[0]
        if self._probed is not None and first is not None and monotonic() > self._next_probe_s:
            self._next_probe_s = monotonic() + _PROBE_INTERVAL_S
            first.put_probe()
        return results

    def _worker_for(self, job: Job, place: int, share: int) -> WorkerProcess | None:
        """The worker at `place`, or None if it cannot take the job; may start or replace it."""
        worker, group = self._workers[place], worker_group(job.solver)
        if worker is not None and worker.group != group:
            if worker.pending:
                return None
            self._remove(worker)
            worker = None
        if worker is None:
            try:
                worker = WorkerProcess(self.limits.memory_bytes, group)
            except (OSError, ForkServerError) as error:
                raise RunError(f"no worker process starts ({error})") from None
            self._workers[place] = worker
        return worker if len(worker.pending) < (share if worker.quick else 1) else None

    def _wait(self, timeout_s: float) -> Results:
        """Wait for events, check the limits if it is time, and return the replies."""
        results: Results = []
        poll, workers = select.poll(), self._live_workers()
        for worker in workers:
            worker.register(poll)
        ready = {descriptor for descriptor, _ in poll.poll(1000 * timeout_s)}
        for worker in workers:
            results += self._receive(worker, ready)
            if worker.process.exit_pipe in ready and worker in self._workers:
                results += self._end_worker(worker, None)
        if self._monitor.due():
            results += self._enforce_limits()
        return results

    def _enforce_limits(self) -> Results:
        """End workers that break a limit; take back the jobs that wait for a slow worker."""
        results: Results = []
        for worker, reply in self._monitor.look(self._live_workers()).items():
            results += self._end_worker(worker, reply)
        for worker in self._live_workers():
            if len(worker.pending) > 1 and monotonic() - worker.status.read().since_s > _SLOW_S:
                worker.quick = False
                self._queue.put_first(worker.withdraw())
        return results

    def _receive(self, worker: WorkerProcess, ready: set[int]) -> Results:
        """Receive a worker's answers, and return its replies to jobs."""
        results: Results = []
        try:
            for number, value, changed in worker.answers(ready):
                if not isinstance(value, float):
                    results += self._job_answered(worker, number, value)
                elif self._probed is not None:
                    self._probed(value)
                if changed:
                    self._remove(worker)
                    break
        except MessageError as error:
            reply = no_answer(Outcome.CRASHED, f"stopped: its worker sent {error}")
            results += self._end_worker(worker, reply)
        return results

    def _job_answered(self, worker: WorkerProcess, number: int, reply: WorkerReply) -> Results:
        self._false_starts = 0
        worker.quick = (reply.reply.times.solve or 0) < _QUICK_S
        answered = worker.pending.pop(number, None)
        if not worker.quick:
            self._queue.put_first(worker.withdraw())
        if answered is None:  # the job was withdrawn, and is solved by another worker
            return []
        self._answered.add(answered.job.solver_key)
        return [(answered.job, reply)]

    def _end_worker(self, worker: WorkerProcess, reply: Reply | None) -> Results:
        """Remove a worker and return the reply to its current job.

        Args:
            worker: a worker that has ended, or that is to be killed.
            reply: the reply to its job if it is to be killed; None if it has ended.
        """
        number, phase = worker.current_number(), worker.status.read().phase
        if reply is not None:
            worker.process.kill()
        crash_reply = worker.crash_reply()
        current = None if number is None else worker.pending.pop(number)
        self._remove(worker)
        if current is None:
            self._false_starts += 1
            if self._false_starts >= _MAX_FALSE_STARTS:
                raise RunError(
                    "worker processes end before they solve anything "
                    f"({crash_reply.solution.message})"
                )
            return []
        self._false_starts = 0
        job, reply = current.job, reply or crash_reply
        if phase in (Phase.LOADING, Phase.WARMING_UP):
            if current.warm_up:  # perhaps the warm-up failed: load the solver again without it
                self._without_warm_up.add(job.solver_key)
                self._queue.put_first([job])
                return []
            reply = self._load_failed(job.solver_key, reply)
        return [(job, WorkerReply(reply))]

    def _load_failed(self, solver: SolverKey, reply: Reply) -> Reply:
        """The reply to a job whose solver ended its worker while it was loaded."""
        (outcome, solution, _), status = reply, reply.solution.native_status
        message = f"{solution.message}, while it was loaded"
        if solver not in self._answered:
            later_message = f"{message} for another cell; not tried again"
            self._unloadable[solver] = no_answer(outcome, later_message, status=status)
        return no_answer(outcome, message, status=status)

    def _remove(self, worker: WorkerProcess) -> None:
        """End a worker and free its place; put its pending jobs back in the queue."""
        self._workers[self._workers.index(worker)] = None
        worker.process.close()
        self._queue.put_first(pending.job for pending in worker.pending.values())

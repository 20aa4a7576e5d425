"""A pool of worker processes with hard limits: jobs in, (job, reply) out.

One loop waits for replies, output and ends of all workers, and looks at their clocks and memory
every 20 ms. Whatever a solver does to its worker is a reply; the pool judges nothing.
"""

from __future__ import annotations

import select
from collections.abc import Callable, Iterable, Iterator
from time import monotonic
from typing import Self

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.fork_server import ForkServerError
from dubins_study.experiments.isolation.job_clock import Phase
from dubins_study.experiments.isolation.job_queue import Job, JobQueue, SolverKey, worker_group
from dubins_study.experiments.isolation.messages import MessageError, WorkerReply
from dubins_study.experiments.isolation.monitor import POLL_INTERVAL_S, Limits, Monitor
from dubins_study.experiments.isolation.worker_process import WorkerProcess
from dubins_study.solvers.protocol import Outcome
from dubins_study.solvers.reply import Reply, no_answer

# Jobs that a worker has in advance, so that it never waits; a single job where solves are long, so
# that none waits for a worker while another one is idle.
_AHEAD_JOBS, _QUICK_S, _SLOW_S = 64, 0.005, 0.1
# without a reply after which whoever writes the rows is given a turn
_NEWS_INTERVAL_S = 0.2
_PROBE_INTERVAL_S = 2.0
# replies without a worker that are yielded together
_MAX_RESULTS = 8
# workers that may end in a row before they have taken up any job
_MAX_FALSE_STARTS = 3


class RunError(DubinsStudyError, RuntimeError):
    """A run that could not go on; what was done is kept."""


# jobs and the replies to them
Results = list[tuple[Job, WorkerReply]]


class WorkerPool:
    """Workers for as long as it is entered; they are started when there are jobs.

    Args:
        workers: processes side by side.
        limits: of every solve.
        warm_up: whether solvers are asked an easy question before their first job.
        probed: called every two seconds with the seconds that a fixed piece of work took.
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
        self._without_warm_up: set[SolverKey] = set()  # their warm-up ended a worker
        self._answered: set[SolverKey] = set()
        # solvers that end workers as they are loaded, and the reply to their other jobs
        self._given_up: dict[SolverKey, Reply] = {}
        self._queue = JobQueue()
        self._false_starts = 0
        self._next_probe_s = monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill_workers()
        for worker in self._running():
            self._remove(worker)

    def kill_workers(self) -> None:
        """End whatever is being solved; may be called from any thread."""
        for worker in self._running():
            worker.process.kill()

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Jobs that are next; may be put while `solve` is under way."""
        self._queue.put_first(jobs)

    def solve(self, jobs: Iterable[Job], stop: Interruption) -> Iterator[Results]:
        """The replies to all jobs as they come; an empty list now and then where none do.

        Once the run is interrupted, only what is being solved is finished.

        Args:
            jobs: taken as workers can be given them, in this order but for `put_first`.
            stop: looked at after every result.

        Raises:
            RunError: if worker processes end before they have done anything.
        """
        self._queue = JobQueue(jobs)
        self._monitor.begin()
        yielded_s = monotonic()
        while True:
            if stop.requested:
                self._queue = JobQueue()
                for worker in self._running():
                    worker.withdraw()
            results = self._feed()
            busy = any(worker.pending for worker in self._running())
            if not (results or busy or self._queue.waiting(1)):
                return
            results += self._wait(0.0 if results else POLL_INTERVAL_S)
            if results or monotonic() - yielded_s > _NEWS_INTERVAL_S:
                yield results
                yielded_s = monotonic()

    def _running(self) -> list[WorkerProcess]:
        return [worker for worker in self._workers if worker is not None]

    def _feed(self) -> Results:
        """Give jobs to workers; replies to jobs that need no worker, a few at a time."""
        results: Results = []
        places = len(self._workers)
        share = min(_AHEAD_JOBS, -(-self._queue.waiting(_AHEAD_JOBS * places) // places))
        for place, worker in enumerate(self._workers):
            if worker is not None and len(worker.pending) > share // 2:
                continue
            while (job := self._queue.next()) and len(results) < _MAX_RESULTS:
                reply = self._given_up.get(job.solver_key)
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
        """The worker of a place, if it may be given a job; it may replace an idle worker."""
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
                message = f"no worker process starts ({error}); the rows written so far are kept"
                raise RunError(message) from None
            self._workers[place] = worker
        return worker if len(worker.pending) < (share if worker.quick else 1) else None

    def _wait(self, timeout_s: float) -> Results:
        """Wait for the next events, then look at the workers if it is time; what they replied."""
        results: Results = []
        poll, workers = select.poll(), self._running()
        for worker in workers:
            worker.register(poll)
        ready = {descriptor for descriptor, _ in poll.poll(1000 * timeout_s)}
        for worker in workers:
            results += self._receive(worker, ready)
            if worker.process.status in ready and worker in self._workers:
                results += self._ended(worker, None)
        if self._monitor.due():
            results += self._look()
        return results

    def _look(self) -> Results:
        """End the workers that break a limit; jobs that wait for a slow worker go to the others."""
        results: Results = []
        for worker, reply in self._monitor.look(self._running()).items():
            results += self._ended(worker, reply)
        for worker in self._running():
            if len(worker.pending) > 1 and monotonic() - worker.clock.read().since_s > _SLOW_S:
                worker.quick = False
                self._queue.put_first(worker.withdraw())
        return results

    def _receive(self, worker: WorkerProcess, ready: set[int]) -> Results:
        """What a worker's answers bring."""
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
            results += self._ended(worker, reply)
        return results

    def _job_answered(self, worker: WorkerProcess, number: int, reply: WorkerReply) -> Results:
        self._false_starts = 0
        worker.quick = (reply.reply.times.solve or 0) < _QUICK_S
        answered = worker.pending.pop(number, None)
        if not worker.quick:
            self._queue.put_first(worker.withdraw())
        if answered is None:  # it was taken back
            return []
        self._answered.add(answered.job.solver_key)
        return [(answered.job, reply)]

    def _ended(self, worker: WorkerProcess, reply: Reply | None) -> Results:
        """A worker has ended, or is to be ended with a reply to the job that it is at."""
        number, phase = worker.current_number(), worker.clock.read().phase
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
                    f"({crash_reply.solution.message}); the rows written so far are kept"
                )
            return []
        self._false_starts = 0
        job, reply = current.job, reply or crash_reply
        if phase in (Phase.LOADING, Phase.WARMING_UP):
            if current.warm_up:  # it may be to blame: the solver is loaded once more, without it
                self._without_warm_up.add(job.solver_key)
                self._queue.put_first([job])
                return []
            reply = self._load_failed(job.solver_key, reply)
        return [(job, WorkerReply(reply))]

    def _load_failed(self, solver: SolverKey, reply: Reply) -> Reply:
        """The reply to a job whose solver ended the worker while it was loaded."""
        (outcome, solution, _), status = reply, reply.solution.native_status
        message = f"{solution.message}, while it was loaded"
        if solver not in self._answered:
            again = f"{message} for another cell; not tried again"
            self._given_up[solver] = no_answer(outcome, again, status=status)
        return no_answer(outcome, message, status=status)

    def _remove(self, worker: WorkerProcess) -> None:
        """End a worker, whose place another one may take; the jobs that it was given wait again."""
        self._workers[self._workers.index(worker)] = None
        worker.process.close()
        self._queue.put_first(pending.job for pending in worker.pending.values())

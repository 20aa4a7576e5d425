"""A pool of worker processes with hard limits: jobs in, (job, reply) out.

One loop waits for replies, output and ends of all workers, and looks at their clocks and memory
every 20 ms. Whatever a solver does to its worker is a reply; the pool judges nothing.
"""

from __future__ import annotations

import selectors
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from time import monotonic
from typing import Self

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.fork_server import ForkServerError
from dubins_study.experiments.isolation.job_clock import Phase
from dubins_study.experiments.isolation.job_queue import Job, JobQueue, worker_group
from dubins_study.experiments.isolation.messages import MessageError, WorkerReply
from dubins_study.experiments.isolation.monitor import POLL_INTERVAL_S, Limits, Monitor
from dubins_study.experiments.isolation.worker import WorkerJob
from dubins_study.experiments.isolation.worker_failures import LoadFailures, crashed, exit_status
from dubins_study.experiments.isolation.worker_process import Answer, WorkerProcess
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
        self._selector = selectors.DefaultSelector()
        self._monitor = Monitor(limits)
        self._load_failures = LoadFailures(warm_up)
        self._queue = JobQueue()
        self._false_starts = 0
        self._next_probe_s = monotonic()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill_workers()
        for worker in filter(None, self._workers):
            self._remove(worker)
        self._selector.close()

    def kill_workers(self) -> None:
        """End whatever is being solved; may be called from any thread."""
        for worker in filter(None, self._workers):
            worker.process.kill()

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Jobs that are next; may be put while `solve` is under way."""
        self._queue.put_first(jobs)

    def solve(self, jobs: Iterable[Job], stop: Interruption) -> Iterator[Results]:
        """The replies to all jobs as they come; an empty list now and then where none do.

        Once the run is interrupted, only what is being solved is finished.

        Args:
            jobs: taken as workers can be given them, in this order but for `put_first`.
            stop: asked after every result.

        Raises:
            RunError: if worker processes end before they have done anything.
        """
        self._queue = JobQueue(jobs)
        self._monitor.begin()
        yielded_s = monotonic()
        while True:
            if stop.requested:
                self._finish_up()
            results = self._feed()
            if not (results or self._queue):
                return
            results += self._wait(0.0 if results else POLL_INTERVAL_S)
            if results or monotonic() - yielded_s > _NEWS_INTERVAL_S:
                yield results
                yielded_s = monotonic()

    def _finish_up(self) -> None:
        """Forget every job but those that workers are at."""
        self._queue.forget_waiting()
        for worker in filter(None, self._workers):
            for number in worker.withdraw():
                self._queue.done(number)

    def _feed(self) -> Results:
        """Give jobs to workers; replies to jobs that need no worker, a few at a time."""
        results: Results = []
        queue = self._queue
        for place, worker in enumerate(self._workers):
            waiting = queue.waiting(_AHEAD_JOBS * len(self._workers))
            share = min(_AHEAD_JOBS, -(-waiting // len(self._workers)))
            if worker is not None and len(worker.pending) > share // 2:
                continue
            while (job := queue.next()) and len(results) < _MAX_RESULTS:
                reply = self._load_failures.reply(job.solver_key)
                if reply is not None:
                    queue.skip()
                    results.append((job, WorkerReply(reply)))
                elif self._fits(place, job, share):
                    self._put(place, queue.give(), job)
                else:
                    break
        first = self._workers[0]
        if self._probed is not None and first is not None and monotonic() > self._next_probe_s:
            self._next_probe_s = monotonic() + _PROBE_INTERVAL_S
            first.put_probe()
        for worker in filter(None, self._workers):
            if not worker.flush():  # the rest of a long message is sent as the worker reads it
                events = selectors.EVENT_READ | selectors.EVENT_WRITE
                self._selector.modify(worker.process.channel, events, worker)
        return results

    def _fits(self, place: int, job: Job, share: int) -> bool:
        """Whether a worker may be given one more job; an idle one of another group is replaced."""
        worker = self._workers[place]
        if worker is not None and worker.group != worker_group(job.solver):
            if worker.pending:
                return False
            self._remove(worker)
            return True
        return worker is None or len(worker.pending) < (share if worker.quick else 1)

    def _put(self, place: int, number: int, job: Job) -> None:
        worker = self._workers[place] or self._start(place, worker_group(job.solver))
        warm_up = self._load_failures.warms_up(job.solver_key)
        worker.put(WorkerJob(number, *job[:3], self.limits.time_s, warm_up))

    def _start(self, place: int, group: str) -> WorkerProcess:
        try:
            worker = WorkerProcess(self.limits.memory_bytes, place, group)
        except (OSError, ForkServerError) as error:
            message = f"no worker process starts ({error}); the rows written so far are kept"
            raise RunError(message) from None
        self._workers[place] = worker
        for source in (worker.process.channel, worker.process.output, worker.process.status):
            self._selector.register(source, selectors.EVENT_READ, worker)
        return worker

    def _wait(self, timeout_s: float) -> Results:
        """Wait for the next events, then look at the workers if it is time; what they replied."""
        results: Results = []
        ended: list[WorkerProcess] = []
        for key, events in self._selector.select(timeout_s):
            worker = key.data
            process = worker.process
            if worker is not self._workers[worker.place]:
                continue  # it was replaced just now
            if events & selectors.EVENT_WRITE and worker.flush():
                self._selector.modify(process.channel, selectors.EVENT_READ, worker)
            if key.fd == process.status:
                ended.append(worker)
            elif key.fd == process.output:
                if not worker.read_output():
                    self._selector.unregister(process.output)
            elif events & selectors.EVENT_READ:
                results += self._receive(worker)
        for worker in ended:
            if worker is self._workers[worker.place]:
                results += self._receive(worker)
            if worker is self._workers[worker.place]:
                results += self._ended(worker, None)
        if self._monitor.due():
            results += self._look()
        return results

    def _look(self) -> Results:
        """End the workers that break a limit; jobs that wait for a slow worker go to the others."""
        results: Results = []
        for worker, reply in self._monitor.look([*filter(None, self._workers)]).items():
            results += self._ended(worker, reply)
        for worker in filter(None, self._workers):
            if len(worker.pending) > 1 and monotonic() - worker.clock.read().since_s > _SLOW_S:
                worker.quick = False
                self._queue.take_back(worker.withdraw())
        return results

    def _receive(self, worker: WorkerProcess) -> Results:
        """What a worker's answers bring."""
        results: Results = []
        try:
            for answer in worker.answers():
                results += self._answered(worker, answer)
                if answer.changes:
                    break
        except (EOFError, OSError):  # what becomes of the worker is told by its end or the monitor
            with suppress(KeyError):
                self._selector.unregister(worker.process.channel)
        except MessageError as error:
            reply = no_answer(Outcome.CRASHED, f"stopped: its worker sent {error}")
            results += self._ended(worker, reply)
        return results

    def _answered(self, worker: WorkerProcess, answer: Answer) -> Results:
        if answer.job is None:
            if self._probed is not None:
                self._probed(answer.probe_s)
            return []
        self._false_starts = 0
        answered = worker.pending.pop(answer.job, None)
        worker.quick = (answer.reply.reply.times.solve or 0) < _QUICK_S
        if answer.changes:
            self._replace(worker)
        elif not worker.quick:
            self._queue.take_back(worker.withdraw())
        if answered is None:  # it was taken back
            return []
        job = self._queue.done(answered.number)
        self._load_failures.note_answer(job.solver_key)
        return [(job, answer.reply)]

    def _ended(self, worker: WorkerProcess, reply: Reply | None) -> Results:
        """A worker has ended, or is to be ended with a reply to the job that it is at."""
        order, phase = worker.current_job(), worker.clock.read().phase
        if reply is not None:
            worker.process.kill()
        code, output = worker.exit_code(), worker.last_output()
        if order is not None:
            del worker.pending[order.number]
        self._replace(worker)
        if order is None:
            self._false_starts += 1
            if self._false_starts >= _MAX_FALSE_STARTS:
                raise RunError(
                    f"worker processes end before they solve anything ({exit_status(code)[1]}"
                    f"{': ' + output if output else ''}); the rows written so far are kept"
                )
            return []
        self._false_starts = 0
        job = self._queue.done(order.number)
        reply = reply or crashed(code, output)
        if phase in (Phase.LOADING, Phase.WARMING_UP):
            failure = self._load_failures.note_failure(job.solver_key, order.warm_up, reply)
            if failure is None:  # the solver is loaded once more, without a warm-up
                self._queue.put_first([job])
                return []
            reply = failure
        return [(job, WorkerReply(reply))]

    def _replace(self, worker: WorkerProcess) -> None:
        """End a worker; the jobs that it was given wait again, and start another one."""
        self._remove(worker)
        self._queue.take_back(worker.pending)

    def _remove(self, worker: WorkerProcess) -> None:
        worker.process.kill()
        worker.exit_code()
        for source in (worker.process.channel, worker.process.output, worker.process.status):
            with suppress(KeyError):  # it was closed by the worker
                self._selector.unregister(source)
        self._workers[worker.place] = None
        worker.process.close()

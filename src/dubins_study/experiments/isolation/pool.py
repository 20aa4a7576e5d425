"""A pool of worker processes with hard limits: jobs in, (job, reply) out.

One loop waits for replies, output and ends of all workers, and looks at their clocks and memory
every 20 ms. Whatever a solver does to its worker is a reply; the pool judges nothing.
"""

from __future__ import annotations

import selectors
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from functools import cache
from itertools import count, islice
from time import monotonic
from typing import Any, NamedTuple, Self

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.exit_status import crashed, exit_status
from dubins_study.experiments.isolation.fork_server import ForkServerError
from dubins_study.experiments.isolation.job_clock import Phase
from dubins_study.experiments.isolation.load_failures import LoadFailures
from dubins_study.experiments.isolation.messages import MessageError, WorkerReply
from dubins_study.experiments.isolation.monitor import POLL_INTERVAL_S, Limits, Monitor
from dubins_study.experiments.isolation.worker import WorkerJob
from dubins_study.experiments.isolation.worker_process import Answer, WorkerProcess
from dubins_study.solvers.protocol import Outcome, Question
from dubins_study.solvers.registry import ours
from dubins_study.solvers.reply import Reply, no_answer

# Jobs in one message, each of which costs as much as a quick solve, and messages that a worker
# has in advance, so that it never waits. A single job where solves are long, so that none waits
# for a worker while another one is idle.
_BATCH_JOBS, _BATCHES, _QUICK_S = 32, 3, 0.005
# without a reply after which whoever writes the rows is given a turn
_NEWS_INTERVAL_S = 0.2
_PROBE_INTERVAL_S = 2.0
# replies without a worker that are yielded together
_MAX_RESULTS = 8
# workers that may end in a row before they have taken up any job
_MAX_FALSE_STARTS = 3


class RunError(DubinsStudyError, RuntimeError):
    """A run that could not go on; what was done is kept."""


class Job(NamedTuple):
    """One question to one solver; `tag` is the caller's."""

    solver: str
    profile: str
    question: Question
    tag: Any = None


# jobs and the replies to them
Results = list[tuple[Job, WorkerReply]]


@cache
def worker_group(solver: str) -> str:
    """Jobs of one group share workers: our own solvers do, each plug-in has its own workers.

    A plug-in may have changed any module of its process.
    """
    return "" if ours(solver) else solver


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
        self._first: deque[Job] = deque()
        self._jobs: Iterator[Job] = iter(())
        self._given: dict[int, Job] = {}
        self._numbers = count()
        self._false_starts = 0
        self._next_probe_s = monotonic()
        # a single job in a message once it was not clear which job of several ended a worker
        self._batch_jobs = _BATCH_JOBS

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.kill_workers()
        for place, worker in enumerate(self._workers):
            if worker is not None:
                self._remove(place, worker)
        self._selector.close()

    def kill_workers(self) -> None:
        """End whatever is being solved; may be called from any thread."""
        for worker in self._workers:
            if worker is not None:
                worker.process.kill()

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Jobs that are next; may be put while `solve` is under way."""
        self._first.extendleft(reversed(list(jobs)))

    def solve(self, jobs: Iterable[Job], stop: Interruption) -> Iterator[Results]:
        """The replies to all jobs as they come; an empty list now and then where none do.

        Once the run is interrupted, only what is being solved is finished.

        Args:
            jobs: taken as workers can be given them, in this order but for `put_first`.
            stop: asked after every result.

        Raises:
            RunError: if worker processes end before they have done anything.
        """
        self._first.clear()
        self._given.clear()
        self._jobs = iter(jobs)
        self._monitor.begin()
        yielded_s = monotonic()
        while True:
            if stop.asked:
                self._finish_up()
            results = self._feed()
            if not (results or self._given):
                return
            results += self._wait(0.0 if results else POLL_INTERVAL_S)
            if results or monotonic() - yielded_s > _NEWS_INTERVAL_S:
                yield results
                yielded_s = monotonic()

    def _refill(self, wanted: int) -> int:
        """Take jobs from the caller's; how many wait now, up to the number wanted."""
        if len(self._first) < wanted:
            self._first.extend(islice(self._jobs, wanted - len(self._first)))
        return len(self._first)

    def _finish_up(self) -> None:
        """Forget every job but those of the batches that workers are at."""
        self._first.clear()
        self._jobs = iter(())
        for worker in filter(None, self._workers):
            for number in worker.pending.keys() - worker.begun():
                del worker.pending[number]
                self._given.pop(number, None)

    def _feed(self) -> Results:
        """Give jobs to workers; replies to jobs that need no worker, a few at a time."""
        results: Results = []
        most = _BATCHES * self._batch_jobs
        for place in range(len(self._workers)):
            waiting = self._refill(most * len(self._workers))
            share = min(most, -(-waiting // len(self._workers)))
            jobs: list[WorkerJob] = []
            while (
                self._first
                and len(results) < _MAX_RESULTS
                and self._fits(place, self._first[0], len(jobs), share)
            ):
                job = self._first.popleft()
                key = job.solver, job.profile
                reply = self._load_failures.reply(key)
                if reply is not None:
                    results.append((job, WorkerReply(reply)))
                    continue
                number, warm_up = next(self._numbers), self._load_failures.warms_up(key)
                self._given[number] = job
                jobs.append(WorkerJob(number, *key, job.question, self.limits.time_s, warm_up))
            for begin in range(0, len(jobs), self._batch_jobs):
                self._put(place, jobs[begin : begin + self._batch_jobs])
        first = self._workers[0]
        if self._probed is not None and first is not None and monotonic() > self._next_probe_s:
            self._next_probe_s = monotonic() + _PROBE_INTERVAL_S
            first.put_probe()
        return results

    def _fits(self, place: int, job: Job, taken: int, share: int) -> bool:
        """Whether a worker may be given one more job; an idle one of another group is replaced."""
        worker, group = self._workers[place], worker_group(job.solver)
        if worker is None:
            return taken == 0
        if worker.group != group:
            if worker.pending or taken:
                return False
            self._remove(place, worker)
            return True
        return len(worker.pending) + taken < (share if worker.quick else 1)

    def _put(self, place: int, jobs: list[WorkerJob]) -> None:
        worker = self._workers[place] or self._start(place, worker_group(jobs[0].solver))
        if not worker.put(jobs):  # the rest of a long message is sent as the worker reads it
            events = selectors.EVENT_READ | selectors.EVENT_WRITE
            self._selector.modify(worker.process.channel, events, (place, worker))

    def _start(self, place: int, group: str) -> WorkerProcess:
        try:
            worker = WorkerProcess(self.limits.memory_bytes, group)
        except (OSError, ForkServerError) as error:
            message = f"no worker process starts ({error}); the rows written so far are kept"
            raise RunError(message) from None
        self._workers[place] = worker
        for source in (worker.process.channel, worker.process.output, worker.process.status):
            self._selector.register(source, selectors.EVENT_READ, (place, worker))
        return worker

    def _wait(self, timeout_s: float) -> Results:
        """Wait for the next events, then look at the workers if it is time; what they replied."""
        results: Results = []
        ended: dict[WorkerProcess, int] = {}
        for key, events in self._selector.select(timeout_s):
            place, worker = key.data
            process = worker.process
            if events & selectors.EVENT_WRITE and process.channel.flush():
                self._selector.modify(process.channel, selectors.EVENT_READ, key.data)
            if key.fd == process.status:
                ended[worker] = place
            elif key.fd == process.output:
                if not worker.read_output():
                    self._selector.unregister(process.output)
            elif events & selectors.EVENT_READ and self._workers[place] is worker:
                results += self._receive(place, worker)
        for worker, place in ended.items():
            if self._workers[place] is worker:
                results += self._receive(place, worker)
            if self._workers[place] is worker:
                results += self._ended(place, worker, None)
        if self._monitor.due():
            workers = {worker: place for place, worker in enumerate(self._workers) if worker}
            for worker, reply in self._monitor.look(list(workers)).items():
                results += self._ended(workers[worker], worker, reply)
        return results

    def _receive(self, place: int, worker: WorkerProcess) -> Results:
        """What a worker's answers bring."""
        results: Results = []
        try:
            for answer in worker.answers():
                results += self._answered(place, worker, answer)
                if answer.changes:
                    break
        except (EOFError, OSError):  # what becomes of the worker is told by its end or the monitor
            with suppress(KeyError):
                self._selector.unregister(worker.process.channel)
        except MessageError as error:
            reply = no_answer(Outcome.CRASHED, f"stopped: its worker sent {error}")
            results += self._ended(place, worker, reply)
        return results

    def _answered(self, place: int, worker: WorkerProcess, answer: Answer) -> Results:
        if answer.probe_s is not None:
            if self._probed is not None:
                self._probed(answer.probe_s)
            return []
        self._false_starts = 0
        results: Results = []
        for number, reply in answer.replies.items():
            worker.pending.pop(number, None)
            job = self._given.pop(number, None)
            if job is not None:
                self._load_failures.note_answer((job.solver, job.profile))
                results.append((job, reply))
        worker.quick = all(
            (reply.reply.times.solve or 0) < _QUICK_S for reply in answer.replies.values()
        )
        # a worker whose process was changed, or which is slow, leaves the rest of its batch
        for number in answer.left:
            worker.pending.pop(number, None)
        self._take_back(answer.left)
        if answer.changes:
            self._replace(place, worker)
        return results

    def _take_back(self, numbers: Iterable[int]) -> None:
        """Jobs that no worker got to wait again, before all others and in their order."""
        jobs = [self._given.pop(number, None) for number in numbers]
        self.put_first(job for job in jobs if job is not None)

    def _ended(self, place: int, worker: WorkerProcess, reply: Reply | None) -> Results:
        """A worker has ended, or is to be ended with a reply to the job that it is at."""
        job, phase = worker.current_job(), worker.clock.read().phase
        if reply is not None:
            worker.process.kill()
        code, output = worker.exit_code(), worker.last_output()
        if job is not None and worker.answered_in_batch(job):
            self._batch_jobs = 1  # which job it was, is seen when they are put one by one
            job = None
        elif job is None:
            self._count_false_start(code, output)
        if job is None:
            self._replace(place, worker)
            return []
        self._false_starts = 0
        del worker.pending[job.number]
        self._replace(place, worker)
        given = self._given.pop(job.number, None)
        if given is None:
            return []
        if reply is None:
            reply = crashed(code, output)
        if phase in (Phase.LOADING, Phase.WARMING_UP):
            key = given.solver, given.profile
            reply = self._load_failures.note_failure(key, job.warm_up, reply)
            if reply is None:
                self.put_first([given])
                return []
        return [(given, WorkerReply(reply))]

    def _count_false_start(self, code: int, output: str) -> None:
        self._false_starts += 1
        if self._false_starts >= _MAX_FALSE_STARTS:
            raise RunError(
                f"worker processes end before they solve anything ({exit_status(code)[1]}"
                f"{': ' + output if output else ''}); the rows written so far are kept"
            )

    def _replace(self, place: int, worker: WorkerProcess) -> None:
        """End a worker; the jobs that it was given wait again, and start another one."""
        self._remove(place, worker)
        self._take_back(worker.pending)

    def _remove(self, place: int, worker: WorkerProcess) -> None:
        worker.process.kill()
        worker.exit_code()
        for source in (worker.process.channel, worker.process.output, worker.process.status):
            with suppress(KeyError):  # it was closed by the worker
                self._selector.unregister(source)
        self._workers[place] = None
        worker.process.close()

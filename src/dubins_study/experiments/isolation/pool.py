"""A pool of worker processes with hard limits: takes jobs, yields (job, reply) pairs.

If a solver crashes or blocks its worker, the job gets a reply too. The pool judges no answer.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from time import monotonic
from typing import Any, NamedTuple, Self

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.fork_server import ForkServerError
from dubins_study.experiments.isolation.messages import WorkerReply, decode_reply, encode_question
from dubins_study.experiments.isolation.worker_process import (
    POLL_INTERVAL_S,
    Allowance,
    Answer,
    Ended,
    Task,
    Watch,
    WorkerProcess,
)
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load, ours
from dubins_study.solvers.reply import Reply, no_answer, with_possible_times

_SERVE = "dubins_study.experiments.isolation.worker:serve"
# Seconds beyond the time limit: a solver that respects the limit needs a moment to send its answer.
# With the poll interval and the kill itself, a solve ends within 0.3 s of its limit.
GRACE_S = 0.1
# Seconds that a solver may take to load, and that a warm-up may take beyond the time limit: it
# loads what later solves find loaded.
_LOADING = Allowance(60.0, activity="loading the solver")
_WARM_UP_S = 10.0
_PROBING = Allowance(60.0, activity="measuring its speed")
# A worker that never waits for its pool has jobs in advance: as long as those that it has are
# expected to take less than `AHEAD_S`, and at most `_AHEAD_JOBS`.
AHEAD_S, _AHEAD_JOBS = 0.05, 64
# How long a solve takes is expected from those before it: their mean, in which each new one has
# this weight, and counts at most that many seconds. One slow solve is forgotten soon.
_NEW_WEIGHT, _MAX_COUNTED_S = 0.2, 0.1
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


class Limits(NamedTuple):
    """Seconds that a solve may take, and bytes that a worker and its children may use."""

    time_s: float
    memory_bytes: int


# A solver's spec and profile.
SolverKey = tuple[str, str]


class Job(NamedTuple):
    """One question to one solver; the caller may attach any object as `tag`."""

    solver: str
    profile: str
    question: Question
    tag: Any = None

    @property
    def solver_key(self) -> SolverKey:
        """Spec and profile: a worker loads a solver once for all jobs with the same key."""
        return self.solver, self.profile


# Jobs and the replies to them.
Results = list[tuple[Job, WorkerReply]]


@cache
def worker_group(solver: str) -> str:
    """The group of a solver: only jobs of the same group share workers.

    Our own solvers that keep their limits are one group. One that does not is a group by itself: a
    worker that is killed takes its loaded solvers with it, and loading a hundred takes half a
    minute. So is each plug-in, since it may have changed any module of its process.
    """
    if not ours(solver):
        return solver
    return "" if load(solver).keeps_limit else solver


class _Worker(WorkerProcess):
    """A worker process, the group whose jobs it solves, and the solvers that it has loaded."""

    def __init__(self, group: str, memory_bytes: int):
        super().__init__(_SERVE, [memory_bytes], memory_bytes)
        self.group = group
        self.loaded: set[SolverKey] = set()
        # Whether tasks were dropped that it still has: it ends with its last pending task.
        self.final = False

    def may_take_more(self) -> bool:
        """Whether it may get a job in advance."""
        soon = self.expected_s < AHEAD_S and len(self.pending) < _AHEAD_JOBS
        return soon and not self.final

    def jobs(self) -> Iterator[Job]:
        """Its unanswered jobs."""
        return (task.tag for task in self.pending if _is_solve(task))

    def keep_first_job(self) -> None:
        """Drop all jobs but the first, which it is solving or makes ready for."""
        for place, task in enumerate(self.pending, 1):
            if _is_solve(task):
                self.final |= len(self.pending) > place
                while len(self.pending) > place:
                    self.pending.pop()
                return


class WorkerPool:
    """Worker processes, started when there are jobs and kept until the `with` block ends.

    With `warm_up` a worker asks its solvers an easy question before their first job. `probed` is
    called every two seconds with the duration (s) of a calibration probe.
    """

    def __init__(
        self,
        workers: int,
        limits: Limits,
        *,
        warm_up: bool = True,
        probed: Callable[[float], None] | None = None,
    ):
        self._limits, self._probed = limits, probed
        self._solving = Allowance(limits.time_s, GRACE_S)
        self._warming_up = Allowance(limits.time_s + _WARM_UP_S, activity="warming up")
        self._workers: list[_Worker | None] = [None] * workers
        self._watch = Watch()
        self._warm_up = warm_up
        # Solvers whose warm-up ended a worker: they are loaded without it.
        self._without_warm_up: set[SolverKey] = set()
        # Solver -> seconds that its next solve is expected to take; a solver that has answered.
        self._expected_s: dict[SolverKey, float] = {}
        # Solver that ended its worker while it was loaded -> the reply to its other jobs.
        self._unloadable: dict[SolverKey, Reply] = {}
        self._first: deque[Job] = deque()
        self._later: Iterator[Job] = iter(())
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
            worker.kill()

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Put jobs at the front of the queue, in their order; allowed while `solve` runs."""
        self._first.extendleft(reversed(list(jobs)))

    def drop_waiting(self) -> None:
        """Forget the jobs that no worker has; allowed while `solve` runs."""
        self._first.clear()
        self._later = iter(())

    def solve(self, jobs: Iterable[Job], stop: Interruption) -> Iterator[Results]:
        """Yield the replies to all jobs as they come, and an empty list if none come for a while.

        Jobs are read when a worker is free, and solved in this order except after `put_first`.
        After an interruption only the current solves are finished.
        """
        self.drop_waiting()
        self._later = iter(jobs)
        self._watch.begin()
        yielded_s = monotonic()
        while True:
            if stop.requested:
                self.drop_waiting()
                for worker in self._live_workers():
                    worker.keep_first_job()
            results = self._feed()
            busy = any(worker.pending for worker in self._live_workers())
            if not (results or busy or self._next_job()):
                return
            timeout_s = 0.0 if results else POLL_INTERVAL_S
            for worker, event in self._watch.wait(self._live_workers(), timeout_s):
                if isinstance(event, Answer):
                    results += self._answered(worker, event)
                else:
                    results += self._ended(worker, event)
            if results or monotonic() - yielded_s > _YIELD_INTERVAL_S:
                yield results
                yielded_s = monotonic()

    def _live_workers(self) -> list[_Worker]:
        return [worker for worker in self._workers if worker is not None]

    def _next_job(self) -> Job | None:
        """The first waiting job, which stays in the queue; None if there is none."""
        if not self._first:
            job = next(self._later, None)
            if job is None:
                return None
            self._first.append(job)
        return self._first[0]

    def _feed(self) -> Results:
        """Give jobs to workers; return a few replies to jobs of unloadable solvers."""
        results: Results = []
        while len(results) < _MAX_RESULTS and (job := self._next_job()) is not None:
            reply = self._unloadable.get(job.solver_key)
            if reply is not None:
                results.append((self._first.popleft(), WorkerReply(reply)))
                continue
            worker = self._free_worker(worker_group(job.solver))
            if worker is None:
                break
            self._give(worker, self._first.popleft())
        first = self._workers[0]
        due = self._probed is not None and monotonic() > self._next_probe_s
        if due and first is not None and not first.final:
            self._next_probe_s = monotonic() + _PROBE_INTERVAL_S
            first.put(["probe"], _PROBING, float)
        return results

    def _free_worker(self, group: str) -> _Worker | None:
        """A worker that can take a job of the group, perhaps a new one; None if there is none.

        Best is an idle worker of the group, then a new process, then one in the place of an idle
        worker of another group, then the worker of the group that is expected to be free first.
        """
        ranks = []
        for place, worker in enumerate(self._workers):
            if worker is None:
                ranks.append((1, 0.0, place))
            elif not worker.pending:
                ranks.append((0 if worker.group == group else 2, 0.0, place))
            elif worker.group == group and worker.may_take_more():
                ranks.append((3, worker.expected_s, place))
        if not ranks:
            return None
        place = min(ranks)[-1]
        worker = self._workers[place]
        if worker is not None and worker.group != group:
            self._remove(worker)
            worker = None
        if worker is None:
            try:
                worker = self._workers[place] = _Worker(group, self._limits.memory_bytes)
            except (OSError, ForkServerError) as error:
                raise RunError(f"no worker process starts ({error})") from None
        return worker

    def _give(self, worker: _Worker, job: Job) -> None:
        """Give a worker a job, and before it the tasks that make the job's solver ready."""
        key = job.solver_key
        expected_s = self._expected_s.get(key, AHEAD_S)
        if key not in worker.loaded:
            worker.loaded.add(key)
            expected_s = AHEAD_S
            worker.put(["load", *key], _LOADING, _ignored, job)
            if self._warm_up and key not in self._without_warm_up:
                message = ["warm up", *key, self._limits.time_s]
                worker.put(message, self._warming_up, _ignored, job)
        message = ["solve", *key, encode_question(job.question), self._limits.time_s]
        worker.put(message, self._solving, decode_reply, job, expected_s)

    def _answered(self, worker: _Worker, answer: Answer) -> Results:
        self._false_starts = 0
        if answer.changed or (worker.final and not worker.pending):
            self._remove(worker)
        if isinstance(answer.value, float) and self._probed is not None:
            self._probed(answer.value)
        if not isinstance(answer.value, WorkerReply):
            return []
        job: Job = answer.task.tag
        seconds = min(answer.seconds, _MAX_COUNTED_S)
        mean_s = self._expected_s.get(job.solver_key, seconds)
        self._expected_s[job.solver_key] = mean_s + _NEW_WEIGHT * (seconds - mean_s)
        reply = with_possible_times(answer.value.reply, answer.waited_s)
        return [(job, answer.value._replace(reply=reply))]

    def _ended(self, worker: _Worker, ended: Ended) -> Results:
        """Replace a worker that has ended; return the reply to the job that it was at, if any."""
        reply, task = ended
        job: Job | None = None if task is None else task.tag
        self._remove(worker)
        if task is None or job is None:
            self._false_starts += 1
            if self._false_starts >= _MAX_FALSE_STARTS:
                raise RunError(
                    f"worker processes end before they solve anything ({reply.solution.message})"
                )
            return []
        self._false_starts = 0
        if task.allowance is self._warming_up:  # load the solver again, without a warm-up
            self._without_warm_up.add(job.solver_key)
            return []
        if task.allowance is _LOADING:
            reply = self._load_failed(job.solver_key, reply)
        self._first.popleft()  # the job, which comes first among those that were put back
        return [(job, WorkerReply(reply))]

    def _load_failed(self, solver: SolverKey, reply: Reply) -> Reply:
        """The reply to a job whose solver ended its worker while it was loaded."""
        (outcome, solution, _), status = reply, reply.solution.native_status
        message = f"{solution.message}, while it was loaded"
        if solver not in self._expected_s:
            later_message = f"{message} for another cell; not tried again"
            self._unloadable[solver] = no_answer(outcome, later_message, status=status)
        return no_answer(outcome, message, status=status)

    def _remove(self, worker: _Worker) -> None:
        """End a worker and free its place; put its unanswered jobs back in the queue."""
        self._workers[self._workers.index(worker)] = None
        worker.close()
        self.put_first(worker.jobs())


def _is_solve(task: Task) -> bool:
    return task.tag is not None and task.decode is decode_reply


def _ignored(value: Any) -> None:
    """Decode the answer to a task that only makes a solver ready."""

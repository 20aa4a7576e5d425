"""A pool of worker processes with hard limits.

A pool takes jobs and yields pairs (job, reply).

If a solver crashes or blocks its worker, the job gets a reply too. The pool judges no answer.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from functools import cache
from time import monotonic
from typing import Any, NamedTuple, Self

from dubins_study.asking.reply import Reply, no_answer, with_possible_times
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.fork_server import ForkServerError
from dubins_study.experiments.isolation.messages import decode_reply, encode_question
from dubins_study.experiments.isolation.worker_process import (
    POLL_INTERVAL_S,
    Allowance,
    Answered,
    Ended,
    Task,
    WorkerProcess,
    wait,
)
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load, ours

# Kinds of tasks (see `worker`), the first item of their messages.
_WARM_UP = "warm up"
_WARM_UP_ROUTE = 3  # place in its message: whether the question is a route
_SOLVE = "solve"
# Seconds beyond the time limit: a solver that respects the limit needs a moment to send its answer.
# With the poll interval and the kill itself, a solve ends within 0.3 s of its limit.
GRACE_S = 0.1
# Seconds that a solver may take to load.
_LOADING = Allowance(60.0, activity="loading the solver")
# Seconds that a warm-up may take beyond the time limit: it loads libraries for later solves.
_WARM_UP_S = 10.0
_PROBING = Allowance(60.0, activity="measuring its speed")
# A worker gets jobs in advance, so that it never waits for its pool. It gets one more if its jobs
# are expected to take less than `AHEAD_S`, and has at most `_AHEAD_JOBS`.
AHEAD_S = 0.05
_AHEAD_JOBS = 64
# After this many seconds without a reply, yield an empty list, so that the caller can write rows.
_YIELD_INTERVAL_S = 0.2
# Seconds between two calibration probes.
_PROBE_INTERVAL_S = 2.0
# Number of workers in a row that may end before they begin a job.
_MAX_FALSE_STARTS = 3
_BYTES_PER_GIB = 2**30


class RunError(DubinsStudyError, RuntimeError):
    """No more questions can be asked.

    The rows that a run has written so far are kept.
    """


# A solver's spec and profile.
SolverKey = tuple[str, str]


class Job(NamedTuple):
    """One question to one solver.

    The caller may attach any object as `tag`.
    """

    solver: str
    profile: str
    question: Question
    time_limit_s: float
    tag: Any = None

    @property
    def solver_key(self) -> SolverKey:
        """Spec and profile.

        A worker loads a solver once for all jobs with the same key.
        """
        return self.solver, self.profile


# Jobs and the replies to them.
Results = list[tuple[Job, Reply]]


@cache
def worker_group(solver: str) -> str:
    """The name of a solver's group.

    Only jobs of the same group share workers. Our own solvers that keep their limits are one group,
    with an empty name. Any other solver is a group by itself, named by its spec. If a worker is
    killed, its loaded solvers are lost, and loading a hundred takes half a minute. A plug-in may
    have changed any module of its process.
    """
    if ours(solver) and load(solver).keeps_limit:
        return ""
    return solver


def _solves(task: Task) -> bool:
    """Whether a task answers a job's question.

    Other tasks load or warm up a solver.
    """
    return task.message[:1] == [_SOLVE]


class _Worker(WorkerProcess):
    """A worker process for the jobs of one group.

    `loaded` and `warmed` name the solvers that its tasks load and warm up.
    """

    def __init__(self, group: str, memory_bytes: int):
        function = "dubins_study.experiments.isolation.worker:serve"
        super().__init__(function, [memory_bytes], memory_bytes)
        self.group = group
        self.loaded: set[SolverKey] = set()
        self.warmed: set[tuple[SolverKey, bool]] = set()  # True: on a route, False: on a leg


class WorkerPool:
    """Worker processes, kept until the `with` block ends.

    Workers are started when there are jobs.

    With `warm_up` a worker asks its solvers an easy question before their first job. `probed` is
    called every two seconds with the duration (s) of a calibration probe; with it the floors of
    the solvers' times are measured, too.
    """

    def __init__(
        self,
        workers: int,
        memory_limit_gib: float = 4.0,
        *,
        warm_up: bool = True,
        probed: Callable[[float], None] | None = None,
    ):
        self._probed = probed
        self._memory_bytes = round(memory_limit_gib * _BYTES_PER_GIB)
        self._most_workers = workers
        self._workers: list[_Worker] = []
        self._warm_up = warm_up
        # Warm-ups that ended a worker and are not tried again: solver, and whether on a route.
        self._without_warm_up: set[tuple[SolverKey, bool]] = set()
        # Solver that has answered -> seconds of its last solve, which are expected of the next.
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
        for worker in [*self._workers]:
            self._remove(worker)

    def kill_workers(self) -> None:
        """Kill all workers; may be called from any thread."""
        for worker in [*self._workers]:
            worker.kill()

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Put jobs at the front of the queue.

        The jobs keep their order. A caller may do this while `solve` runs.
        """
        self._first.extendleft(reversed(list(jobs)))

    def begin_no_more(self) -> None:
        """Read no further jobs; allowed while `solve` runs.

        Jobs that are put first, such as the next cell of a chain, are still solved.
        """
        self._later = iter(())

    def solve(self, jobs: Iterable[Job], stop: Interruption) -> Iterator[Results]:
        """Yield the replies to all jobs as they come.

        Each list has pairs of a job and its reply. The list is empty if none come for a while.

        Jobs are read when a worker is free. After an interruption the current solves are finished.
        """
        self._first.clear()
        self._later = iter(jobs)
        yielded_s = monotonic()
        while True:
            if stop.requested:
                self._first.clear()
                self.begin_no_more()
            results = self._feed()
            if not (results or any(worker.pending for worker in self._workers)):
                return
            timeout_s = POLL_INTERVAL_S
            if results:
                timeout_s = 0.0
            for worker, event in wait([*self._workers], timeout_s):
                if isinstance(event, Ended):
                    results += self._ended(worker, event)
                    continue
                results += self._answered(worker, event)
                # A changed worker answers no more. After an interruption no worker begins another
                # job: its waiting jobs go back to the queue, which is then emptied.
                if event.changed or (_solves(event.task) and stop.requested):
                    self._remove(worker)
            if results or monotonic() - yielded_s > _YIELD_INTERVAL_S:
                yield results
                yielded_s = monotonic()

    def _next_job(self) -> Job | None:
        """The first waiting job, or None.

        The job stays in the queue.
        """
        if not self._first:
            job = next(self._later, None)
            if job is None:
                return None
            self._first.append(job)
        return self._first[0]

    def _feed(self) -> Results:
        """Give jobs to workers until none takes more.

        If the solver of the next job cannot be loaded, that job and its reply are returned at once.
        Otherwise the list is empty. A calibration probe is put every two seconds.
        """
        while (job := self._next_job()) is not None:
            reply = self._unloadable.get(job.solver_key)
            if reply is not None:
                return [(self._first.popleft(), reply)]
            worker = self._free_worker(worker_group(job.solver))
            if worker is None:
                break
            self._give(worker, self._first.popleft())
        if self._workers and self._probed is not None and monotonic() > self._next_probe_s:
            self._next_probe_s = monotonic() + _PROBE_INTERVAL_S
            self._workers[0].put(["probe"], _PROBING)
        return []

    def _free_worker(self, group: str) -> _Worker | None:
        """A worker for a group's job, or None.

        The worker may be a new one. Best is an idle worker of the group, then a new process, then
        one in the place of an idle worker of another group, then the worker of the group that is
        expected to be free first.
        """
        idle = [worker for worker in self._workers if not worker.pending]
        for worker in idle:
            if worker.group == group:
                return worker
        if idle and len(self._workers) == self._most_workers:
            self._remove(idle[0])
        if len(self._workers) < self._most_workers:
            return self._start(group)
        candidates = [
            worker
            for worker in self._workers
            if worker.group == group and len(worker.pending) < _AHEAD_JOBS
        ]
        first = min(candidates, key=self._expected_left_s, default=None)
        if first is None or self._expected_left_s(first) >= AHEAD_S:
            return None
        return first

    def _start(self, group: str) -> _Worker:
        """A new worker."""
        try:
            worker = _Worker(group, self._memory_bytes)
        except (OSError, ForkServerError) as error:
            raise RunError(f"no worker process starts ({error})") from None
        self._workers.append(worker)
        return worker

    def _expected_left_s(self, worker: _Worker) -> float:
        """Seconds until a worker has answered all its tasks.

        The number is an estimate.
        """
        return sum(map(self._expected_task_s, worker.pending))

    def _expected_task_s(self, task: Task) -> float:
        """Seconds that a task is expected to take.

        For a solve they are the seconds of the solver's last one. Any other task, and a solver's
        first solve, counts as `AHEAD_S`: no further job is then put behind it.
        """
        if not _solves(task):
            return AHEAD_S
        return self._expected_s.get(task.tag.solver_key, AHEAD_S)

    def _give(self, worker: _Worker, job: Job) -> None:
        """Put a job's tasks into a worker's queue.

        Tasks that load the solver and warm it up come before the solve, once per worker.
        """
        key = job.solver_key
        limit_s = job.time_limit_s
        if key not in worker.loaded:
            worker.loaded.add(key)
            worker.put(["load", *key], _LOADING, job)
        warm_ups = {False: "warming up on a leg"}  # by whether the question is a route
        if job.question.scenario.via:
            warm_ups[True] = "warming up on a route"
        for route, activity in warm_ups.items():
            if self._warm_up and (key, route) not in worker.warmed | self._without_warm_up:
                worker.warmed.add((key, route))
                message = [_WARM_UP, *key, route, limit_s, self._probed is not None]
                worker.put(message, Allowance(limit_s + _WARM_UP_S, activity=activity), job)
        message = [_SOLVE, *key, encode_question(job.question), limit_s]
        worker.put(message, Allowance(limit_s, margin_s=GRACE_S), job)

    def _answered(self, worker: _Worker, answer: Answered) -> Results:
        """The answered job with its reply.

        The list is empty for a load, a warm-up or a probe. The duration of a probe is reported, and
        the duration of a solve is kept as the estimate for the next one.
        """
        self._false_starts = 0
        task = answer.task
        if task.allowance is _PROBING and self._probed is not None:
            self._probed(answer.value)
        if not _solves(task):
            return []
        reply = with_possible_times(decode_reply(answer.value), monotonic() - task.put_s)
        self._expected_s[task.tag.solver_key] = reply.times.wall_s or 0.0
        return [(task.tag, reply)]

    def _ended(self, worker: _Worker, ended: Ended) -> Results:
        """Remove an ended worker; return its job's reply.

        The jobs behind that job go back to the queue. The list is empty if the worker had begun no
        job, or was warming up: the job is then asked without this warm-up.
        """
        reply = ended.reply
        task = ended.task
        self._remove(worker)
        if task is None or task.tag is None:  # it was starting, idle, or measuring its speed
            self._false_starts += 1
            if self._false_starts >= _MAX_FALSE_STARTS:
                raise RunError(
                    f"worker processes end before they solve anything ({reply.solution.message})"
                )
            return []
        self._false_starts = 0
        key = task.tag.solver_key
        if task.message[0] == _WARM_UP:  # load the solver again, without this warm-up
            self._without_warm_up.add((key, task.message[_WARM_UP_ROUTE]))
            return []
        if task.allowance is _LOADING:
            solution = reply.solution
            message = f"{solution.message}, while it was loaded"
            reply = no_answer(reply.outcome, message, status=solution.native_status)
            if key not in self._expected_s:
                self._unloadable[key] = reply
        self._first.popleft()  # the job, which comes first among those that were put back
        return [(task.tag, reply)]

    def _remove(self, worker: _Worker) -> None:
        """End a worker; put back its unanswered jobs."""
        self._workers.remove(worker)
        worker.close()
        self.put_first(task.tag for task in worker.pending if _solves(task))

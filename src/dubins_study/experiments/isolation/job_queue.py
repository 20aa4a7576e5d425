"""Jobs on their way through a pool: each one waits, or is with a worker under a number."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from functools import cache
from itertools import count, islice
from typing import Any, NamedTuple

from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import ours


class Job(NamedTuple):
    """One question to one solver; `tag` is the caller's."""

    solver: str
    profile: str
    question: Question
    tag: Any = None

    @property
    def solver_key(self) -> tuple[str, str]:
        """What a worker loads once for all jobs that share it."""
        return self.solver, self.profile


@cache
def worker_group(solver: str) -> str:
    """Jobs of one group share workers: our own solvers do, each plug-in has its own workers.

    A plug-in may have changed any module of its process.
    """
    return "" if ours(solver) else solver


# never the same number twice, so that no late reply of a worker passes for another job's
_numbers = count()


class JobQueue:
    """Jobs in the caller's order, but for those that are put first.

    Args:
        jobs: taken only as they are needed.
    """

    def __init__(self, jobs: Iterable[Job] = ()):
        self._later: Iterator[Job] = iter(jobs)
        self._first: deque[Job] = deque()
        self._given: dict[int, Job] = {}

    def __bool__(self) -> bool:
        return bool(self._given or self.waiting(1))

    def waiting(self, most: int) -> int:
        """How many jobs wait, counted up to a number."""
        if len(self._first) < most:
            self._first.extend(islice(self._later, most - len(self._first)))
        return len(self._first)

    def next(self) -> Job | None:
        """The next job, which still waits."""
        return self._first[0] if self.waiting(1) else None

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Let jobs wait before all others, in their order."""
        self._first.extendleft(reversed(list(jobs)))

    def skip(self) -> None:
        """The next job needs no worker."""
        self._first.popleft()

    def give(self) -> int:
        """The number under which a worker is given the next job."""
        number = next(_numbers)
        self._given[number] = self._first.popleft()
        return number

    def done(self, number: int) -> Job:
        """The job of a number that a worker is through with."""
        return self._given.pop(number)

    def take_back(self, numbers: Iterable[int]) -> None:
        """Let jobs that no worker has begun wait again, before all others and in their order."""
        self.put_first([self._given.pop(number) for number in numbers])

    def forget_waiting(self) -> None:
        """Forget every job that is not with a worker."""
        self._first.clear()
        self._later = iter(())

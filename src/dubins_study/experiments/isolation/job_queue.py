"""Jobs for a pool, and the order in which its workers are given them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from functools import cache
from itertools import islice
from typing import Any, NamedTuple

from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import ours

# a solver's spec and profile
SolverKey = tuple[str, str]


class Job(NamedTuple):
    """One question to one solver; `tag` is the caller's."""

    solver: str
    profile: str
    question: Question
    tag: Any = None

    @property
    def solver_key(self) -> SolverKey:
        """What a worker loads once for all jobs that share it."""
        return self.solver, self.profile


@cache
def worker_group(solver: str) -> str:
    """Jobs of one group share workers: our own solvers do, each plug-in has its own workers.

    A plug-in may have changed any module of its process.
    """
    return "" if ours(solver) else solver


class JobQueue:
    """Jobs in the caller's order, but for those that are put first.

    Args:
        jobs: taken only as they are needed.
    """

    def __init__(self, jobs: Iterable[Job] = ()):
        self._first: deque[Job] = deque()
        self._later = iter(jobs)

    def waiting(self, most: int) -> int:
        """How many jobs wait, counted up to a number."""
        if len(self._first) < most:
            self._first.extend(islice(self._later, most - len(self._first)))
        return len(self._first)

    def next(self) -> Job | None:
        """The next job, which still waits."""
        return self._first[0] if self.waiting(1) else None

    def take(self) -> Job:
        """The next job, which waits no more."""
        return self._first.popleft()

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Let jobs wait before all others, in their order."""
        self._first.extendleft(reversed(list(jobs)))

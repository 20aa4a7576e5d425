"""Jobs for a pool, and the order in which its workers are given them."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from functools import cache
from itertools import islice
from typing import Any, NamedTuple

from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load, ours

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


class JobQueue:
    """Jobs in the caller's order, except those that are put first.

    Args:
        jobs: read one by one when they are needed.
    """

    def __init__(self, jobs: Iterable[Job] = ()):
        self._first: deque[Job] = deque()
        self._later = iter(jobs)

    def waiting(self, most: int) -> int:
        """Number of waiting jobs, or `most` if there are more."""
        if len(self._first) < most:
            self._first.extend(islice(self._later, most - len(self._first)))
        return len(self._first)

    def next(self) -> Job | None:
        """The next job; it stays in the queue. None if the queue is empty."""
        return self._first[0] if self.waiting(1) else None

    def take(self) -> Job:
        """Remove the next job from the queue and return it."""
        return self._first.popleft()

    def put_first(self, jobs: Iterable[Job]) -> None:
        """Put jobs at the front of the queue, in their order."""
        self._first.extendleft(reversed(list(jobs)))

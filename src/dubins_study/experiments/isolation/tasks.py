"""Chains of cells on their way through workers: what waits, and what has been put to one."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from functools import cache
from itertools import count
from typing import NamedTuple

from dubins_study.experiments.isolation.worker import Order
from dubins_study.experiments.plan.cells import Cell, Chain, given_guess
from dubins_study.solvers.registry import ours
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Key


class Task(NamedTuple):
    """Where a chain of cells has got to, and the last path found on the way."""

    chain: Chain
    place: int
    path: Path | None

    @property
    def cell(self) -> Cell:
        return self.chain[self.place]

    @property
    def kind(self) -> str:
        """Cells of one kind share workers: all of our own solvers do, a plug-in's have their own.

        A plug-in may have changed any module of its process, which nothing puts back.
        """
        return _kind(self.cell.solver)

    def initial_guess(self) -> Path | None:
        return self.path if self.cell.initial_guess == "warm" else given_guess(self.cell)


class Tasks:
    """Every task is in one place: it waits, or is with a worker under an order's number."""

    def __init__(self, chains: Iterable[Chain] = (), before: Mapping[Key, Path] | None = None):
        known = before or {}
        tasks = [Task(chain, 0, known.get(chain[0].key)) for chain in chains]
        # ours first, then each plug-in by itself, so that a worker is seldom replaced between them
        self.waiting = deque(sorted(tasks, key=lambda task: task.kind))
        self._given: dict[int, Task] = {}
        self._numbers = count()

    def __bool__(self) -> bool:
        return bool(self.waiting or self._given)

    def give(self, task: Task, limit: float, warm_up: bool) -> Order:
        """The order by which a worker is asked a task that no longer waits."""
        number, cell = next(self._numbers), task.cell
        self._given[number] = task
        scenario, branch = cell.scenario, cell.branch
        return Order(
            number,
            cell.solver,
            cell.profile,
            scenario,
            branch,
            task.initial_guess(),
            limit,
            warm_up,
        )

    def take(self, number: int) -> Task:
        """The task of an order that a worker is through with."""
        return self._given.pop(number)

    def take_back(self, numbers: Iterable[int]) -> None:
        """Tasks that no worker got to wait again, before all others and in their order."""
        self.waiting.extendleft(reversed([self.take(number) for number in numbers]))

    def go_on(self, task: Task, path: Path | None) -> None:
        """The next cell of a task's chain waits, before all others, for the path found now."""
        if task.place + 1 < len(task.chain):
            # after a failure the last path that was found serves on
            self.waiting.appendleft(Task(task.chain, task.place + 1, path or task.path))


@cache
def _kind(spec: str) -> str:
    return "" if ours(spec) else spec

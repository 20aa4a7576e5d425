"""One search: the function that every engine calls, counted, with a deadline and a budget."""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.stochastic.penalty_function import PenaltyFunction
from dubins_study.study.path import FloatArray


class SearchEndError(Exception):
    """The search is over, whatever the engine would still do."""


class BudgetSpentError(SearchEndError):
    """As many evaluations as were granted; the next would be too many."""


class OutOfTimeError(SearchEndError):
    """The time limit."""


class CountedFunction:
    """A penalty function that counts its evaluations and keeps the best point.

    What ends the search is raised out of the engine. So every engine stops at the same budget to
    the evaluation, and none can return a worse point than it has seen.

    Args:
        function: to minimise.
        budget: largest number of evaluations.
        until: when to stop, on `perf_counter` (s).
    """

    def __init__(self, function: PenaltyFunction, budget: int, until: float) -> None:
        self.function, self.budget, self._until = function, budget, until
        self.evaluations = 0
        self.value = math.inf
        self.best: FloatArray = np.full(function.upper.size, math.nan)

    def __call__(self, free: FloatArray) -> float:
        """The value at one point, shape (n,)."""
        self._spend(1)
        value = self.function.at(free)
        if value < self.value:
            self.value, self.best = value, np.array(free)
        return value

    def at_each(self, free: FloatArray) -> FloatArray:
        """The values at several points, shape (n, points) -> (points,)."""
        self._spend(free.shape[1])
        values = self.function.at_each(free)
        least = int(np.argmin(values))
        if values[least] < self.value:
            self.value, self.best = float(values[least]), free[:, least].copy()
        return values

    def _spend(self, evaluations: int) -> None:
        if self.evaluations + evaluations > self.budget:
            raise BudgetSpentError(f"{self.budget} evaluations are spent")
        if perf_counter() > self._until:
            raise OutOfTimeError("out of time")
        self.evaluations += evaluations


class Task(NamedTuple):
    """What an engine is given.

    Args:
        function: to minimise; `function.function.upper` are the upper bounds of its variables.
        guess: where to begin, shape (n,); None for engines that take none.
        random: the source of every random number.
    """

    function: CountedFunction
    guess: FloatArray | None
    random: np.random.Generator

    @property
    def upper(self) -> FloatArray:
        """Upper bounds of the variables, shape (n,); the lower ones are 0."""
        return self.function.function.upper

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """The box, as SciPy takes it."""
        return [(0.0, float(high)) for high in self.upper]


# Minimises until the engine has enough; returns the engine's own message.
Engine = Callable[[Task], str]

"""The model (4.12) without equations, and search engines.

The function is the length plus a weight times the miss. The model, and the size that its weight
needs: docs/formulations/penalty.md. The box 0 <= z1, z2 <= 2 pi, 0 <= z3 <= |T| + 3 holds every
solution. Full turns are never part of a shortest path (docs/derivation.md, section 7). The straight
is a tangent of the second turn's circle, whose centre is within 3 of the start.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from time import perf_counter
from typing import Any, NamedTuple, Protocol

import numpy as np

from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.one_leg.model import Case, end_point
from dubins_study.solvers.runs import EngineResult
from dubins_study.solvers.setting_checks import OPTION_SETS, OptionValues
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import Claim

_FARTHEST_CENTRE = 3.0  # radii from the start: 1 to the first circle's centre, 2 to the second's


class BoxFunction(Protocol):
    """A function of n variables in a box.

    The variables are between 0 and upper bounds.
    """

    upper: FloatArray  # shape (n,)

    def at(self, free: FloatArray) -> float:
        """The value at one point, shape (n,)."""

    def at_each(self, free: FloatArray) -> FloatArray:
        """The values at several points.

        Shape (n, points) -> (points,).
        """


class PenaltyFunction:
    """The function phi of a case's free lengths."""

    def __init__(self, case: Case, weight: float) -> None:
        self._free = list(case.subproblem.free)
        self._target = case.target.X, case.target.Y
        self._weight = weight
        farthest = math.hypot(*self._target) + _FARTHEST_CENTRE
        # upper bounds of the free lengths, shape (n,); the lower ones are 0
        self.upper: FloatArray = np.array((TWO_PI, TWO_PI, farthest))[self._free]

    def at(self, free: FloatArray) -> float:
        """The value of phi at one point (radii).

        The free lengths have shape (n,), in radii.
        """
        z = [0.0, 0.0, 0.0]
        for index, length in zip(self._free, free.tolist(), strict=True):
            z[index] = length
        return float(self._phi(z, math))

    def at_each(self, free: FloatArray) -> FloatArray:
        """The values of phi at several points.

        Shape (n, points) -> (points,).
        """
        z = np.zeros((3, free.shape[1]))
        z[self._free] = free
        values: FloatArray = self._phi(z, np)
        return values

    def _phi(self, z: Any, functions: Any) -> Any:
        z1, z2, z3 = z
        X, Y = self._target
        x, y = end_point(z1, z1 - z2, z3, functions)
        return z1 + z2 + z3 + self._weight * functions.hypot(X - x, Y - y)

    def lengths(self, free: FloatArray) -> FloatArray:
        """All three lengths z of a point.

        The free ones are cut to the box; shape (n,) -> (3,).
        """
        z = np.zeros(3)
        z[self._free] = np.clip(free, 0.0, self.upper)
        return z


class SearchEndError(Exception):
    """The evaluations or the time are spent.

    It ends the search whatever the engine would still do.
    """


class CountedFunction:
    """A function that counts its evaluations.

    The attributes `best` and `value` are the best point so far and its value. `trace` lists each
    point that was the best, with the evaluations until then.

    After `budget` evaluations, or at the time `until` (s, on `perf_counter`), a SearchEndError is
    raised out of the engine. So every engine stops at the same budget, and none returns a worse
    point than it has seen.
    """

    def __init__(self, function: BoxFunction, budget: float, until: float) -> None:
        self.function = function
        self.budget = budget
        self._until = until
        self.trace: list[tuple[int, FloatArray]] = []
        self.evaluations = 0
        self.value = math.inf
        self.best: FloatArray = np.full(function.upper.size, math.nan)

    def __call__(self, free: FloatArray) -> float:
        """The value at one point, shape (n,)."""
        self._spend(1)
        value = self.function.at(free)
        if value < self.value:
            self._improve(value, free)
        return value

    def at_each(self, free: FloatArray) -> FloatArray:
        """The values at several points.

        Shape (n, points) -> (points,).
        """
        self._spend(free.shape[1])
        values = self.function.at_each(free)
        least = int(np.argmin(values))
        if values[least] < self.value:
            self._improve(float(values[least]), free[:, least])
        return values

    def _improve(self, value: float, point: FloatArray) -> None:
        self.value = value
        self.best = np.array(point)
        self.trace.append((self.evaluations, self.best))

    def _spend(self, evaluations: int) -> None:
        if self.evaluations + evaluations > self.budget:
            raise SearchEndError(f"{self.budget} evaluations are spent")
        if perf_counter() > self._until:
            raise SearchEndError("out of time")
        self.evaluations += evaluations


class Task(NamedTuple):
    """The task that an engine is given."""

    function: CountedFunction  # to minimise
    guess: FloatArray | None  # where to begin, shape (n,); None for engines that take none
    random: np.random.Generator  # the source of every random number

    @property
    def upper(self) -> FloatArray:
        """Upper bounds of the variables, shape (n,).

        The lower bounds are 0.
        """
        return self.function.function.upper

    def _elsewhere(self) -> Task:
        """The same task from a uniform random point.

        A task without a guess stays as it is.
        """
        if self.guess is None:
            return self
        return self._replace(guess=self.upper * self.random.uniform(size=self.upper.size))

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """The box, as SciPy takes it."""
        return [(0.0, float(high)) for high in self.upper]

    def search(
        self, engine: str, options: str = OPTION_SETS[0], restarts: bool = False
    ) -> EngineResult:
        """Let an engine minimise.

        Returns the end of the search, with the best point that was evaluated. With `restarts` an
        engine that ends earlier begins anew until the evaluations are spent. An engine that takes a
        guess then begins at a random point, uniform in the box.
        """
        claim = Claim.FEASIBLE
        run: Search = ENGINES[engine].load()(options=options)
        try:
            message = run(self)
            while restarts:
                message = run(self._elsewhere())
        except SearchEndError as end:
            claim = Claim.LIMIT
            message = str(end)
        if self.function.evaluations >= self.function.budget:  # the engine counts as well
            claim = Claim.LIMIT
        return EngineResult(
            self.function.best,
            claim,
            evaluations=self.function.evaluations,
            status=claim.value,
            message=message,
        )


# The engines: each minimises until it stops by itself, and returns its own message. The budget
# replaces all its own limits on evaluations and iterations.

Search = Callable[[Task], str]


# Arguments of SciPy's global searches beside the box and the options of their set.
_LIMITS: dict[str, Callable[[Task], OptionValues]] = {
    "differential_evolution": lambda task: {"maxiter": task.function.budget, "rng": task.random},
    "dual_annealing": lambda task: {"maxiter": task.function.budget, "rng": task.random},
    "shgo": lambda task: {"options": {"maxfev": task.function.budget}},
    "direct": lambda task: dict.fromkeys(("maxfun", "maxiter"), task.function.budget),
}


def scipy_search(options: OptionValues, name: str) -> Search:
    """A global search of `scipy.optimize`.

    With `vectorized` it evaluates a generation at once.
    """

    def run(task: Task) -> str:
        from scipy import optimize

        function: Any = task.function
        if options.get("vectorized"):
            function = task.function.at_each
        arguments = _LIMITS[name](task) | options
        message = getattr(optimize, name)(function, task.bounds, **arguments).message
        if isinstance(message, list):
            return str(message[0])
        return str(message)

    return run


def minimize(options: OptionValues, method: str) -> Search:
    """A method of `scipy.optimize.minimize` within the box.

    The search returns SciPy's message; `task.function` keeps the best point.
    """

    def run(task: Task) -> str:
        from scipy import optimize

        limits = dict.fromkeys(("maxiter", "maxfev"), task.function.budget)
        chosen = {"bounds": task.bounds, "options": limits | options}
        ended = optimize.minimize(task.function, task.guess, method=method, **chosen)
        return str(ended.message)

    return run


def cma_es(options: OptionValues) -> Search:
    """CMA-ES of the package `cma`, from a uniform point.

    A restart begins from another point.
    """
    chosen = dict(options)
    step = chosen.pop("sigma0")
    restarts = chosen.pop("restarts", 0)

    def run(task: Task) -> str:
        import cma

        n = task.upper.size
        upper = np.resize(task.upper, max(n, 2))  # cma refuses a single variable: a second is idle

        def begin() -> FloatArray:
            return upper * task.random.uniform(size=upper.size)

        of_task: OptionValues = {
            "bounds": [0.0, upper.tolist()],
            "CMA_stds": upper,
            "maxfevals": task.function.budget,
            # numbers from `task.random`; with a seed cma would seed NumPy's own generator
            "randn": lambda *shape: task.random.standard_normal(shape),
            "seed": math.nan,
        }
        _, strategy = cma.fmin2(
            lambda free: task.function(free[:n]), begin, step, of_task | chosen, restarts=restarts
        )
        return ", ".join(strategy.stop())

    return run

"""CMA-ES of the package `cma`, restarted with doubled populations as its makers advise (IPOP)."""

from __future__ import annotations

import math
from typing import Any

from dubins_study.solvers.stochastic.search import Task
from dubins_study.study.path import FloatArray

# of the box's width: the makers' advice is about a quarter of the range that holds the optimum
_STEP = 0.25
_RESTARTS = 9  # the most that `cma` advises; the budget ends the search before


def cma_es(task: Task) -> str:
    """Restarts from uniform points until the budget is spent."""
    import cma

    def begin() -> FloatArray:
        return task.upper * task.random.uniform(size=task.upper.size)

    options: dict[str, Any] = {
        "bounds": [0.0, task.upper.tolist()],
        "CMA_stds": task.upper,
        "maxfevals": task.function.budget,
        # numbers from `task.random`; with a seed cma would seed NumPy's own generator
        "randn": lambda *shape: task.random.standard_normal(shape),
        "seed": math.nan,
        "verbose": -9,
        "verb_log": 0,
    }
    _, strategy = cma.fmin2(task.function, begin, _STEP, options, restarts=_RESTARTS)
    return ", ".join(strategy.stop())

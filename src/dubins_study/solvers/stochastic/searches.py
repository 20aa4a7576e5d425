"""The engines of the penalty function: SciPy's searches and CMA-ES.

An option that is not named has its default.
"""

from __future__ import annotations

import math
from typing import Any

from dubins_study.solvers.stochastic.penalty_function import Task
from dubins_study.study.path import FloatArray

# CMA-ES, as its makers advise: a step of about a quarter of the box's width, and at most so many
# restarts; the budget ends the search before
_STEP, _RESTARTS = 0.25, 9
_EXACT = 1e-10  # where a search stops by itself: radii, and values of the function


def differential_evolution(task: Task) -> str:
    """Storn and Price's; a generation is evaluated at once, which takes a tenth of the time."""
    from scipy.optimize import differential_evolution

    result = differential_evolution(
        task.function.at_each,
        task.bounds,
        maxiter=task.function.budget,
        # less greedy than SciPy's best1bin and (0.5, 1), under which one of five runs gathers about
        # a longer path in the disc's centre
        strategy="randtobest1bin",
        mutation=(0.5, 1.5),
        tol=0.0,
        atol=_EXACT,
        polish=False,  # by L-BFGS-B, which wants a smooth function
        rng=task.random,
        vectorized=True,
        updating="deferred",
    )
    return str(result.message)


def dual_annealing(task: Task) -> str:
    """Generalised simulated annealing, with its own local searches by L-BFGS-B."""
    from scipy.optimize import dual_annealing

    # every step takes several evaluations, so that the budget ends it
    steps = task.function.budget
    result = dual_annealing(task.function, task.bounds, maxiter=steps, rng=task.random)
    return str(result.message[0])


def shgo(task: Task) -> str:
    """Simplicial homology: local searches by SLSQP from what a triangulation finds."""
    from scipy.optimize import shgo

    result = shgo(task.function, task.bounds, options={"maxfev": task.function.budget})
    return str(result.message)


def direct(task: Task) -> str:
    """Dividing rectangles, locally biased; deterministic."""
    from scipy.optimize import direct

    budget = task.function.budget
    limits = {"maxfun": budget, "maxiter": budget, "vol_tol": 0.0, "len_tol": _EXACT}
    return str(direct(task.function, task.bounds, **limits).message)


def nelder_mead(task: Task) -> str:
    """The simplex of Nelder and Mead, cut to the box."""
    return _minimize(task, "Nelder-Mead", {"xatol": _EXACT, "fatol": _EXACT})


def powell(task: Task) -> str:
    """Powell's search along conjugate directions."""
    return _minimize(task, "Powell", {"xtol": _EXACT, "ftol": _EXACT})


def _minimize(task: Task, method: str, options: dict[str, float]) -> str:
    from scipy.optimize import minimize

    limits: dict[str, Any] = dict.fromkeys(("maxiter", "maxfev"), task.function.budget)
    result = minimize(
        task.function, task.guess, method=method, bounds=task.bounds, options=options | limits
    )
    return str(result.message)


def cma_es(task: Task) -> str:
    """CMA-ES of the package `cma`, with restarts from uniform points and doubled populations."""
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

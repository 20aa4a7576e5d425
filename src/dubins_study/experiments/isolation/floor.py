"""Floor of a time: seconds for a trivial problem.

The engine solves it through the same adapter. Beside the time of a solve, the floor shows the
overhead of the adapter and the engine.
"""

from __future__ import annotations

import math
import timeit
from collections.abc import Callable, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from dubins_study.solvers.convex.adapters import Ask, prepare
from dubins_study.solvers.convex.solver import Convex
from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.one_leg.model import case_of, end_point
from dubins_study.solvers.paper_nlp.nlp import PaperNlp
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.registry import load
from dubins_study.solvers.tour.circuit import TourCircuit
from dubins_study.solvers.tour.milp import TourMilp
from dubins_study.solvers.tour.routing import TourRouting
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import Local
from dubins_study.study.convex.problem import read
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import DERIVATIVE_FREE, NLP, PROVEN, QP, ROOTS, SAMPLING

# The first call loads and compiles. Of the others, the shortest counts; quick ones are repeated.
_REPEATS = 5
_QUICK_S = 0.1
_LIMIT_S = 1.0


def floor_s(solver: Solver) -> float | None:
    """Seconds of an engine's call on a trivial problem.

    None if the solver has no trivial problem, or if the call fails or takes a second.
    """
    try:
        call = _trivial(solver)
        if call is None:
            return None
        call()
        timer = timeit.Timer(call, timer=perf_counter)
        seconds = timer.timeit(1)
        if seconds < _QUICK_S:
            seconds = min(seconds, *timer.repeat(_REPEATS, 1))
        if seconds >= _LIMIT_S:
            return None
        return seconds
    except Exception:  # whatever a library raises
        return None


def _trivial(solver: Solver) -> Callable[[], Any] | None:
    """A function that solves a trivial problem, or None.

    The function takes no arguments, and calls the solver's own engine. None if the solver calls
    no engine that is known here.
    """
    if isinstance(solver, PaperNlp):
        return _word(solver)
    if isinstance(solver, Convex):
        return _one_variable(solver)
    if isinstance(solver, TourMilp | TourCircuit | TourRouting):
        return _two_places(solver)
    engine = getattr(solver, "engine", getattr(solver, "root", None))
    if not isinstance(engine, str) or engine not in ENGINES:
        return None
    return _BY_KIND[ENGINES[engine].kind](engine)


def _word(solver: PaperNlp) -> Callable[[], Any]:
    """A function that solves LS, begun at the solution."""
    # lengths in radii: left turn, right turn, straight; the target is at the end of this path
    z = np.array((0.5, 0.0, 1.0))
    X, Y = end_point(0.5, 0.5, 1.0, math)
    adapter = solver.adapter()
    case = case_of("LS", Local(X, Y, 0.0))
    return lambda: adapter(case, z, _LIMIT_S)


def _one_variable(solver: Convex) -> Callable[[], Any]:
    """A function that builds and solves a frozen problem.

    The problem has one variable.
    """
    problem = read("trivial")
    ask = Ask(solver.tolerance, _LIMIT_S, tuned=solver.options == "tuned")
    return lambda: prepare(solver.engine, solver.interface, problem)(ask)


def _two_places(solver: Solver) -> Callable[[], Any]:
    """A function that solves a tour of two places.

    Each place has one heading. The model is built here, once.
    """
    model = solver.build(Question(Scenario(target_x=5, target_y=0, final_heading=0)))
    return lambda: solver.solve(model, _LIMIT_S)


def _nlp(engine: str) -> Callable[[], Any] | None:
    return _trivial(load(f"nlp[engine={engine}]"))


def _proven(engine: str) -> Callable[[], Any]:
    """A function that minimises x on [0, 2].

    The row x >= 1 bounds it.
    """
    from dubins_study.solvers.minlp_engines.mixed_program import (
        MixedProgram,
        Row,
        Settings,
        Written,
    )

    def write(x: Sequence[Any], functions: Any) -> Written:
        return Written(x[0], [Row(x[0], 1.0, math.inf)])

    program = MixedProgram(np.zeros(1), np.full(1, 2.0), np.zeros(1, np.bool_), write)
    solve = ENGINES[engine].load()(Settings(gap=1e-6, feastol=1e-8))
    return lambda: solve(program, _LIMIT_S)


class _Square:
    """Function (x - 1)^2 on [0, 2], for searches."""

    upper: FloatArray = np.full(1, 2.0)

    def at(self, free: FloatArray) -> float:
        return float((free[0] - 1.0) ** 2)

    def at_each(self, free: FloatArray) -> FloatArray:
        values: FloatArray = (free[0] - 1.0) ** 2
        return values


def _search(engine: str) -> Callable[[], Any]:
    """A function that minimises a square of one variable.

    The search has the engine's default budget of evaluations. They cost nothing here, so that the
    engine's own work is measured.
    """
    from dubins_study.solvers.stochastic.penalty_function import CountedFunction, Task

    def call() -> Any:
        end = perf_counter() + _LIMIT_S
        function = CountedFunction(_Square(), ENGINES[engine].evaluations, end)
        return Task(function, np.full(1, 0.5), np.random.default_rng(0)).search(engine)

    return call


def _root(engine: str) -> Callable[[], Any]:
    from scipy.optimize import root

    return lambda: root(lambda x: x - 1.0, np.zeros(1), method=engine)


def _qp(engine: str) -> Callable[[], Any]:
    """A function that minimises a square with cvxpy.

    cvxpy compiles the problem at the first call only.
    """
    import cvxpy

    x = cvxpy.Variable(nonneg=True)
    nearest = cvxpy.Parameter(value=1.0)
    problem = cvxpy.Problem(cvxpy.Minimize(cvxpy.square(x - nearest)))
    return lambda: problem.solve(solver=engine.upper())


_BY_KIND: dict[str, Callable[[str], Callable[[], Any] | None]] = {
    NLP: _nlp,
    PROVEN: _proven,
    SAMPLING: _search,
    DERIVATIVE_FREE: _search,
    ROOTS: _root,
    QP: _qp,
}

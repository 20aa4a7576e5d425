"""qpbenchmark's side: quadratic programs.

Each cell is one program: the point nearest to a target.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import qpsolvers
from qpbenchmark.problem import Problem
from qpbenchmark.solver_settings import SolverSettings
from qpbenchmark.test_set import TestSet
from qpbenchmark.tolerance import Tolerance

from benchmarks.overhead.trivial import TARGET_Y, question, solved, targets


def _solve(problem: Problem, **_: object) -> qpsolvers.Solution:
    path = solved(question(-float(problem.q[0])))
    solution = qpsolvers.Solution(problem)
    solution.found = True
    solution.x = np.array(path.end[:2])
    solution.y = solution.z = solution.z_box = np.empty(0)
    return solution


qpsolvers.solvers.solve_function["trivial"] = _solve
for known in (qpsolvers.available_solvers, qpsolvers.dense_solvers):
    known.append("trivial")
SolverSettings.IMPLEMENTED_SOLVERS.add("trivial")


class Projections(TestSet):
    """Quadratic programs: the nearest point to each target.

    Each minimises |z|^2 / 2 - target . z over the plane.
    """

    description = title = "projections"
    sparse_only = False

    def __init__(self, cells: int):
        self.cells = cells
        super().__init__()
        self.solvers = {"trivial"}

    def define_tolerances(self, runtime: float = 10.0) -> None:
        self.tolerances = {"default": Tolerance(1.0, 1.0, 1.0, runtime)}

    def define_solver_settings(self) -> None:
        self.solver_settings = {"default": SolverSettings()}

    def __iter__(self) -> Iterator[Problem]:
        for number, x in enumerate(targets(self.cells)):
            q = np.array([-x, -TARGET_Y])
            yield Problem(np.eye(2), q, *[None] * 6, name=str(number))

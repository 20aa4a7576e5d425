"""The MILP of `heading-milp`: stated in cvxpy, compiled once, then solved for new parameters."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.sparse import csr_array, eye_array, kron

from solvers.turn_rate_template import Compiled
from study.path import FloatArray

# Sub-MIPs cost several times what they save on problems that are solved in a few dozen nodes.
_OPTIONS = {
    "threads": 1,
    "mip_heuristic_run_rins": False,
    "mip_heuristic_run_rens": False,
    "mip_heuristic_run_root_reduced_cost": False,
    "primal_feasibility_tolerance": 1e-9,
    "mip_feasibility_tolerance": 1e-9,
    "mip_abs_gap": 1e-9,
}


class Answer(NamedTuple):
    """HiGHS's answer.

    Its status; the choice made in every group (None without a point); the bound it proved on
    the objective; nodes; simplex iterations.
    """

    status: str
    chosen: list[int] | None
    bound: float
    nodes: int
    iterations: int


class Template:
    """The MILP for groups of given sizes, N choices in all, q + 1 legs with every choice.

        minimise    sum_j toll_j z_j + sum_jr slope_jr s_jr
        subject to  sum_j shift_j z_j + sum_jr direction_jr s_jr = target
                    sum_r s_jr <= reach_j z_j        legs only with their own choice
                    sum over a group of z_j = 1,  z binary,  s >= 0

    `z_j` says that a turn ends with step j, so step i is taken when the z_j from i on sum to one:
    a binary for every turning step, ordered as turning is. Stated by last steps, the linear
    relaxation is much tighter than with a binary "step i is taken" for every step.

    The parameters toll, reach (N,), slope (N (q+1),), shift (2, N), direction (2, N (q+1)) and
    target (2,) are attributes, arrays to be written into.
    """

    toll: FloatArray
    slope: FloatArray
    shift: FloatArray
    direction: FloatArray
    target: FloatArray
    reach: FloatArray

    def __init__(self, sizes: tuple[int, ...], legs: int) -> None:
        import cvxpy as cp

        n, each = sum(sizes), legs + 1
        shapes: dict[str, Any] = {
            "toll": n,
            "slope": n * each,
            "shift": (2, n),
            "direction": (2, n * each),
            "target": 2,
            "reach": n,
        }
        p = {name: cp.Parameter(shape, name=name) for name, shape in shapes.items()}
        self.z, self.s = cp.Variable(n, boolean=True), cp.Variable(n * each, bounds=[0, None])
        self.starts = np.cumsum((0, *sizes))
        member = csr_array(
            (np.ones(n), (np.repeat(np.arange(len(sizes)), sizes), np.arange(n))),
            shape=(len(sizes), n),
        )
        own = kron(eye_array(n), np.ones((1, each)), format="csr")
        constraints = [
            p["shift"] @ self.z + p["direction"] @ self.s == p["target"],
            member @ self.z == 1,
            own @ self.s - cp.multiply(p["reach"], self.z) <= 0,
        ]
        objective = cp.Minimize(p["toll"] @ self.z + p["slope"] @ self.s)
        self.problem = cp.Problem(objective, constraints)
        self._compiled = Compiled(self.problem, list(p.values()), "HIGHS")
        for name, view in zip(p, self._compiled.views, strict=True):
            setattr(self, name, view)

    def solve(self, gap: float, cutoff: float, seconds: float) -> Answer:
        """Solve the MILP for the parameters' present values.

        Args:
            gap: relative gap of bound and objective at which HiGHS calls it optimal.
            cutoff: objective above which nothing is looked for.
            seconds: time limit.
        """
        import cvxpy as cp

        self._compiled.memory.clear()  # or an answer would depend on the question before
        options = {"mip_rel_gap": gap, "objective_bound": cutoff, "time_limit": seconds}
        try:
            self._compiled.solve(_OPTIONS | options)
        except cp.error.SolverError as error:
            return Answer(str(error), None, -np.inf, 0, 0)
        info = self.problem.solver_stats.extra_stats
        return Answer(
            str(self.problem.status),
            self._chosen(),
            float(info.mip_dual_bound),
            int(info.mip_node_count),
            int(info.simplex_iteration_count),
        )

    def _chosen(self) -> list[int] | None:
        z = self.z.value
        if z is None:
            return None
        groups = [z[a:b] for a, b in zip(self.starts[:-1], self.starts[1:], strict=True)]
        if any(group.max() < 0.5 for group in groups):
            return None  # stopped at a limit without a point, cvxpy hands on zeros
        return [int(np.argmax(group)) for group in groups]


@lru_cache(maxsize=32)
def template(sizes: tuple[int, ...], legs: int) -> Template:
    """The compiled MILP; kept, since compiling takes as long as many solves."""
    return Template(sizes, legs)

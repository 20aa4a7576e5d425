"""The MILP of `heading-milp`: compiled once for HiGHS, or stated anew for another engine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.sparse import eye_array, kron

from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.minlp_engines.program import (
    MixedProgram,
    ProvenResult,
    Row,
    Settings,
    Written,
)
from dubins_study.solvers.optimal_control.turn_rate_template import Compiled
from dubins_study.study.path import FloatArray
from dubins_study.study.words import Claim

# of rows, in radii or shares of a gap: the least that HiGHS, Gurobi and SCIP all take
TOLERANCE = 1e-9

# The linear relaxation is nearly always integral, so that HiGHS hardly branches. Presolving and
# heuristics, which save branching, take several times longer than all the rest.
_OPTIONS = {
    "threads": 1,
    "presolve": "off",
    "mip_detect_symmetry": False,
    "mip_heuristic_run_feasibility_jump": False,
    "primal_feasibility_tolerance": TOLERANCE,
    "mip_feasibility_tolerance": TOLERANCE,
    "mip_abs_gap": 1e-9,
}


# what cvxpy calls the ends of HiGHS's runs
_CLAIMS = {
    "optimal": Claim.OPTIMAL,
    "infeasible": Claim.INFEASIBLE,
    "user_limit": Claim.LIMIT,
}


class Template:
    """The MILP for n choices with m legs each:

        minimise    sum_j toll_j z_j + sum_jr slope_jr s_jr
        subject to  sum_r along_jr s_jr = z_j     for every choice j, the legs lead from the end
                    sum_r across_jr s_jr = 0      of its turns to the target
                    sum_j z_j = 1,  z binary,  s >= 0

    `along` and `across` are the legs' directions relative to the gap between the end of the turns
    and the target, and s_jr are lengths in units of that gap. A pair of equations for every choice
    makes the linear relaxation the convex hull of the choices (Balas 1985, Disjunctive programming
    and a hierarchy of relaxations, SIAM J. Algebraic Discrete Methods 6). The parameters toll (n,),
    slope, along and across (n m,) are arrays to be written into.
    """

    toll: FloatArray
    slope: FloatArray
    along: FloatArray
    across: FloatArray

    def __init__(self, n: int, m: int) -> None:
        import cvxpy as cp

        self.n = n
        shapes = {"toll": n, "slope": n * m, "along": n * m, "across": n * m}
        p = {name: cp.Parameter(shape, name=name) for name, shape in shapes.items()}
        self.z, s = cp.Variable(n, boolean=True), cp.Variable(n * m, bounds=[0, None])
        each_choice = kron(eye_array(n), np.ones((1, m)), format="csr")
        bridged = [
            each_choice @ cp.multiply(p["along"], s) - self.z == 0,
            each_choice @ cp.multiply(p["across"], s) == 0,
        ]
        objective = cp.Minimize(p["toll"] @ self.z + p["slope"] @ s)
        self.problem = cp.Problem(objective, [*bridged, cp.sum(self.z) == 1])
        self._compiled = Compiled(self.problem, list(p.values()), "HIGHS")
        for name, view in zip(p, self._compiled.views, strict=True):
            setattr(self, name, view)

    def solve(self, gap: float, cutoff: float, seconds: float) -> ProvenResult:
        """Solve the MILP for the parameters' present values, to a relative gap; points with an
        objective above `cutoff` are ignored. The point's first n variables are z, the status is
        cvxpy's word.
        """
        import cvxpy as cp

        self._compiled.memory.clear()  # or an answer would depend on the previous question
        options = {"mip_rel_gap": gap, "objective_bound": cutoff, "time_limit": seconds}
        try:
            self._compiled.solve(_OPTIONS | options)
        except cp.error.SolverError as error:
            return ProvenResult(None, Claim.FAILED, -math.inf, 0, 0, str(error), "")
        info, status = self.problem.solver_stats.extra_stats, str(self.problem.status)
        z, counts = self.z.value, (int(info.mip_node_count), int(info.simplex_iteration_count))
        # HiGHS leaves zeros where it stopped at its limit without a point
        point = z if z is not None and z.max() > 0.5 else None
        claim = _CLAIMS.get(status, Claim.FAILED)
        return ProvenResult(point, claim, float(info.mip_dual_bound), *counts, status, "")


@lru_cache(maxsize=32)
def template(n: int, m: int) -> Template:
    """The compiled MILP; kept, since compiling takes as long as many solves."""
    return Template(n, m)


class Stated:
    """The same MILP as `Template` has, with the same attributes."""

    def __init__(self, n: int, m: int, name: str) -> None:
        self.n, self.m, self.name = n, m, name
        self.toll = np.zeros(n)
        self.slope, self.along, self.across = (np.zeros(n * m) for _ in range(3))

    def solve(self, gap: float, cutoff: float, seconds: float) -> ProvenResult:
        """Solve the MILP for the parameters' present values; as `Template.solve`."""
        n, size = self.n, self.n * (1 + self.m)
        upper = np.full(size, math.inf)
        upper[:n] = 1.0
        program = MixedProgram(np.zeros(size), upper, np.arange(size) < n, self._write)
        # as with HiGHS: the relaxation is nearly always integral, so that branching needs no help
        settings = Settings(gap, TOLERANCE, lean=True, cutoff=cutoff)
        result: ProvenResult = ENGINES[self.name].load()(settings)(program, seconds)
        known = (status for status, claim in _CLAIMS.items() if claim is result.claim)
        return result._replace(
            status=next(known, result.message),
            nodes=result.nodes or 0,
            iterations=result.iterations or 0,
        )

    def _write(self, x: Sequence[Any], functions: Any) -> Written:
        n, m = self.n, self.m
        z, s = x[:n], x[n:]
        rows = [Row(_sum(z), 1.0, 1.0)]
        for j in range(n):
            legs = range(m * j, m * (j + 1))
            rows.append(Row(_product(self.along, s, legs) - z[j]))
            if self.across[legs].any():
                rows.append(Row(_product(self.across, s, legs)))
        objective = _product(self.toll, z, range(n)) + _product(self.slope, s, range(n * m))
        return Written(objective, rows)


def _product(numbers: Any, variables: Sequence[Any], places: range) -> Any:
    return _sum([float(numbers[i]) * variables[i] for i in places])


def _sum(terms: Sequence[Any]) -> Any:
    """The sum by halves: term by term some interfaces copy all that went before."""
    if len(terms) == 1:
        return terms[0]
    half = len(terms) // 2
    return _sum(terms[:half]) + _sum(terms[half:])

"""The MILP of `heading-milp` for the engines of `solvers.minlp_engines`, stated anew each time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.heading_milp.template import TOLERANCE, Answer
from dubins_study.solvers.minlp_engines.program import MixedProgram, Row, Settings, Written
from dubins_study.study.words import Claim

# what cvxpy calls the ends of HiGHS's runs
_STATUSES = {
    Claim.OPTIMAL: "optimal",
    Claim.INFEASIBLE: "infeasible",
    Claim.LIMIT: "user_limit",
}


class Stated:
    """The same MILP as `solvers.heading_milp.template.Template`, with the same attributes."""

    def __init__(self, n: int, m: int, name: str) -> None:
        self.n, self.m, self.name = n, m, name
        self.toll = np.zeros(n)
        self.slope, self.along, self.across = (np.zeros(n * m) for _ in range(3))

    def solve(self, gap: float, cutoff: float, seconds: float) -> Answer:
        """Solve the MILP for the parameters' present values; as `Template.solve`."""
        n, size = self.n, self.n * (1 + self.m)
        upper = np.full(size, math.inf)
        upper[:n] = 1.0
        program = MixedProgram(np.zeros(size), upper, np.arange(size) < n, self._write)
        # as with HiGHS: the relaxation is nearly always integral, so that branching needs no help
        settings = Settings(gap, TOLERANCE, lean=True, cutoff=cutoff)
        result = ENGINES[self.name].load()(settings)(program, seconds)
        return Answer(
            _STATUSES.get(result.claim, result.message),
            None if result.x is None else int(np.argmax(result.x[:n])),
            result.bound,
            result.nodes or 0,
            result.iterations or 0,
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

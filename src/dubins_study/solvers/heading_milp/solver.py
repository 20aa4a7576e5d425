"""`heading-milp`: turns that end on a grid of headings, chosen by a MILP, and straight legs."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any, ClassVar, NamedTuple

import numpy as np
from scipy.sparse import eye_array, kron

from dubins_study.solvers.answers import Run, at_start, coordinate_rounding, costs, in_world
from dubins_study.solvers.engines import ENGINES, MINLP_ENGINES, EngineSolver, packages
from dubins_study.solvers.heading_milp.grid import (
    FULL_TURN,
    ROUNDED,
    Family,
    Legs,
    controls,
    least_legs,
    one_turn,
    rounding,
    two_turns,
)
from dubins_study.solvers.minlp_engines.program import (
    MixedProgram,
    ProvenResult,
    Row,
    Settings,
    Written,
)
from dubins_study.solvers.optimal_control.turn_rate_template import Compiled
from dubins_study.solvers.paper_nlp.polish import one_sided_only
from dubins_study.solvers.presolve import nearer_first
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.setting_checks import one_of, whole, within
from dubins_study.study.path import FloatArray, Path
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


class Template(Compiled):
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
        problem = cp.Problem(objective, [*bridged, cp.sum(self.z) == 1])
        super().__init__(problem, list(p.values()), "HIGHS")

    def solve(self, gap: float, cutoff: float, seconds: float) -> ProvenResult:
        """Solve the MILP to a relative gap; points with an objective above `cutoff` are ignored.

        The point's first n variables are z, the status is cvxpy's word.
        """
        import cvxpy as cp

        self.forget()
        options = {"mip_rel_gap": gap, "objective_bound": cutoff, "time_limit": seconds}
        try:
            self.solve_compiled(_OPTIONS | options)
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

    def __init__(self, n: int, m: int, engine: str) -> None:
        self.n, self.m, self.engine = n, m, engine
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
        result: ProvenResult = ENGINES[self.engine].load()(settings)(program, seconds)
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


class Choice(NamedTuple):
    """What one MILP has chosen; without a path that arrives, `legs` is None."""

    family: Family
    choice: int
    legs: Legs | None


def solution(
    question: Question, runs: list[Run[Choice]], complete: bool, grid: str, engine: str
) -> Solution:
    """The shortest path of the MILPs that there was time for, `complete` if these are all.

    `grid` and `engine` are for messages.
    """
    scenario, R = question.scenario, question.scenario.radius
    counts = costs(runs)
    counts["native_status"] = "; ".join(
        dict.fromkeys(f"{run.subproblem} {run.status}" for run in runs)
    )
    claims = {run.claim for run in runs}
    stopped = not complete or Claim.LIMIT in claims
    best = min(runs, key=lambda run: run.length, default=None)
    if best is None or best.point.legs is None:
        message = f"no path on {grid} was found"
        if not stopped and claims == {Claim.INFEASIBLE}:
            message = f"{message}: {engine} proves that there is none, on this grid only"
        return Solution(Claim.LIMIT if stopped else Claim.FAILED, message=message, **counts)
    done = claims <= {Claim.OPTIMAL, Claim.INFEASIBLE}
    claim = Claim.LIMIT if stopped else Claim.LOCAL if done else Claim.FEASIBLE
    curvature, length = controls(best.point.family, best.point.choice, best.point.legs.length)
    path = Path(scenario.start, np.array(curvature) / R, np.array(length) * R)
    # "infeasible": the family has no path shorter than the best one, at whose length it is cut off
    bound = min(best.length if run.claim is Claim.INFEASIBLE else run.bound for run in runs)
    message = f"{best.subproblem}; not all words were solved"
    if math.isfinite(bound):
        proven = f"{engine}'s bound {bound * R:.9g}"
        message = (
            f"{best.subproblem}; {proven} holds for paths on {grid} only, not for the scenario"
        )
    if claim is not Claim.LIMIT and (reason := one_sided_only(question, path)):
        claim, message = Claim.FAILED, reason
    return Solution(
        claim,
        path=path,
        claimed_length=best.length * R,
        multipliers=None if best.duals is None else in_world(scenario, best.duals),
        message=message,
        best_run=best.effort,
        **counts,
    )


BRANCHES = ("best", "LS", "RS")
# not MAiNGO, which ended in no time limit here even for LS alone
_ENGINES = ("highs", *(name for name in MINLP_ENGINES if name != "maingo"))


class Case(NamedTuple):
    """One MILP of a question: the shape of its paths, and the problem that it is put into."""

    family: Family
    milp: Template | Stated


class Model(NamedTuple):
    """A question; its target (2,) in body coordinates, in radii."""

    question: Question
    target: FloatArray
    cases: list[Case]


@dataclass(frozen=True)
class HeadingMilp(EngineSolver):
    """Full-rate turning steps between headings on a grid, and straight legs; optimal on that grid.

    One MILP for each word: LS and RS with a binary for every turning step, and for `best` near the
    start also RL and LR with a binary for every pair of steps. The legs are continuous. The
    optimum is that of the discretised problem, and so is the engine's bound, which the message
    states.
    LR and RL as branches allow nothing but two full-rate arcs. On a grid of headings these end in
    finitely many points, so the two branches are not answered.

    Args:
        headings: number of turning steps in a full circle.
        legs: number of parts of the last step before a straight; legs may be driven between them.
            With 1 they have the grid's headings only. Driving between two of these headings
            instead of along one costs a length that falls with the square of headings * legs.
        engine: `highs`, in a problem that cvxpy has compiled; `scip`, `gurobi`, `xpress` or
            `maingo`, stated anew for every question. The licences in Gurobi's and Xpress' wheels
            end at 2 000 variables and at 5 000 variables and rows: with 72 headings RL and LR have
            3 250 variables, with 48 all words fit. MAiNGO is not made for so many binaries.
        gap: relative gap at which the engine calls an answer optimal.
        presolve: whether words that cannot exist are left out (`solvers.presolve`).
    """

    engine: str = one_of("highs", _ENGINES)
    # With steps above 30 degrees a CC path has hardly a first arc. cvxpy's memory grows with the
    # square of the number of headings, to two gigabytes at the upper ends.
    headings: int = whole(72, 12, 1000)
    legs: int = whole(6, 1, 12)
    gap: float = within(1e-6, 0, 1, ends=False)
    presolve: bool = False

    name: ClassVar[str] = "heading-milp"
    guarantee: ClassVar[Guarantee] = Guarantee.DISCRETISED
    branches: ClassVar[tuple[str, ...]] = BRANCHES
    packages: ClassVar[tuple[str, ...]] = packages(("highs", *MINLP_ENGINES))
    summary: ClassVar[str] = (
        "turning steps between headings on a grid as binaries, by a MILP engine"
    )
    variants: ClassVar[tuple[str, ...]] = tuple(
        f"heading-milp[engine={name}]" for name in _ENGINES if name != "highs"
    )
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"headings": 48},
        "accurate": {"headings": 144},
    }

    @property
    def method(self) -> Method:
        return Method("grid of headings", ENGINES[self.engine].label, "none", TOLERANCE)

    @property
    def keeps_limit(self) -> bool:
        # compiling takes 0.3 s at 1800 headings of legs, 2.4 s at 6000 and 8 s at 12 000
        return self.headings * self.legs <= 1000

    def build(self, question: Question) -> Model:
        target = np.array(question.scenario.local())
        families = self._families(question, *map(float, target))
        milp = template if self.engine == "highs" else partial(Stated, engine=self.engine)
        cases = [Case(family, milp(*family.heading.shape)) for family in families]
        return Model(question, target, cases)

    def _families(self, question: Question, X: float, Y: float) -> list[Family]:
        """The families of a question; the likelier side first, since its length cuts off others."""
        families: list[Family] = []
        for word in nearer_first(question, self.presolve, Y):
            if word[1] == "S":
                side = 1 if word == "LS" else -1
                families.append(one_turn(side, self.headings, self.legs, X, Y))
            else:
                families += two_turns(1 if word == "RL" else -1, self.headings)
        return families

    def solve(self, model: Model, limit: float) -> Solution:
        deadline = time.perf_counter() + limit
        if answer := at_start(model.question, coordinate_rounding(model.question.scenario)):
            return answer
        runs: list[Run[Choice]] = []
        cutoff = self._longest(math.hypot(*model.target))
        for case in model.cases:
            seconds = deadline - time.perf_counter()
            if seconds <= 0:
                break
            runs.append(_solved(case, model.target, cutoff, self.gap, seconds))
            cutoff = min(cutoff, runs[-1].length)
        return solution(
            model.question,
            runs,
            len(runs) == len(model.cases),
            f"the grid of {self.headings} headings",
            ENGINES[self.engine].label,
        )

    def _longest(self, distance: float) -> float:
        """An upper bound (radii) on the shortest length: a full turn and a straight.

        The straight is longer than the distance by a radius, and by 1 / cos(b / 2) between two
        headings b apart.
        """
        between = FULL_TURN / (self.headings * self.legs)
        return (distance + 3 * math.pi) / math.cos(between / 2)


def _solved(
    case: Case, target: FloatArray, cutoff: float, gap: float, seconds: float
) -> Run[Choice]:
    """The run of one MILP for a target (2,) in radii; longer paths than `cutoff` are ignored.

    The objective is a path's length less the target's distance, so that a gap keeps its meaning
    however far the target is.
    """
    family, milp = case
    distance = math.hypot(*target)
    gaps = target[:, None] - family.shift
    bridged = np.hypot(*gaps)
    # the legs' directions relative to the gap that they bridge; their parts across it are scaled
    # to a largest of 1, or neighbouring directions would differ by less than HiGHS's tolerance
    seen = family.heading - np.arctan2(gaps[1], gaps[0])[:, None]
    seen[bridged <= ROUNDED] = 0.0
    across = np.sin(seen)
    across[np.abs(across) * bridged[:, None] <= rounding(bridged)[:, None]] = 0.0
    widest = np.abs(across).max(axis=1, keepdims=True)
    bearing = math.atan2(target[1], target[0])
    milp.along[:] = np.cos(seen).ravel()
    milp.across[:] = (across / np.where(widest > 0, widest, 1.0)).ravel()
    milp.toll[:] = family.length - target @ family.shift / distance
    # 1 - cos, which keeps no digits of small angles
    slope = bridged[:, None] * 2 * np.sin((family.heading - bearing) / 2) ** 2
    milp.slope[:] = slope.ravel()
    began = time.perf_counter()
    result = milp.solve(gap, cutoff - distance, seconds)
    spent = time.perf_counter() - began
    choice, legs, length = 0, None, math.inf
    if result.x is not None:
        choice = int(np.argmax(result.x[: milp.n]))
        legs = least_legs(family.heading[choice], gaps[:, choice])
    if legs is not None:
        length = float(family.length[choice] + legs.length.sum())
    return result.run(family.name, spent, Choice(family, choice, legs), length)._replace(
        duals=legs and legs.duals,
        iterations=result.iterations,
        evaluations=result.nodes,
        bound=distance + result.bound,
    )

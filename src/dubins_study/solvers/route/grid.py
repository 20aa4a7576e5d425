"""`heading-milp`: the headings at the points on a grid, chosen by a mixed-integer linear program.

With exact legs between any two headings of the grid, this is a shortest path through layers, whose
linear relaxation is integral: an engine has nothing to branch on. So it is a check of what engines
make of the easiest of integer programs, and of what a grid costs. The legs are the closed form's.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from typing import Any, ClassVar, NamedTuple

import numpy as np
from scipy.sparse import block_array, csr_array, eye_array, kron

from dubins_study.solvers.course import coordinate_rounding, path_of
from dubins_study.solvers.engines import MINLP_ENGINES, EngineSolver, others, packages
from dubins_study.solvers.minlp_engines.mixed_program import (
    MixedProgram,
    ProvenResult,
    Row,
    Settings,
    Written,
)
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.route.legs import WORD_TURNS, Route, legs, route_of
from dubins_study.solvers.runs import Run, at_start, spent
from dubins_study.solvers.setting_checks import one_of, whole, within
from dubins_study.solvers.statuses import claim_of
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import IN_ORDER, Claim

# of rows: the least that HiGHS takes
TOLERANCE = 1e-9
# not MAiNGO, which ended in no time limit here
_ENGINES = ("highs", *(name for name in MINLP_ENGINES if name != "maingo"))


class Layers(NamedTuple):
    """Headings at the points, and the lengths (radii) of legs between those of two points.

    Of n legs: n + 1 arrays of headings (rad), and n of lengths, shape (headings before, after).
    """

    headings: list[FloatArray]
    lengths: list[FloatArray]

    def least(self) -> float:
        """The length of the shortest path through the layers."""
        least = np.zeros(1)
        for lengths in self.lengths:
            least = (least[:, None] + lengths).min(axis=0)
        return float(least.min())

    def shortest(self) -> FloatArray:
        """The headings of the shortest path through the layers, by dynamic programming."""
        least, chosen = np.zeros(1), []
        for lengths in self.lengths:
            through = least[:, None] + lengths
            chosen.append(through.argmin(axis=0))
            least = through.min(axis=0)
        place = int(least.argmin())
        places = [place]
        for before in reversed(chosen):
            place = int(before[place])
            places.insert(0, place)
        pairs = zip(self.headings, places, strict=True)
        return np.array([headings[place] for headings, place in pairs])


def layers(route: Route, count: int) -> Layers:
    """So many headings at each point, equally far apart, from the start's on."""
    grid = route.first + TWO_PI / count * np.arange(count)
    headings = [np.array([route.first]), *[grid] * route.unknowns]
    if route.last is not None:
        headings.append(np.array([route.last]))
    return layers_between(headings, route.steps)


def layers_between(headings: list[FloatArray], steps: FloatArray) -> Layers:
    """The layers of some headings at each of the points that are these steps (radii) apart."""
    lengths = []
    for (before, after), (x, y) in zip(pairwise(headings), steps, strict=True):
        a, b = (each.ravel() for each in np.meshgrid(before, after, indexing="ij"))
        segments, _ = legs(np.full(a.size, x), np.full(a.size, y), a, b)
        lengths.append(segments.sum(axis=0).reshape(before.size, after.size))
    return Layers(headings, lengths)


class Flow(NamedTuple):
    """The program: min cost x, one leg leaves the start, as many leave a heading as reach it.

    x, shape (m,), is 1 for each leg that is driven, 0 for all others; flow x = begin.
    """

    cost: FloatArray  # shape (m,)
    flow: csr_array  # shape (headings, m), of all points but the last
    begin: FloatArray  # shape (headings,)


def flow_of(found: Layers) -> Flow:
    """The program of layers; a leg's place is that of its two headings, leg after leg."""
    n = len(found.lengths)
    blocks: list[list[Any]] = [[None] * n for _ in range(n)]  # of a point's headings and a leg
    for leg, lengths in enumerate(found.lengths):
        before, after = lengths.shape
        blocks[leg][leg] = kron(eye_array(before), np.ones((1, after)))
        if leg + 1 < n:
            blocks[leg + 1][leg] = kron(np.ones((1, before)), -eye_array(after))
    flow = csr_array(block_array(blocks))
    flow.sort_indices()
    begin = np.zeros(flow.shape[0])
    begin[0] = 1.0
    return Flow(np.concatenate([lengths.ravel() for lengths in found.lengths]), flow, begin)


class PosedGrid(NamedTuple):
    """A question, translated for `solve`."""

    question: Question
    route: Route
    layers: Layers
    flow: Flow


@dataclass(frozen=True)
class HeadingMilp(EngineSolver):
    """Headings on a grid, exact legs between them; optimal on that grid.

    A binary for each leg between two headings. The optimum and the engine's bound are those of the
    grid, so that the row carries no bound.

    Args:
        headings: number of headings at each point.
        engine: `highs`, stated in cvxpy, or `scip`. MAiNGO is not made for so many binaries.
        gap: relative gap at which the engine calls an answer optimal.
    """

    engine: str = one_of("highs", _ENGINES)
    headings: int = whole(72, 4, 1000)
    gap: float = within(1e-6, 0, 1, ends=False)

    name: ClassVar[str] = "heading-milp"
    guarantee: ClassVar[Guarantee] = Guarantee.DISCRETISED
    takes: ClassVar[frozenset[str]] = IN_ORDER
    packages: ClassVar[tuple[str, ...]] = packages(("highs", *MINLP_ENGINES))
    summary: ClassVar[str] = "headings on a grid, exact legs between them, by a MILP engine"
    keeps_limit = False  # a program of thousands of legs takes seconds to state
    variants: ClassVar[tuple[str, ...]] = others("heading-milp", _ENGINES, "highs")
    profiles: ClassVar[dict[str, dict[str, Any]]] = {
        "fast": {"headings": 36},
        "accurate": {"headings": 144},
    }

    @property
    def method(self) -> Method:
        return Method("grid of headings", self.library.label, "none", TOLERANCE)

    def build(self, question: Question) -> PosedGrid:
        route = route_of(question.scenario)
        found = layers(route, self.headings)
        return PosedGrid(question, route, found, flow_of(found))

    def solve(self, model: PosedGrid, limit: float) -> Solution:
        question, route, found, flow = model
        scenario = question.scenario
        rounding = coordinate_rounding(scenario)
        if there := at_start(scenario, route.target, rounding):
            return there
        began = perf_counter()
        if self.engine == "highs":
            proven = _by_cvxpy(flow, self.gap, limit)
        else:
            ask = self.library.load()(Settings(self.gap, TOLERANCE))
            proven = ask(_mixed(flow), limit)
        result = proven.counted(iterations=proven.iterations, evaluations=proven.nodes)
        run = Run("grid", perf_counter() - began, result, result.x, bound=proven.bound)
        if proven.x is None or not np.isfinite(proven.x).all():
            claim = Claim.LIMIT if run.claim is Claim.LIMIT else Claim.FAILED
            return Solution(claim, message=result.message or result.status, **spent([run]))
        segments, words = route.shortest(_chosen(found, proven.x))
        length = float(segments.sum()) * scenario.radius
        bound = f"{self.library.label}'s bound {run.bound * scenario.radius:.9g}"
        return Solution(
            Claim.LOCAL if run.claim is Claim.OPTIMAL else Claim.FEASIBLE,
            path=path_of(scenario, WORD_TURNS[words].ravel(), segments.T.ravel()),
            claimed_length=length,
            message=f"{bound} holds for {self.headings} headings only, not for the scenario",
            **spent([run], run),
        )


def _chosen(found: Layers, x: FloatArray) -> FloatArray:
    """The headings that a point x drives through, shape (n + 1,)."""
    headings, place, done = [found.headings[0][0]], 0, 0
    for after, lengths in zip(found.headings[1:], found.lengths, strict=True):
        taken = x[done : done + lengths.size].reshape(lengths.shape)
        place = int(np.argmax(taken[place]))
        headings.append(after[place])
        done += lengths.size
    return np.array(headings)


def _by_cvxpy(flow: Flow, gap: float, seconds: float) -> ProvenResult:
    import cvxpy as cp

    x = cp.Variable(flow.cost.size, boolean=True)
    problem = cp.Problem(cp.Minimize(flow.cost @ x), [flow.flow @ x == flow.begin])
    options = {"threads": 1, "mip_rel_gap": gap, "time_limit": seconds}
    try:
        problem.solve(solver=cp.HIGHS, **options)
    except cp.error.SolverError as error:
        return ProvenResult(None, Claim.FAILED, -math.inf, 0, 0, str(error), "")
    info, status = problem.solver_stats.extra_stats, str(problem.status)
    # HiGHS leaves zeros where it stopped at its limit without a point
    point = x.value if x.value is not None and x.value.max() > 0.5 else None
    return ProvenResult(
        point,
        claim_of("cvxpy", status),
        bound=float(info.mip_dual_bound),
        nodes=int(info.mip_node_count),
        iterations=int(info.simplex_iteration_count),
        status=status,
        message="",
    )


def _mixed(flow: Flow) -> MixedProgram:
    """The same program for the engines of `minlp_engines`."""
    lines = [
        (flow.flow.indices[a:b].tolist(), flow.flow.data[a:b].tolist())
        for a, b in pairwise(flow.flow.indptr)
    ]

    def write(x: Any, functions: Any) -> Written:
        rows = [
            Row(_sum([value * x[i] for i, value in zip(*line, strict=True)]), least, least)
            for line, least in zip(lines, flow.begin.tolist(), strict=True)
        ]
        return Written(_sum([cost * x[i] for i, cost in enumerate(flow.cost.tolist())]), rows)

    m = flow.cost.size
    return MixedProgram(np.zeros(m), np.ones(m), np.ones(m, dtype=bool), write)


def _sum(terms: list[Any]) -> Any:
    """The sum by halves: term by term some interfaces copy all that went before."""
    if len(terms) == 1:
        return terms[0]
    half = len(terms) // 2
    return _sum(terms[:half]) + _sum(terms[half:])

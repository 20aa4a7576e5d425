"""`tour-milp`: a tour through headings on a grid.

Engines of mixed-integer linear programs solve it.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

from dubins_study.solvers.engines import EngineSolver, packages
from dubins_study.solvers.minlp_engines.mixed_program import Settings
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.setting_checks import one_of, whole, within
from dubins_study.solvers.tour.graph import (
    COSTS,
    LENGTHS,
    Graph,
    answered,
    cycles,
    graph_of,
    tour_run,
)
from dubins_study.solvers.tour.linear_program import (
    CUTS,
    FLOW,
    MODELS,
    LinearProgram,
    program_of,
    with_cuts,
)
from dubins_study.solvers.tour.milp_engines import FEASIBILITY, solved
from dubins_study.solvers.tour.places import empty_path
from dubins_study.study.words import NEEDS, Claim

_ENGINES = ("highs", "scip", "glpk", "cbc")


@dataclass(frozen=True)
class TourMilp(EngineSolver):
    """Points in any order and headings on a grid.

    It is a generalised travelling salesman problem.

    Args:
        engine: `highs`, `scip`, `glpk`, or `cbc` by OR-tools.
        model: the way to forbid subtours: `flow`, `mtz`, or `cuts`, which are added while subtours
            are found.
        costs: `lengths` of legs between headings give an optimum of the grid, and no bound.
            `bounds` of legs between intervals of headings give a bound of the question; the tour
            then has the best headings of the grid in the order that is found.
        headings: number of headings at each point; with `bounds` of intervals.
        gap: relative gap at which the engine calls an answer optimal.
        polish: whether the headings of the tour are improved at the end, off the grid; by this
            package, not the engine.
        seed: of the engine, together with the question's repeat.
    """

    engine: str = one_of("highs", _ENGINES)
    model: str = one_of(FLOW, MODELS)
    costs: str = one_of(LENGTHS, COSTS)
    headings: int = whole(8, 2, 360)
    gap: float = within(1e-6, 0, 1, ends=False)
    polish: bool = False
    seed: int = whole(0, 0, 10**6)

    name = "tour-milp"
    guarantee = Guarantee.DISCRETISED
    takes = frozenset(NEEDS)
    packages = packages(_ENGINES)
    summary = "tours: order and headings on a grid, by a MILP engine"
    keeps_limit = False  # thousands of arcs take seconds to state
    variants = (
        "tour-milp[engine=scip]",
        "tour-milp[engine=glpk]",
        "tour-milp[engine=cbc]",
        "tour-milp[model=mtz]",
        "tour-milp[model=cuts]",
        "tour-milp[costs=bounds]",
    )

    @property
    def method(self) -> Method:
        return Method("tour MILP", self.library.label, "none", FEASIBILITY)

    def build(self, question: Question) -> tuple[Graph, LinearProgram]:
        graph = graph_of(question, self.headings, self.costs)
        return graph, program_of(graph, self.model)

    def solve(self, model: tuple[Graph, LinearProgram], limit: float) -> Solution:
        graph, program = model
        if there := empty_path(graph.question):
            return there
        began = perf_counter()
        seed = self.seed + graph.question.repeat
        settings = Settings(gap=self.gap, feastol=FEASIBILITY, seed=seed)
        result = solved(self, program, settings, limit)
        bound = result.bound
        nodes = [result.nodes]
        # every program with fewer cuts bounds the same tours, so the best bound so far counts
        while self.model == CUTS and result.claim is Claim.OPTIMAL and result.x is not None:
            subtours = cycles(graph, result.x)
            seconds_left = limit - (perf_counter() - began)
            if len(subtours) == 1 or seconds_left <= 0.0:
                break
            program = with_cuts(program, graph, subtours)
            result = solved(self, program, settings, seconds_left)
            bound = max(bound, result.bound)
            nodes.append(result.nodes)
        counts = [number for number in nodes if number is not None]
        total = None
        if counts:
            total = sum(counts)
        end = tour_run(graph, result._replace(bound=bound, nodes=total))
        return answered(graph, end, perf_counter() - began, self.polish)

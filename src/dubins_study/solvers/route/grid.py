"""`heading-milp`: headings on a grid, by a MILP.

With exact legs between any two headings of the grid, this is a shortest path through layers. Its
linear relaxation is integral, so an engine has nothing to branch on. The solver therefore shows how
engines do on the easiest of integer programs, and the cost of a grid. The legs are the closed
form's.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import ClassVar

from dubins_study.solvers.engines import MINLP_ENGINES, EngineSolver, others, packages
from dubins_study.solvers.minlp_engines.mixed_program import Settings
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.runs import Run, spent
from dubins_study.solvers.setting_checks import one_of, whole, within
from dubins_study.solvers.tour.graph import LENGTHS, Graph, graph_of, tour_run
from dubins_study.solvers.tour.linear_program import CUTS, LinearProgram, program_of
from dubins_study.solvers.tour.milp_engines import FEASIBILITY, solved
from dubins_study.solvers.tour.places import empty_path, tour_path
from dubins_study.study.words import IN_ORDER, Claim

# not MAiNGO, which ended in no time limit here
_ENGINES = ("highs", *(name for name in MINLP_ENGINES if name != "maingo"))


@dataclass(frozen=True)
class HeadingMilp(EngineSolver):
    """Headings on a grid, exact legs between them.

    The path is optimal on that grid. There is a binary for each leg between two headings. The
    optimum and the engine's bound are those of the grid, so that the row carries no bound.

    Args:
        headings: number of headings at each point.
        engine: `highs` or `scip`. MAiNGO is not made for so many binaries.
        gap: relative gap at which the engine calls an answer optimal.
    """

    engine: str = one_of("highs", _ENGINES)
    headings: int = whole(72, 4, 1000)
    gap: float = within(1e-6, 0, 1, ends=False)

    name = "heading-milp"
    guarantee = Guarantee.DISCRETISED
    takes = IN_ORDER
    packages = packages(("highs", *MINLP_ENGINES))
    summary = "headings on a grid, exact legs between them, by a MILP engine"
    keeps_limit = False  # a program of thousands of legs takes seconds to state
    variants = others("heading-milp", _ENGINES, "highs")
    profiles: ClassVar = {
        "fast": {"headings": 36},
        "accurate": {"headings": 144},
    }

    @property
    def method(self) -> Method:
        return Method("grid of headings", self.library.label, "none", FEASIBILITY)

    def build(self, question: Question) -> tuple[Graph, LinearProgram]:
        graph = graph_of(question, self.headings, LENGTHS)
        return graph, program_of(graph, CUTS)

    def solve(self, model: tuple[Graph, LinearProgram], limit: float) -> Solution:
        graph, program = model
        if there := empty_path(graph.question):
            return there
        scenario = graph.question.scenario
        began = perf_counter()
        proven = solved(self, program, Settings(gap=self.gap, feastol=FEASIBILITY), limit)
        result = proven.counted(iterations=proven.iterations, evaluations=proven.nodes)
        run = Run("grid", perf_counter() - began, result, result.x, bound=proven.bound)
        end = tour_run(graph, proven)
        if end.tour is None:
            claim = Claim.FAILED
            if run.claim is Claim.LIMIT:
                claim = Claim.LIMIT
            return Solution(claim, message=result.status, **spent([run]))
        order = list(range(graph.places.count))
        path = tour_path(scenario, graph.places, order, graph.headings[end.tour])
        bound = f"{self.library.label}'s bound {run.bound * scenario.radius:.9g}"
        claim = Claim.FEASIBLE
        if run.claim is Claim.OPTIMAL:
            claim = Claim.LOCAL
        return Solution(
            claim,
            path=path,
            claimed_length=path.length,
            message=f"{bound} holds for {self.headings} headings only, not for the scenario",
            **spent([run], run),
        )

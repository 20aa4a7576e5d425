"""`tour-circuit`: a tour by CP-SAT's circuit constraint.

Headings are on a grid, and the circuit may leave nodes out.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from dubins_study.solvers.engines import EngineSolver, packages
from dubins_study.solvers.minlp_engines.mixed_program import ProvenResult
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.setting_checks import one_of, whole, within
from dubins_study.solvers.statuses import claim_of
from dubins_study.solvers.tour.graph import (
    COSTS,
    LENGTHS,
    Graph,
    answered,
    graph_of,
    tour_run,
)
from dubins_study.solvers.tour.places import empty_path
from dubins_study.study.words import NEEDS, Claim


@dataclass(frozen=True)
class TourCircuit(EngineSolver):
    """Points in any order and headings on a grid.

    The tour is a circuit that leaves nodes out. There is a literal for each arc, and one for each
    heading that is not driven through. Costs are whole numbers of about a millionth of a radius,
    rounded down.

    Args:
        costs, headings, gap, polish, seed: as those of `tour-milp`.
    """

    costs: str = one_of(LENGTHS, COSTS)
    headings: int = whole(8, 2, 360)
    gap: float = within(1e-6, 0, 1, ends=False)
    polish: bool = False
    seed: int = whole(0, 0, 10**6)

    name = "tour-circuit"
    guarantee = Guarantee.DISCRETISED
    takes = frozenset(NEEDS)
    engine = "cp-sat"
    packages = packages((engine,))
    summary = "tours: order and headings on a grid, by CP-SAT's circuit"
    variants = ("tour-circuit[costs=bounds]",)

    @property
    def method(self) -> Method:
        return Method("tour circuit", self.library.label)

    def build(self, question: Question) -> tuple[Graph, Circuit]:
        graph = graph_of(question, self.headings, self.costs)
        return graph, _circuit(graph)

    def solve(self, model: tuple[Graph, Circuit], limit: float) -> Solution:
        from ortools.sat.python import cp_model

        graph, circuit = model
        if there := empty_path(graph.question):
            return there
        began = perf_counter()
        engine = cp_model.CpSolver()
        engine.parameters.max_time_in_seconds = limit
        engine.parameters.num_workers = 1
        engine.parameters.random_seed = self.seed + graph.question.repeat
        engine.parameters.relative_gap_limit = self.gap
        status = engine.status_name(engine.solve(circuit.program))
        claim = claim_of("cp-sat", status)
        x = None
        if claim in (Claim.OPTIMAL, Claim.FEASIBLE):
            x = np.array(engine.values(circuit.literals))
        bound = engine.best_objective_bound / circuit.scale
        result = ProvenResult(
            x,
            claim,
            bound,
            nodes=int(engine.num_branches),
            iterations=None,
            status=status,
        )
        end = tour_run(graph, result)
        return answered(graph, end, perf_counter() - began, self.polish)


class Circuit(NamedTuple):
    """The circuit model.

    `scale` is the number of units of cost in a radius.
    """

    program: Any
    literals: list[Any]  # of the arcs
    scale: float


def _circuit(graph: Graph) -> Circuit:
    """The circuit model of a graph."""
    from ortools.sat.python import cp_model

    program = cp_model.CpModel()
    literals = [program.new_bool_var("") for _ in graph.tails]
    skipped = [program.new_bool_var("") for _ in graph.owner]
    circuit = list(zip(graph.tails.tolist(), graph.heads.tolist(), literals, strict=True))
    # CP-SAT leaves a node out by an arc from the node to itself
    circuit += [(node, node, literal) for node, literal in enumerate(skipped)]
    program.add_circuit(circuit)
    for place in range(graph.places.count):
        program.add_exactly_one(skipped[node].negated() for node in graph.nodes(place))
    costs, scale = graph.whole_costs()
    program.minimize(cp_model.LinearExpr.weighted_sum(literals, costs.tolist()))
    return Circuit(program, literals, scale)

"""`tour-routing`: a tour by OR-tools' routing library.

The headings are on a grid.
"""

from __future__ import annotations

from dataclasses import dataclass
from time import perf_counter

import numpy as np

from dubins_study.solvers.engines import EngineSolver, packages
from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution
from dubins_study.solvers.setting_checks import one_of, whole
from dubins_study.solvers.statuses import claim_of
from dubins_study.solvers.tour.graph import (
    LENGTHS,
    Graph,
    TourRun,
    answered,
    graph_of,
)
from dubins_study.solvers.tour.places import empty_path
from dubins_study.study.words import FREE_START, NEEDS

_FEW = 3  # places that can be passed in one order only, the start among them
DESCENT = "descent"
GUIDED = "guided"
_SEARCHES = (DESCENT, GUIDED)
# `operations_research::routing::RoutingSearchStatus`
_STATUSES = (
    "ROUTING_NOT_SOLVED",
    "ROUTING_SUCCESS",
    "ROUTING_PARTIAL_SUCCESS_LOCAL_OPTIMUM_NOT_REACHED",
    "ROUTING_FAIL",
    "ROUTING_FAIL_TIMEOUT",
    "ROUTING_INVALID",
    "ROUTING_INFEASIBLE",
    "ROUTING_OPTIMAL",
)


@dataclass(frozen=True)
class TourRouting(EngineSolver):
    """Points in any order and headings on a grid.

    The tour is that of a vehicle that visits one heading a point.

    The headings of a point form a disjunction: one of them is visited. The library proves nothing
    and draws no random numbers.

    Args:
        headings, polish: as those of `tour-milp`.
        search: `descent` ends in a local optimum; `guided` goes on from it by guided local search
            until the time is up, if there is more than one via point.
    """

    headings: int = whole(8, 2, 360)
    search: str = one_of(DESCENT, _SEARCHES)
    polish: bool = False

    name = "tour-routing"
    guarantee = Guarantee.DISCRETISED
    # the vehicle has one depot: the start with its heading
    takes = frozenset(NEEDS) - {FREE_START}
    engine = "routing"
    packages = packages((engine,))
    summary = "tours: order and headings on a grid, by OR-tools' routing library"

    @property
    def method(self) -> Method:
        return Method("tour routing", self.library.label)

    def build(self, question: Question) -> Graph:
        return graph_of(question, self.headings, LENGTHS)

    def solve(self, model: Graph, limit: float) -> Solution:
        if there := empty_path(model.question):
            return there
        began = perf_counter()
        end = _visited(model, self.search, limit)
        return answered(model, end, perf_counter() - began, self.polish)


def _visited(graph: Graph, search: str, seconds: float) -> TourRun:
    """Plan a vehicle's tour through the graph's nodes.

    The run's tour has the nodes that are visited, from the start on. It is None if the library
    found no tour of arcs.
    """
    from ortools.constraint_solver import pywrapcp, routing_enums_pb2

    began = perf_counter()
    count = graph.owner.size
    manager = pywrapcp.RoutingIndexManager(count, 1, 0)
    routing = pywrapcp.RoutingModel(manager)
    costs, _ = graph.whole_costs()
    never = 10**13  # more than all whole costs together
    table = np.full((count, count), never, np.int64)
    table[graph.tails, graph.heads] = costs
    routing.SetArcCostEvaluatorOfAllVehicles(routing.RegisterTransitMatrix(table.tolist()))
    for place in range(1, graph.places.count):
        penalty = -1  # the disjunction cannot be left out
        nodes = [manager.NodeToIndex(node) for node in graph.nodes(place)]
        routing.AddDisjunction(nodes, penalty, 1)
    parameters = pywrapcp.DefaultRoutingSearchParameters()
    strategies = routing_enums_pb2.FirstSolutionStrategy
    parameters.first_solution_strategy = strategies.PATH_CHEAPEST_ARC
    metaheuristics = routing_enums_pb2.LocalSearchMetaheuristic
    parameters.local_search_metaheuristic = metaheuristics.GREEDY_DESCENT
    if search == GUIDED and graph.places.count > _FEW:  # with fewer it waits for its time to end
        parameters.local_search_metaheuristic = metaheuristics.GUIDED_LOCAL_SEARCH
    seconds_left = max(seconds - (perf_counter() - began), 0.01)
    parameters.time_limit.FromMilliseconds(int(1000 * seconds_left))
    tour = routing.SolveWithParameters(parameters)
    status = _STATUSES[routing.status()]
    claim = claim_of("routing", status)
    if tour is None or tour.ObjectiveValue() >= never:  # the tour has a step that is no arc
        return TourRun(None, claim, status)
    index = routing.Start(0)
    visited = []
    while not routing.IsEnd(index):
        visited.append(manager.IndexToNode(index))
        index = tour.Value(routing.NextVar(index))
    return TourRun(visited, claim, status)

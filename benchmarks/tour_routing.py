"""OR-tools' routing library on headings of a grid.

A heading is a node, and one node of each point is visited.

A local search (guided, of a given time) without a proof.
"""

from __future__ import annotations

import math
from importlib.util import find_spec

import numpy as np

from benchmarks.harness import sized
from dubins_study.study.route.heading_grids import leg_table
from dubins_study.study.tour.short_orders import lengths_between
from dubins_study.study.tour.stops import Stops

NO_ORTOOLS = "ortools is not installed"
HEADINGS = 8
SECONDS = sized(2, 1)
UNITS = 10_000  # of whole numbers, a radius
_NOT_VISITED = 10**9
_LAST_HEADINGS = 72


def routed(stops: Stops) -> float:
    """Length of the tour.

    NaN without the library; infinite without a tour.
    """
    if find_spec("ortools") is None:
        return math.nan
    from ortools.constraint_solver import pywrapcp, routing_enums_pb2

    costs = grid_costs(stops)
    size = len(costs)
    manager = pywrapcp.RoutingIndexManager(size, 1, [size - 2], [size - 1])
    routing = pywrapcp.RoutingModel(manager)

    def cost(start: int, end: int) -> int:
        return int(costs[manager.IndexToNode(start), manager.IndexToNode(end)])

    routing.SetArcCostEvaluatorOfAllVehicles(routing.RegisterTransitCallback(cost))
    for first in range(0, size - 2, HEADINGS):
        nodes = [manager.NodeToIndex(first + k) for k in range(HEADINGS)]
        routing.AddDisjunction(nodes, _NOT_VISITED)
    asked = pywrapcp.DefaultRoutingSearchParameters()
    asked.first_solution_strategy = routing_enums_pb2.FirstSolutionStrategy.PATH_CHEAPEST_ARC
    asked.local_search_metaheuristic = (
        routing_enums_pb2.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    )
    asked.time_limit.seconds = SECONDS
    solution = routing.SolveWithParameters(asked)
    if solution is None or solution.ObjectiveValue() >= _NOT_VISITED:
        return math.inf
    return float(solution.ObjectiveValue() / UNITS)


def grid_costs(stops: Stops) -> np.ndarray:
    """Lengths between all headings.

    Those of the start and to the target are in the last two rows.
    """
    n = len(stops.points)
    grid = np.linspace(-math.pi, math.pi, HEADINGS, endpoint=False)
    last = np.linspace(-math.pi, math.pi, _LAST_HEADINGS, endpoint=False)
    begin = np.arange(n + 1) * HEADINGS
    between = lengths_between(stops.points, begin, np.tile(grid, n))
    lengths = np.full((between.shape[0] + 2,) * 2, math.inf)
    lengths[:-2, :-2] = between
    for i, point in enumerate(stops.points):
        some = slice(begin[i], begin[i + 1])
        live = np.ones((1, HEADINGS), np.int8)
        lengths[-2, some] = leg_table(point, np.array([stops.first]), grid, live)[0][0]
        live = np.ones((HEADINGS, _LAST_HEADINGS), np.int8)
        way = np.array(stops.target) - point
        lengths[some, -1] = leg_table(way, grid, last, live)[0].min(axis=1)
    return np.minimum(np.rint(UNITS * lengths), _NOT_VISITED).astype(np.int64)

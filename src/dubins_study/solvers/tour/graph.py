"""A tour as a generalised travelling salesman problem.

Each place has some headings, of which the tour passes one. The costs of its arcs are the shortest
lengths between headings, or proven bounds of legs between intervals of headings. With bounds no
tour costs more than it is long, in any order. A bound of the program's optimum is then one of the
question's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.minlp_engines.mixed_program import ProvenResult
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.solvers.runs import EngineResult, Run, spent
from dubins_study.solvers.tour.order_headings import (
    headings_on_grid,
    layers_between,
    polished,
)
from dubins_study.solvers.tour.places import Places, places_of, tour_path
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray, IntArray
from dubins_study.study.words import Claim

LENGTHS = "lengths"
BOUNDS = "bounds"
COSTS = (LENGTHS, BOUNDS)
# The share taken off a bound: more than engines' tolerances and rounded sums add to it.
_SAFE = 1e-6
_UNITS = 1e6  # of whole costs in a radius, unless the costs are too long for that
_MOST_UNITS = 1e12  # of all places together


class Graph(NamedTuple):
    """A question's headings as nodes, with arcs between them.

    There are arcs between places that may follow each other.
    """

    question: Question
    places: Places
    per_place: int  # headings or intervals
    of_bounds: bool  # whether costs are bounds over intervals, and headings their middles
    owner: IntArray  # place of each node, shape (n,)
    headings: FloatArray  # of each node (rad), shape (n,)
    tails: IntArray  # nodes, shape (arcs,)
    heads: IntArray
    costs: FloatArray  # radii

    @property
    def pairs(self) -> tuple[IntArray, IntArray]:
        """The places at both ends of each arc."""
        return self.owner[self.tails], self.owner[self.heads]

    def nodes(self, place: int) -> list[int]:
        """The nodes of a place."""
        nodes: list[int] = np.flatnonzero(self.owner == place).tolist()
        return nodes

    def whole_costs(self) -> tuple[IntArray, float]:
        """Costs as whole numbers, rounded down.

        Returns also the number of their units in a radius.
        """
        longest = max(float(self.costs.max()) * self.places.count, 1.0)
        scale = min(_UNITS, _MOST_UNITS / longest)
        return np.floor(self.costs * scale).astype(np.int64), scale


class TourRun(NamedTuple):
    """The end of one run of an engine."""

    tour: list[int] | None  # nodes from the start on, one of each place
    claim: Claim
    status: str
    bound: float = -math.inf  # radii
    cost: float = math.inf  # radii; of the tour
    nodes: int | None = None  # of the engine's tree


def graph_of(question: Question, count: int, costs: str) -> Graph:
    """The graph of a question.

    Each place has `count` headings, or intervals if `costs` is `bounds`.
    """
    places = places_of(question.scenario)
    grid = places.headings(count)
    owner = np.repeat(np.arange(places.count), [each.size for each in grid])
    begin = np.searchsorted(owner, np.arange(places.count))
    halves = np.where([heading is None for heading in places.given], math.pi / count, 0.0)
    tails = []
    heads = []
    lengths = []
    for i, j in np.argwhere(places.next_places):
        step = places.points[j] - places.points[i]
        if j == 0 and not places.closed:  # an open tour does not go back to its start
            block = np.zeros((grid[i].size, grid[j].size))
        elif costs == BOUNDS:
            # half of an interval's width; 0 where the heading is given
            block = _bounds(step, (grid[i], halves[i]), (grid[j], halves[j]))
        else:
            [block] = layers_between([grid[i], grid[j]], step[None]).lengths
        before, after = np.indices(block.shape).reshape(2, -1)
        tails.append(begin[i] + before)
        heads.append(begin[j] + after)
        lengths.append(block.ravel())
    return Graph(
        question,
        places,
        per_place=count,
        of_bounds=costs == BOUNDS,
        owner=owner,
        headings=np.concatenate(grid),
        tails=np.concatenate(tails),
        heads=np.concatenate(heads),
        costs=np.concatenate(lengths),
    )


def _bounds(
    step: FloatArray, first: tuple[FloatArray, float], last: tuple[FloatArray, float]
) -> FloatArray:
    """Bounds of a leg over intervals at both ends.

    `first` and `last` are the intervals' middles (rad), and half of their width. Returns a bound
    (radii) for each interval at the beginning and each at the end, shape (first, last).
    """
    from dubins_study.study.route.intervals import OVERLAP  # loads Numba
    from dubins_study.study.route.leg_bound import bound_leg

    ends = []
    for headings, half in (first, last):
        middles = np.remainder(headings + math.pi, TWO_PI) - math.pi
        # the remainder's rounding grows with the heading
        half_widths = half + OVERLAP * (1.0 + np.abs(headings))
        ends.append((middles, half_widths, np.zeros(middles.size)))
    live = np.ones((first[0].size, last[0].size), np.int8)
    bounds = np.empty(live.shape)
    bound_leg(step, *ends, live, bounds, np.empty(live.shape, np.int8))
    return np.maximum(bounds, np.hypot(*step))


def tour_run(graph: Graph, result: ProvenResult) -> TourRun:
    """The tour in an engine's result.

    The engine's x begins with a number for each arc. Without x, or if the arcs make several cycles,
    the tour is None.
    """
    end = TourRun(None, result.claim, result.status, result.bound, nodes=result.nodes)
    if result.x is None:
        return end
    tours = cycles(graph, result.x)
    if len(tours) != 1:
        return end
    cost = float(graph.costs @ result.x[: graph.costs.size])
    return end._replace(tour=tours[0], cost=cost)


def cycles(graph: Graph, x: FloatArray) -> list[list[int]]:
    """The nodes along each cycle of driven arcs.

    An arc is driven if its number in x is near 1. The start's cycle is first, from the start on.
    """
    chosen = x[: graph.costs.size] > 0.5
    after = dict(zip(graph.tails[chosen].tolist(), graph.heads[chosen].tolist(), strict=True))
    all_cycles = []
    while after:
        node = min(after)
        cycle = []
        while node in after:
            cycle.append(node)
            node = after.pop(node)
        all_cycles.append(cycle)
    return all_cycles


def answered(graph: Graph, end: TourRun, seconds: float, polish: bool) -> Solution:
    """The solution of an engine's run.

    The bound is the question's only if the costs are bounds. The claim is `feasible`: an optimum of
    the program is none of the question.
    """
    scenario = graph.question.scenario
    places = graph.places
    result = EngineResult(np.empty(0), end.claim, iterations=end.nodes, status=end.status)
    run = Run("tour", seconds, result, result.x)
    lower_bound = None
    if graph.of_bounds and 0.0 < end.bound < math.inf:
        lower_bound = end.bound * (1.0 - _SAFE) * scenario.radius
    if end.tour is None:
        claim = Claim.LIMIT
        if end.claim is Claim.FAILED:
            claim = Claim.FAILED
        message = f"no tour; {_bound_text(graph, end)}"
        return Solution(claim, lower_bound=lower_bound, message=message, **spent([run]))
    order = graph.owner[end.tour].tolist()
    headings = graph.headings[end.tour]
    if places.closed:
        headings = np.append(headings, headings[0])
    if graph.of_bounds:
        headings = headings_on_grid(places, order, graph.per_place)
    message = _bound_text(graph, end)
    if polish:
        headings = polished(places, order, headings, graph.per_place)
        message += "; then polished"
    path = tour_path(scenario, places, order, headings)
    return Solution(
        Claim.FEASIBLE,
        path=path,
        claimed_length=path.length,
        lower_bound=lower_bound,
        message=message,
        **spent([run], run),
    )


def _bound_text(graph: Graph, end: TourRun) -> str:
    """The engine's bound as text, with its scope."""
    if end.bound == -math.inf:
        return "no bound"
    text = f"bound {end.bound * graph.question.scenario.radius:.9g}"
    if end.tour is not None:
        open_part = max(0.0, end.cost - end.bound)
        text += f", gap {open_part / max(end.cost, 1.0 / _UNITS):.2g}"
    if graph.of_bounds:
        return f"{text}, of bounds over {graph.per_place} intervals a point"
    return f"{text}, of {graph.per_place} headings a point only, not of the scenario"

"""A genetic search for the order of a tour.

Its operators and its loop come from DEAP; headings are those of a grid.

Orders are crossed and parts of them turned round; one is as good as its best headings. A genetic
search for Dubins tours is that of Yu and Hung 2012; this one has no proof either.
"""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from importlib.util import find_spec
from itertools import pairwise

import numpy as np

from benchmarks.harness import sized
from benchmarks.tour_routing import HEADINGS, UNITS, grid_costs
from dubins_study.study.tour.stops import Stops

NO_DEAP = "deap is not installed"
_PEOPLE = 200
_GENERATIONS = sized(300, 20)
# shares of a generation
_CROSSED = 0.8
_CHANGED = 0.3
_RIVALS = 3
_SEED = 34


def evolved(stops: Stops) -> float:
    """Length of the best tour; NaN without the library."""
    if find_spec("deap") is None:
        return math.nan
    from deap import algorithms, base, tools

    costs = grid_costs(stops) / UNITS
    n = len(stops.points)
    random.seed(_SEED)  # DEAP takes no generator of ours

    fitness = type("Fitness", (base.Fitness,), {"weights": (-1.0,)})

    class Order(list[int]):
        def __init__(self, points: Sequence[int]) -> None:
            super().__init__(points)
            self.fitness = fitness()

    box = base.Toolbox()
    box.register("evaluate", lambda order: (length_on_grid(order, costs),))
    box.register("mate", tools.cxOrdered)
    box.register("mutate", tools.mutInversion)
    box.register("select", tools.selTournament, tournsize=_RIVALS)
    people = [Order(random.sample(range(n), n)) for _ in range(_PEOPLE)]
    best = tools.HallOfFame(1)
    algorithms.eaSimple(people, box, _CROSSED, _CHANGED, _GENERATIONS, None, best, verbose=False)
    return float(best[0].fitness.values[0])


def length_on_grid(order: Sequence[int], costs: np.ndarray) -> float:
    """Length of an order with the grid's best headings."""
    start, target = len(costs) - 2, len(costs) - 1
    nodes = [slice(HEADINGS * point, HEADINGS * (point + 1)) for point in order]
    to = costs[start, nodes[0]]
    for here, there in pairwise(nodes):
        to = (to[:, None] + costs[here, there]).min(axis=0)
    return float((to + costs[nodes[-1], target]).min())

"""The shortest route of a scenario with via points: the search, in the scenario's own units."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from dubins_study.study.path import Path
from dubins_study.study.route.search import search
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import TURN

# A search is done when its interval is this narrow, of the route's length: a thousandth of what the
# strictest profile asks for. Points in line, where lengths have cubic minima, take long to get to
# less.
_NARROW = 1e-9


class ShortestRoute(NamedTuple):
    """The best path found, and a proven interval around the shortest length (length unit)."""

    path: Path
    at: tuple[float, ...]  # the arc lengths of the via points on it
    low: float
    high: float


def shortest_route(scenario: Scenario, limit: float) -> ShortestRoute:
    """Search for the shortest path through a scenario's points, anew whatever is known.

    Args:
        scenario: its via points, and its final heading if that is given.
        limit: seconds.
    """
    radius = scenario.radius
    points = (scenario.points - scenario.points[0]) / radius
    found = search(points, scenario.heading, scenario.final_heading, limit=limit, tolerance=_NARROW)
    rates = np.array([TURN[letter] for word in found.words for letter in word])
    segments = found.segments * radius
    driven = segments.ravel() > 0.0
    route = ShortestRoute(
        Path(scenario.start, rates[driven] / radius, segments.ravel()[driven]),
        tuple(np.cumsum(segments.sum(axis=1))[:-1].tolist()),
        math.nextafter(found.low * radius, -math.inf),
        math.nextafter(found.high * radius, math.inf),
    )
    _last_search(scenario)[:] = [(math.inf if found.closed else limit, route)]
    return route


def known_route(scenario: Scenario, limit: float) -> ShortestRoute:
    """What the last search of this process found, if more time would not change it; or a search."""
    for searched, route in _last_search(scenario):
        if searched >= limit:
            return route
    return shortest_route(scenario, limit)


@lru_cache(maxsize=4096)  # the cells of a run ask each question often, in shuffled order
def _last_search(scenario: Scenario) -> list[tuple[float, ShortestRoute]]:
    """Its limit, infinite if it closed the gap, and its result; empty before the first search."""
    return []

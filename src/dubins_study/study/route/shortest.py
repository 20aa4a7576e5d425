"""The shortest route of a scenario with via points: the search, in the scenario's own units."""

from __future__ import annotations

import math
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
    """Search for the shortest path through a scenario's points.

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
    return ShortestRoute(
        Path(scenario.start, rates[driven] / radius, segments.ravel()[driven]),
        tuple(np.cumsum(segments.sum(axis=1))[:-1].tolist()),
        math.nextafter(found.low * radius, -math.inf),
        math.nextafter(found.high * radius, math.inf),
    )

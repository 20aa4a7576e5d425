"""Random tours and the cost of the best.

The cost comes from all orders one by one, or from headings of a grid.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations, pairwise, permutations
from typing import Any, NamedTuple

import numpy as np

from dubins_study.study.arrays import FloatArray
from dubins_study.study.closed_form.pose import shortest_to_pose
from dubins_study.study.kinds.shortest import BOXES_A_SECOND, ShortestRoute, shortest_route
from dubins_study.study.route.search import search
from dubins_study.study.scenario import Pose, Scenario

KINDS = (
    *("open", "target", "heading", "closed", "free start", "free ends", "headings at points"),
    "free loop",
)
BOXES = 60 * BOXES_A_SECOND  # whatever else the machine does
CLOSE = 1e-8  # of the length: what searches are asked for here


class Shortest(NamedTuple):
    """Proven interval and best order of a tour."""

    low: float
    high: float
    order: tuple[int, ...]


def random_tour(rng: np.random.Generator, kind: str, points: int, side: float) -> Scenario:
    """A random tour of points in a square.

    The radius is 1.
    """
    via: list[Any] = rng.uniform(0.0, side, (points, 2)).tolist()
    heading: float | None = rng.uniform(-3.0, 3.0)
    x, y = rng.uniform(0.0, side, 2)
    more: dict[str, Any] = {}
    if kind in ("closed", "free loop"):
        more = {"closed": True}
    elif kind not in ("open", "free ends"):
        more = dict(zip(("target_x", "target_y"), rng.uniform(0.0, side, 2), strict=True))
    if kind == "heading":
        more["final_heading"] = rng.uniform(-3.0, 3.0)
    if kind.startswith("free"):
        heading = None
    if kind == "headings at points":
        given = rng.random(points) < 0.5
        given[0] = True
        angles = rng.uniform(-3.0, 3.0, points)
        via = [
            (*point, angle) if one else point
            for point, angle, one in zip(via, angles, given, strict=True)
        ]
    return Scenario(x, y, heading, via=via, order="free", **more)


def tour_of(scenario: Scenario) -> ShortestRoute:
    """The search's own interval."""
    return shortest_route(scenario, math.inf, BOXES)


def by_all_orders(scenario: Scenario, length: float) -> Shortest:
    """Interval of the best tour, by searching every order.

    Each order is searched as a route. The search ends where a route is longer than `length` or
    than the best so far. If no order is that short, the lower end is above `length`.
    """
    low = math.inf
    best = math.inf
    order = ()
    start = np.array([scenario.x, scenario.y])
    for permutation in permutations(range(len(scenario.via))):
        stops = [scenario.stops[i] for i in permutation] + list(scenario.stops[len(permutation) :])
        places = np.array([stop[:2] for stop in stops])
        route = search(
            np.vstack([np.zeros(2), (places - start) / scenario.radius]),
            scenario.heading,
            stops[-1].heading,
            via_headings=[stop.heading for stop in stops[:-1]],
            closed=scenario.closed and scenario.heading is None,
            boxes=BOXES,
            tolerance=CLOSE,
            cutoff=min(best, length / scenario.radius) * (1.0 + CLOSE),
        )
        low = min(low, route.low)
        if route.length < best:
            best = route.length
            order = permutation
    return Shortest(low * scenario.radius, best * scenario.radius, order)


def length_through(scenario: Scenario, order: Sequence[int], headings: Sequence[float]) -> float:
    """Length of one tour by closed forms.

    Headings are given at its start and at all stops in turn.
    """
    stops = [scenario.stops[i] for i in order] + list(scenario.stops[len(order) :])
    places = [(scenario.x, scenario.y), *(stop[:2] for stop in stops)]
    poses = [Pose(*place, angle) for place, angle in zip(places, headings, strict=True)]
    legs = [shortest_to_pose(*both, scenario.radius) for both in pairwise(poses)]
    return sum(leg.total for leg in legs if leg is not None) * scenario.radius


def any_tour(scenario: Scenario, rng: np.random.Generator) -> float:
    """Length of a random tour.

    The order is random, and so are headings where none is given.
    """
    order = rng.permutation(len(scenario.via)).tolist()
    stops = [scenario.stops[i] for i in order] + list(scenario.stops[len(order) :])
    given = [scenario.heading, *(stop.heading for stop in stops)]
    headings = [rng.uniform(-4.0, 4.0) if angle is None else angle for angle in given]
    if scenario.closed:
        headings[-1] = headings[0]
    return length_through(scenario, order, headings)


def by_grid(scenario: Scenario, size: int) -> float:
    """Shortest tour with headings of a grid.

    The tour ends at a target. The method is Held and Karp's program.
    """
    n = len(scenario.via)
    circle = np.linspace(-math.pi, math.pi, size, endpoint=False)
    poses = [[Pose(x, y, angle) for angle in circle] for x, y in scenario.via]
    ends = [Pose(*scenario.stops[-1][:2], angle) for angle in circle]
    if scenario.final_heading is not None:
        ends = [Pose(*scenario.stops[-1][:2], scenario.final_heading)]

    def lengths(some: list[Pose], others: list[Pose]) -> FloatArray:
        legs = [shortest_to_pose(one, other, scenario.radius) for one in some for other in others]
        return np.array([leg.total for leg in legs if leg]).reshape(len(some), len(others))

    between = {(i, j): lengths(poses[i], poses[j]) for i in range(n) for j in range(n) if i != j}
    costs = {(1 << i, i): lengths([scenario.start], poses[i])[0] for i in range(n)}
    for count in range(2, n + 1):
        for chosen in combinations(range(n), count):
            every = sum(1 << i for i in chosen)
            for last in chosen:
                before = every ^ (1 << last)
                ways = [
                    (costs[before, i][:, None] + between[i, last]).min(axis=0)
                    for i in chosen
                    if i != last
                ]
                costs[every, last] = np.min(ways, axis=0)
    full = (1 << n) - 1
    last_legs = [costs[full, i] + lengths(poses[i], ends).min(axis=1) for i in range(n)]
    return float(np.min(last_legs)) * scenario.radius


def mapped(scenario: Scenario, change: Any, turn: float, mirror: int, scale: float) -> Scenario:
    """The scenario moved, mirrored and turned.

    `change` moves its points; its headings are mirrored and turned.
    """

    def headed(angle: float | None) -> float | None:
        return None if angle is None else mirror * angle + turn

    via = [(*change(x, y), *map(headed, heading)) for x, y, *heading in scenario.via]
    target: tuple[float | None, float | None] = (None, None)
    if scenario.target_x is not None:
        target = change(scenario.target_x, scenario.target_y)
    return Scenario(
        *change(scenario.x, scenario.y),
        headed(scenario.heading),
        *target,
        radius=scale * scenario.radius,
        via=via,
        final_heading=headed(scenario.final_heading),
        order="free",
        closed=scenario.closed,
    )

"""Search for a scenario's shortest route or tour.

Results are in the scenario's own units.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dubins_study.study.path import Path
from dubins_study.study.route.search import Route, search
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tour.search import Tour, search_tour
from dubins_study.study.tour.stops import Stops
from dubins_study.study.words import TURN, Order

# A search is done when its interval is this share of the route's length: a thousandth of the gap
# that the strictest profile allows. Less would take long for points in line, where lengths have
# cubic minima.
_NARROW = 1e-9
BOXES_A_SECOND = 100_000  # of one core of a server of 2026, which does 120 000 to 190 000
_AS_LONG = 0.95  # share of the wanted seconds after which an earlier search was long enough
_MOST_KNOWN = 4096  # the cells of a run ask each question often, in shuffled order


class _Searched(NamedTuple):
    """Last search of a scenario, and its effort.

    The effort is infinite if the search came to its end: more would change nothing.
    """

    route: ShortestRoute
    boxes: float = math.inf
    seconds: float = math.inf


_known: dict[Scenario, _Searched] = {}


class ShortestRoute(NamedTuple):
    """Best path of a search, with a proven interval.

    The interval holds the shortest length (length unit).
    """

    path: Path
    at: tuple[float, ...]  # the arc lengths on it at which its legs end, but for the last
    low: float
    high: float


def shortest_route(scenario: Scenario, limit: float, boxes: float = math.inf) -> ShortestRoute:
    """Search for the shortest path through a scenario's points.

    The search starts anew, even if a result is known.

    Args:
        scenario: a route, or a tour.
        limit: seconds.
        boxes: the most boxes that it may bound, as in `search`.
    """
    radius = scenario.radius
    points = (scenario.points - scenario.points[0]) / radius
    headings = [scenario.heading, *(stop.heading for stop in scenario.stops)]
    closed = scenario.closed and scenario.heading is None
    # the only point is the start, and its heading is free: nothing has to be driven
    if len(points) == 2 and not points.any():
        path = Path(Pose(scenario.x, scenario.y, headings[-1] or 0.0), [], [])
        return ShortestRoute(path, (), 0.0, 0.0)
    result: Route | Tour
    if scenario.order is Order.FREE and len(scenario.via) > 1:
        n = len(scenario.via)
        target = None
        last = None
        if scenario.target is not None:
            target = tuple(points[-1].tolist())
            last = headings[-1]
        stops = Stops(
            points=points[1 : n + 1],
            headings=headings[1 : n + 1],
            first=scenario.heading,
            target=target,
            last=last,
            closed=closed,
        )
        result = search_tour(stops, limit=limit, boxes=boxes, tolerance=_NARROW)
        best = result.route
    else:
        best = search(
            points,
            first=headings[0],
            last=headings[-1],
            via_headings=headings[1:-1],
            closed=closed,
            limit=limit,
            boxes=boxes,
            tolerance=_NARROW,
        )
        result = best
    rates = np.array([TURN[letter] for letter in "".join(best.words)])
    segments = best.segments * radius
    driven = segments.ravel() > 0.0
    heading = scenario.heading
    if heading is None:
        heading = best.headings[0]
    start = Pose(scenario.x, scenario.y, heading)
    route = ShortestRoute(
        path=Path(start, rates[driven] / radius, segments.ravel()[driven]),
        at=tuple(np.cumsum(segments.sum(axis=1))[:-1].tolist()),
        low=max(math.nextafter(result.low * radius, -math.inf), 0.0),
        high=math.nextafter(result.high * radius, math.inf),
    )
    if len(_known) >= _MOST_KNOWN:
        _known.clear()
    _known[scenario] = _Searched(route)
    if result.seconds > limit or result.boxes >= boxes:  # a limit ended the search
        _known[scenario] = _Searched(route, boxes=result.boxes, seconds=result.seconds)
    return route


def known_route(scenario: Scenario, search_s: float, seconds: float) -> ShortestRoute:
    """Shortest route as far as it is known.

    If the last search of this process was as long as is wanted, its result counts. Otherwise the
    route is searched for.

    Args:
        search_s: seconds of a machine that bounds `BOXES_A_SECOND`. The search ends after that many
            boxes, so that the result is the same on a slower one.
        seconds: the search ends after them in any case. A search that took as long is not repeated.
    """
    boxes = round(search_s * BOXES_A_SECOND)
    last = _known.get(scenario)
    if last is not None and (last.boxes >= boxes or last.seconds >= _AS_LONG * seconds):
        return last.route
    return shortest_route(scenario, limit=seconds, boxes=boxes)

"""The search for tours at its edges.

There its lower end or its limits are easily wrong.
"""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import pytest

from dubins_study.study.route.search import search
from dubins_study.study.tour.search import search_tour
from dubins_study.study.tour.stops import Stops

_ABOVE_LISTING = 70  # points: too many to list orders of
_ONLY_A_TREE = 110  # points: too many for chains


@pytest.mark.parametrize("away", [1e-170, 1e-9, 0.0])
@pytest.mark.parametrize("more", [(), ((12.0, 4.0), (-3.0, 5.0))])  # by orders, and by chains
def test_a_point_at_the_start_adds_no_length_to_the_lower_end(
    away: float, more: tuple[tuple[float, float], ...]
) -> None:
    points = np.array([(away, 0.0), (6.0, 1.0), (4.0, -3.0), *more])
    heading = 0.0  # passes the point by the start at once
    stops = Stops(points, [None] * len(points), heading, (9.0, 0.0), None)
    tour = search_tour(stops, tolerance=1e-8, boxes=1e6)
    assert tour.closed
    orders = permutations(range(1, len(points)))
    lengths = [
        search([(0.0, 0.0), *points[list(order)], (9.0, 0.0)], heading).length for order in orders
    ]
    assert search_tour(stops, boxes=1).low <= min(lengths) + 1e-8
    assert tour.low <= min(lengths) + 1e-8
    assert tour.high == pytest.approx(min(lengths), abs=1e-7)


@pytest.mark.parametrize("count", [_ABOVE_LISTING, _ONLY_A_TREE])
@pytest.mark.parametrize("closed", [False, True])
def test_many_points_have_a_good_tour_and_a_lower_end(count: int, closed: bool) -> None:
    random = np.random.default_rng([count, closed])
    points = random.uniform(0.0, 8.0 * math.sqrt(count), (count, 2))
    target = (0.0, 0.0) if closed else None
    first = None if closed else 0.4
    stops = Stops(points, [None] * count, first, target, None, closed=closed)
    tour = search_tour(stops, boxes=3e5)
    assert sorted(tour.order) == list(range(count))
    assert 0.5 * tour.high < tour.low <= tour.route.length <= tour.high


def test_a_dense_loop_is_bounded_as_well_as_a_route() -> None:
    """A dense loop's bound matches a route's.

    Both ways round two points and a start are one loop, which the search for routes bounds.
    """
    points = np.array([(1.0, 0.0), (0.5, 0.8)])
    stops = Stops(points, [None] * 2, None, (0.0, 0.0), None, closed=True)

    tour = search_tour(stops, boxes=1e5)

    route = search([(0.0, 0.0), *points, (0.0, 0.0)], None, closed=True, boxes=1e5)
    assert max(tour.low, route.low) <= min(tour.high, route.high)
    assert tour.low > 0.99 * tour.high  # by straight lines it would be 0.23

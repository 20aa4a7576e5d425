"""The search for tours, where its lower end or its limits are easily wrong."""

from __future__ import annotations

import math

import numpy as np
import pytest

from dubins_study.study.route.search import search
from dubins_study.study.route.tour import Stops, search_tour

_ABOVE_LISTING = 70  # points: too many to list orders of
_ONLY_A_TREE = 110  # points: too many for chains


@pytest.mark.parametrize("away", [1e-170, 1e-9, 0.0])
def test_a_point_at_the_start_adds_no_length_to_the_lower_end(away: float) -> None:
    points = np.array([(away, 0.0), (6.0, 1.0), (4.0, -3.0)])
    heading = 0.0  # passes the point by the start at once
    stops = Stops(points, [None] * 3, heading, (9.0, 0.0), None)
    found = search_tour(stops, tolerance=1e-8, boxes=1e6)
    assert found.closed
    orders = [(1, 2), (2, 1)]
    lengths = [
        search([(0.0, 0.0), *points[list(order)], (9.0, 0.0)], heading).length for order in orders
    ]
    assert search_tour(stops, boxes=1).low <= min(lengths) + 1e-8
    assert found.low <= min(lengths) + 1e-8
    assert found.high == pytest.approx(min(lengths), abs=1e-7)


@pytest.mark.parametrize("count", [_ABOVE_LISTING, _ONLY_A_TREE])
@pytest.mark.parametrize("closed", [False, True])
def test_many_points_have_a_good_tour_and_a_lower_end(count: int, closed: bool) -> None:
    random = np.random.default_rng([count, closed])
    points = random.uniform(0.0, 8.0 * math.sqrt(count), (count, 2))
    target = (0.0, 0.0) if closed else None
    first = None if closed else 0.4
    stops = Stops(points, [None] * count, first, target, None, closed=closed)
    found = search_tour(stops, boxes=3e5)
    assert sorted(found.order) == list(range(count))
    assert 0.5 * found.high < found.low <= found.route.length <= found.high

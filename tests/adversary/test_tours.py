"""The search for tours against independent answers.

They come from all orders, grids of headings, symmetries and random tours.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from dubins_study.study.kinds.shortest import ShortestRoute
from dubins_study.study.scenario import Scenario
from tests.adversary import WHOLE
from tests.adversary.tours import (
    CLOSE,
    KINDS,
    any_tour,
    by_all_orders,
    by_grid,
    length_through,
    mapped,
    random_tour,
    tour_of,
)

# square root of the square's area a point: 1.5 and 3 radii are dense, where orders are hard to tell
DENSE = (1.0, 1.5, 3.0)
SETS = 200
SMALL = 24
PARTS = 20


def checked_by_all_orders(seed: int, points: int) -> None:
    """Tours whose answer agrees with all orders.

    The tour is no longer than the best order. Its lower end is no longer than any order's.
    """
    rng = np.random.default_rng((34, seed))
    scenario = random_tour(
        rng, KINDS[seed % len(KINDS)], points, DENSE[seed % 3] * math.sqrt(points)
    )

    tour = tour_of(scenario)
    best = by_all_orders(scenario, tour.high)

    room = 1e-12 * best.high
    assert tour.low <= best.high + room, scenario
    assert tour.high >= best.low - room, scenario
    assert tour.high <= best.high * (1.0 + 2.0 * CLOSE) + room, scenario
    assert tour.path.length <= tour.high + room


@pytest.mark.smoke
@pytest.mark.many(12)
@pytest.mark.parametrize("seed", range(SMALL))
def test_few_points_are_those_of_the_best_order(seed: int) -> None:
    """Few points are visited in the best order.

    There are all kinds of ends, in three densities.
    """
    checked_by_all_orders(seed, 2 + seed % 3)


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("part", range(PARTS if WHOLE else 6))
def test_dense_points_are_those_of_the_best_order(part: int) -> None:
    """Dense points are visited in the best order.

    Each set has 3 to 6 points; the whole attack has 200 sets.
    """
    for seed in range(SMALL + part, SMALL + SETS, PARTS):
        checked_by_all_orders(seed, 6 if seed % 30 == 0 else 3 + seed % 3)


def agree(one: ShortestRoute, other: ShortestRoute, scale: float = 1.0) -> None:
    """Two intervals hold one length, and are narrow."""
    for found in (one, other):
        assert found.high - found.low <= 1.1e-9 * found.high
    room = 1e-9 * one.high
    assert abs(one.high - other.high / scale) <= room
    assert abs(one.low - other.low / scale) <= room


SYMMETRIES = {
    "mirrored": (lambda x, y: (x, -y), 0.0, -1, 1.0),
    "turned": (lambda x, y: (0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y), math.atan2(0.6, 0.8), 1, 1.0),
    "shifted": (lambda x, y: (x + 7.0, y - 3.0), 0.0, 1, 1.0),
    "scaled": (lambda x, y: (250.0 * x, 250.0 * y), 0.0, 1, 250.0),
    "turned by full turns": (lambda x, y: (x, y), 4.0 * math.pi, 1, 1.0),
}


@pytest.mark.smoke
@pytest.mark.many(8)
@pytest.mark.parametrize("name", SYMMETRIES)
@pytest.mark.parametrize("kind", KINDS)
def test_symmetric_tours_are_as_long(kind: str, name: str) -> None:
    scenario = random_tour(np.random.default_rng((KINDS.index(kind), 2)), kind, 5, 12.0)
    change, turn, mirror, scale = SYMMETRIES[name]

    agree(tour_of(scenario), tour_of(mapped(scenario, change, turn, mirror, scale)), scale)


@pytest.mark.smoke
@pytest.mark.many(4)
@pytest.mark.parametrize("kind", KINDS)
def test_points_in_another_order_are_the_same_tour(kind: str) -> None:
    rng = np.random.default_rng((KINDS.index(kind), 3))
    scenario = random_tour(rng, kind, 6, 15.0)
    via = [scenario.via[i] for i in rng.permutation(6)]

    agree(tour_of(scenario), tour_of(replace(scenario, via=via)))


@pytest.mark.smoke
@pytest.mark.many(4)
@pytest.mark.parametrize("kind", KINDS)
def test_a_point_on_the_best_tour_leaves_the_length(kind: str) -> None:
    """A point on the best tour leaves the length.

    It has its heading there, or none.
    """
    rng = np.random.default_rng((KINDS.index(kind), 4))
    scenario = random_tour(rng, kind, 5, 14.0)
    tour = tour_of(scenario)
    x, y, heading = tour.path.at(rng.uniform(0.2, 0.8) * tour.path.length)[0].tolist()

    for point in ((x, y), (x, y, heading)):
        more = tour_of(replace(scenario, via=[*scenario.via, point]))
        assert more.low <= tour.high * (1.0 + 1e-9)
        assert more.high >= tour.low * (1.0 - 1e-9)
        assert more.high <= tour.high * (1.0 + 1e-7)


@pytest.mark.smoke
@pytest.mark.parametrize("seed", range(3))
def test_a_closed_tour_is_as_long_the_other_way_round(seed: int) -> None:
    """A closed tour is as long when reversed.

    All headings are turned by half a turn.
    """
    rng = np.random.default_rng((seed, 5))
    scenario = random_tour(rng, "closed", 5, 12.0)
    headed = replace(scenario, via=[(*scenario.via[0], 1.0), *scenario.via[1:]])
    for one in (scenario, headed):
        other = mapped(one, lambda x, y: (x, y), math.pi, 1, 1.0)
        agree(tour_of(one), tour_of(other))


@pytest.mark.smoke
@pytest.mark.many(6)
@pytest.mark.parametrize("seed", range(14))
def test_no_random_tour_is_shorter_than_the_lower_end(seed: int) -> None:
    """No random tour is below the lower end.

    A thousand are tried in all, and those of the best order with headings near the best ones.
    """
    rng = np.random.default_rng((34, seed, 6))
    kind = KINDS[seed % len(KINDS)]
    scenario = random_tour(rng, kind, 7, (4.0, 8.0)[seed % 2] * math.sqrt(7))
    tour = tour_of(scenario)

    for _ in range(75):
        assert any_tour(scenario, rng) >= tour.low
    poses = tour.path.at(np.array([0.0, *tour.at, tour.path.length]))
    headings = poses[:, 2]
    places = poses[1 : len(scenario.via) + 1, :2]
    points = np.array([stop[:2] for stop in scenario.stops[: len(scenario.via)]])
    order = np.argmin(np.hypot(*(places[:, None] - points[None]).transpose(2, 0, 1)), axis=1)
    given = [scenario.heading, *(scenario.stops[i].heading for i in order)]
    given += [stop.heading for stop in scenario.stops[len(order) :]]
    for size in (1e-1, 1e-2, 1e-3, 1e-4):
        moved = headings + size * rng.normal(size=headings.size)
        moved = [
            angle if known is None else known for angle, known in zip(moved, given, strict=True)
        ]
        if scenario.closed:
            moved[-1] = moved[0]
        assert length_through(scenario, order.tolist(), moved) >= tour.low


# comrob/gdip, python/problems/gdip-n10.txt at f32ca16; radius 1
GDIP = (
    *((6.71627, 8.3767), (6.40217, 9.49307), (3.41556, 10.2848), (5.91928, 7.20563)),
    *((3.90768, 3.7961), (7.52977, 3.70221), (8.84408, 3.80583), (10.6659, 6.6348)),
    *((12.1318, 7.59114), (10.5947, 10.1087)),
)
# comrob/OptimalDTSPN at fcb82d1: the first instances of 6 and 8 discs, their centres, and the lower
# bound of a closed tour of the discs in `results`, which is one of their centres too; radius 1
BEHDANI = {
    33.92062571661774: (
        *((4.86392, 0.149846), (1.46245, 3.64452), (2.35701, 1.65899), (15.8164, 4.45692)),
        *((1.90533, 0.0466933), (0.142582, 3.7788)),
    ),
    35.76007458512579: (
        *((2.35701, 1.65899), (15.8164, 4.45692), (1.90533, 0.0466933), (0.142582, 3.7788)),
        *((8.50661, 5.71184), (9.62822, 6.07166), (2.65975, 6.63045), (7.21262, 3.52123)),
    ),
}
# Kaya 2019, examples 2 and 4 with their order free: curvature, points, first and last heading (rad)
KAYA = {
    2: (
        *(3, [(-0.1, 0.3), (0.2, 0.8), (1, 1), (0.5, 0.5)], (0, 0), (0.5, 0)),
        *(-math.pi / 3, -math.pi / 6, 6.27803455030931356617),
    ),
    4: (
        3,
        [*((0, 0.5), (0.5, 0.5), (1, 0.5), (1.5, 0.5), (2, 0.5), (2, 0), (1.5, 0)), (1, 0)],
        *((0.5, 1.2), (0.5, 0), 5 * math.pi / 6, 0.0, math.inf),
    ),
}


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_ten_published_points_beside_a_grid_of_headings() -> None:
    """A grid of headings beats no published ten points.

    Held and Karp's program over orders and headings finds nearly the same length.
    """
    (x, y), *via, (target_x, target_y) = GDIP
    scenario = Scenario(x, y, 0.0, target_x, target_y, via=via, order="free")
    tour = tour_of(scenario)
    grid = by_grid(scenario, 24)

    assert tour.high - tour.low <= 1e-8 * tour.high
    assert tour.low <= grid <= 1.05 * tour.high
    in_order = replace(scenario, order="given")
    assert tour.high < tour_of(in_order).low


@pytest.mark.smoke
@pytest.mark.parametrize("bound", BEHDANI)
def test_published_bounds_of_discs_are_below_the_tours_of_their_centres(bound: float) -> None:
    """Published bounds of discs are below their centres' tours.

    A tour is closed, from the first centre, whatever its heading there.
    """
    (x, y), *via = BEHDANI[bound]
    for heading in (0.0, 2.0, -2.0):
        tour = tour_of(Scenario(x, y, heading, via=via, order="free", closed=True))
        assert tour.high >= bound
        assert tour.low <= tour.high <= 1.3 * bound


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("example", KAYA)
def test_published_routes_with_their_order_free(example: int) -> None:
    """A free order is never longer than the printed.

    A grid of headings finds no shorter tour.
    """
    curvature, via, start, end, first, last, printed = KAYA[example]
    scenario = Scenario(*start, first, *end, 1 / curvature, via=via, final_heading=last)
    tour = tour_of(replace(scenario, order="free"))

    assert tour.low <= min(printed, tour_of(scenario).high)
    assert tour.low <= tour.high <= tour_of(scenario).high * (1.0 + 1e-9)
    assert tour.low <= by_grid(scenario, 12)

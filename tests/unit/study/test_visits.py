"""Visits of points by a path.

They are compared with dense sampling, and tested at the edges of its arcs.
"""

import math

import numpy as np
import pytest

from dubins_study.study.check.visits import legs, visits
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Stop

STRAIGHTS = (0.0, 1e-300, 1e-12, -1e-9, 1e-6)


def random_path(rng: np.random.Generator, radius: float = 1.0) -> Path:
    """A path of all kinds of arcs.

    There are all curvatures, arcs of no length and of more than a turn.
    """
    n = int(rng.integers(1, 9))
    rates = rng.choice([-1.0, 1.0, 0.0, rng.uniform(-1, 1), *rng.choice(STRAIGHTS, 1)], n)
    lengths = rng.choice([0.0, 1e-7, 1.0], n, p=[0.1, 0.1, 0.8]) * rng.uniform(0, 8, n)
    start = Pose(*rng.uniform(-5, 5, 2) * radius, rng.uniform(-9, 9))
    return Path(start, rates / radius, lengths * radius)


@pytest.mark.parametrize("seed", range(300))
def test_the_least_distance_is_that_of_dense_samples(seed):
    """The least distance is that of dense samples.

    The point is never reached: no sample is nearer, and one is as near.
    """
    rng = np.random.default_rng(seed)
    radius = 10.0 ** rng.uniform(-3, 3)
    path = random_path(rng, radius)
    point = np.array(path.start[:2]) + rng.uniform(-6, 6, 2) * radius

    seen = visits(path, [Stop(*point, None)], radius, 0.0)

    samples = path.sample(20_001)[:, :2]
    sampled = float(np.hypot(*(samples - point).T).min())
    assert sampled >= seen.miss - 1e-12 * radius
    # between samples the distance changes by at most half the way from one to the next
    assert sampled <= seen.miss + path.length / 40_000 + 1e-12 * radius
    there = path.at(seen.at[0])[0, :2]
    assert np.hypot(*(there - point)) == pytest.approx(seen.miss, abs=1e-9 * radius)


def test_each_visit_is_the_earliest_after_the_one_before():
    """Each visit is the earliest possible.

    It comes after the one before. On a circle driven twice, points on opposite sides alternate.
    """
    path = Path(Pose(0, 0, 0), [1.0], [4 * math.pi])
    right = Stop(1, 1, None)
    top = Stop(0, 2, None)
    left = Stop(-1, 1, None)
    at = [0.5 * math.pi, math.pi, 1.5 * math.pi]

    assert visits(path, [right, top, left], 1, 1e-6).at == pytest.approx(at)
    turn = 2 * math.pi
    assert visits(path, [left, right], 1, 1e-6).at == pytest.approx([at[2], at[0] + turn])
    assert visits(path, [left, right, top], 1, 1e-6).miss < 1e-12
    assert visits(path, [left, right, left], 1, 1e-6).miss < 1e-12
    assert visits(path, [left, right, left, right], 1, 1e-6).miss > 0.1  # a third turn is missing


def test_what_is_near_is_not_cut_in_two():
    """A near stretch is not cut in two.

    A point beside the joint of two arcs is visited where the second one is nearest to it.
    """
    path = Path(Pose(0, 0, 0), [0.0, 1.0], [1.0, 2.0])
    x, y, heading = path.at(1 + 5e-7)[0]
    point = Stop(x - 2e-7 * math.sin(heading), y + 2e-7 * math.cos(heading), None)

    seen = visits(path, [point], 1, 1e-6)

    assert seen.miss == pytest.approx(2e-7, rel=1e-6)
    assert seen.at == pytest.approx([1 + 5e-7], abs=1e-12)


@pytest.mark.parametrize("curvature", [0.0, 1e-300, 1e-14, 1e-8, -1e-8])
def test_arcs_that_hardly_turn_keep_their_digits(curvature):
    path = Path(Pose(0, 0, 0), [curvature], [1e6])
    x, y, _ = path.at(3e5)[0]

    assert visits(path, [Stop(x, y + 3e-7, None)], 1, 1e-6).miss == pytest.approx(3e-7, rel=1e-3)


@pytest.mark.parametrize(
    ("arcs", "point", "miss"),
    [
        (([1.0, 0.0], [1.0, 0.1]), (0, 1), 1),  # the centre of an arc
        *((arcs, (3, 4), 5) for arcs in (([], []), ([1.0], [0.0]))),  # of no length
        *((arcs, (0, 0), 0) for arcs in (([], []), ([1.0], [0.0]))),
        (([1e300, 1.0], [1e-3, 1.0]), (1e200, 0), math.nan),  # numbers that overflow
    ],
)
def test_misses_known_in_advance(arcs, point, miss):
    places = visits(Path(Pose(0, 0, 0), *arcs), [Stop(*point, None)], 1, 1e-6).miss

    assert places == pytest.approx(miss) or (math.isnan(miss) and not places <= 1e-6)


def test_legs_end_where_points_are_visited():
    path = Path(Pose(0, 0, 0), [1.0, 0.0, -1.0], [1.0, 4.0, 1.0])

    first, second, third = legs(path, (1.0, 3.0), 1)

    assert first.word() == "L"
    assert (second.word(), second.length) == ("S", 2.0)
    assert third.word() == "SR"
    assert third.start == pytest.approx(path.at(3.0)[0])


@pytest.mark.parametrize("length", [3.0, 1e-9, 1e-14])
def test_a_leg_however_short_keeps_its_word(length):
    """A leg however short keeps its word.

    A path goes on to a point that is next to the one before, driven straight.
    """
    path = Path(Pose(0, 0, 0), [1.0, 0.0], [1.0, length])

    assert [leg.word() for leg in legs(path, (1.0,), 1)] == ["L", "S"]

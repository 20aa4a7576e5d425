"""One leg with a final heading.

The six words are compared with search, peers, symmetries and differences.
"""

import math

import numpy as np
import pytest
from hypothesis import strategies as st

from dubins_study.study.body_coordinates import EPS
from dubins_study.study.check.enclosure import enclose_pose
from dubins_study.study.closed_form.kernel import NO_PATH
from dubins_study.study.closed_form.pose import (
    WORDS6,
    leg,
    pose_delta,
    pose_path,
    pose_segments,
    pose_shortest,
    shortest_to_pose,
)
from dubins_study.study.closed_form.pose_kernel import pose_rows
from dubins_study.study.scenario import Pose
from dubins_study.study.words import POSE_BRANCHES
from tests.brute_force import integrated, pose_words_by_search
from tests.hard_cases import hard_poses, poses_of

START = Pose(0, 0, 0)
angles = st.floats(-math.pi, math.pi)


def arrays(n: int, seed: int = 0) -> list[np.ndarray]:
    """n hard legs in the order of `PoseArrays`."""
    frame = hard_poses(n, seed)
    return [frame[name].to_numpy() for name in frame]


def random_arrays(n: int, seed: int) -> list[np.ndarray]:
    """n legs from the origin with R = 1.

    Ends are up to 30 radii away at every scale from 0.03.
    """
    rng = np.random.default_rng(seed)
    size = 10 ** rng.uniform(-1.5, 1.5, n)
    x, y = size * rng.uniform(-1, 1, (2, n))
    heading, final = rng.uniform(-math.pi, math.pi, (2, n))
    return [np.zeros(n), np.zeros(n), heading, x, y, np.ones(n), final]


def test_every_word_against_a_search():
    """Every word agrees with a search.

    In 200 random legs it is on a grid of the first arc, bisected.
    """
    rng = np.random.default_rng(3)
    for _ in range(200):
        size = rng.choice([1, 3, 8])
        X = rng.uniform(-size, size)
        Y = rng.uniform(-size, size)
        heading = rng.uniform(-3, 3)
        expected = pose_words_by_search(X, Y, heading)
        for index, word in enumerate(WORDS6):
            total = sum(pose_segments(X, Y, 0.0, heading, index, 0.0))
            assert (math.inf if math.isnan(total) else total) == pytest.approx(
                expected[word], abs=1e-9
            ), (X, Y, heading, word)


def test_paths_arrive():
    """Paths arrive.

    Driven by an integrator at 1e-12, every word of 40 hard legs ends at its pose.
    """
    for row in zip(*arrays(40, seed=4), strict=True):
        start, end, radius = poses_of(row)
        for word in WORDS6:
            path = pose_path(start, end, radius, word)
            if path is not None and path.length < 30 * radius:
                x, y, heading = integrated(path, radius)
                off = math.hypot(x - end.x, y - end.y) / radius
                assert off < 1e-7, (row, word)
                assert abs(math.remainder(heading - end.heading, 2 * math.pi)) < 1e-7


@pytest.mark.parametrize(
    ("end", "word", "length"),
    [
        ((0, 0, 0), "", 0.0),
        ((3, 0, 0), "S", 3.0),
        ((4, 0, 0), "S", 4.0),
        ((4, 0, 2 * math.pi), "S", 4.0),
        ((math.sin(0.3), 1 - math.cos(0.3), 0.3), "L", 0.3),
        ((0, 2, math.pi), "L", math.pi),
        ((2, 2, 0), "LR", math.pi),
        ((0, 4, 0), "LR", 2 * math.pi),
        ((-3, 0, 0), "LSL", 3 + 2 * math.pi),
        ((0, 0, math.pi), "RLR", 7 * math.pi / 3),
    ],
)
def test_edges_known_in_advance(end, word, length):
    """Edges known in advance.

    They are straight, one arc, two arcs without S, equal points; of a tie the first word.

    The last two are as long mirrored, which turns on the spot by 7 pi / 3.
    """
    shortest = shortest_to_pose(START, Pose(*end), 1.0)

    assert shortest.word == word
    assert shortest.total == pytest.approx(length, abs=2e-15 * (1 + length))
    if len(word) == 3:
        mirrored = word.translate(str.maketrans("LR", "RL"))
        assert shortest_to_pose(START, Pose(*end), 1.0, mirrored).total == pytest.approx(length)


@pytest.mark.parametrize("moved", [0.0, 4e-16, -4e-16])
@pytest.mark.parametrize("axis", range(3))
def test_an_arc_that_rounding_hides_is_nothing(moved, axis):
    """An arc that rounding hides is nothing.

    A target that was computed to be straight ahead, or on an arc, is reached without a turn.
    """
    for end in ((3.0, 0.0, 0.0), (math.sin(0.3), 1 - math.cos(0.3), 0.3), (2.0, 2.0, 0.0)):
        exact = shortest_to_pose(START, Pose(*end), 1.0)
        shifted = list(end)
        shifted[axis] += moved
        shortest = shortest_to_pose(START, Pose(*shifted), 1.0)
        assert shortest.total == pytest.approx(exact.total, abs=1e-14)


def test_beyond_the_reach_of_a_word_there_is_none():
    """No word exists beyond its reach.

    LSR where the circles are less than 2 apart, LRL where they are more than 4: by 1e-12.
    """
    for sign in (-1, 1):
        x = math.sqrt(4 - 1)
        near = shortest_to_pose(START, Pose(x + sign * 1e-12, 3, 0), 1.0, "LSR")
        far = shortest_to_pose(START, Pose(4 + sign * 1e-12, 0, 0), 1.0, "LRL")
        assert (near is None, far is None) == (sign < 0, sign > 0)
    edge = shortest_to_pose(START, Pose(4, 0, 0), 1.0, "LRL")
    assert edge.segments == pytest.approx((math.pi / 2, math.pi, math.pi / 2), abs=1e-15)


def test_a_word_of_one_circle_is_one_arc():
    """A word of one circle is one arc.

    LRL from a circle to itself takes a full middle turn; LSL is the arc alone.
    """
    end = Pose(math.sin(2), 1 - math.cos(2), 2)

    assert shortest_to_pose(START, end, 1.0, "LSL").segments == pytest.approx((0, 0, 2), abs=1e-15)
    assert shortest_to_pose(START, end, 1.0, "LRL").total == pytest.approx(2 + 2 * math.pi)


@pytest.mark.parametrize("p", [0.0, 1e-16, 1e-15, 1.5e-13, 1e-9])
def test_the_arcs_of_nearly_one_circle_add_up_to_the_turn(p):
    """Arcs of nearly one circle sum to the turn.

    They are of LSL and RSR with a straight so short that nobody knows where on the circle it is.
    """
    for a, first, last in ((-1.744, 1.164, 0.474), (0.3, 4.0, 5.0), (2.0, 1e-3, 3.0)):
        for index, turn in ((0, 1), (1, -1)):
            middle = a + turn * first
            b = a + turn * (first + last)
            x = turn * (math.sin(b) - math.sin(a)) + p * math.cos(middle)
            y = -turn * (math.cos(b) - math.cos(a)) + p * math.sin(middle)
            t, _, q = pose_segments(x, y, a, b, index, pose_delta(0.0, abs(x) + abs(y)))

            assert abs(math.remainder(t + q - turn * (b - a), 2 * math.pi)) < 1e-14


@pytest.mark.parametrize("branch", POSE_BRANCHES)
def test_rows_are_the_scalar_form(branch):
    """Rows are the scalar form.

    Of random and of hard legs they have the word, and the length to 20 EPS of it or of R.
    """
    n, allowed = (3_000, 20 * EPS) if branch == "best" else (500, 1e-12)
    for columns in (random_arrays(n, seed=6), arrays(n, seed=6)):
        rows = pose_rows(*columns, branch=branch)
        found = rows.segments / columns[5]
        for i, row in enumerate(zip(*columns, strict=True)):
            scalar = shortest_to_pose(*poses_of(row), branch)
            assert (rows.word[i] == NO_PATH) == (scalar is None)
            if scalar is None:
                continue
            assert abs(rows.length[i] / row[5] - scalar.total) <= allowed * max(scalar.total, 1.0)
            if branch == "best":
                _, word, *segments = pose_shortest(*leg(*poses_of(row)))
                assert rows.word[i] == word, row
                np.testing.assert_allclose(found[:, i], segments, atol=1e-7)


def test_large_headings_keep_their_digits():
    """Large headings keep their digits.

    Beside 1e8 whole turns' worth of heading, they are as doubles hold them.
    """
    for turns in (1e3, 1e8):
        start, end = Pose(0, 0, 1 + turns), Pose(2, 3, 2 + turns)
        enclosure = enclose_pose(start, end, 1.0)
        columns = ([0.0], [0.0], [start.heading], [2.0], [3.0], [1.0], [end.heading])
        for length in (shortest_to_pose(start, end, 1.0).total, pose_rows(*columns).length[0]):
            assert enclosure.holds(length, 0.0)


@pytest.mark.slow
def test_a_million_random_legs_against_a_peer():
    """A million random legs agree with a peer.

    They agree to 1e-12 of the length or of R. Where they differ, balls say that OMPL is wrong.

    It takes arcs below 1e-6 for nothing, and is then off by up to 1e-6.
    """
    space = pytest.importorskip("ompl.base").DubinsStateSpace(1.0)
    columns = random_arrays(1_000_000, seed=5)
    start, end = space.allocState(), space.allocState()
    start.setX(0.0)
    start.setY(0.0)
    theirs = np.empty(1_000_000)
    rows = zip(*(columns[k].tolist() for k in (2, 3, 4, 6)), strict=True)
    for i, (heading, x, y, final) in enumerate(rows):
        start.setYaw(heading)
        end.setX(x)
        end.setY(y)
        end.setYaw(final)
        theirs[i] = space.distance(start, end)
    ours = pose_rows(*columns).length
    other = np.flatnonzero(~(abs(theirs - ours) <= 1e-12 * np.maximum(ours, 1.0)))

    assert other.size <= 20
    for i in other:
        enclosure = enclose_pose(*poses_of(tuple(column[i] for column in columns)))
        assert enclosure.holds(ours[i], 0.0)
        assert not enclosure.holds(theirs[i], 0.0)
        assert abs(theirs[i] - ours[i]) < 2e-6


def test_the_uncertainty_grows_with_the_distance_from_the_origin():
    near, far = leg(START, Pose(1, 1, 0), 1.0), leg(Pose(1e6, 0, 0), Pose(1e6 + 1, 1, 0), 1.0)

    assert pose_delta(0.0, 0.0) < near.delta < 1e-14 < far.delta < 1e-8

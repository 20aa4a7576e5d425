"""Proven intervals of one leg, and their loops.

The intervals are balls; the compiled loops run over frames.

The adversary (`tests/adversary`) tests that those of a free final heading hold the truth, and
compares its loops with the scalar form.
"""

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import mpmath as mp
import numpy as np
import pandas as pd
import pytest

from dubins_study.study.check.enclosure import enclose, enclose_pose
from dubins_study.study.closed_form.kernel import NO_PATH, Rows, ScenarioArrays, shortest_rows
from dubins_study.study.closed_form.kernel_compile import SMALL, compiled
from dubins_study.study.closed_form.kernel_math import full_arctangent, sine_cosine
from dubins_study.study.closed_form.pose import leg, shortest_to_pose
from dubins_study.study.closed_form.pose_kernel import PoseArrays, pose_rows
from dubins_study.study.judging.judge import judge
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import POSE_BRANCHES
from tests.hard_cases import hard_frame, hard_poses, poses_of

START = Pose(0, 0, 0)


def textbook(X: mp.mpf, Y: mp.mpf, heading: mp.mpf) -> dict[str, mp.mpf]:
    """Textbook lengths of the words in 60 digits.

    Shkel and Lumelsky write them with acos and mod.

    Robotics and Autonomous Systems 34 (2001) 179-202, eqs. 8 to 13; a word without a path is left
    out.
    """
    turn = 2 * mp.pi
    d = mp.hypot(X, Y)
    phi = mp.atan2(Y, X)
    a, b = -phi % turn, (heading - phi) % turn
    sa, ca, sb, cb = mp.sin(a), mp.cos(a), mp.sin(b), mp.cos(b)
    both = 2 * mp.cos(a - b)
    lengths = {}
    for word, k in (("LSL", 1), ("RSR", -1)):
        to = mp.atan2(k * (cb - ca), d + k * (sa - sb))
        p = mp.sqrt(max(2 + d * d - both + 2 * k * d * (sa - sb), mp.mpf(0)))
        lengths[word] = k * (to - a) % turn + p + k * (b - to) % turn
    for word, k in (("LSR", 1), ("RSL", -1)):
        square = d * d - 2 + both + 2 * k * d * (sa + sb)
        if square >= 0:
            p = mp.sqrt(square)
            to = mp.atan2(-k * (ca + cb), d + k * (sa + sb)) - mp.atan2(-2 * k, p)
            lengths[word] = k * (to - a) % turn + p + k * (to - b) % turn
    for word, k in (("LRL", 1), ("RLR", -1)):
        cosine = (6 - d * d + both - 2 * k * d * (sa - sb)) / 8
        if abs(cosine) <= 1:
            p = turn - mp.acos(cosine)
            t = (k * (mp.atan2(k * (cb - ca), d + k * (sa - sb)) - a) + p / 2) % turn
            lengths[word] = t + p + (k * (b - a) - t + p) % turn
    return lengths


def lengths_within_delta(
    row: pd.Series, rng: np.random.Generator, n: int
) -> Iterator[dict[str, mp.mpf]]:
    """Words' lengths of n ends of a leg.

    They are in the length unit, with the least as `best`.

    The ends are anywhere in the cube of half width delta about the exact values of the doubles.
    """
    start, end, radius = poses_of(row)
    delta = leg(start, end, radius).delta
    R = mp.mpf(radius)
    dx, dy = (mp.mpf(end.x) - start.x) / R, (mp.mpf(end.y) - start.y) / R
    c, s = mp.cos(mp.mpf(start.heading)), mp.sin(mp.mpf(start.heading))
    heading = mp.mpf(end.heading) - start.heading
    for shift in (delta * rng.uniform(-1, 1, (n, 3))).tolist():
        truth = textbook(shift[0] + dx * c + dy * s, shift[1] + dy * c - dx * s, shift[2] + heading)
        truth["best"] = min(truth.values())
        yield {branch: length * R for branch, length in truth.items()}


@pytest.mark.parametrize("seed", range(3))
def test_balls_hold_the_lengths_of_ends_within_delta(seed):
    """Balls hold the lengths of ends within delta.

    Of 150 hard legs three ends each are taken, in 60 digits; every word, and the shortest of all.
    """
    rng = np.random.default_rng(seed)
    with mp.workdps(60):
        for _, row in hard_poses(150, seed).iterrows():
            enclosures = {branch: enclose_pose(*poses_of(row), branch) for branch in POSE_BRANCHES}
            for truth in lengths_within_delta(row, rng, 3):
                for branch, found in enclosures.items():
                    if branch in truth:
                        inside = any(a <= truth[branch] <= b for a, b in found.parts)
                        assert inside, (row, branch)
                    else:
                        assert found.absent, (row, branch)


def test_balls_hold_the_closed_form_and_are_narrow():
    """Balls hold the closed form and are narrow.

    Every word of 600 hard legs: what is taken to be on an edge is within delta of it.

    Next to the edge of a word's reach lengths go like a root, and are known to 1e-6 only.
    """
    for _, row in hard_poses(600, seed=5).iterrows():
        start, end, radius = poses_of(row)
        for branch in POSE_BRANCHES:
            enclosure = enclose_pose(start, end, radius, branch)
            closed = shortest_to_pose(start, end, radius, branch)
            if closed is None:
                assert enclosure.absent, (row, branch)
            else:
                slack = 1e-14 * max(closed.total, 1.0) * radius
                assert enclosure.holds(closed.total * radius, slack), (row, branch)
            delta = leg(start, end, radius).delta
            for low, high in enclosure.parts:
                assert high - low <= radius * 10 * math.sqrt(delta), (row, branch)


def test_a_straight_leg_has_one_length():
    """A straight leg has one length.

    The four words of S jump there one by one, but one of them is short on each side.
    """
    for end in (Pose(3, 0, 0), Pose(4, 0, 0), Pose(700, 0, 0)):
        enclosure = enclose_pose(START, end, 1.0)
        assert len(enclosure.parts) == 1
        assert enclosure.high - enclosure.low < 1e-13 * end.x


@pytest.mark.parametrize("heading", [1e9, 1e20, -1e28, 1e150])
def test_a_heading_of_many_turns_is_its_direction(heading):
    """A heading of many turns is its direction.

    A double of that size is an exact angle, of which 400 digits tell the direction.
    """
    with mp.workdps(400):
        reduced = float(mp.atan2(mp.sin(mp.mpf(heading)), mp.cos(mp.mpf(heading))))
    many, few = (enclose_pose(START, Pose(10, 5, angle), 1.0) for angle in (heading, reduced))

    assert many.high - many.low < 1e-12
    assert abs(many.low - few.low) < 1e-12
    assert abs(many.high - few.high) < 1e-12


def test_an_arc_has_two_lengths():
    """An arc has two lengths.

    On the circle it is the arc; off it the arc and a full turn, and nothing between.
    """
    enclosure = enclose_pose(START, Pose(math.sin(1), 1 - math.cos(1), 1), 1.0)

    assert [round(low, 3) for low, _ in enclosure.parts] == [1.0, 7.283]
    assert all(high - low < 1e-13 for low, high in enclosure.parts)


@pytest.mark.parametrize("arc", [math.pi, 3.3, 4.0, 4.6, 1.5 * math.pi, 5.5, 6.2])
@pytest.mark.parametrize("side", [1, -1])
def test_an_arc_of_half_a_turn_or_more_has_one_length(arc, side):
    """An arc of half a turn has one length.

    So has a longer one. Off the circle straights before and after the arc reach every end; at half
    a turn by a root.

    No path to any of 200 ends within delta is longer, in 60 digits.
    """
    row = pd.Series([0.0, 0, 0, math.sin(arc), side * (1 - math.cos(arc)), 1, side * arc])
    enclosure = enclose_pose(*poses_of(row))

    assert len(enclosure.parts) == 1
    assert enclosure.high - enclosure.low < (3e-7 if arc == math.pi else 1e-12)
    with mp.workdps(60):
        for truth in lengths_within_delta(row, np.random.default_rng(1), 200):
            assert enclosure.low <= truth["best"] <= enclosure.high


def test_edges_of_reach_are_known_to_a_root():
    """Edges of reach are known to a root.

    LRL at centres 4 apart: a length from 2 pi on, and maybe none.
    """
    enclosure = enclose_pose(START, Pose(4, 0, 0), 1.0, "LRL")

    assert enclosure.absent
    assert enclosure.low < 2 * math.pi < enclosure.high < 2 * math.pi + 1e-6


def test_the_jump_across_a_circle_is_not_blurred():
    """The jump across a circle is not blurred.

    On the circle there are the arc, and a full turn more of the targets just inside; not what is
    between.

    A millionth inside the circle, the full turn alone.
    """
    on = Scenario(0, 0, 0, math.sin(0.3), 1 - math.cos(0.3), 1)
    inside = Scenario(0, 0, 0, (1 - 1e-6) * math.sin(0.3), 1 - (1 - 1e-6) * math.cos(0.3), 1)

    assert judge(on, None).region == "circle"
    assert [round(low, 3) for low, _ in enclose(on).parts] == [0.3, 6.535]
    assert all(high - low < 1e-13 for low, high in enclose(on).parts)
    assert enclose(inside).low > 6.5


def test_just_behind_the_start_a_turn_of_nothing_is_none():
    """Behind the start a turn of nothing is none.

    Found in review: the arc there is a full turn less 2e-7, which no path of 6e-7 replaces.
    """
    scenario = Scenario(0, 0, 0, -2e-7, 2e-14, 1)
    for branch in ("best", "RL"):
        enclosure = enclose(scenario, branch)
        assert enclosure.low <= 2 * math.pi - 2e-7 <= enclosure.high + 1e-13
        assert enclosure.low > 6.28


class Kind(NamedTuple):
    """Loops of one kind of leg, and hard frames."""

    lengths: Callable[..., Rows]
    arrays: type[ScenarioArrays | PoseArrays]
    hard: Callable[[int], pd.DataFrame]


FREE = Kind(shortest_rows, ScenarioArrays, hard_frame)
GIVEN = Kind(pose_rows, PoseArrays, hard_poses)
KINDS = pytest.mark.parametrize("kind", [FREE, GIVEN], ids=["free", "given"])


def columns(kind, frame):
    return kind.arrays(*(frame[name].to_numpy() for name in kind.arrays._fields))


@KINDS
def test_threads_and_vectors_do_not_change_a_bit(kind):
    """Threads and vectors do not change a bit.

    Threaded, alone, and one row at a time: strict IEEE arithmetic gives the same numbers.
    """
    frame = kind.hard(700)
    many = pd.concat([frame] * (SMALL // 700 + 2), ignore_index=True)
    short, long = columns(kind, frame), columns(kind, many)
    alone = kind.lengths(*short)
    threaded = kind.lengths(*long)
    for i in range(0, 700, 7):
        single = kind.lengths(*columns(kind, frame[i : i + 1]))
        for a, b in zip(single, alone, strict=True):
            np.testing.assert_array_equal(a[..., 0], b[..., i])
    for a, b in zip(alone, threaded, strict=True):
        np.testing.assert_array_equal(a, b[..., :700])
        np.testing.assert_array_equal(a, b[..., 700:1400])


GOOD = {"x": 0.0, "y": 0.0, "heading": 0.0, "target_x": 3.0, "target_y": 1.0, "radius": 1.0}
GOOD |= {"final_heading": 0.5}
BAD = [
    *({"x": math.nan}, {"x": math.inf}, {"target_y": math.inf}, {"heading": math.nan}),
    *({"radius": math.nan}, {"radius": 0.0}, {"target_x": 1e300, "radius": 1e-300}),
    *({"final_heading": math.nan}, {"radius": -1.0}),
]


@pytest.mark.parametrize("values", BAD)
def test_a_bad_row_has_no_path_beside_one_that_is_good(values):
    frame = pd.DataFrame([GOOD | values, GOOD])
    rows = GIVEN.lengths(*columns(GIVEN, frame))

    assert (rows.word == NO_PATH).tolist() == [True, False]
    assert np.isnan(rows.length).tolist() == [True, False]


@compiled
def sines_and_angles(angles, slopes, out):
    for i in range(angles.size):
        out[0, i], out[1, i] = sine_cosine(angles[i])
        out[2, i] = full_arctangent(slopes[0, i], slopes[1, i])


def test_sines_and_angles_of_the_loops_are_those_of_60_digits():
    """The loops' sines and angles are right.

    They are those of 60 digits: of angles at every size up to the largest, and of points in all
    directions, near the axes.
    """
    rng = np.random.default_rng(10)
    n = 5_000
    angles = rng.choice([-1, 1], n) * 10 ** rng.uniform(-3, 9, n)
    slopes = rng.choice([-1, 1], (2, n)) * 10 ** rng.uniform(-4, 4, (2, n))
    out = np.empty((3, n))
    sines_and_angles(angles, slopes, out)
    with mp.workdps(60):
        for angle, y, x, found in zip(angles, *slopes, out.T, strict=True):
            direction = mp.atan2(y, x) % (2 * mp.pi)
            expected = mp.sin(mp.mpf(angle)), mp.cos(mp.mpf(angle)), direction
            off = [abs(a - b) for a, b in zip(found, expected, strict=True)]
            assert max(off[:2]) < 2.1e-16
            assert off[2] < 2 * math.ulp(float(direction)) + 2 * math.ulp(1.0) * (y < 0)

"""Proven intervals of one leg in balls, and the compiled loops over frames: lengths and bounds.

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
from hard_cases import hard_frame, hard_poses, poses_of

from dubins_study.study.check import enclosure_kernel
from dubins_study.study.check.enclosure import enclose, enclose_pose
from dubins_study.study.check.enclosure_kernel import bound_rows
from dubins_study.study.closed_form.kernel import NO_PATH, Rows, ScenarioArrays, shortest_rows
from dubins_study.study.closed_form.kernel_compile import SMALL, compiled
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE
from dubins_study.study.closed_form.pose import leg, shortest_to_pose
from dubins_study.study.closed_form.pose_kernel import PoseArrays, pose_rows, turn_between
from dubins_study.study.judging.judge import judge
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import POSE_BRANCHES

START = Pose(0, 0, 0)


def textbook(X: mp.mpf, Y: mp.mpf, heading: mp.mpf) -> dict[str, mp.mpf]:
    """The words' lengths as Shkel and Lumelsky write them, with acos and mod, in 60 digits.

    Robotics and Autonomous Systems 34 (2001) 179-202, eqs. 8 to 13; a word without a path is left
    out.
    """
    turn = 2 * mp.pi
    d, phi = mp.hypot(X, Y), mp.atan2(Y, X)
    a, b = -phi % turn, (heading - phi) % turn
    sa, ca, sb, cb = mp.sin(a), mp.cos(a), mp.sin(b), mp.cos(b)
    both = 2 * mp.cos(a - b)
    found = {}
    for word, k in (("LSL", 1), ("RSR", -1)):
        to = mp.atan2(k * (cb - ca), d + k * (sa - sb))
        p = mp.sqrt(max(2 + d * d - both + 2 * k * d * (sa - sb), mp.mpf(0)))
        found[word] = k * (to - a) % turn + p + k * (b - to) % turn
    for word, k in (("LSR", 1), ("RSL", -1)):
        square = d * d - 2 + both + 2 * k * d * (sa + sb)
        if square >= 0:
            p = mp.sqrt(square)
            to = mp.atan2(-k * (ca + cb), d + k * (sa + sb)) - mp.atan2(-2 * k, p)
            found[word] = k * (to - a) % turn + p + k * (to - b) % turn
    for word, k in (("LRL", 1), ("RLR", -1)):
        cosine = (6 - d * d + both - 2 * k * d * (sa - sb)) / 8
        if abs(cosine) <= 1:
            p = turn - mp.acos(cosine)
            t = (k * (mp.atan2(k * (cb - ca), d + k * (sa - sb)) - a) + p / 2) % turn
            found[word] = t + p + (k * (b - a) - t + p) % turn
    return found


def lengths_within_delta(
    row: pd.Series, rng: np.random.Generator, n: int
) -> Iterator[dict[str, mp.mpf]]:
    """The words' lengths, and the least as `best`, of n ends of a leg, in the length unit.

    The ends are anywhere in the cube of half width delta about the exact values of the doubles.
    """
    start, end, radius = poses_of(row)
    delta, R = leg(start, end, radius).delta, mp.mpf(radius)
    dx, dy = (mp.mpf(end.x) - start.x) / R, (mp.mpf(end.y) - start.y) / R
    c, s = mp.cos(mp.mpf(start.heading)), mp.sin(mp.mpf(start.heading))
    heading = mp.mpf(end.heading) - start.heading
    for shift in (delta * rng.uniform(-1, 1, (n, 3))).tolist():
        truth = textbook(shift[0] + dx * c + dy * s, shift[1] + dy * c - dx * s, shift[2] + heading)
        truth["best"] = min(truth.values())
        yield {branch: length * R for branch, length in truth.items()}


@pytest.mark.parametrize("seed", range(3))
def test_balls_hold_the_lengths_of_ends_within_delta(seed):
    """Of 150 hard legs three ends each, in 60 digits; every word, and the shortest of all."""
    rng = np.random.default_rng(seed)
    with mp.workdps(60):
        for _, row in hard_poses(150, seed).iterrows():
            enclosures = {branch: enclose_pose(*poses_of(row), branch) for branch in POSE_BRANCHES}
            for truth in lengths_within_delta(row, rng, 3):
                for branch, found in enclosures.items():
                    if branch in truth:
                        held = any(a <= truth[branch] <= b for a, b in found.parts)
                        assert held, (row, branch)
                    else:
                        assert found.absent, (row, branch)


def test_balls_hold_the_closed_form_and_are_narrow():
    """Of 600 hard legs every word: what is taken to be on an edge is within delta of it.

    Next to the edge of a word's reach lengths go like a root, and are known to 1e-6 only.
    """
    for _, row in hard_poses(600, seed=5).iterrows():
        start, end, radius = poses_of(row)
        for branch in POSE_BRANCHES:
            found = enclose_pose(start, end, radius, branch)
            closed = shortest_to_pose(start, end, radius, branch)
            if closed is None:
                assert found.absent, (row, branch)
            else:
                slack = 1e-14 * max(closed.total, 1.0) * radius
                assert found.holds(closed.total * radius, slack), (row, branch)
            delta = leg(start, end, radius).delta
            for low, high in found.parts:
                assert high - low <= radius * 10 * math.sqrt(delta), (row, branch)


def test_a_straight_leg_has_one_length():
    """The four words of S jump there one by one, but one of them is short on each side."""
    for end in (Pose(3, 0, 0), Pose(4, 0, 0), Pose(700, 0, 0)):
        found = enclose_pose(START, end, 1.0)
        assert len(found.parts) == 1
        assert found.high - found.low < 1e-13 * end.x


@pytest.mark.parametrize("heading", [1e9, 1e20, -1e28, 1e150])
def test_a_heading_of_many_turns_is_its_direction(heading):
    """A double of that size is an exact angle, of which 400 digits tell the direction."""
    with mp.workdps(400):
        reduced = float(mp.atan2(mp.sin(mp.mpf(heading)), mp.cos(mp.mpf(heading))))
    many, few = (enclose_pose(START, Pose(10, 5, angle), 1.0) for angle in (heading, reduced))

    assert many.high - many.low < 1e-12
    assert abs(many.low - few.low) < 1e-12
    assert abs(many.high - few.high) < 1e-12


def test_an_arc_has_two_lengths():
    """On the circle the arc; off it the arc and a full turn, and nothing between."""
    found = enclose_pose(START, Pose(math.sin(1), 1 - math.cos(1), 1), 1.0)

    assert [round(low, 3) for low, _ in found.parts] == [1.0, 7.283]
    assert all(high - low < 1e-13 for low, high in found.parts)


@pytest.mark.parametrize("arc", [math.pi, 3.3, 4.0, 4.6, 1.5 * math.pi, 5.5, 6.2])
@pytest.mark.parametrize("side", [1, -1])
def test_an_arc_of_half_a_turn_or_more_has_one_length(arc, side):
    """Off the circle straights before and after the arc reach every end; at half a turn by a root.

    No path to any of 200 ends within delta is longer, in 60 digits.
    """
    row = pd.Series([0.0, 0, 0, math.sin(arc), side * (1 - math.cos(arc)), 1, side * arc])
    found = enclose_pose(*poses_of(row))

    assert len(found.parts) == 1
    assert found.high - found.low < (3e-7 if arc == math.pi else 1e-12)
    with mp.workdps(60):
        for truth in lengths_within_delta(row, np.random.default_rng(1), 200):
            assert found.low <= truth["best"] <= found.high


def test_edges_of_reach_are_known_to_a_root():
    """LRL at centres 4 apart: a length from 2 pi on, and maybe none."""
    found = enclose_pose(START, Pose(4, 0, 0), 1.0, "LRL")

    assert found.absent
    assert found.low < 2 * math.pi < found.high < 2 * math.pi + 1e-6


def test_loops_hold_the_lengths_of_ends_within_delta():
    """Of the rows of 400 hard legs that they decide, two ends each, in 60 digits."""
    frame, rng, compared = hard_poses(400, seed=8), np.random.default_rng(8), 0
    arrays = PoseArrays(*(frame[name].to_numpy() for name in frame))
    bounds = {branch: bound_rows(arrays, branch) for branch in POSE_BRANCHES}
    with mp.workdps(60):
        for i, row in frame.iterrows():
            for truth in lengths_within_delta(row, rng, 2):
                for branch, (low, high, left) in bounds.items():
                    if not left[i]:
                        assert low[i] <= truth.get(branch, mp.inf) <= high[i], (row, branch)
                        compared += 1
    assert compared > 3_000


def test_the_jump_across_a_circle_is_not_blurred():
    """On the circle the arc, and a full turn more of the targets just inside; not what is between.

    A millionth inside the circle, the full turn alone.
    """
    on = Scenario(0, 0, 0, math.sin(0.3), 1 - math.cos(0.3), 1)
    inside = Scenario(0, 0, 0, (1 - 1e-6) * math.sin(0.3), 1 - (1 - 1e-6) * math.cos(0.3), 1)

    assert judge(on, None).region == "circle"
    assert [round(low, 3) for low, _ in enclose(on).parts] == [0.3, 6.535]
    assert all(high - low < 1e-13 for low, high in enclose(on).parts)
    assert enclose(inside).low > 6.5


def test_just_behind_the_start_a_turn_of_nothing_is_none():
    """Found in review: the arc there is a full turn less 2e-7, which no path of 6e-7 replaces."""
    scenario = Scenario(0, 0, 0, -2e-7, 2e-14, 1)
    for branch in ("best", "RL"):
        found = enclose(scenario, branch)
        assert found.low <= 2 * math.pi - 2e-7 <= found.high + 1e-13
        assert found.low > 6.28


class Kind(NamedTuple):
    """The loops of one kind of leg, frames of hard ones, and the branches that are enclosed."""

    lengths: Callable[..., Rows]
    arrays: type[ScenarioArrays | PoseArrays]
    hard: Callable[[int], pd.DataFrame]
    branches: tuple[str, ...]


FREE = Kind(shortest_rows, ScenarioArrays, hard_frame, ())
GIVEN = Kind(pose_rows, PoseArrays, hard_poses, POSE_BRANCHES)
KINDS = pytest.mark.parametrize("kind", [FREE, GIVEN], ids=["free", "given"])


def columns(kind, frame):
    return kind.arrays(*(frame[name].to_numpy() for name in kind.arrays._fields))


@KINDS
def test_threads_and_vectors_do_not_change_a_bit(kind):
    """Threaded, alone, and one row at a time: strict IEEE arithmetic gives the same numbers."""
    frame = kind.hard(700)
    many = pd.concat([frame] * (SMALL // 700 + 2), ignore_index=True)
    short, long = columns(kind, frame), columns(kind, many)
    alone, threaded = kind.lengths(*short), kind.lengths(*long)
    for i in range(0, 700, 7):
        single = kind.lengths(*columns(kind, frame[i : i + 1]))
        for a, b in zip(single, alone, strict=True):
            np.testing.assert_array_equal(a[..., 0], b[..., i])
    of_branches = ((bound_rows(short, b), bound_rows(long, b)) for b in kind.branches)
    for few, all_rows in [(alone, threaded), *of_branches]:
        for a, b in zip(few, all_rows, strict=True):
            np.testing.assert_array_equal(a, b[..., :700])
            np.testing.assert_array_equal(a, b[..., 700:1400])


GOOD = {"x": 0.0, "y": 0.0, "heading": 0.0, "target_x": 3.0, "target_y": 1.0, "radius": 1.0}
GOOD |= {"final_heading": 0.5}
BAD = [
    *({"x": math.nan}, {"x": math.inf}, {"target_y": math.inf}, {"heading": math.nan}),
    *({"radius": math.nan}, {"radius": 0.0}, {"target_x": 1e300, "radius": 1e-300}),
]
UNDECIDED = [
    *({"radius": math.inf}, {"heading": 2 * LARGEST_ANGLE}),
    {"target_x": 0.0, "target_y": 0.0, "final_heading": 0.0},  # the start
    {"target_x": math.sin(1), "target_y": 1 - math.cos(1), "final_heading": 1.0},
    {"target_x": 1.0, "target_y": 1.0, "final_heading": math.pi / 2},  # on the circle
]
UNDECIDED_IF_GIVEN = [
    *({"final_heading": 2 * LARGEST_ANGLE}, {"final_heading": math.nan}, {"radius": -1.0}),
    {"target_y": 0.0, "final_heading": 0.0},  # straight ahead
    {"target_x": 2.0, "target_y": 2.0, "final_heading": 0.0},
]
CASES = [*((values, True) for values in BAD + UNDECIDED + UNDECIDED_IF_GIVEN), ({}, False)]


@pytest.mark.parametrize(("values", "left"), CASES)
def test_rows_that_the_loops_cannot_decide_are_left(values, left):
    """A bad row has no path, beside one that is good."""
    frame = pd.DataFrame([GOOD | values, GOOD])
    rows = GIVEN.lengths(*columns(GIVEN, frame))

    assert bound_rows(columns(GIVEN, frame)).left.tolist() == [left, False]
    no_path = values in BAD or values in UNDECIDED_IF_GIVEN[1:3]
    if no_path or not left:
        assert (rows.word == NO_PATH).tolist() == [no_path, False]
        assert np.isnan(rows.length).tolist() == [no_path, False]


def test_the_turn_of_the_loops_is_within_its_proven_error():
    """Of headings at every size up to the largest, in 60 digits, modulo a full turn."""
    rng = np.random.default_rng(10)
    headings = rng.choice([-1, 1], (2, 2_000)) * 10 ** rng.uniform(-3, 9, (2, 2_000))
    found = turns(*headings)
    with mp.workdps(60):
        for a, b, turn in zip(*headings.tolist(), found.tolist(), strict=True):
            parts = (mp.mpf(b) - a - turn) / (2 * mp.pi)
            assert abs(parts - mp.nint(parts)) * 2 * mp.pi < enclosure_kernel._TURN_ERROR
            assert 0 <= turn < 2 * math.pi + 1e-15


@compiled
def turns(a, b):
    """`turn_between` of arrays."""
    found = np.empty(a.size)
    for i in range(a.size):
        found[i] = turn_between(a[i], b[i])
    return found

"""The compiled loops over frames: lengths and proven bounds, with the final heading free or given.

The adversary (`tests/adversary`) compares those of a free final heading with the scalar form, and
with an oracle of 60 digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import mpmath as mp
import numpy as np
import pandas as pd
import pytest
from hard_cases import hard_frame, hard_poses

from dubins_study.study.check import pose_enclosure_kernel
from dubins_study.study.check.enclosure_kernel import bound_rows
from dubins_study.study.check.pose_enclosure_kernel import bound_pose_rows
from dubins_study.study.closed_form.kernel import NO_PATH, Rows, ScenarioArrays, shortest_rows
from dubins_study.study.closed_form.kernel_compile import SMALL, compiled
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE
from dubins_study.study.closed_form.pose_kernel import PoseArrays, PoseRows, pose_rows, turn_between
from dubins_study.study.words import BRANCHES, POSE_BRANCHES


class Kind(NamedTuple):
    """The loops of one kind of leg, and frames of hard ones."""

    lengths: Callable[..., Rows | PoseRows]
    bounds: Callable[..., object]
    arrays: type[ScenarioArrays | PoseArrays]
    hard: Callable[[int], pd.DataFrame]
    out: Callable[[int], Rows | PoseRows]


FREE = Kind(shortest_rows, bound_rows, ScenarioArrays, hard_frame, Rows.empty)
GIVEN = Kind(pose_rows, bound_pose_rows, PoseArrays, hard_poses, PoseRows.empty)
KINDS = pytest.mark.parametrize("kind", [FREE, GIVEN], ids=["free", "given"])
EACH = [(kind, b) for kind, names in ((FREE, BRANCHES), (GIVEN, POSE_BRANCHES)) for b in names]


def columns(kind, frame):
    return kind.arrays(*(frame[name].to_numpy() for name in kind.arrays._fields))


def bounded(kind, frame, branch):
    return kind.bounds(columns(kind, frame), branch)


@KINDS
def test_threads_and_vectors_do_not_change_a_bit(kind):
    """Threaded, alone, and one row at a time: strict IEEE arithmetic gives the same numbers."""
    frame = kind.hard(700)
    many = pd.concat([frame] * (SMALL // 700 + 2), ignore_index=True)
    alone, threaded = (kind.lengths(*columns(kind, rows)) for rows in (frame, many))
    for i in range(0, 700, 7):
        single = kind.lengths(*columns(kind, frame[i : i + 1]))
        assert [a[0] for a in single] == [a[i] for a in alone]
    pairs = [(alone, threaded)]
    for _, branch in (each for each in EACH if each[0] is kind):
        pairs.append((bounded(kind, frame, branch), bounded(kind, many, branch)))
    for few, all_rows in pairs:
        for a, b in zip(few, all_rows, strict=True):
            np.testing.assert_array_equal(a, b[:700])
            np.testing.assert_array_equal(a, b[700:1400])


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
DECIDED = [{}, {"target_x": 5e-324, "target_y": 4.0}]  # whose axis is no edge of `best`
CASES = [
    *((FREE, values, True) for values in BAD + UNDECIDED),
    *((FREE, values, False) for values in DECIDED),
    *((GIVEN, values, True) for values in BAD + UNDECIDED + UNDECIDED_IF_GIVEN),
    (GIVEN, {}, False),
]


@pytest.mark.parametrize(("kind", "values", "left"), CASES)
def test_rows_that_the_loops_cannot_decide_are_left(kind, values, left):
    """A bad row has no path, beside one that is good."""
    frame = pd.DataFrame([GOOD | values, GOOD])
    rows = kind.lengths(*columns(kind, frame))

    assert bounded(kind, frame, "best").left.tolist() == [left, False]
    no_path = values in BAD or values in UNDECIDED_IF_GIVEN[1:3]
    if no_path or not left:
        assert (rows.word == NO_PATH).tolist() == [no_path, False]
        assert np.isnan(rows.length).tolist() == [no_path, False]


@KINDS
def test_outputs_can_be_given_and_shapes_are_checked(kind):
    data = columns(kind, kind.hard(10))
    out = kind.out(10)

    assert kind.lengths(*data, out=out).length is out.length
    assert kind.lengths(*(column[:0] for column in data)).length.shape == (0,)
    with pytest.raises(ValueError, match=r"shape \(9,\); expected \(10,\)"):
        kind.lengths(*data, out=kind.out(9))
    other = "LSR" if kind is FREE else "LS"  # a word of the other kind
    with pytest.raises(ValueError, match=f"no branch '{other}'"):
        kind.lengths(*data, branch=other)


@cache
def random_legs(n):
    """Poses and radii without an edge in mind: a fifth of the targets lie in a turning circle."""
    rng = np.random.default_rng(1)
    poses = {name: rng.uniform(-4, 4, n) for name in ScenarioArrays._fields[:5]}
    return pd.DataFrame(poses).assign(
        radius=rng.uniform(0.2, 5, n), final_heading=rng.uniform(-4, 4, n)
    )


# widths in ulp of the length: the median, 999 of 1000, the widest
WIDTHS = {**dict.fromkeys(("best", "LS", "RS"), (110, 500, 3000))}
WIDTHS |= dict.fromkeys(("LR", "RL"), (150, 5000, 20_000))


@pytest.mark.parametrize(("kind", "branch"), EACH)
def test_random_legs_are_bounded_narrowly(kind, branch):
    """One row in a thousand is left at most; the closed form is within its bounds."""
    frame = random_legs(1_000_000 if kind is FREE else 300_000)
    bounds, rows = bounded(kind, frame, branch), kind.lengths(*columns(kind, frame), branch=branch)
    found = ~bounds.left & np.isfinite(bounds.high)
    low, high, length = bounds.low[found], bounds.high[found], rows.length[found]
    ulps = (high - low) / np.spacing(high)
    median, most, widest = WIDTHS[branch] if kind is FREE else (600, 10_000, math.inf)

    assert bounds.left.mean() < 1e-3
    assert np.median(ulps) < median
    assert np.quantile(ulps, 0.999) < most
    assert ulps.max() < widest
    assert (low <= length).all()
    assert (length <= high).all()
    assert np.isnan(rows.length[~bounds.left & ~found]).all()


def test_the_turn_of_the_loops_is_within_its_proven_error():
    """Of headings at every size up to the largest, in 60 digits, modulo a full turn."""
    rng = np.random.default_rng(10)
    headings = rng.choice([-1, 1], (2, 2_000)) * 10 ** rng.uniform(-3, 9, (2, 2_000))
    found = turns(*headings)
    with mp.workdps(60):
        for a, b, turn in zip(*headings.tolist(), found.tolist(), strict=True):
            parts = (mp.mpf(b) - a - turn) / (2 * mp.pi)
            assert abs(parts - mp.nint(parts)) * 2 * mp.pi < pose_enclosure_kernel._TURN_ERROR
            assert 0 <= turn < 2 * math.pi + 1e-15


@compiled
def turns(a, b):
    """`turn_between` of arrays."""
    found = np.empty(a.size)
    for i in range(a.size):
        found[i] = turn_between(a[i], b[i])
    return found

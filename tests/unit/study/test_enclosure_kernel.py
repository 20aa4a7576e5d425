"""Intervals of frames in compiled loops: they hold every length, are narrow, and leave few rows."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from flint import ctx
from hard_cases import hard_frame

from dubins_study.study.check import enclosure
from dubins_study.study.check.enclosure import Enclosure, enclose
from dubins_study.study.check.enclosure_kernel import Bounds, bound_rows
from dubins_study.study.closed_form.kernel import ScenarioArrays
from dubins_study.study.closed_form.kernel_compile import SMALL
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE
from dubins_study.study.scenario import Scenario, check_frame, scenarios
from dubins_study.study.words import BRANCHES

FIELDS = ScenarioArrays._fields


def bounded(frame: pd.DataFrame, branch: str) -> Bounds:
    return bound_rows(ScenarioArrays(*(frame[name].to_numpy() for name in FIELDS)), branch)


def random_targets(n: int, seed: int) -> pd.DataFrame:
    """Poses, targets and radii without an edge in mind: a fifth of the targets lie in a disc."""
    rng = np.random.default_rng(seed)
    columns = [rng.uniform(-4, 4, n) for _ in range(5)]
    return check_frame(
        pd.DataFrame(dict(zip(FIELDS, [*columns, rng.uniform(0.2, 5, n)], strict=True)))
    )


def placed(X, Y, x, y, heading, radius) -> pd.DataFrame:
    """Scenarios with targets at (X, Y) of the vehicle's frame, up to rounding."""
    c, s = np.cos(heading), np.sin(heading)
    target = x + radius * (X * c - Y * s), y + radius * (X * s + Y * c)
    return check_frame(
        pd.DataFrame(dict(zip(FIELDS, (x, y, heading, *target, radius), strict=True)))
    )


def near_edges(n: int, seed: int) -> pd.DataFrame:
    """Targets within 1e-16 to 0.1 of circles of 1 and 3 radii, of the axis and of the start."""
    rng = np.random.default_rng(seed)
    off = rng.choice([-1, 1], n) * 10 ** rng.uniform(-16, -1, n)
    angle, side = rng.uniform(-math.pi, math.pi, n), rng.choice([-1, 1], n)
    kind = rng.integers(0, 5, n)
    distance = np.choose(kind, [1, 1, 3, 0, 0]) + off
    X, Y = distance * np.sin(angle), side * (1 - distance * np.cos(angle))
    along = rng.choice([-1, 1], n) * 10 ** rng.uniform(-9, 2, n)
    X, Y = np.where(kind == 3, along, X), np.where(kind == 3, off, Y)
    X, Y = np.where(kind == 4, off * np.cos(angle), X), np.where(kind == 4, off * np.sin(angle), Y)
    x, y = rng.uniform(-5, 5, (2, n)) * (rng.random(n) < 0.5)
    return placed(X, Y, x, y, rng.uniform(-7, 7, n), np.ones(n))


def extreme(n: int, seed: int) -> pd.DataFrame:
    """Radii from 1e-130 to 1e130, starts up to 1e12 radii away, headings up to 1e9 and beyond."""
    rng = np.random.default_rng(seed)
    radius = 10 ** rng.uniform(-130, 130, n)
    X, Y = rng.standard_normal((2, n)) * 10 ** rng.uniform(-3, 6, n)
    x, y = rng.standard_normal((2, n)) * radius * 10 ** rng.uniform(-3, 12, n)
    heading = rng.uniform(-1, 1, n) * 10 ** rng.uniform(-20, 11, n)
    return placed(X, Y, x, y, heading, radius)


MAKERS = {"random": random_targets, "edges": near_edges, "extreme": extreme}


def one_target(scenario: Scenario, branch: str, shift: tuple[int, int]) -> Enclosure:
    """The length of one of the scenario's targets by the balls: of a corner or the middle, say."""
    with ctx.workprec(300):
        X, Y = enclosure._square(scenario)
        # a ball's radius is rounded up, by less than this
        X, Y = (v.mid() + v.rad() * k * (1 - 1e-6) for v, k in zip((X, Y), shift, strict=True))
        if branch == "best":
            parts = enclosure._best(X, abs(Y))
        else:
            word = enclosure._left_straight if branch[1] == "S" else enclosure._right_left
            parts, _ = word(X, -Y if branch in ("RS", "LR") else Y)
        return enclosure._outwards(parts, False, scenario.radius)


@pytest.mark.parametrize("n", [1_000, pytest.param(70_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("maker", MAKERS)
@pytest.mark.parametrize("branch", BRANCHES)
def test_every_interval_holds_the_lengths_of_all_targets(branch, maker, n):
    """The balls of the whole square of targets, and of one of its corners, edges or its middle.

    There is no path only where there is none to that target. A million rows in all in the slow run.
    """
    frame = MAKERS[maker](n, seed=n + len(branch))
    bounds = bounded(frame, branch)
    decided = ~bounds.left
    shifts = np.random.default_rng(n).integers(-1, 2, (decided.sum(), 2)).tolist()

    # of the extreme ones a tenth lie so far from the origin that delta is above 1e-7
    assert decided.mean() > {"random": 0.999, "edges": 0.6, "extreme": 0.8}[maker]
    for low, high, scenario, shift in zip(
        bounds.low[decided], bounds.high[decided], scenarios(frame[decided]), shifts, strict=True
    ):
        one, whole = one_target(scenario, branch, shift), enclose.__wrapped__(scenario, branch)
        assert low <= min(one.low, whole.low), (scenario, shift)
        assert max(one.high, whole.high) <= high, (scenario, shift)
        assert len(one.parts) <= 1
        assert math.isinf(low) == math.isinf(one.low), (scenario, shift)
        assert not whole.absent or math.isinf(low), scenario


@pytest.mark.parametrize("branch", BRANCHES)
def test_random_targets_are_bounded_narrowly(branch):
    """Of a million rows one in a thousand is left at most; widths in ulp of the length."""
    bounds = bounded(random_targets(1_000_000, seed=1), branch)
    found = ~bounds.left & np.isfinite(bounds.high)
    ulps = (bounds.high[found] - bounds.low[found]) / np.spacing(bounds.high[found])

    assert bounds.left.mean() < 1e-3
    assert np.median(ulps) < (150 if branch in ("LR", "RL") else 110)
    assert np.quantile(ulps, 0.999) < (5000 if branch in ("LR", "RL") else 500)
    assert ulps.max() < (20_000 if branch in ("LR", "RL") else 3000)


@pytest.mark.parametrize("branch", BRANCHES)
def test_nothing_wide_is_kept(branch):
    """Next to (0, 2) inside the disc, and at the edge of reach, lengths go like a square root."""
    frame = near_edges(50_000, seed=4)
    bounds = bounded(frame, branch)
    found = ~bounds.left & np.isfinite(bounds.high)
    extent = abs(frame[["x", "y", "target_x", "target_y"]]).sum(axis=1)
    delta = (2 * extent + 12 * extent) * math.ulp(1.0)  # at most
    allowed = 6e-13 * bounds.low + 75 * delta

    assert (bounds.high[found] <= (bounds.low + allowed)[found]).all()
    assert found.mean() > 0.1


@pytest.mark.parametrize(
    "values",
    [
        {"x": math.nan},
        {"target_y": math.inf},
        {"heading": math.nan},
        {"heading": 2 * LARGEST_ANGLE},
        {"radius": math.nan},
        {"radius": 0.0},
        {"radius": math.inf},
        {"target_x": 0.0, "target_y": 0.0},  # the start
        {"target_x": 5e-324, "target_y": 4.0},  # decided for `best`, whose axis is no edge
        {"target_x": 1.0, "target_y": 1.0},  # on the circle
        {"target_x": math.sin(0.3), "target_y": 1 - math.cos(0.3)},
        {"target_x": 1e300, "radius": 1e-300},
    ],
)
def test_rows_that_the_loops_cannot_decide_are_left(values):
    row = {**dict(zip(FIELDS, (0.0, 0.0, 0.0, 3.0, 1.0, 1.0), strict=True)), **values}
    frame = pd.DataFrame([row])
    left = {branch: bool(bounded(frame, branch).left[0]) for branch in BRANCHES}

    assert left["best"] == (values != {"target_x": 5e-324, "target_y": 4.0})


@pytest.mark.parametrize(
    ("branch", "target"),
    [
        ("LS", (2.0, 0.0)),
        ("RS", (2.0, 0.0)),
        ("RL", (0.0, 2.0)),
        ("LR", (0.0, -2.0)),
        ("RL", (1.0, -1.0)),
    ],
)
def test_edges_of_words_are_left(branch, target):
    """The axis ahead; three radii and one from the other circle's centre."""
    frame = pd.DataFrame([dict(zip(FIELDS, (0.0, 0.0, 0.0, *target, 1.0), strict=True))])

    assert bounded(frame, branch).left[0]


def test_a_few_ulp_from_the_circle_is_decided():
    """As soon as the square of targets within delta is clear of it."""
    delta = 12 * math.ulp(1.0) * 2 + 2 * math.ulp(1.0) * 2
    for side in (-1, 1):
        targets = 1 - side * np.array([0.5, 4]) * delta
        frame = pd.DataFrame({name: np.zeros(2) for name in FIELDS})
        frame = frame.assign(target_x=targets, target_y=1.0, radius=1.0)
        bounds = bounded(frame, "best")
        assert bounds.left.tolist() == [True, False]
        # inside, nearly a turn more: 3/4 of it by RL beyond the quarter turn of the circle itself
        jump = bounds.low[1] - math.pi / 2
        assert jump > 3 if side == 1 else abs(jump) < 1e-13


def test_threads_do_not_change_a_bit():
    frame = hard_frame(700)
    many = pd.concat([frame] * (SMALL // 700 + 2), ignore_index=True)
    for branch in BRANCHES:
        alone, threaded = bounded(frame, branch), bounded(many, branch)
        for a, b in zip(alone, threaded, strict=True):
            np.testing.assert_array_equal(a, b[700:1400])


def test_mirror_images_have_equal_bounds():
    frame = random_targets(5_000, seed=8).assign(x=0.0, y=0.0)
    mirrored = frame.assign(heading=-frame["heading"], target_y=-frame["target_y"])
    for branch, other in (("best", "best"), ("LS", "RS"), ("LR", "RL")):
        for a, b in zip(bounded(frame, branch), bounded(mirrored, other), strict=True):
            np.testing.assert_array_equal(a, b)

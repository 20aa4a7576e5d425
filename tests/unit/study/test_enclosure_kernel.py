"""Intervals of frames in compiled loops: they hold every length, are narrow, and leave few rows."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from cases import scenario_frame
from hard_cases import hard_frame

from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.enclosure_kernel import Bounds, bound_rows
from dubins_study.study.closed_form.kernel import ScenarioArrays
from dubins_study.study.closed_form.kernel_compile import SMALL
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE
from dubins_study.study.scenario import check_frame, scenarios
from dubins_study.study.words import BRANCHES
from tests.adversary.generators import case

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


def hard_cases(n: int) -> pd.DataFrame:
    """Cases of the campaign: at every edge, beside them from 1e-16 on, and at every scale."""
    return scenario_frame(case(5, number)[1] for number in range(n))


@pytest.mark.parametrize("n", [1_000, pytest.param(30_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("branch", BRANCHES)
def test_every_interval_holds_that_of_the_balls(branch, n):
    """There is no path only where there is none, and where there may be none the row is left.

    Beyond 10 000 R from the origin, next to an edge, the balls themselves may be wider: in 4 rows
    of 30 000, by up to 7.5 % of their width. The campaign tests that intervals hold the truth.
    """
    frame = hard_cases(n)
    bounds = bounded(frame, branch)
    decided = ~bounds.left

    assert decided.mean() > 0.4
    for low, high, scenario in zip(
        bounds.low[decided], bounds.high[decided], scenarios(frame[decided]), strict=True
    ):
        whole = enclose(scenario, branch)
        far = math.isfinite(low) and scenario.extent > 1e4 * scenario.radius
        slack = 0.1 * (whole.high - whole.low) if far else 0.0
        assert low - slack <= whole.low, scenario
        assert whole.high <= high + slack, scenario
        assert math.isinf(low) == math.isinf(whole.low), scenario
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
    frame = hard_cases(3_000)
    bounds = bounded(frame, branch)
    found = ~bounds.left & np.isfinite(bounds.high)
    extent = abs(frame[["x", "y", "target_x", "target_y"]]).sum(axis=1) / frame["radius"]
    delta = (2 * extent + 12 * extent) * math.ulp(1.0) * frame["radius"]  # at most
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


def test_edges_of_words_are_left():
    """The axis ahead; three radii and one from the other circle's centre."""
    edges = {"LS": (2, 0), "RS": (2, 0), "RL": (0, 2), "LR": (0, -2)}
    for branch, target in [*edges.items(), ("RL", (1, -1))]:
        frame = pd.DataFrame([dict(zip(FIELDS, (0.0, 0.0, 0.0, *target, 1.0), strict=True))])
        assert bounded(frame, branch).left[0], branch


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

"""Proven intervals: across a circle in balls, and in the compiled loops of frames.

The adversary (`tests/adversary`) tests that both hold the truth and are narrow.
"""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hard_cases import hard_frame

from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.enclosure_kernel import Bounds, bound_rows
from dubins_study.study.check.verdict import judge
from dubins_study.study.closed_form.kernel import ScenarioArrays
from dubins_study.study.closed_form.kernel_compile import SMALL
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import check_frame
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


def test_threads_do_not_change_a_bit():
    frame = hard_frame(700)
    many = pd.concat([frame] * (SMALL // 700 + 2), ignore_index=True)
    for branch in BRANCHES:
        alone, threaded = bounded(frame, branch), bounded(many, branch)
        for a, b in zip(alone, threaded, strict=True):
            np.testing.assert_array_equal(a, b[700:1400])


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

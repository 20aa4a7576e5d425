"""Intervals of shares against published values, scipy and the equation that defines them."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from dubins_study.report.statistics.intervals import (
    scenario_share,
    scenario_shares,
    wilson_interval,
    wilson_intervals,
)


@pytest.mark.parametrize(
    ("successes", "trials", "expected"),
    [
        (81, 263, (0.2553, 0.3662)),
        (15, 148, (0.0624, 0.1605)),
        (0, 20, (0.0000, 0.1611)),
        (1, 29, (0.0061, 0.1718)),
    ],
)
def test_the_examples_of_newcombe(successes, trials, expected):
    """Newcombe 1998, "Two-sided confidence intervals for the single proportion", Stat. Med. 17,
    table I, method 3; printed to four decimals."""
    assert wilson_interval(successes, trials) == pytest.approx(expected, abs=5e-5)


@given(st.integers(1, 10**6), st.floats(0, 1), st.floats(0.5, 0.999))
def test_whole_numbers_as_in_scipy(trials, fraction, level):
    """scipy solves the same quadratic; its own rounding is some units in the last place."""
    successes = round(fraction * trials)
    expected = binomtest(successes, trials).proportion_ci(level, method="wilson")

    assert wilson_interval(successes, trials, level) == pytest.approx(tuple(expected), abs=1e-12)


@given(st.integers(1, 1000), st.floats(0.01, 0.99))
def test_the_ends_are_z_standard_errors_from_the_share(trials, share):
    """The definition: |share - p| = z sqrt(p (1 - p) / n) at both ends p; fractional successes."""
    low, high = wilson_interval(share * trials, trials)

    for end in (low, high):
        error = math.sqrt(end * (1 - end) / trials)
        assert abs(share - end) == pytest.approx(1.959963984540054 * error, rel=1e-6)


def test_all_none_and_nothing():
    """The ends are 0 and 1 without rounding; of no trials nothing is known."""
    ends = wilson_intervals([0, 7, 0], [7, 7, 0])

    assert ends[0, 0] == 0.0
    assert ends[1, 1] == 1.0
    assert ends[0, 1] == pytest.approx(1 - ends[1, 0])
    assert ends[2].tolist() == [0.0, 1.0]
    assert wilson_intervals([], []).shape == (0, 2)
    assert wilson_intervals([[1], [2]], [4, 5, 6]).shape == (2, 3, 2)


@given(st.integers(1, 10**6), st.floats(0.01, 0.999))
def test_the_outer_ends_are_free_of_rounding(trials, level):
    """None of n: exactly 0; n of n: exactly 1."""
    assert wilson_interval(0, trials, level)[0] == 0.0
    assert wilson_interval(trials, trials, level)[1] == 1.0


@pytest.mark.parametrize(
    ("successes", "trials", "level", "message"),
    [
        (5, 4, 0.95, "5 successes of 4 trials"),
        (-1, 4, 0.95, "-1 successes"),
        (math.nan, 4, 0.95, "nan successes"),
        (1, math.inf, 0.95, "inf trials"),
        (1, 4, 95, "level 95"),
        (1, 4, math.nan, "level nan"),
    ],
)
def test_what_is_no_share_is_refused(successes, trials, level, message):
    """One message that names the value and the rule."""
    with pytest.raises(ValueError, match=message):
        wilson_interval(successes, trials, level)


def test_repeats_of_one_scenario_are_one_trial():
    """Scenario a: 3 of 3, b: 1 of 2, c: 0 of 1: rates 1, 1/2, 0 of three scenarios, not 4 of 6."""
    success = pd.Series([True, True, True, True, False, False])
    share = scenario_share(success, pd.Series(list("aaabbc")))

    assert share[:3] == (1.5, 3, 0.5)
    assert share[3:] == wilson_interval(1.5, 3)


def test_every_group_has_the_share_of_its_attempts():
    """Each line is `scenario_share` of the rows of one solver in one region; c never succeeds."""
    rng = np.random.default_rng(2)
    rows = pd.DataFrame(
        {
            "solver": rng.choice(["a", "b", "c"], 200),
            "region": rng.choice(["outside", "left disc"], 200),
            "experiment": rng.choice(["x", "y"], 200),
            "scenario_id": rng.choice(["1", "2", "3"], 200),
        }
    )
    rows["ok"] = (rows["solver"] != "c") & (rng.random(200) < 0.8)
    table = scenario_shares(
        rows, by=["solver", "region"], success="ok", scenario=["experiment", "scenario_id"]
    )

    assert len(table) == 6
    for key, part in rows.groupby(["solver", "region"]):
        expected = scenario_share(part["ok"], part["experiment"] + part["scenario_id"])
        assert table.loc[key].tolist() == pytest.approx(list(expected))
    assert (table.loc["c", "low"] == 0).all()
    empty = scenario_shares(rows.iloc[:0], by=["solver"], success="ok", scenario=["scenario_id"])
    assert empty.empty


def test_a_missing_key_takes_no_attempt_away():
    """A crash may leave no region behind; it stays a group and a trial."""
    rows = pd.DataFrame({"region": [None, "outside"], "scenario_id": ["1", None], "ok": False})
    table = scenario_shares(rows, by=["region"], success="ok", scenario=["scenario_id"])

    assert table["trials"].tolist() == [1, 1]
    assert scenario_share(rows["ok"], rows["scenario_id"]).trials == 2


def test_the_interval_of_scenarios_covers_as_often_as_it_claims():
    """Simulated: repeats that always agree, with the share 0.9 of 100 scenarios.

    Counting 300 attempts as trials would cover 0.9 in about three cases of four, counting scenarios
    covers it in 95 of 100; 0.03 is three standard errors of 0.95 in 500 simulations.
    """
    rng = np.random.default_rng(1)
    scenario, covered = pd.Series(np.repeat(np.arange(100), 3)), 0
    for _ in range(500):
        share = scenario_share(pd.Series(np.repeat(rng.random(100) < 0.9, 3)), scenario)
        covered += share.low <= 0.9 <= share.high

    assert covered / 500 == pytest.approx(0.95, abs=0.03)


def test_a_share_of_nothing():
    """No attempts: no share, and any share is possible."""
    share = scenario_share(pd.Series([], dtype=bool), pd.Series([], dtype=object))

    assert (share.successes, share.trials, share.low, share.high) == (0.0, 0, 0.0, 1.0)
    assert math.isnan(share.share)

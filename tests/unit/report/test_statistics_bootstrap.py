"""Bootstrap intervals against published values, exact distributions, scipy and brute force."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from dubins_study.report.statistics import bootstrap
from dubins_study.report.statistics.means import shifted_geometric_mean

INF, NAN = float("inf"), float("nan")
# Survival of the treated mice, days: Efron and Tibshirani 1993, An Introduction to the Bootstrap,
# table 2.1.
MICE = (94, 197, 16, 38, 99, 141, 23)
INTERVALS = {
    "median": bootstrap.median_intervals,
    "mean": lambda table, **given: bootstrap.mean_intervals(table, 1.0, **given),
    "average": bootstrap.average_intervals,
    "median ratio": lambda table, **given: bootstrap.median_ratio_intervals(table, "a", **given),
    "mean ratio": lambda table, **given: bootstrap.mean_ratio_intervals(table, "a", 1.0, **given),
}


def resampled(table, scenarios, seed, resamples):
    """Each resample written out, row by row, from the counts of scenarios."""
    labels = list(dict.fromkeys(scenarios))
    for counts in bootstrap.scenario_counts(len(labels), resamples, seed):
        times = dict(zip(labels, counts.astype(int), strict=True))
        yield np.repeat(table, [times[scenario] for scenario in scenarios], axis=0)


def test_the_median_of_the_mice_has_its_exact_distribution():
    """Each of the seven survivals is the median of a resample with a known probability.

    The median is above the k-th value if at most three of seven draws are among the first k: a
    binomial probability (Efron 1982, The Jackknife, the Bootstrap and Other Resampling Plans, sec.
    10.3). The standard error of that distribution is printed as 37.83 in Efron and Tibshirani 1993,
    table 2.2; the ends of the interval are its quantiles. 20000 resamples leave a share uncertain
    by 0.0035 (one standard error at 1/2), and no quantile lies within 0.01 of a step.
    """
    ordered = np.sort(MICE)
    above = [stats.binom.cdf(3, 7, k / 7) for k in range(8)]
    probability = -np.diff(above)
    centre = probability @ ordered
    assert math.sqrt(probability @ (ordered - centre) ** 2) == pytest.approx(37.83, abs=0.005)

    table = pd.DataFrame({"treated": MICE})
    for level in (0.95, 0.7, 0.5):
        quantiles = [(1 - level) / 2, (1 + level) / 2]
        below = np.cumsum(probability)
        assert np.abs(below[:, np.newaxis] - quantiles).min() > 0.01
        expected = ordered[np.searchsorted(below, quantiles)]
        line = bootstrap.median_intervals(table, level=level, resamples=20_000).loc["treated"]
        assert line.tolist() == [94, *expected]


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, 4),
            *[st.one_of(st.floats(0.1, 100), st.just(INF), st.just(NAN))] * 2,
        ),
        min_size=1,
        max_size=12,
    ),
    st.integers(0, 1000),
)
def test_medians_and_means_as_of_every_resample_written_out(rows, seed):
    """numpy's median of each written-out resample, repeats of a scenario (first entry) together."""
    scenarios, values = [row[0] for row in rows], np.array([row[1:] for row in rows])
    table = pd.DataFrame(values, scenarios, ["a", "b"])
    medians = bootstrap.median_intervals(table, level=0.5, resamples=8, seed=seed)
    means = bootstrap.mean_intervals(table, 2.0, level=0.5, resamples=8, seed=seed)

    for place, solver in enumerate(table.columns):
        for line, statistic in (
            (medians.loc[solver], np.median),
            (means.loc[solver], lambda known: shifted_geometric_mean(known, 2.0)),
        ):
            samples = [
                values[:, place],
                *(s[:, place] for s in resampled(values, scenarios, seed, 8)),
            ]
            known = [sample[~np.isnan(sample)] for sample in samples]
            with np.errstate(invalid="ignore"):  # numpy's mean of two infinite values
                each = [statistic(sample) if sample.size else NAN for sample in known]
                each = [
                    INF if np.isinf(s).sum() * 2 >= s.size > 0 and np.isnan(e) else e
                    for e, s in zip(each, known, strict=True)
                ]
            low, high = ends(each[1:], 0.5)
            assert line.tolist() == pytest.approx([each[0], low, high], rel=1e-9, nan_ok=True)


def ends(statistics, level):
    """The outermost of the sorted statistics that the two quantiles lie between."""
    known = sorted(value for value in statistics if not math.isnan(value))
    if not known:
        return NAN, NAN
    last = len(known) - 1
    return (
        known[math.floor((1 - level) / 2 * last)],
        known[math.ceil((1 + level) / 2 * last)],
    )


@pytest.mark.parametrize("name", ["median", "average"])
def test_intervals_as_those_of_scipy(name):
    """scipy's percentile bootstrap of 60 lognormal costs, with its own resamples.

    Both ends are quantiles of 9999 resamples: their standard error is about a tenth of the
    statistic's own, sqrt(0.025 * 0.975 / 9999) / density(1.96) = 0.027 standard errors; six times
    that of two independent ends leaves 0.25.
    """
    values = np.random.default_rng(3).lognormal(size=60)
    statistic = {"median": np.median, "average": np.mean}[name]
    other = stats.bootstrap(
        (values,), statistic, method="percentile", n_resamples=9999, rng=np.random.default_rng(4)
    )
    line = INTERVALS[name](pd.DataFrame({"a": values}), resamples=9999).loc["a"]

    tolerance = 0.25 * other.standard_error
    assert line["low"] == pytest.approx(other.confidence_interval.low, abs=tolerance)
    assert line["high"] == pytest.approx(other.confidence_interval.high, abs=tolerance)
    assert line["estimate"] == pytest.approx(statistic(values))


def test_the_interval_of_a_mean_covers_as_often_as_it_claims():
    """400 samples of 50 normal values: the mean 0 is inside in 95 of 100, which is uncertain by
    0.011; quantiles of the normal instead of the t distribution take about 0.01 away."""
    values = np.random.default_rng(5).normal(size=(50, 400))
    frame = bootstrap.average_intervals(pd.DataFrame(values))

    inside = ((frame["low"] <= 0) & (frame["high"] >= 0)).mean()
    assert inside == pytest.approx(0.94, abs=0.03)


def width(frame):
    """The length of the one interval of a frame."""
    return (frame["high"] - frame["low"]).item()


def test_repeats_of_one_scenario_stay_together():
    """Ten scenarios whose three repeats agree are no thirty: the intervals of one repeat remain,
    and repeats as scenarios of their own give shorter ones."""
    values = np.random.default_rng(6).lognormal(size=(10, 1))
    once = pd.DataFrame(values, columns=["a"])
    thrice = pd.DataFrame(np.repeat(values, 3, axis=0), np.repeat(np.arange(10), 3), ["a"])

    for name in ("median", "mean", "average"):
        single, together = INTERVALS[name](once), INTERVALS[name](thrice)
        apart = INTERVALS[name](thrice.reset_index(drop=True))
        assert together.to_numpy() == pytest.approx(single.to_numpy())
        assert width(apart) < 0.8 * width(together)


def test_ratios_pair_the_resamples():
    """A column that is always twice another has the ratio 2 in every resample, and each column
    has the ratio 1 to itself; independent resamples would give an interval around them."""
    values = np.random.default_rng(7).lognormal(size=30)
    table = pd.DataFrame({"a": values, "twice": 2 * values})

    for frame in (
        bootstrap.median_ratio_intervals(table, "a"),
        bootstrap.mean_ratio_intervals(table, "a", 0.0),
    ):
        assert frame.loc["twice"].tolist() == pytest.approx([2.0] * 3)
        assert frame.loc["a"].tolist() == pytest.approx([1.0] * 3)


def test_a_ratio_is_of_the_rows_that_both_have():
    """b was not asked the third question, so that a's cost of it does not count either."""
    table = pd.DataFrame({"a": [1.0, 1.0, 100.0], "b": [3.0, 3.0, NAN]})

    for frame in (
        bootstrap.median_ratio_intervals(table, "a"),
        bootstrap.mean_ratio_intervals(table, "a", 1.0),
    ):
        assert frame.loc["b", "estimate"] == pytest.approx(3.0)


def test_failures_in_ratios():
    """All of b fails: infinite against a, a is 0 of b, and b against itself is not determined."""
    table = pd.DataFrame({"a": [1.0, 2.0, 3.0], "b": [INF] * 3})

    assert bootstrap.median_ratio_intervals(table, "a").loc["b"].tolist() == [INF] * 3
    against = bootstrap.median_ratio_intervals(table, "b")
    assert against.loc["a"].tolist() == [0.0] * 3
    assert math.isnan(against.loc["b", "estimate"])
    assert against.loc["b", ["low", "high"]].tolist() == [0.0, INF]


def test_a_share_of_failures_near_a_half_makes_the_upper_end_infinite():
    """Two of five fail: the median is a number, its upper end is not."""
    line = bootstrap.median_intervals(pd.DataFrame({"a": [1.0, 2.0, 3.0, INF, INF]})).loc["a"]

    assert line.tolist() == [3.0, 1.0, INF]


def test_differences_of_successes():
    """Of ten questions a wins three and loses one: the difference of the shares is 0.2."""
    table = pd.DataFrame({"a - b": [1.0] * 3 + [-1.0] + [0.0] * 6})
    line = bootstrap.average_intervals(table).loc["a - b"]

    assert line["estimate"] == pytest.approx(0.2)
    assert -1 <= line["low"] < 0.2 < line["high"] <= 1


@pytest.mark.parametrize("name", list(INTERVALS))
def test_one_seed_one_result(name):
    """Another seed gives other ends, and the same estimate."""
    table = pd.DataFrame(np.random.default_rng(8).lognormal(size=(500, 2)), columns=["a", "b"])
    first, again, other = (INTERVALS[name](table, seed=seed).loc["b"] for seed in (1, 1, 2))

    assert first.equals(again)
    assert first["estimate"] == other["estimate"]
    assert first["low"] != other["low"]


@pytest.mark.parametrize("name", list(INTERVALS))
def test_edges(name):
    """No rows: NaN. One scenario: no spread. A column without values: NaN."""
    nothing = INTERVALS[name](pd.DataFrame({"a": [], "b": []}))
    single = INTERVALS[name](pd.DataFrame({"a": [2.0], "b": [4.0]}))
    missing = INTERVALS[name](pd.DataFrame({"a": [2.0, 3.0], "b": [NAN, NAN]}))

    assert nothing.isna().all(axis=None)
    assert single.loc["b", "low"] == single.loc["b", "high"] == single.loc["b", "estimate"]
    assert missing.loc["b"].isna().all()
    assert missing.loc["a"].notna().all()


def test_what_cannot_be_resampled_is_refused():
    """Each message names the value."""
    table = pd.DataFrame({"a": [1.0]})
    with pytest.raises(ValueError, match="0 resamples"):
        bootstrap.median_intervals(table, resamples=0)
    with pytest.raises(ValueError, match="level 95"):
        bootstrap.median_intervals(table, level=95)
    with pytest.raises(ValueError, match="no solver named 'z' to divide by; choose one of: a"):
        bootstrap.median_ratio_intervals(table, "z")
    with pytest.raises(ValueError, match="shift of -1"):
        bootstrap.mean_intervals(table, -1.0)


@given(st.integers(1, 50), st.integers(1, 20), st.integers(0, 10**6))
def test_a_resample_has_the_size_of_the_sample(scenarios, resamples, seed):
    """Whole numbers that add up."""
    counts = bootstrap.scenario_counts(scenarios, resamples, seed)

    assert counts.shape == (resamples, scenarios)
    assert (counts == np.floor(counts)).all()
    assert counts.min() >= 0
    assert counts.sum(axis=1).tolist() == [scenarios] * resamples


@pytest.mark.slow
def test_very_many_scenarios_draw_fewer_resamples():
    """Their counts would take gigabytes; the interval covers the mean and is narrow."""
    many = pd.DataFrame({"a": np.random.default_rng(4).normal(3.0, 1.0, 50_000)})

    (row,) = bootstrap.average_intervals(many).itertuples()

    assert row.low < 3.0 < row.high
    # four standard errors wide: 95 % is 3.92 of them, give or take the resamples' own spread
    assert row.high - row.low == pytest.approx(3.92 / np.sqrt(50_000), rel=0.25)

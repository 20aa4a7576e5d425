"""Intervals and paired tests against other computations.

They are exact distributions, scipy, R and brute force.
"""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from scipy.stats import binomtest

from dubins_study.report.statistics import intervals
from dubins_study.report.statistics.costs import shifted_geometric_means
from dubins_study.report.statistics.intervals import (
    averages,
    bootstrap,
    bootstrap_of_both,
    geometric_means,
    holm,
    medians,
    paired_tests,
    sign_test,
    wilson_intervals,
)

INF, NAN = float("inf"), float("nan")
# Name -> the statistic, and the column to divide by.
STATISTICS = {
    "median": (medians,),
    "mean": (geometric_means(1.0),),
    "average": (averages,),
    "median ratio": (medians, "a"),
    "mean ratio": (geometric_means(1.0), "a"),
}


@given(st.integers(1, 1000), st.floats(0.01, 0.99))
def test_the_ends_are_z_standard_errors_from_the_share(trials, share):
    """The ends are z standard errors away.

    The definition: |share - p| = z sqrt(p (1 - p) / n) at both ends p; fractional successes.
    """
    low, high = wilson_intervals(share * trials, trials)

    for end in (low, high):
        error = math.sqrt(end * (1 - end) / trials)
        assert abs(share - end) == pytest.approx(1.959963984540054 * error, rel=1e-6)


def test_all_none_and_nothing():
    """Intervals of all, none and no trials.

    The ends are 0 and 1 without rounding; of no trials nothing is known.
    """
    ends = wilson_intervals([0, 7, 0], [7, 7, 0])

    assert ends[0, 0] == 0.0
    assert ends[1, 1] == 1.0
    assert ends[0, 1] == pytest.approx(1 - ends[1, 0])
    assert ends[2].tolist() == [0.0, 1.0]
    assert wilson_intervals([], []).shape == (0, 2)
    assert wilson_intervals([[1], [2]], [4, 5, 6]).shape == (2, 3, 2)


def shares(rows, **names):
    """`scenario_shares` of successes at scenarios.

    The arguments `ok` and `scenario_id` come in groups of solvers.
    """
    named = {"by": ["solver"], "success": "ok", "scenario": ["scenario_id"]} | names
    return intervals.scenario_shares(rows, **named)


def test_repeats_of_one_scenario_are_one_trial():
    """Repeats of one scenario are one trial.

    Scenario a: 3 of 3, b: 1 of 2, c: 0 of 1: rates 1, 1/2, 0 of three scenarios, not 4 of 6. A
    missing name is a solver, and a scenario.
    """
    right = [True, True, True, True, False, False]
    rows = pd.DataFrame({"solver": "x", "scenario_id": [*"aaabb", None], "ok": right})

    line = shares(rows).loc["x"].tolist()
    assert line == [1.5, 3, 0.5, *wilson_intervals(1.5, 3)]
    assert shares(rows.assign(solver=None))["trials"].tolist() == [3]
    assert shares(rows.iloc[:0]).empty


def resampled(table, scenarios, resamples):
    """Each resample written out, row by row.

    It follows from the counts of scenarios.
    """
    labels = list(dict.fromkeys(scenarios))
    for counts in intervals.scenario_counts(len(labels), resamples):
        times = dict(zip(labels, counts.astype(int), strict=True))
        yield np.repeat(table, [times[scenario] for scenario in scenarios], axis=0)


def test_a_resample_draws_each_scenario_as_often_as_by_chance():
    """Resamples draw each scenario by chance.

    They draw with replacement: how often one of seven is drawn is binomial; 20000 resamples leave
    a share uncertain by 0.0035 (one standard error at 1/2).
    """
    counts = intervals.scenario_counts(7, 20_000)
    times = [(counts == k).mean(axis=0) for k in range(8)]

    assert (counts.sum(axis=1) == 7).all()
    for k, share in enumerate(times):
        assert share == pytest.approx(np.full(7, stats.binom.pmf(k, 7, 1 / 7)), abs=0.015)


@given(
    st.lists(
        st.tuples(
            st.integers(0, 4),
            st.one_of(st.floats(0.1, 100), st.just(INF), st.just(NAN)),
            st.one_of(st.floats(0.1, 100), st.just(NAN)),
        ),
        min_size=1,
        max_size=12,
    )
)
def test_medians_and_means_as_of_every_resample_written_out(rows):
    """Medians and means are those of written-out resamples.

    The first entry is numpy's median of each, with repeats of a scenario together. The second is
    the mean of the second column, which has no failures.
    """
    scenarios = [row[0] for row in rows]
    values = np.array([row[1:] for row in rows])
    table = pd.DataFrame(values, scenarios, ["a", "b"])
    middle = bootstrap(table, medians, resamples=80).loc["a"]
    mean, average = (
        bootstrap(table[["b"]], statistic, resamples=80).loc["b"]
        for statistic in (geometric_means(2.0), averages)
    )
    samples = [values, *resampled(values, scenarios, 80)]

    for line, place, statistic in (
        (middle, 0, np.median),
        (mean, 1, lambda known: shifted_geometric_means(pd.DataFrame(known), 2.0)[0]),
        (average, 1, np.mean),
    ):
        known = [sample[~np.isnan(sample[:, place]), place] for sample in samples]
        each = [statistic(sample) if sample.size else NAN for sample in known]
        assert line.tolist() == pytest.approx([each[0], *ends(each[1:])], rel=1e-9, nan_ok=True)


def ends(statistics):
    """Outermost statistics between the two quantiles.

    The statistics are sorted; the quantiles lie between these two.
    """
    known = sorted(value for value in statistics if not math.isnan(value))
    if not known:
        return NAN, NAN
    last = len(known) - 1
    return known[math.floor(0.025 * last)], known[math.ceil(0.975 * last)]


def test_ratios_pair_the_resamples():
    """Ratios pair the resamples.

    A column that is always twice another has the ratio 2 in every resample, and each column has
    the ratio 1 to itself; independent resamples would give an interval around them. A row that
    only one of them has does not count.
    """
    values = np.random.default_rng(7).lognormal(size=30)
    table = pd.DataFrame({"a": values, "twice": 2 * values})
    table.loc[0, "twice"] = NAN

    for frame in (
        bootstrap(table, medians, "a"),
        bootstrap(table, geometric_means(0.0), "a"),
    ):
        assert frame.loc["twice"].tolist() == pytest.approx([2.0] * 3)
        assert frame.loc["a"].tolist() == pytest.approx([1.0] * 3)


@pytest.mark.parametrize("name", list(STATISTICS))
def test_edges(name):
    """Edges of intervals.

    No rows: NaN. One scenario: no spread. A column without values: NaN.
    """
    nothing = bootstrap(pd.DataFrame({"a": [], "b": []}), *STATISTICS[name])
    single = bootstrap(pd.DataFrame({"a": [2.0], "b": [4.0]}), *STATISTICS[name])
    missing = bootstrap(pd.DataFrame({"a": [2.0, 3.0], "b": [NAN, NAN]}), *STATISTICS[name])

    assert nothing.isna().all(axis=None)
    assert single.loc["b", "low"] == single.loc["b", "high"] == single.loc["b", "estimate"]
    assert missing.loc["b"].isna().all()
    assert missing.loc["a"].notna().all()


@pytest.mark.slow
def test_very_many_scenarios_draw_fewer_resamples():
    """Very many scenarios draw fewer resamples.

    Their counts would take gigabytes; the interval covers the mean and is narrow.
    """
    many = pd.DataFrame({"a": np.random.default_rng(4).normal(3.0, 1.0, 50_000)})

    (row,) = bootstrap(many, averages).itertuples()

    assert row.low < 3.0 < row.high
    # four standard errors wide: 95 % is 3.92 of them, give or take the resamples' own spread
    assert row.high - row.low == pytest.approx(3.92 / np.sqrt(50_000), rel=0.25)


@pytest.mark.parametrize("of", [1, 7, 67])
def test_the_extreme_of_several_has_a_wider_interval(of):
    """The extreme of several has a wider interval.

    All of them lie in such intervals at once: each misses its own with 5 % / `of`.
    """
    for k, n in ((0, 30), (7, 30), (384, 384)):
        expected = stats.binomtest(k, n).proportion_ci(1 - 0.05 / of, "wilson")
        assert wilson_intervals(k, n, of) == pytest.approx((expected.low, expected.high), abs=1e-12)


def brute_force(table, engines, draws=2000):
    """Percentiles of a mean by single draws.

    Lines and engines of the table are drawn one by one.
    """
    random = np.random.default_rng(5)
    lines = table.index.unique()
    names = sorted(set(engines))
    means = []
    for _ in range(draws):
        rows = np.concatenate(
            [np.flatnonzero(table.index == x) for x in random.choice(lines, lines.size)]
        )
        columns = np.concatenate(
            [np.flatnonzero(np.array(engines) == x) for x in random.choice(names, len(names))]
        )
        means.append(np.nanmean(table.to_numpy()[np.ix_(rows, columns)]))
    return np.quantile(means, [0.025, 0.975])


def test_engines_are_drawn_as_well_as_scenarios():
    """Engines are drawn as well as scenarios.

    Drawing one by one is the comparison; engines that differ make the interval wide.
    """
    random = np.random.default_rng(1)
    engines = ["a", "a", "b", "c", "d", "e"]
    effect = np.array([0.0, 0.1, 5.0, 1.0, 2.0, 8.0])
    values = effect + random.normal(size=(40, 6))
    values[3, 2] = values[7, :3] = np.nan
    table = pd.DataFrame(values, index=np.repeat(np.arange(20), 2))
    ends = bootstrap_of_both(table, engines).loc["all"]
    scenarios_alone = bootstrap(table.mean(axis=1).to_frame("x"), averages).loc["x"]

    assert ends["estimate"] == pytest.approx(np.nanmean(values))
    assert (ends["low"], ends["high"]) == pytest.approx(brute_force(table, engines), abs=0.35)
    assert ends["high"] - ends["low"] > 3 * (scenarios_alone["high"] - scenarios_alone["low"])


def test_of_no_values_there_is_no_mean():
    """NaN, and no warning."""
    table = pd.DataFrame({"x": [np.nan, np.nan]})
    assert bootstrap_of_both(table, ["e"]).isna().all(axis=None)


@given(st.integers(0, 400), st.integers(0, 400))
def test_the_sign_test_as_in_scipy(wins, losses):
    costs = [1.0] * wins + [2.0] * losses
    rivals = [2.0] * wins + [1.0] * losses
    expected = binomtest(wins, wins + losses).pvalue if wins + losses else 1.0

    assert sign_test(costs, rivals).p == pytest.approx(expected)


def test_ties_failures_and_what_was_not_asked():
    """Ties, failures and questions not asked.

    Equal costs and two failures tie; a pair with NaN is none; only ties, or nothing: p = 1.
    """
    outcome = sign_test([1.0, 2.0, INF, INF, NAN, 0.0, 0.0], [1.0, 3.0, INF, 5.0, 1.0, 0.0, 2.0])

    assert outcome[:4] == (6, 2, 1, 3)
    assert 0 < outcome.p <= 1
    assert sign_test([1.0, INF, 0.0], [1.0, INF, 0.0]) == (3, 0, 0, 3, 1.0)
    assert sign_test([], []) == (0, 0, 0, 0, 1.0)
    assert sign_test([INF, INF], [1.0, 2.0]).losses == 2


@pytest.mark.parametrize(
    ("p", "expected"),
    [
        (
            [
                *(0.838541367553, 0.642193923795, 0.680845947633, 0.967833824309, 0.71626938238),
                *(0.177096952723, 5.23656777e-5, 0.0202732688798, 2.8140506198e-4, 0.0149877310796),
            ],
            [*[1.0] * 6, 5.23656777e-4, 0.141912882158, 2.53264555782e-3, 0.11990184863680001],
        ),
        ([0.002, 0.004, 0.006, 0.008, 0.01, 0.012], [0.012, 0.02, 0.024, 0.024, 0.024, 0.024]),
    ],
)
def test_holm_as_in_r(p, expected):
    """Holm's correction is R's.

    R's package multtest, mt.rawp2adjp: the values by which statsmodels tests its `multipletests`
    (statsmodels/stats/tests/test_multi.py, res_multtest1 and 2, column Holm).
    """
    assert holm(p) == pytest.approx(expected, rel=1e-11)


def test_holm_leaves_out_what_was_not_tested():
    """NaN stays and does not count; nothing stays nothing."""
    assert holm([0.01, NAN, 0.04])[[0, 2]].tolist() == [0.02, 0.04]
    assert math.isnan(holm([NAN])[0])
    assert holm([]).shape == (0,)


def test_pairs_are_tested_and_corrected():
    """Pairs are tested and corrected.

    a is always half of b, and c is b but for the last question: p times what Holm says.
    """
    b = np.arange(1.0, 11.0)
    table = pd.DataFrame({"a": b / 2, "b": b, "c": np.append(b[:-1], INF)})
    frame = paired_tests(table, [("a", "b"), ("a", "c"), ("b", "c")])

    assert frame[["solver", "rival"]].to_numpy().tolist() == [["a", "b"], ["a", "c"], ["b", "c"]]
    assert frame[["wins", "losses", "ties"]].to_numpy().tolist() == [
        [10, 0, 0],
        [10, 0, 0],
        [1, 0, 9],
    ]
    assert frame["p"].tolist() == pytest.approx([2 / 2**10] * 2 + [1.0])
    assert frame["p_holm"].tolist() == pytest.approx([6 / 2**10] * 2 + [1.0])


def test_pairs_without_a_common_question_are_no_test():
    table = pd.DataFrame({"a": [1.0, NAN], "b": [NAN, 1.0], "c": [2.0, 2.0]})
    frame = paired_tests(table, [("a", "b"), ("a", "c")])

    assert frame[["p", "p_holm"]].isna().to_numpy().tolist() == [[True, True], [False, False]]
    assert frame["pairs"].tolist() == [0, 1]
    assert paired_tests(table, []).empty

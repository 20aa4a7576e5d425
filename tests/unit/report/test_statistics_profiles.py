"""Profiles against their definitions, counted question by question."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import ecdf as scipy_ecdf

from dubins_study.report.statistics import profiles

INF, NAN = float("inf"), float("nan")
FACTORS = [1.0, 2.0, 4.0, 100.0, INF]
# whole numbers, so that ties and equal ratios occur
cost = st.one_of(st.integers(1, 8).map(float), st.just(INF))
tables = st.lists(st.tuples(cost, cost, cost), min_size=1, max_size=8).map(
    lambda rows: pd.DataFrame(rows, columns=["a", "b", "c"])
)


def test_performance_profile_by_hand():
    """a: ratios 1, 2, inf, inf; b: 1, 1, 1, inf. Nobody answers the last question."""
    table = pd.DataFrame({"a": [3.0, 4.0, INF, INF], "b": [3.0, 2.0, 5.0, INF]})

    ratios = profiles.performance_ratios(table)
    assert ratios["a"].tolist() == [1.0, 2.0, INF, INF]
    assert ratios["b"].tolist() == [1.0, 1.0, 1.0, INF]
    profile = profiles.performance_profile(table, FACTORS)
    assert profile["a"].tolist() == [0.25, 0.5, 0.5, 0.5, 0.5]
    assert profile["b"].tolist() == [0.75] * 5
    assert profile.index.tolist() == FACTORS


@given(tables)
def test_performance_profile_as_dolan_and_more_define_it(table):
    """rho_s(tau) = size{p: t_ps <= tau min_s t_ps} / n_p, counted (Dolan and More 2002, sec. 2)."""
    profile = profiles.performance_profile(table, FACTORS)

    for solver in table:
        for factor in FACTORS:
            within = [
                row[solver] < INF and row[solver] <= factor * min(row)
                for _, row in table.iterrows()
            ]
            assert profile.loc[factor, solver] == pytest.approx(sum(within) / len(table))


@given(tables, st.floats(1e-3, 1e3))
def test_a_profile_has_no_unit_and_rises(table, unit):
    """Costs in another unit give the same curves; the cheapest are all questions that anyone
    answers; powers of two, so that scaling is exact."""
    scale = 2.0 ** math.floor(math.log2(unit))
    profile = profiles.performance_profile(table, FACTORS)

    pd.testing.assert_frame_equal(profiles.performance_profile(scale * table, FACTORS), profile)
    assert (profile.diff().dropna() >= 0).all(axis=None)
    answered = np.isfinite(table.min(axis=1)).mean()
    assert profile.loc[1.0].sum() >= answered - 1e-12


def test_a_third_solver_turns_the_order_of_two():
    """What Gould and Scott 2016 warn of: a beats b within a factor of 2 in the joint profile with
    c, and loses to b in their own profile, which c does not change.

    Alone, b is within twice the cheapest on all questions, a on two of three. c is much cheaper
    than b on the questions where b wins.
    """
    table = pd.DataFrame({"a": [2.0, 2.0, 9.0], "b": [3.0, 3.0, 3.0], "c": [1.0, 1.0, 9.0]})

    joint = profiles.performance_profile(table, [2.0]).loc[2.0]
    pair = profiles.pairwise_profile(table, "a", "b", [2.0]).loc[2.0]
    assert joint["a"] > joint["b"]
    assert pair["a"] < pair["b"]
    shares = profiles.pairwise_shares(table, 2.0)
    assert (shares.loc["a", "b"], shares.loc["b", "a"]) == (pair["a"], pair["b"])


@pytest.mark.slow
@given(tables, st.sampled_from([1.0, 2.0, 3.0]))
def test_pairwise_shares_are_those_of_pairwise_profiles(table, factor):
    """Each entry is one point of one profile; the diagonal is no comparison."""
    shares = profiles.pairwise_shares(table, factor)

    for solver in table:
        for rival in table:
            if solver == rival:
                assert math.isnan(shares.loc[solver, rival])
            else:
                pair = profiles.pairwise_profile(table, solver, rival, [factor])
                assert shares.loc[solver, rival] == pair.loc[factor, solver]


def test_questions_not_put_to_every_solver_are_in_no_joint_profile():
    """They are in the profile of a pair that both met."""
    table = pd.DataFrame({"a": [1.0, 1.0], "b": [2.0, 2.0], "c": [5.0, NAN]})

    assert len(profiles.performance_ratios(table)) == 1
    assert profiles.pairwise_shares(table, 2.0).loc["b", "a"] == 1.0
    assert profiles.pairwise_shares(table[["b"]].assign(c=NAN)).isna().all(axis=None)


def test_a_cost_of_nothing():
    """0 by 0 is a tie; beside a cost of 0 any other is infinite."""
    table = pd.DataFrame({"a": [0.0, 0.0], "b": [0.0, 3.0]})

    assert profiles.performance_ratios(table).to_numpy().tolist() == [[1.0, 1.0], [1.0, INF]]
    assert profiles.pairwise_shares(table).loc["b", "a"] == 0.5


def test_edges_of_performance_profiles():
    """One solver is always the cheapest; all failures are no success; no questions, no share."""
    alone = profiles.performance_profile(pd.DataFrame({"a": [1.0, INF]}), FACTORS)
    none = profiles.performance_profile(pd.DataFrame({"a": [INF], "b": [INF]}), FACTORS)
    empty = profiles.performance_profile(pd.DataFrame({"a": [], "b": []}), FACTORS)

    assert alone["a"].tolist() == [0.5] * 5
    assert (none == 0).all(axis=None)
    assert empty.isna().all(axis=None)
    assert empty.shape == (5, 2)
    with pytest.raises(ValueError, match=r"factor of 0\.5"):
        profiles.pairwise_shares(pd.DataFrame({"a": [1.0]}), 0.5)


@given(st.lists(st.integers(0, 9).map(float), min_size=1, max_size=30))
def test_ecdf_and_its_steps_as_in_scipy(values):
    """scipy's empirical distribution function of the same sample."""
    expected = scipy_ecdf(values).cdf

    places, shares = profiles.steps(values)
    assert places.tolist() == expected.quantiles.tolist()
    assert shares == pytest.approx(expected.probabilities)
    at = np.arange(-1, 11) / 1.0
    assert profiles.ecdf(values, at) == pytest.approx(expected.evaluate(at))


def test_ecdf_of_what_is_not_finite():
    """Infinity counts, NaN does not; of nothing there is no share and no step."""
    assert profiles.ecdf([1.0, INF, NAN, 3.0], [0.0, 1.0, 5.0]).tolist() == [0.0, 1 / 3, 2 / 3]
    assert profiles.steps([2.0, INF])[1].tolist() == [0.5]
    assert np.isnan(profiles.ecdf([NAN], [1.0])).all()
    assert [ends.size for ends in profiles.steps([])] == [0, 0]


@given(tables, st.lists(st.integers(0, 5), min_size=8, max_size=8))
def test_data_profile_as_more_and_wild_define_it(table, unknowns):
    """d_s(kappa) = size{p: t_ps / (n_p + 1) <= kappa} / n_p, counted (More and Wild 2009)."""
    sizes = pd.Series(unknowns[: len(table)])
    budgets = [0.5, 1.0, 2.5, INF]
    profile = profiles.data_profile(table, sizes, budgets)

    for solver in table:
        for budget in budgets:
            within = [
                t < INF and t / (n + 1) <= budget for t, n in zip(table[solver], sizes, strict=True)
            ]
            assert profile.loc[budget, solver] == pytest.approx(sum(within) / len(table))


def test_unknowns_of_each_formulation():
    """One number, one per question and one per cell; 0 counts plain evaluations."""
    table = pd.DataFrame({"a": [6.0, 12.0], "b": [6.0, INF]})

    assert profiles.data_profile(table, 2, [2.0, 4.0])["a"].tolist() == [0.5, 1.0]
    assert profiles.data_profile(table, pd.Series([5, 11]), [1.0])["a"].tolist() == [1.0]
    each = pd.DataFrame({"a": [5, 5], "b": [2, 2]})
    assert profiles.data_profile(table, each, [1.0, 2.0])["b"].tolist() == [0.0, 0.5]
    assert profiles.data_profile(table, 0, [6.0, 11.0])["a"].tolist() == [0.5, 0.5]
    for missing in (-1, pd.Series([2]), each[["a"]]):
        with pytest.raises(ValueError, match="unknowns"):
            profiles.data_profile(table, missing, [1.0])


@given(
    st.lists(st.tuples(st.sampled_from([0.0, 1e-3, 0.1, 1.0, INF, NAN]), cost), max_size=8),
    st.lists(st.sampled_from([1e-9, 1e-3, 0.05, 0.1, 1.0]), min_size=1, max_size=4),
)
def test_target_ecdf_counts_pairs(runs, targets):
    """Every pair of a run and a target, counted (Hansen et al. 2021)."""
    gaps = pd.DataFrame({"a": [gap for gap, _ in runs]}, dtype=float)
    costs = pd.DataFrame({"a": [cost for _, cost in runs]}, dtype=float)
    at = [0.5, 3.0, 8.0, INF]
    curve = profiles.target_ecdf(gaps, costs, at, targets)["a"]

    for point in at:
        pairs = [
            gap <= target and cost <= point and cost < INF
            for gap, cost in runs
            for target in targets
        ]
        expected = sum(pairs) / len(pairs) if pairs else NAN
        assert curve[point] == pytest.approx(expected, nan_ok=True)


def test_target_ecdf_by_hand():
    """Gaps 0.05 at cost 1 and 0 at cost 10 (none arrived for b), targets 0.1 and 0.01: half of the
    pairs of the first run, all of the second."""
    gaps = pd.DataFrame({"a": [0.05, 0.0], "b": [NAN, NAN]})
    costs = pd.DataFrame({"a": [1.0, 10.0], "b": [1.0, 10.0]})
    curves = profiles.target_ecdf(gaps, costs, [0.9, 1.0, 10.0], [0.1, 0.01])

    assert curves["a"].tolist() == [0.0, 0.25, 0.75]
    assert curves["b"].tolist() == [0.0] * 3
    costs.loc[1, "b"] = NAN  # not asked: the question counts for neither
    assert profiles.target_ecdf(gaps, costs, [10.0], [0.1, 0.01])["a"].tolist() == [0.5]


def test_target_ecdf_refuses_what_does_not_fit():
    """No targets, a NaN among them, or tables of different questions."""
    table = pd.DataFrame({"a": [1.0]})
    for targets in ([], [NAN]):
        with pytest.raises(ValueError, match="gap targets"):
            profiles.target_ecdf(table, table, [1.0], targets)
    with pytest.raises(ValueError, match="same questions and solvers"):
        profiles.target_ecdf(table, table.rename(columns={"a": "b"}), [1.0])


def test_gap_targets_are_five_a_decade():
    """From 1 to 1e-8."""
    steps = np.diff(np.log10(profiles.GAP_TARGETS))

    assert steps == pytest.approx(np.full(40, -0.2))
    assert (profiles.GAP_TARGETS[0], profiles.GAP_TARGETS[-1]) == (1.0, pytest.approx(1e-8))

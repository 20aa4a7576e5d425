"""Means, ranks and profiles.

They are compared with scipy, their definitions, and tables worked by hand.
"""

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import gmean

from dubins_study.report.statistics import costs
from dubins_study.report.statistics.costs import cost_table, shared_questions

INF, NAN = float("inf"), float("nan")
paid = st.lists(st.floats(1e-6, 1e6), min_size=1, max_size=30)
# whole numbers, so that ties and equal ratios occur
cost = st.one_of(st.integers(1, 8).map(float), st.just(INF))
tables = st.lists(st.tuples(cost, cost, cost), min_size=1, max_size=8).map(
    lambda rows: pd.DataFrame(rows, columns=["a", "b", "c"])
)


def mean_of(values, shift):
    return costs.shifted_geometric_means(pd.DataFrame({"a": values}, dtype=float), shift)["a"]


@given(paid, st.floats(0, 1e3))
def test_shifted_geometric_mean_as_in_scipy(values, shift):
    """The shifted geometric mean is scipy's.

    That is scipy's geometric mean of the shifted costs; the difference cancels digits of the
    shift.
    """
    expected = gmean(np.array(values) + shift) - shift

    assert mean_of(values, shift) == pytest.approx(expected, rel=1e-9, abs=1e-12 * shift)


def test_special_values_of_the_shifted_geometric_mean():
    """Special values of the shifted geometric mean.

    A failure is infinite, NaN is left out, a cost of 0 has the geometric mean 0.
    """
    assert mean_of([1.0, INF], 1.0) == INF
    assert mean_of([1.0, 7.0, NAN], 1.0) == pytest.approx(3.0)
    assert mean_of([0.0, 5.0], 0.0) == 0.0
    assert math.isnan(mean_of([], 1.0))
    assert math.isnan(mean_of([NAN], 1.0))


def test_the_shift_is_the_lower_quartile():
    assert costs.chosen_shift([4.0, 1.0, 2.0, 3.0, 5.0, INF, NAN]) == 2.0
    assert costs.chosen_shift([INF]) == 0.0


def test_a_rank_that_depends_on_a_choice_is_none():
    """A rank that depends on a choice is none.

    a is fast but fails one of four; b is slow and right; c is worst by any measure.

    With failures at the limit 10 a's geometric mean is near 0.01^(3/4) 10^(1/4), far below b's 2; a
    shift of 10 times 2 nears the arithmetic mean: (0.03 + 10 k) / 4 above 2 for every penalty k.
    """
    table = pd.DataFrame({"a": [0.01] * 3 + [INF], "b": [2.0] * 4, "c": [9.0] * 3 + [INF]})
    ranking = costs.ranking(table, 10.0, 2.0)

    assert ranking["rank"].isna().tolist() == [True, True, False]
    assert ranking.loc["c", "rank"] == 3
    assert ranking[["best", "worst"]].to_numpy().tolist() == [[1, 2], [1, 2], [3, 3]]
    assert costs.ranking(table[["b", "c"]], 10.0, 2.0)["rank"].tolist() == [1, 2]


def test_a_penalty_alone_may_take_a_rank_away():
    """A penalty alone may take a rank away.

    Geometric means are 0.1^(1/2) 10^(1/2) = 1 against 2 at the limit; at ten times it, 3.2.
    """
    table = pd.DataFrame({"a": [0.1, INF], "b": [2.0, 2.0]})
    ranking = costs.ranking(table, 10.0, 0.0)

    assert ranking[["best", "worst"]].to_numpy().tolist() == [[1, 2], [1, 2]]
    assert costs.shifted_geometric_means(costs.penalised(table, 10.0), 0.0).tolist() == (
        pytest.approx([1, 2])
    )
    assert ranking["rank"].isna().all()


def test_equal_means_share_a_rank():
    """Equal means share a rank.

    One solver alone is first; a table without common questions ranks nobody.
    """
    same = pd.DataFrame({"a": [1.0, 2.0], "b": [1.0, 2.0], "c": [3.0, 3.0]})

    assert costs.ranking(same, 10.0, 1.0)["rank"].tolist() == [1, 1, 3]
    assert costs.ranking(same[["b"]], 10.0, 1.0)["rank"].tolist() == [1]
    assert costs.ranking(same[["a", "b"]].mask(same > 0), 10.0, 1.0)["rank"].isna().all()
    assert costs.ranking(same.iloc[:0], 10.0, 1.0)["rank"].isna().all()


def test_cost_table_takes_the_median_over_repeats_and_no_half_right_answer():
    """The cost table takes medians over repeats.

    It takes no half right answer. Question p: a is right thrice, b wrong once; question q was put
    to a alone, uncounted.
    """
    rows = pd.DataFrame(
        {
            "scenario": ["p"] * 6 + ["q"],
            "solver": ["a"] * 3 + ["b"] * 3 + ["a"],
            "wall_s": [1.0, 9.0, 2.0, 1.0, 1.0, 1.0, NAN],
            "right": [True] * 5 + [False, True],
        }
    )
    table = cost_table(rows, "wall_s", ["scenario"])

    assert table.loc["p"].to_dict() == {"a": 2.0, "b": INF}
    assert table.loc["q"].isna().all()
    assert shared_questions(table).index.tolist() == ["p"]


@given(tables)
def test_performance_profile_as_dolan_and_more_define_it(table):
    """The performance profile is Dolan and More's.

    rho_s(tau) = size{p: t_ps <= tau min_s t_ps} / n_p, counted (Dolan and More 2002, sec. 2).
    """
    profile = costs.performance_profile(table)

    assert profile.index[0] == 1.0
    for solver in table:
        for factor in profile.index[::10]:
            within = [
                row[solver] < INF and row[solver] / min(row) <= factor
                for _, row in table.iterrows()
            ]
            assert profile.loc[factor, solver] == pytest.approx(sum(within) / len(table))
        right = np.isfinite(table[solver]).mean()
        assert profile[solver].iloc[-1] == pytest.approx(right)


def test_a_cost_above_the_limit_is_a_failure():
    """A cost above the limit is a failure.

    It counts as so many times the limit; a question that was not asked stays so.
    """
    paid = costs.penalised(pd.DataFrame({"a": [1.0, 4.0, INF, NAN]}), 3.0, 2.0)["a"].tolist()

    assert paid == pytest.approx([1.0, 6.0, 6.0, NAN], nan_ok=True)

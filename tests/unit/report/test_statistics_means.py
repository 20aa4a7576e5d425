"""Means against scipy, identities and tables worked by hand."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import gmean

from dubins_study.report.statistics import means
from dubins_study.report.statistics.cost_table import cost_table, shared_questions

INF, NAN = float("inf"), float("nan")
# Three questions; b fails the second and was not asked the fourth; nobody answers the last.
TABLE = pd.DataFrame({"a": [1.0, 4.0, 2.0, 3.0, INF], "b": [2.0, INF, 1.0, NAN, INF]})
costs = st.lists(st.floats(1e-6, 1e6), min_size=1, max_size=30)


def test_shifted_geometric_mean_by_hand():
    """Costs 1 and 7 with shift 1: sqrt(2 * 8) - 1 = 3."""
    assert means.shifted_geometric_mean([1.0, 7.0], 1.0) == pytest.approx(3.0)


@given(costs, st.floats(0, 1e3))
def test_shifted_geometric_mean_as_in_scipy(values, shift):
    """scipy's geometric mean of the shifted costs; the difference cancels digits of the shift."""
    expected = gmean(np.array(values) + shift) - shift

    assert means.shifted_geometric_mean(values, shift) == pytest.approx(
        expected, rel=1e-9, abs=1e-12 * shift
    )


@given(costs)
def test_a_shift_leads_from_the_geometric_to_the_arithmetic_mean(values):
    """It rises with the shift, between the two means; 1e-9 is the rounding of logarithms."""
    means_at = [means.shifted_geometric_mean(values, shift) for shift in (0.0, 1.0, 1e3)]
    rising = [gmean(values), *means_at, np.mean(values)]

    assert all(b >= a - 1e-9 * (a + 1e3) for a, b in pairwise(rising))


def test_special_values_of_the_shifted_geometric_mean():
    """A failure is infinite, NaN is left out, a cost of 0 has the geometric mean 0."""
    assert means.shifted_geometric_mean([1.0, INF], 1.0) == INF
    assert means.shifted_geometric_mean([1.0, 7.0, NAN], 1.0) == pytest.approx(3.0)
    assert means.shifted_geometric_mean([0.0, 5.0], 0.0) == 0.0
    assert math.isnan(means.shifted_geometric_mean([], 1.0))
    assert math.isnan(means.shifted_geometric_mean([NAN], 1.0))


@pytest.mark.parametrize(
    ("values", "shift", "message"),
    [([1.0], -1.0, "shift of -1"), ([1.0], INF, "shift of inf"), ([-2.0], 3.0, "cost of -2")],
)
def test_negative_costs_and_shifts_are_refused(values, shift, message):
    """A logarithm would be NaN, or a mean meaningless."""
    with pytest.raises(ValueError, match=message):
        means.shifted_geometric_mean(values, shift)


def test_the_shift_is_the_lower_quartile():
    """Of what is finite."""
    assert means.chosen_shift([4.0, 1.0, 2.0, 3.0, 5.0, INF, NAN]) == 2.0
    assert means.chosen_shift([INF]) == 0.0


def test_par2_by_hand():
    """Limit 5: a pays 1 + 4 + 2 + 3 + 10 over five, b 2 + 10 + 1 + 10 over the four it was asked;
    with the limit 3 the answer after 4 is late."""
    assert means.par(TABLE, 5.0).to_dict() == {"a": 4.0, "b": 23 / 4}
    assert means.par(TABLE, 3.0)["a"] == (1 + 6 + 2 + 3 + 6) / 5
    assert means.penalised(TABLE, 5.0)["b"].tolist()[:3] == [2.0, 5.0, 1.0]
    assert math.isnan(means.penalised(TABLE, 5.0).loc[3, "b"])


@pytest.mark.parametrize(
    ("limit", "factor", "message"),
    [(0.0, 1.0, "limit of 0"), (INF, 1.0, "limit of inf"), (1.0, 0.5, "penalty of 0.5")],
)
def test_penalties_without_meaning_are_refused(limit, factor, message):
    """A failure costs at least the limit, and the limit is a number."""
    with pytest.raises(ValueError, match=message):
        means.penalised(TABLE, limit, factor)


def test_mean_table_by_hand():
    """Four questions were put to both, two answered by both; shift 1, limit 7."""
    table = means.mean_table(TABLE, 7.0, 1.0)

    assert table["questions"].tolist() == [4, 4]
    assert table["solved"].tolist() == [3, 2]
    assert table["common"].tolist() == [2, 2]
    assert table["par2"].tolist() == [(1 + 4 + 2 + 14) / 4, (2 + 14 + 1 + 14) / 4]
    assert table.loc["a", "mean_limit"] == pytest.approx((2 * 5 * 3 * 8) ** 0.25 - 1)
    assert table["mean_common"].tolist() == pytest.approx([6**0.5 - 1] * 2)
    late = means.mean_table(TABLE, 3.0, 1.0)  # a's answer after 4 came too late
    assert late["solved"].tolist() == [2, 2]
    in_half = means.mean_table(TABLE, 1.5, 1.0)  # of the common questions nobody answers two
    assert (in_half["common"].tolist(), in_half["solved"].tolist()) == ([0, 0], [1, 1])


def test_a_rank_that_depends_on_a_choice_is_none():
    """a is fast but fails one of four; b is slow and right; c is worst by any measure.

    With failures at the limit 10 a's geometric mean is near 0.01^(3/4) 10^(1/4), far below b's 2; a
    shift of 10 times 2 nears the arithmetic mean: (0.03 + 10 k) / 4 above 2 for every penalty k.
    """
    table = pd.DataFrame({"a": [0.01] * 3 + [INF], "b": [2.0] * 4, "c": [9.0] * 3 + [INF]})
    ranking = means.ranking(table, 10.0, 2.0)

    assert ranking["rank"].isna().tolist() == [True, True, False]
    assert ranking.loc["c", "rank"] == 3
    assert ranking[["best", "worst"]].to_numpy().tolist() == [[1, 2], [1, 2], [3, 3]]
    assert means.ranking(table[["b", "c"]], 10.0)["rank"].tolist() == [1, 2]
    by_shift = means.ranking(table, 10.0, 2.0, penalties=[1.0])
    assert by_shift["rank"].isna().tolist() == [True, True, False]
    chosen = means.ranking(table, 10.0, 2.0, penalties=[1.0], shift_factors=[1.0])
    assert chosen["rank"].tolist() == [1, 2, 3]


def test_a_penalty_alone_may_take_a_rank_away():
    """Geometric means 0.1^(1/2) 10^(1/2) = 1 against 2 at the limit; at ten times it, 3.2."""
    table = pd.DataFrame({"a": [0.1, INF], "b": [2.0, 2.0]})

    at_limit = means.ranking(table, 10.0, 0.0, penalties=[1.0])
    assert at_limit["rank"].tolist() == [1, 2]
    assert at_limit["mean"].tolist() == pytest.approx([1.0, 2.0])
    assert means.ranking(table, 10.0, 0.0)["rank"].isna().all()


def test_equal_means_share_a_rank():
    """And one solver alone is first; a table without common questions ranks nobody."""
    same = pd.DataFrame({"a": [1.0, 2.0], "b": [1.0, 2.0], "c": [3.0, 3.0]})

    assert means.ranking(same, 10.0)["rank"].tolist() == [1, 1, 3]
    assert means.ranking(same[["b"]], 10.0)["rank"].tolist() == [1]
    assert means.ranking(same[["a", "b"]].mask(same > 0), 10.0)["rank"].isna().all()
    assert means.ranking(same.iloc[:0], 10.0)["rank"].isna().all()


def test_all_failures():
    """Nobody answers anything: all cost the limit, all are first, nothing is common."""
    table = pd.DataFrame({"a": [INF, INF], "b": [INF, INF]})
    summary = means.mean_table(table, 3.0)

    assert summary["solved"].tolist() == [0, 0]
    assert summary["mean_limit"].tolist() == pytest.approx([3.0, 3.0])
    assert summary["mean_common"].isna().all()


def test_cost_table_takes_the_median_over_repeats_and_no_half_right_answer():
    """Question p: a is right thrice, b wrong once; question q was put to a alone, uncounted."""
    rows = pd.DataFrame(
        {
            "scenario": ["p"] * 6 + ["q"],
            "solver": ["a"] * 3 + ["b"] * 3 + ["a"],
            "wall_s": [1.0, 9.0, 2.0, 1.0, 1.0, 1.0, NAN],
            "right": [True] * 5 + [False, True],
        }
    )
    table = cost_table(rows, cost="wall_s", right="right", question=["scenario"])

    assert table.loc["p"].to_dict() == {"a": 2.0, "b": INF}
    assert table.loc["q"].isna().all()
    assert shared_questions(table).index.tolist() == ["p"]


def test_a_question_without_a_name_is_a_question():
    """A missing value in a key takes no attempt away: pandas drops such groups by default."""
    rows = pd.DataFrame(
        {
            "scenario": ["p", "p", None, None],
            "branch": ["best"] * 4,
            "solver": ["a", "b", "a", "b"],
            "wall_s": [1.0, 2.0, 3.0, 4.0],
            "right": [True, True, True, False],
        }
    )
    table = cost_table(rows, cost="wall_s", right="right", question=["scenario", "branch"])

    assert sorted(map(tuple, table.to_numpy().tolist())) == [(1.0, 2.0), (3.0, INF)]


def test_cost_tables_with_a_mistake_are_refused():
    """A negative cost, and two columns of one name."""
    with pytest.raises(ValueError, match="cost of -1"):
        shared_questions(pd.DataFrame({"a": [-1.0]}))
    with pytest.raises(ValueError, match="named twice: a"):
        shared_questions(pd.DataFrame([[1.0, 2.0]], columns=["a", "a"]))

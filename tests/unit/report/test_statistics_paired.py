"""Paired tests against published examples and all sign patterns written out."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest, rankdata, wilcoxon

from dubins_study.report.statistics.intervals import (
    holm,
    paired_tests,
    sign_test,
    wilcoxon_test,
)

INF, NAN = float("inf"), float("nan")
# Darwin's maize: cross- minus self-fertilised height of 15 pairs in eighths of an inch (Fisher
# 1935, The Design of Experiments, sec. 17 and 21).
MAIZE = np.array([49, -67, 8, 16, 6, 23, 28, 41, 14, 29, 56, 24, 75, 60, -48])


def costs_of(differences):
    """Costs of a solver and a rival whose logarithms differ by the given amounts."""
    return np.exp(np.array(differences) / 100.0), np.ones(len(differences))


def test_the_sign_test_of_darwins_maize():
    """13 of 15 are positive: 2 (1 + 15 + 105) / 2^15 (Conover 1999, sec. 3.4, uses the tail)."""
    outcome = sign_test(*costs_of(MAIZE))

    assert (outcome.pairs, outcome.wins, outcome.losses, outcome.ties) == (15, 2, 13, 0)
    assert outcome.p == pytest.approx(242 / 2**15)


def test_wilcoxon_of_darwins_maize():
    """scipy's documentation prints p = 0.041259765625 for these data, with the rank sum 24."""
    assert wilcoxon_test(*costs_of(MAIZE)).p == pytest.approx(0.041259765625, rel=1e-12)


@given(st.lists(st.integers(-9, 9), min_size=1, max_size=9))
def test_wilcoxon_as_all_sign_patterns_give_it(differences):
    """Exact: the share of the 2^n sign patterns with a rank sum as far from its mean, ties too."""
    decided = [d for d in differences if d]
    outcome = wilcoxon_test(*costs_of(differences))
    if not decided:
        assert outcome.p == 1.0
        return

    ranks = rankdata(np.abs(decided))
    centre = ranks.sum() / 2
    sums = np.array([ranks @ signs for signs in product([0, 1], repeat=len(decided))])
    far = abs(ranks @ (np.array(decided) > 0) - centre)
    assert outcome.p == pytest.approx((np.abs(sums - centre) >= far - 1e-9).mean())
    assert outcome.ties == len(differences) - len(decided)


def test_many_pairs_with_ties_as_in_scipy():
    """Normal above 50 pairs, with scipy's correction of the variance for ties of ranks."""
    differences = np.random.default_rng(1).integers(-4, 6, 300)
    expected = wilcoxon(differences[differences != 0], method="asymptotic").pvalue

    assert wilcoxon_test(*costs_of(differences)).p == pytest.approx(expected)


@given(st.integers(0, 400), st.integers(0, 400))
def test_the_sign_test_as_in_scipy(wins, losses):
    costs = [1.0] * wins + [2.0] * losses
    rivals = [2.0] * wins + [1.0] * losses
    expected = binomtest(wins, wins + losses).pvalue if wins + losses else 1.0

    assert sign_test(costs, rivals).p == pytest.approx(expected)


def test_a_failure_loses_by_the_largest_rank():
    """One failure against seven small wins, exactly as one loss larger than all of them: 2^8 sign
    patterns, of which 2 * 25 have a rank sum at most 8 or at least 28 (partitions of up to 8 into
    distinct parts up to 8: 1+1+1+2+2+3+4+5+6 = 25)."""
    failed = wilcoxon_test([1.0] * 7 + [INF], [1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.0])

    assert (failed.wins, failed.losses) == (7, 1)
    assert failed.p == pytest.approx(2 * 25 / 2**8)


@pytest.mark.parametrize("test", [sign_test, wilcoxon_test])
def test_ties_failures_and_what_was_not_asked(test):
    """Equal costs and two failures tie; a pair with NaN is none; only ties, or nothing: p = 1."""
    outcome = test([1.0, 2.0, INF, INF, NAN, 0.0, 0.0], [1.0, 3.0, INF, 5.0, 1.0, 0.0, 2.0])

    assert outcome[:4] == (6, 2, 1, 3)
    assert 0 < outcome.p <= 1
    assert test([1.0, INF, 0.0], [1.0, INF, 0.0]) == (3, 0, 0, 3, 1.0)
    assert test([], []) == (0, 0, 0, 0, 1.0)
    assert test([INF, INF], [1.0, 2.0]).losses == 2


@pytest.mark.parametrize("test", [sign_test, wilcoxon_test])
@given(
    pairs=st.lists(
        st.tuples(*[st.sampled_from([0.0, 0.5, 1.0, 2.0, 7.0, INF, NAN])] * 2), max_size=30
    )
)
def test_a_test_has_two_sides(test, pairs):
    """The rival's test has the same p, with wins and losses exchanged, and is as certain."""
    costs, rivals = [a for a, _ in pairs], [b for _, b in pairs]
    one, other = test(costs, rivals), test(rivals, costs)

    assert (one.wins, one.losses) == (other.losses, other.wins)
    assert one.p == pytest.approx(other.p)
    assert 0 <= one.p <= 1


def test_holm_as_in_r():
    """R's package multtest, mt.rawp2adjp: the values by which statsmodels tests its `multipletests`
    (statsmodels/stats/tests/test_multi.py, res_multtest1, column Holm)."""
    p = [
        *(0.838541367553, 0.642193923795, 0.680845947633, 0.967833824309, 0.71626938238),
        *(0.177096952723, 5.23656777208e-005, 0.0202732688798, 0.00028140506198, 0.0149877310796),
    ]
    expected = [
        *(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 5.2365677720800005e-04, 1.4191288215860001e-01),
        *(2.5326455578199999e-03, 1.1990184863680001e-01),
    ]

    assert holm(p) == pytest.approx(expected, rel=1e-12)


def test_holm_keeps_adjusted_values_in_order():
    """The same source, res_multtest2: 0.002 to 0.012 by six give 0.012, 0.02, 0.024 and no less."""
    p = [0.002, 0.004, 0.006, 0.008, 0.01, 0.012]

    assert holm(p) == pytest.approx([0.012, 0.02, 0.024, 0.024, 0.024, 0.024])


def test_holm_leaves_out_what_was_not_tested():
    """NaN stays and does not count; nothing stays nothing."""
    assert holm([0.01, NAN, 0.04])[[0, 2]].tolist() == [0.02, 0.04]
    assert math.isnan(holm([NAN])[0])
    assert holm([]).shape == (0,)


def test_pairs_are_tested_and_corrected():
    """a is always half of b, and c is b but for the last question: p times what Holm says."""
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

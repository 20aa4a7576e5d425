"""Spread over seeds against scipy, and rows worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import iqr, variation

from dubins_study.report.statistics.intervals import wilson_interval
from dubins_study.report.statistics.metrics import seed_spread

NAN = float("nan")
# Solver a: question p changes its verdict, q does not; solver b was asked p once.
ROWS = pd.DataFrame(
    {
        "solver": ["a"] * 6 + ["b"],
        "question": [0, 0, 0, 1, 1, 1, 0],
        "verdict": ["optimal", "longer", "optimal", "misses", "misses", "misses", "optimal"],
        "right": [True, False, True, False, False, False, True],
        "wall_s": [1.0, 2.0, 6.0, 4.0, 4.0, 4.0, 3.0],
    }
)


def test_spread_by_hand():
    """Costs 1, 2, 6 have quartiles 1.5 and 4, mean 3, variance 7, and one of a's two questions
    changes; b was never asked again."""
    table = seed_spread(ROWS)

    assert table.index.tolist() == ["a"]
    line = table.loc["a"]
    assert (line["questions"], line["repeats"], line["changing"]) == (2, 3, 0.5)
    assert (line["changing_low"], line["changing_high"]) == wilson_interval(1, 2)
    assert line["sometimes"] == 0.5
    assert line["iqr_relative"] == pytest.approx((1.25 + 0) / 2)
    assert line["cv"] == pytest.approx(math.sqrt(7) / 6)
    assert seed_spread(ROWS.iloc[:0]).empty


def test_one_unsteady_question_does_not_make_a_solver_unsteady():
    """Medians over questions: of three, two take the same time with every seed."""
    rows = pd.DataFrame(
        {"solver": "a", "question": [0, 1, 2] * 2, "wall_s": [1.0, 2.0, 3.0, 1.0, 2.0, 9.0]}
    ).assign(verdict="optimal", right=True)
    line = seed_spread(rows).loc["a"]

    assert (line["iqr_relative"], line["cv"], line["changing"]) == (0.0, 0.0, 0.0)


@given(
    st.lists(
        st.tuples(st.floats(0.1, 100), st.sampled_from(["x", "y", None])), min_size=2, max_size=20
    )
)
def test_a_question_as_in_scipy(rows):
    """scipy's interquartile range and coefficient of variation of a question's costs."""
    frame = pd.DataFrame(rows, columns=["wall_s", "verdict"])
    right = frame["verdict"] == "x"
    line = seed_spread(frame.assign(solver="a", question=0, right=right)).loc["a"]

    costs = frame["wall_s"]
    assert line["iqr_relative"] == pytest.approx(iqr(costs) / np.median(costs), abs=1e-12)
    assert line["cv"] == pytest.approx(variation(costs, ddof=1), abs=1e-9)
    assert line["changing"] == (len(set(frame["verdict"].fillna("missing"))) > 1)
    assert line["sometimes"] == (0 < right.mean() < 1)


def test_costs_that_are_not_finite_are_left_out():
    """A crash has no time, and no verdict: it is a verdict of its own."""
    rows = ROWS.assign(
        wall_s=[1.0, NAN, math.inf, NAN, NAN, NAN, 0.0],
        verdict=[None, "optimal", None, *[None] * 4],
    )
    line = seed_spread(rows).loc["a"]

    assert (line["changing"], line["iqr_relative"]) == (0.5, 0.0)
    assert math.isnan(line["cv"])

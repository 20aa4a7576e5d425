"""Spread over seeds against scipy, question by question, and rows worked by hand."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import iqr, variation

from dubins_study.report.statistics.intervals import wilson_interval
from dubins_study.report.statistics.metrics import question_spread, solver_spread

NAN = float("nan")
# Solver a: question p changes its verdict, q does not; solver b was asked p once.
ROWS = pd.DataFrame(
    {
        "solver": ["a"] * 6 + ["b"],
        "scenario_id": list("pppqqqp"),
        "repeat": [0, 1, 2, 0, 1, 2, 0],
        "verdict": ["optimal", "longer", "optimal", "misses", "misses", "misses", "optimal"],
        "right": [True, False, True, False, False, False, True],
        "wall_s": [1.0, 2.0, 6.0, 4.0, 4.0, 4.0, 3.0],
    }
)


def test_spread_by_hand():
    """Costs 1, 2, 6: quartiles 1.5 and 4, mean 3, variance 7."""
    spread = question_spread(ROWS, question=["scenario_id"])

    line = spread.loc[("a", "p")]
    assert (line["repeats"], line["verdicts"], line["changes"]) == (3, 2, True)
    assert line["success"] == pytest.approx(2 / 3)
    assert (line["median"], line["iqr"]) == (2.0, 2.5)
    assert line["cv"] == pytest.approx(math.sqrt(7) / 3)
    assert spread.loc[("a", "q"), ["verdicts", "iqr", "cv"]].tolist() == [1, 0.0, 0.0]
    assert math.isnan(spread.loc[("b", "p"), "cv"])


def test_solvers_are_judged_by_the_questions_that_were_repeated():
    """One of a's two questions changes; b was never asked again."""
    table = solver_spread(question_spread(ROWS, question=["scenario_id"]))

    assert table.index.tolist() == ["a"]
    line = table.loc["a"]
    assert (line["questions"], line["repeats"], line["changing"]) == (2, 3, 0.5)
    assert (line["changing_low"], line["changing_high"]) == wilson_interval(1, 2)
    assert line["sometimes"] == 0.5
    assert line["success"] == pytest.approx(1 / 3)
    assert line["iqr_relative"] == pytest.approx((1.25 + 0) / 2)
    assert line["cv"] == pytest.approx(math.sqrt(7) / 6)


def test_one_unsteady_question_does_not_make_a_solver_unsteady():
    """Medians over questions: of three, two take the same time with every seed."""
    rows = pd.DataFrame(
        {"solver": "a", "scenario_id": list("pqr") * 2, "wall_s": [1.0, 2.0, 3.0, 1.0, 2.0, 9.0]}
    ).assign(verdict="optimal", right=True)
    line = solver_spread(question_spread(rows, question=["scenario_id"])).loc["a"]

    assert (line["iqr_relative"], line["cv"], line["changing"]) == (0.0, 0.0, 0.0)


@given(
    st.lists(
        st.tuples(st.sampled_from("pq"), st.floats(0.1, 100), st.sampled_from(["x", "y", None])),
        min_size=1,
        max_size=20,
    )
)
def test_each_question_as_in_scipy(rows):
    """scipy's interquartile range and coefficient of variation of each question's costs."""
    frame = pd.DataFrame(rows, columns=["scenario_id", "wall_s", "verdict"])
    frame = frame.assign(solver="a", right=frame["verdict"] == "x")
    spread = question_spread(frame, question=["scenario_id"])

    for question, part in frame.groupby("scenario_id"):
        line = spread.loc[("a", question)]
        assert line["iqr"] == pytest.approx(iqr(part["wall_s"]), abs=1e-12)
        if len(part) > 1:
            assert line["cv"] == pytest.approx(variation(part["wall_s"], ddof=1), abs=1e-9)
        assert line["verdicts"] == len(set(part["verdict"].fillna("missing")))
        assert line["success"] == pytest.approx(np.mean(part["verdict"] == "x"))


def test_costs_that_are_not_finite_are_left_out():
    """A crash has no time, and no verdict: it is a verdict of its own."""
    rows = ROWS.assign(
        wall_s=[1.0, NAN, math.inf, NAN, NAN, NAN, 0.0],
        verdict=[None, "optimal", None, *[None] * 4],
    )
    spread = question_spread(rows, question=["scenario_id"])

    assert spread.loc[("a", "p"), ["median", "iqr", "verdicts"]].tolist() == [1.0, 0.0, 2]
    assert spread.loc[("a", "q"), ["median", "iqr", "cv"]].isna().all()
    assert not spread.loc[("a", "q"), "changes"]


def test_a_missing_key_takes_no_attempt_away():
    """A question whose name is missing has its repeats, a repeat without a number its attempts."""
    rows = ROWS.assign(scenario_id=[None] * 3 + list("qqqp"), repeat=[None, 1, 1, 1, 1, 1, 0])

    assert question_spread(rows, question=["scenario_id"])["repeats"].sum() == len(ROWS)


def test_no_rows():
    spread = question_spread(ROWS.iloc[:0], question=["scenario_id"])

    assert spread.empty
    assert solver_spread(spread).empty

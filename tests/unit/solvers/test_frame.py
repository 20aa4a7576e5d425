"""solve_frame: one judged row a scenario, the same columns whatever the solver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pandas as pd
import pyarrow as pa
import pytest
from hard_cases import hard_frame

from dubins_study.solvers import frame as solvers_frame
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.attempt import QuestionError, attempt
from dubins_study.solvers.frame import COLUMNS, solve_frame
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError
from dubins_study.study.check.extremal import MEASURED
from dubins_study.study.rows.schema import ANSWER, SCENARIO, names
from dubins_study.study.scenario import NUMBERS, ScenarioError, scenarios
from dubins_study.study.words import BRANCHES

TIMES = {"build_s", "solve_s", "wall_s"}
FRAME = pd.DataFrame(
    {
        "x": [0.0, 1.0, 0.0],
        "y": 0.0,
        "heading": 0.0,
        "target_x": [3.0, 1.3, 0.0],
        "target_y": [1.0, 0.5, 0.0],
        "radius": 1.0,
    },
    index=["far", "near", "here"],
)


def test_headings_with_units_are_solved_as_those_in_radians():
    numbers = FRAME.assign(heading=[0.5, -np.pi / 2, np.radians(30)])
    texts = FRAME.assign(heading=["0.5", "-90deg", "30deg"])

    rows = solve_frame(texts).drop(columns=[*TIMES])
    pd.testing.assert_frame_equal(rows, solve_frame(numbers).drop(columns=[*TIMES]))


@pytest.mark.slow
@pytest.mark.parametrize("branch", BRANCHES)
def test_a_frame_says_what_single_attempts_say(branch):
    """Texts and flags equal; numbers to 1e-11 of the radius and coordinates."""
    frame = hard_frame(150, seed=4)
    rows = solve_frame(frame, branch=branch, certified=True)

    for (_, row), scenario in zip(rows.iterrows(), scenarios(frame), strict=True):
        answer = attempt(Analytic(), Question(scenario, branch)).row()
        size = scenario.extent + scenario.radius
        for name in COLUMNS:
            one, other = answer[name], row[name]
            if name in TIMES or (name in ("gap", "margin") and one is not None):
                continue
            if name in MEASURED and one is not None:
                # angles, of which a length's rounding leaves its square root next to an edge;
                # costates have no bound where the second arc nears half a turn
                assert abs(one - other) <= 1e-6 * max(1.0, abs(one)), name
                continue
            if isinstance(one, list):
                np.testing.assert_allclose(list(other), one, rtol=1e-6, atol=1e-6 * size)
            elif isinstance(one, float):
                assert abs(one - other) <= 1e-11 * size, name
            elif one is None:
                assert pd.isna(other), name
            else:
                assert one == other, name


def test_every_answer_of_the_closed_form_is_optimal_or_rightly_absent():
    frame = hard_frame(5000, seed=8)
    for branch in BRANCHES:
        rows = solve_frame(frame, branch=branch)
        assert set(rows["verdict"]) <= {"optimal", "none exists"}
        assert not rows["false_claim"].any()
    assert (solve_frame(frame)["verdict"] == "optimal").all()


@pytest.mark.parametrize("solver", ["analytic", "slsqp"])
@pytest.mark.parametrize("rows", [slice(None), slice(0, 0), slice(1, 2)])
def test_same_columns_and_index_whatever_the_solver(solver, rows):
    frame = FRAME[rows]
    answers = solve_frame(frame, solver=solver)

    assert list(answers.columns) == names(SCENARIO) + names(ANSWER)
    assert answers.index.equals(frame.index)
    assert answers[list(frame.columns)].equals(frame)
    batch = solve_frame(frame)
    assert [str(t) for t in answers.dtypes] == [str(t) for t in batch.dtypes]


def test_an_index_with_repeats_is_kept_and_the_input_is_not_touched():
    frame = FRAME.set_axis([7, 7, 7])
    before = frame.copy(deep=True)

    assert list(solve_frame(frame).index) == [7, 7, 7]
    pd.testing.assert_frame_equal(frame, before)


def test_missing_is_null():
    """No path: no lengths, no word, null lists; nothing is a NaN inside Arrow."""
    answers = solve_frame(FRAME, branch="LS")
    near = answers.loc["near"]

    assert near["outcome"] == "returned"
    assert near["claim"] == "infeasible"
    assert near["verdict"] == "none exists"
    assert near["message"] == "no LS path exists"
    for name in ("word", "reference_word", "length", "gap", "miss", "curvatures", "lengths"):
        assert pd.isna(near[name]), name
    table = pa.Table.from_pandas(answers)
    for name in ("length", "lengths", "iterations", "multiplier_x"):
        assert table[name][1].as_py() is None, name
    assert table["lengths"][2].as_py() == []  # at the start: a path, of no arcs


def test_a_branch_that_a_solver_does_not_answer_is_a_row():
    answers = solve_frame(FRAME, solver="turn-rate-qp", branch="RL")

    assert (answers["outcome"] == "unsupported").all()
    assert (answers["verdict"] == "none").sum() == len(FRAME)


@pytest.mark.parametrize(
    ("change", "options", "error", "message"),
    [
        ({"radius": [1.0, -2.0, 1.0]}, {}, ScenarioError, "row 'near': radius is -2.0"),
        ({"wind": 1.0}, {}, ScenarioError, "unknown column 'wind'"),
        ({}, {"branch": "LL"}, QuestionError, "no branch named 'LL'.* choose one of: best"),
        ({}, {"branch": "LSL"}, QuestionError, "row .*: branch 'LSL' is none of one leg"),
        ({}, {"solver": "magic"}, SolverError, "no solver named 'magic'"),
        ({}, {"limit": -1.0}, QuestionError, "limit is -1.0"),
    ],
)
def test_bad_requests_are_refused(change, options, error, message):
    with pytest.raises(error, match=message):
        solve_frame(FRAME.assign(**change), **options)


@dataclass(frozen=True)
class Raising(Analytic):
    name: ClassVar[str] = "raising"

    def solve_frame(self, frame, branch):
        raise ArithmeticError("no luck")


def test_a_backend_that_raises_has_answered_no_row(monkeypatch):
    monkeypatch.setattr(solvers_frame, "load", lambda spec, profile: Raising())
    answers = solve_frame(FRAME, solver="raising")

    assert (answers["outcome"] == "raised").all()
    assert (answers["message"] == "ArithmeticError: no luck").all()
    assert (answers["verdict"] == "none").all()
    assert answers["length"].isna().all()


def test_integers_and_extension_dtypes_are_read():
    frame = FRAME.assign(y=0, radius=1).astype({"target_x": "Float64"})

    assert solve_frame(frame)["length"].equals(solve_frame(FRAME)["length"])
    assert list(NUMBERS) == list(solve_frame(frame).columns[: len(NUMBERS)])

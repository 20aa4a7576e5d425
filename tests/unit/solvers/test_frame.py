"""solve_frame: one judged row a scenario.

The columns are the same whatever the solver.
"""

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numba
import numpy as np
import pandas as pd
import pyarrow as pa
import pytest

from dubins_study.asking import frame as solvers_frame
from dubins_study.asking.attempt import QuestionError, attempt
from dubins_study.asking.frame import COLUMNS, solve_frame
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError
from dubins_study.study.check.extremal import Extremal
from dubins_study.study.closed_form import kernel_compile
from dubins_study.study.judging import verdict_frame
from dubins_study.study.judging.judge import judge
from dubins_study.study.rows.schema import ANSWER, SCENARIO, names
from dubins_study.study.scenario import ScenarioError
from dubins_study.study.scenario_frame import check_frame, scenarios
from dubins_study.study.words import BRANCHES, POSE_BRANCHES
from tests.hard_cases import hard_frame, hard_poses

MEASURED = {*Extremal._fields, "cut_margin"} - {"abnormal"}
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


def random_poses(n: int, seed: int) -> pd.DataFrame:
    """n legs with a final heading.

    They are up to 30 radii long.
    """
    x, y, tx, ty = np.random.default_rng(seed).uniform(-10, 10, (4, n))
    heading, final = np.random.default_rng(seed + 1).uniform(-6, 6, (2, n))
    points = {"x": x, "y": y, "heading": heading, "target_x": tx, "target_y": ty}
    return pd.DataFrame({**points, "radius": 2.0, "speed": 3.0, "final_heading": final})


KINDS = {
    "targets": (partial(hard_frame, 150, seed=4), BRANCHES),
    "hard poses": (partial(hard_poses, 600, seed=4), POSE_BRANCHES),
    "random poses": (partial(random_poses, 600, seed=4), POSE_BRANCHES),
}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "branch"), [(kind, b) for kind, (_, branches) in KINDS.items() for b in branches]
)
def test_a_frame_says_what_single_attempts_say(kind, branch):
    """A frame agrees with single attempts.

    Texts and flags are equal; numbers to 1e-11 of the radius and coordinates, references to 1e-7.
    """
    frame = KINDS[kind][0]()
    rows = solve_frame(frame, branch=branch, certified=True)

    for (_, row), scenario in zip(rows.iterrows(), scenarios(check_frame(frame)), strict=True):
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
                # next to an edge, lengths of two parts of an interval are a root of rounding apart
                allowed = 1e-7 if name == "reference" else 1e-11
                assert abs(one - other) <= allowed * size, name
            elif one is None:
                assert pd.isna(other), name
            else:
                assert one == other, name


def test_poses_are_answered_in_compiled_loops(monkeypatch):
    """Poses are answered in compiled loops.

    Rows are the shortest paths, and some have none: the scalar check judges one in a hundred.
    """
    calls = []
    monkeypatch.setattr(verdict_frame, "judge", lambda *asked: calls.append(asked) or judge(*asked))
    frame = random_poses(1000, seed=2)
    for branch in POSE_BRANCHES:
        rows = solve_frame(frame, branch=branch, certified=True)
        assert set(rows["verdict"]) <= {"optimal", "none exists"}
        assert (rows["proof"] == "proved").all()
    assert len(calls) < 70


@pytest.mark.parametrize("dropped", [[], ["final_heading"]])
def test_rows_shared_out_among_threads_are_those_of_small_frames(dropped, monkeypatch):
    frame = random_poses(3000, seed=5).drop(columns=dropped)
    parts = [solve_frame(part, certified=True) for part in (frame[:1500], frame[1500:])]
    monkeypatch.setattr(kernel_compile, "SMALL", 2000)
    monkeypatch.setattr(kernel_compile, "PIECE", 64)
    monkeypatch.setitem(vars(numba.config), "NUMBA_NUM_THREADS", 3)

    rows = solve_frame(frame, certified=True).drop(columns=[*TIMES])

    pd.testing.assert_frame_equal(rows, pd.concat(parts)[[*rows]], check_exact=True)


@pytest.mark.parametrize("free", [None, np.nan, pd.NA])
def test_free_and_given_headings_and_routes_in_one_frame(free):
    """Free headings, given ones and routes in one frame.

    Each row is as in a frame of its own kind, in its place; what is missing is free.
    """
    frame = pd.concat([FRAME] * 2).assign(
        final_heading=pd.Series([free, 0.5, free, 1, free, "90deg"], dtype=object).array,
        via_x=pd.Series([None, None, [6, 2], None, None, None], dtype=object).array,
        via_y=pd.Series([None, None, [1, 7], None, None, None], dtype=object).array,
    )
    rows = solve_frame(frame, certified=True)

    assert rows.index.equals(frame.index)
    for kind in ([0, 4], [1, 3, 5], [2]):
        alone = solve_frame(frame.iloc[kind], certified=True)
        for name in COLUMNS:
            if name not in TIMES:
                assert rows[name].dtype.kind == alone[name].dtype.kind
                value = rows[name].iloc[kind].tolist()
                expected = alone[name].tolist()
                assert str(value) == str(expected), name


def test_answers_can_be_asked_again_and_other_columns_are_carried():
    """Answers can be asked again.

    An answer's own columns are answered anew; the caller's stay as they are.
    """
    frame = FRAME.assign(wind=["a", None, "c"], word="LSR", radius_2=5.0).set_axis([7, 7, 7])
    before = frame.copy(deep=True)
    rows = solve_frame(frame)
    pd.testing.assert_frame_equal(frame, before)
    again = solve_frame(rows, branch="LS")

    assert [*rows.columns] == [*COLUMNS, "wind", "radius_2"] == [*again.columns]
    assert rows["wind"].equals(frame["wind"])
    expected = solve_frame(FRAME, branch="LS").drop(columns=[*TIMES]).set_axis([7, 7, 7])
    pd.testing.assert_frame_equal(again[[*expected.columns]], expected)


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


def test_missing_is_null():
    """Missing values are null.

    Without a path there are no lengths, no word, and null lists; nothing is a NaN inside Arrow.
    """
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


@pytest.mark.parametrize(
    ("change", "options", "error", "message"),
    [
        ({"radius": [1.0, -2.0, 1.0]}, {}, ScenarioError, "row 'near': radius is -2.0"),
        ({"final_headng": 1.0}, {}, ScenarioError, "unknown column 'final_headng'"),
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

"""Plug-ins that hand in nonsense or lie: judged."""

import ast
import math
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.asking.attempt import QuestionError, attempt
from dubins_study.asking.frame import solve_frame
from dubins_study.asking.reply import ask
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.solve import solve
from dubins_study.solvers.protocol import MAX_ARCS, FrameSolution, Question, Solution, Solver
from dubins_study.solvers.registry import load
from dubins_study.study.path import Path, Paths
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome, Verdict
from tests.cases import PAPER, scenario_frame

ASKED = Scenario(0, 0, 0.3, 3, 2, 1)


BAD_FIELDS = {
    "path='x'": "path is 'x'; expected a Path",
    "claim='superb'": "claim is 'superb'; expected one of: optimal",
    "claimed_length='1'": "claimed_length is '1'; expected a number",
    "claimed_length=b'12'": "claimed_length is b'12'; expected a number",
    "lower_bound=True": "lower_bound is True; expected a number",
    "lower_bound=[1]": r"lower_bound is \[1\]; expected a number",
    "multipliers=(1.0,)": r"multipliers is \(1.0,\); expected two numbers",
    "multipliers=('a', None)": "multipliers is .*; expected two numbers",
    "iterations='x'": "iterations is 'x'; expected a count",
    "iterations=9007199254740993": "iterations is 9007199254740993; expected a count",
    "evaluations=-1": "evaluations is -1; expected a count",
}


@pytest.mark.parametrize("field", BAD_FIELDS)
def test_a_solution_of_wrong_types_is_its_makers_failure(field):
    """A solution of wrong types is its maker's failure.

    It cannot even be made, so that the plug-in that tries has raised.
    """
    name, _, text = field.partition("=")
    given = {"claim": "none"} | {name: ast.literal_eval(text)}
    with pytest.raises(TypeError, match=BAD_FIELDS[field]):
        Solution(**given)


class Acting(Solver):
    """Does what it is told."""

    name = "acting"

    def __init__(self, act):
        self.act = act

    def solve(self, question, limit):
        return self.act(question)


class OddError(BaseException):
    """Neither an Exception nor an interruption."""


def raises(error):
    def act(question):
        raise error

    return act


def to_elsewhere(question):
    elsewhere = solve(PAPER["problem 2"]).path
    return Solution(Claim.LOCAL, elsewhere, claimed_length=math.nan)


ACTS = {
    "raises": (raises(RuntimeError("boom")), Verdict.NONE, "RuntimeError: boom"),
    "leaves the program": (raises(SystemExit(3)), Verdict.NONE, "SystemExit"),
    "raises what is no Exception": (raises(OddError("now")), Verdict.NONE, "OddError: now"),
    "returns a number": (lambda question: 3, Verdict.NONE, "expected a Solution"),
    "claims without a path": (
        lambda question: Solution(Claim.OPTIMAL, claimed_length=1.0),
        *(Verdict.NONE, None),
    ),
    "drives elsewhere": (to_elsewhere, Verdict.MISSES, None),
}


@pytest.mark.parametrize("name", ACTS)
def test_whatever_a_solver_does_becomes_a_row(name):
    """Judged is the question as it was put."""
    act, verdict, message = ACTS[name]
    answer = attempt(Acting(act), Question(ASKED))

    assert answer.scenario == ASKED
    assert answer.verdict is verdict
    if message is None:
        assert answer.outcome is Outcome.RETURNED
        assert answer.false_claim
    else:
        assert answer.outcome is Outcome.RAISED
        assert message in answer.message
    assert answer.claimed_length == (1.0 if name == "claims without a path" else None)


def test_ctrl_c_belongs_to_the_caller():
    with pytest.raises(KeyboardInterrupt):
        attempt(Acting(raises(KeyboardInterrupt)), Question(ASKED))


@pytest.mark.parametrize("text", ["\ud800", "a\0b"])
def test_texts_that_no_row_holds(text):
    solution = Solution(Claim.NONE, message=text, native_status=text)

    assert solution.message.encode()


N = 3
GOOD = {"curvatures": np.zeros((2, N)), "lengths": np.ones((2, N)), "returned": np.ones(N, bool)}
ARRAYS = {
    "big-endian": {"lengths": np.ones((2, N), ">f8")},
    "integers": {"lengths": np.ones((2, N), int), "curvatures": np.ones((2, N), np.int8)},
    "read-only": {"lengths": np.broadcast_to(1.0, (2, N))},
    "of objects": {"lengths": np.ones((2, N), object)},
    "lists": {"lengths": [[1.0] * N] * 2},
    "NaN": {"lengths": np.full((2, N), np.nan)},
    "strided": {"lengths": np.ones((4, 2 * N))[::2, ::2]},
    "claims": {"claim": np.ones(N, ">i4")},
    "bounds": {"lower_bound": np.ones(N, ">f4"), "claimed_length": [1, 2, 3]},
}
BAD_ARRAYS = {
    "complex": ({"lengths": np.ones((2, N), complex)}, "lengths is an array of complex128"),
    "of text": ({"lengths": np.full((2, N), "1_0")}, "lengths is an array of <U3"),
    "of odd objects": ({"lengths": np.full((2, N), None)}, "lengths holds None"),
    "durations": ({"lengths": np.ones((2, N), "m8[s]")}, "lengths is an array of timedelta64"),
    "of one row": ({"lengths": np.ones(N)}, r"lengths has shape \(3,\); expected \(2, 3\)"),
    "numbers for flags": ({"returned": np.ones(N)}, "returned is an array of float64"),
    "few flags": (
        {"returned": np.ones(1, bool)},
        r"returned is an array of bool, shape \(1,\); expected bool",
    ),
    "claims that are NaN": ({"claim": np.full(N, np.nan)}, "claim is neither a Claim nor indices"),
    "claims of text": ({"claim": ["optimal"] * N}, "claim is neither a Claim nor indices"),
    "a bound": ({"lower_bound": 1.0}, r"lower_bound has shape \(\); expected \(3,\)"),
    "messages of lists": ({"message": [[1]] * N}, "expected a text, or 3 texts"),
    "few messages": ({"message": ["a"]}, "expected a text, or 3 texts"),
    "a status": ({"native_status": 3}, "native_status is 3; expected a text"),
    "few paths": ({"paths": Paths(np.zeros((2, 2)), np.zeros((2, 2)))}, "2 paths for 3 scenarios"),
    "unknown claims": ({"claim": np.full(N, 99)}, "claim is neither a Claim nor indices"),
    "no paths": ({"paths": None}, "paths is None; expected Paths"),
}


def frame_of(monkeypatch, changes):
    """The rows of a plug-in whose arrays are so."""

    class Whole(Acting):
        branches = ("best",)

        def solve_frame(self, frame, branch):
            arrays = GOOD | {k: v for k, v in changes.items() if k in GOOD}
            others = {"claim": Claim.NONE, "paths": Paths(**arrays)}
            return FrameSolution(**others | {k: v for k, v in changes.items() if k not in GOOD})

    monkeypatch.setattr("dubins_study.asking.frame.load", lambda spec, profile: Whole(None))
    return solve_frame(scenario_frame([ASKED] * N), certified=True)


def test_a_frame_that_is_changed_is_judged_as_it_was_put(monkeypatch):
    class Easier(Acting):
        branches = ("best",)

        def solve_frame(self, frame, branch):
            frame["target_x"], frame["target_y"] = frame["x"], frame["y"]
            return FrameSolution(Claim.OPTIMAL, Paths(np.zeros((2, N)), np.zeros((2, N))))

    monkeypatch.setattr("dubins_study.asking.frame.load", lambda spec, profile: Easier(None))
    rows = solve_frame(scenario_frame([ASKED] * N))

    assert rows["target_x"].tolist() == [ASKED.target_x] * N
    assert set(rows["outcome"]) == {"returned"}
    assert set(rows["verdict"]) == {"misses"}


@pytest.mark.parametrize("name", ARRAYS)
def test_arrays_of_every_kind_are_read(monkeypatch, name):
    rows = frame_of(monkeypatch, ARRAYS[name])

    assert set(rows["outcome"]) == {"returned"}
    assert set(rows["verdict"]) == {"misses"}


@pytest.mark.parametrize("name", BAD_ARRAYS)
def test_other_arrays_are_the_plug_ins_failure(monkeypatch, name):
    """Other arrays are the plug-in's failure.

    One message names the field, its value and what was expected.
    """
    changes, message = BAD_ARRAYS[name]
    rows = frame_of(monkeypatch, changes)

    assert set(rows["outcome"]) == {"raised"}
    assert rows["message"].astype(str).str.contains(message).all(), rows["message"].iloc[0]
    assert rows["length"].isna().all()
    assert isinstance(rows, pd.DataFrame)


@given(st.lists(st.floats(), max_size=4), st.lists(st.floats(), max_size=4))
def test_any_numbers_make_an_answer(curvature, length):
    if len(curvature) != len(length):
        with pytest.raises(ValueError, match="expected one shape"):
            Path(ASKED.start, curvature, length)
        return
    solution = Solution(Claim.OPTIMAL, Path(ASKED.start, curvature, length))
    answer = attempt(Acting(lambda question: solution), Question(ASKED))

    assert answer.outcome is Outcome.RETURNED
    assert answer.length is None or math.isfinite(answer.length)


def test_a_path_of_more_arcs_than_can_be_judged_is_refused():
    """A path of too many arcs is refused.

    The check has no limit of time and memory of its own.
    """
    arcs = np.full(MAX_ARCS + 1, 1e-3)
    start = Scenario(target_x=3, target_y=1).start

    Solution(Claim.LOCAL, Path(start, arcs[1:], arcs[1:]))
    with pytest.raises(TypeError, match=f"path has {MAX_ARCS + 1} arcs; expected at most"):
        Solution(Claim.LOCAL, Path(start, arcs, arcs))


@pytest.mark.parametrize("clock", [[5.0, 4.0, 3.0], [0.0, 0.0, 1e9], [0.0, 1.0, math.nan]])
def test_a_time_that_is_impossible_is_refused(monkeypatch, clock):
    """An impossible time is refused.

    A library that replaces the clock spoils its own row, and no folder.
    """
    readings = iter(clock)
    monkeypatch.setattr("dubins_study.asking.reply.perf_counter", lambda: next(readings))
    answer = attempt(load("analytic"), Question(ASKED))

    assert answer.outcome is Outcome.RAISED
    assert "expected a time from 0 to" in answer.message
    assert (answer.solve_s, answer.wall_s, answer.path) == (None, None, None)


@pytest.mark.parametrize("limit", [10**400, True, 0, -1.0, "5", math.nan, math.inf, None])
def test_a_limit_that_is_none_is_refused(limit):
    with pytest.raises(QuestionError, match="expected a finite number of seconds above 0"):
        solve(Scenario(target_x=3, target_y=1), "slsqp", limit=limit)


def test_any_number_is_a_limit():
    for limit in (5, np.int64(5), np.float32(1), Fraction(5, 2)):
        assert solve(Scenario(target_x=3, target_y=1), "slsqp", limit=limit).verdict == "optimal"


@pytest.mark.parametrize(("building", "left"), [(0.0, 0.95), (0.5, 0.45), (3.0, 0.05)])
def test_a_solver_is_told_what_is_left_of_its_limit(monkeypatch, building, left):
    """A solver is told the rest of its limit.

    It is less a twentieth, so that what is found at the last moment is handed over in time.
    """
    told: list[float] = []

    class Listens(Solver):
        name = "listens"

        def solve(self, model, limit):
            told.append(limit)
            return Solution(Claim.FAILED)

    readings = iter([0.0, building, building])
    monkeypatch.setattr("dubins_study.asking.reply.perf_counter", lambda: next(readings))
    ask(Listens(), Question(ASKED), limit=1.0)

    assert told == [pytest.approx(left)]


@pytest.mark.parametrize(
    ("name", "value"),
    [("branch", np.array(["best", "LS"])), ("profile", []), ("isolated", np.array([1, 2]))],
)
def test_requests_of_other_types_are_refused_by_name(name, value):
    with pytest.raises(DubinsStudyError, match=name):
        solve(Scenario(target_x=3, target_y=1), "slsqp", **{name: value})

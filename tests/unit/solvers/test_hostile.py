"""Plug-ins that hand in nonsense, change the question or lie: contained and judged."""

from __future__ import annotations

import ast

import numpy as np
import pytest
from cases import scenario_frame

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.frame import solve_frame
from dubins_study.solvers.frame_solution import FrameSolution
from dubins_study.solvers.protocol import Guarantee, Question, Solution, Solver
from dubins_study.solvers.registry import SolverError, load
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path, Paths
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Claim, Outcome, Verdict

EASY = Scenario(0, 0, 0.3, 3, 2, 1)
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
    """It cannot even be made, so that the plug-in that tries has raised."""
    name, _, text = field.partition("=")
    given = {"claim": "none"} | {name: ast.literal_eval(text)}
    with pytest.raises(TypeError, match=BAD_FIELDS[field]):
        Solution(**given)


class Sneaky(Solver):
    """A solver that changes what it was asked, or hands in a path that lies about its end."""

    name, method, guarantee, branches = "sneaky", ("penalty", "sneaky"), Guarantee.LOCAL, ("best",)
    warm, packages, summary = False, (), "nothing"

    def __init__(self, trick):
        self.trick = trick

    def unavailable(self):
        return None

    def build(self, question):
        return question

    def solve(self, question, limit):
        if self.trick == "leave":
            raise SystemExit(3)
        if self.trick == "easier":
            object.__setattr__(question.scenario, "radius", question.scenario.radius / 2)
            return Solution(Claim.OPTIMAL, path=shortest_path(question.scenario))

        class Liar(Path):
            end = Pose(question.scenario.target_x, question.scenario.target_y, 0.0)
            total_length = 1.0

        return Solution(Claim.OPTIMAL, path=Liar(question.scenario.start, [0.0], [1.0]))


@pytest.mark.parametrize("trick", ["easier", "liar"])
def test_what_was_asked_and_what_was_driven_cannot_be_talked_away(trick):
    """Judged is the question as it was put, and the controls, whatever a subclass says of them."""
    answer = attempt(Sneaky(trick), Question(EASY))

    assert answer.scenario == EASY
    assert answer.verdict is Verdict.MISSES
    assert answer.false_claim


def test_a_solver_that_leaves_the_program_has_raised():
    answer = attempt(Sneaky("leave"), Question(EASY))

    assert answer.outcome is Outcome.RAISED
    assert "SystemExit" in answer.message


class Whole(Sneaky):
    """Answers frames, each time wrong in another way."""

    def solve_frame(self, frame, branch):
        n = len(frame)
        paths = Paths(np.zeros((2, n)), np.zeros((2, n)))
        if self.trick == "easier":
            frame["target_x"], frame["target_y"] = frame["x"], frame["y"]
        if self.trick == "short":
            paths = Paths(np.zeros((2, n - 1)), np.zeros((2, n - 1)))
        codes = np.full(n, 99) if self.trick == "code" else Claim.OPTIMAL
        lengths = np.zeros(n - 1) if self.trick == "lengths" else None
        return FrameSolution(codes, paths, claimed_length=lengths)


@pytest.mark.parametrize("trick", ["easier", "short", "code", "lengths"])
def test_frames_are_guarded_likewise(monkeypatch, trick):
    monkeypatch.setattr("dubins_study.solvers.frame.load", lambda spec, profile: Whole(trick))
    rows = solve_frame(scenario_frame([EASY] * 4))

    assert rows["target_x"].tolist() == [EASY.target_x] * 4
    assert set(rows["outcome"]) == {"returned" if trick == "easier" else "raised"}
    assert set(rows["verdict"]) == {"misses" if trick == "easier" else "none"}


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("packages = None", "packages is None; expected texts"),
        ("branches = ('best', 3)", r"branches is \('best', 3\); expected texts"),
        ("profiles = 3", "profiles is 3; expected a dict"),
        ("def __init__(self): raise OSError('no')", "cannot be made: OSError"),
    ],
)
def test_classes_that_only_look_like_solvers_are_refused(tmp_path, line, message):
    file = tmp_path / "bad.py"
    lines = [
        "from dubins_study import Solver",
        "class Bad(Solver):",
        "    name = method = guarantee = summary = 'bad'",
        "    branches, warm, packages = ('best',), False, ()",
        "    unavailable = build = solve = None",
        f"    {line}",
    ]
    file.write_text("\n".join(lines))
    with pytest.raises(SolverError, match=message):
        load(f"{file}:Bad")

"""The table of kinds.

Each question is of one kind. Code that needs the kind asks the table.
"""

import ast
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import dubins_study
from dubins_study.study.kinds.table import (
    BRANCHES_WITHOUT_PATH,
    EVERY_BRANCH,
    EVERY_KIND,
    KINDS,
    branches_of,
    kind_of,
    pathless_kind_of,
    reference_of,
    rows_of,
)
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import check_frame
from dubins_study.study.words import BRANCHES, POSE_BRANCHES

PACKAGE = Path(dubins_study.__file__).parent
OF_KIND = {
    "leg": Scenario(target_x=5, target_y=2),
    "pose": Scenario(target_x=5, target_y=2, final_heading=0.0),
    "route": Scenario(target_x=5, target_y=2, via=[(2, 3)]),
    "tour": Scenario(target_x=5, target_y=2, via=[(2, 3), (1, -4)], order="free"),
}


@pytest.mark.parametrize("name", OF_KIND)
def test_a_scenario_is_of_one_kind(name):
    scenario = OF_KIND[name]

    assert [kind.name for kind in KINDS if kind.matches(scenario)] == [name]
    assert kind_of(scenario).name == name


def test_a_route_to_a_heading_is_a_route():
    assert kind_of(Scenario(target_x=5, target_y=2, via=[(2, 3)], final_heading=1)).name == "route"


def test_branches_are_those_of_the_kinds():
    assert branches_of(OF_KIND["leg"]) == (*BRANCHES, "frozen")
    assert branches_of(OF_KIND["pose"]) == (*POSE_BRANCHES, "frozen")
    assert branches_of(OF_KIND["route"]) == ("best", "frozen")
    assert set(EVERY_BRANCH) == {*BRANCHES, *POSE_BRANCHES, *BRANCHES_WITHOUT_PATH}
    assert [pathless_kind_of(branch) is None for branch in ("best", "frozen")] == [True, False]


@pytest.mark.parametrize("kind", EVERY_KIND, ids=lambda kind: kind.name)
def test_examples_are_of_their_kind(kind):
    assert all(kind.matches(scenario) for scenario in kind.examples.values())


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.name)
def test_the_exact_answer_is_within_the_reference(kind):
    """The exact answer is within the reference.

    Closed forms and search stand beside ball arithmetic and the search's own bounds.
    """
    for scenario in (OF_KIND[kind.name], *kind.examples.values()):
        answer = kind.exact(scenario, "best", 10.0)
        reference = reference_of(scenario)

        assert answer.low <= reference.enclosure.high
        assert reference.enclosure.low <= answer.high
        assert reference.path.length == pytest.approx(answer.path.length, rel=1e-9)


def test_rows_of_a_frame_are_of_the_kinds_of_their_scenarios():
    names = [*OF_KIND, "leg", "route"]
    columns = ("target_x", "target_y", "via_x", "via_y", "final_heading", "order")
    rows = [{c: getattr(OF_KIND[name], c) for c in columns} for name in names]
    frame = check_frame(pd.DataFrame(rows))

    for kind in KINDS:
        assert rows_of(frame, kind).tolist() == [name == kind.name for name in names]
    assert np.sum([rows_of(frame, kind) for kind in KINDS]) == len(names)


# Who asks for the kind outside the table: the function, and why the table does not serve.
_SOLVER = "solvers import no kind, which knows the answer"
_FIELD = "it writes or reads the field itself"
WHO_ASKS = {
    "solvers/protocol.py:columns": _SOLVER,
    "solvers/course.py:free_target": _SOLVER,
    "solvers/export.py:export": _SOLVER,
    "asking/attempt.py:_scenario_text": _FIELD,
    "cli/solving/question.py:question_of": "it reads an option of that name",
    "conformance/answers.py:_advice": "the two discs are of one free leg",
    "experiments/isolation/pool.py:_give": "a solver is warmed up on a route only before one",
    "experiments/plan/scenarios.py:scenario_id": _FIELD,
    "study/scenario_frame.py:solve_command": _FIELD,
    "study/check/verdict.py:visited": _FIELD,
}


def _asks(node: ast.AST) -> bool:
    """Whether an expression asks for a question's kind."""
    text = ast.unparse(node)
    test = node.test if isinstance(node, ast.If | ast.IfExp | ast.While) else None
    if isinstance(node, ast.Compare):
        return text.endswith((".final_heading is None", ".final_heading is not None", " is LEG"))
    if isinstance(node, ast.Attribute):
        return node.attr == "one_free_leg"
    asked = test.operand if isinstance(test, ast.UnaryOp) else test
    return isinstance(asked, ast.Attribute) and asked.attr == "via"


def test_few_ask_for_the_kind_themselves():
    """Few functions ask for the kind themselves.

    At most fifteen do outside the table and the scenario, each with its reason.
    """
    functions = set()
    for file in PACKAGE.rglob("*.py"):
        name = str(file.relative_to(PACKAGE))
        if name.startswith("study/kinds/") or name == "study/scenario.py":
            continue
        for function in ast.walk(ast.parse(file.read_text())):
            if isinstance(function, ast.FunctionDef) and any(map(_asks, ast.walk(function))):
                functions.add(f"{name}:{function.name}")

    assert functions == set(WHO_ASKS)
    assert len(functions) <= 15

"""What strangers' folders hold is shown as text, or refused before numbers are made of it."""

from __future__ import annotations

import math

import pytest

from dubins_study import render
from dubins_study.report.data.results import load
from dubins_study.study.rows.files import ResultsError
from dubins_study.study.values import printable_text as visible
from tests.unit.report.results_folder import attempt, paper_scenarios

ESCAPES = "\x1b[31m\x07\x9b\u202e\ud800"


def test_what_cannot_be_printed_is_written_out():
    assert visible(ESCAPES) == "\\x1b[31m\\x07\\x9b\\u202e\\ud800"
    assert visible("a\n\tπ ≤ 2") == "a\n\tπ ≤ 2"


def test_no_control_character_reaches_a_page(results, tmp_path):
    """In the manifest halves of pairs too, which no file can hold."""
    experiment = {"name": "x" + ESCAPES, "title": ESCAPES, "question": ESCAPES, "text": "a\n\x1b"}
    said = ESCAPES.replace("\ud800", "")
    rows = [attempt(s, "s" + said, message=said, path=None) for s in paper_scenarios()]
    folder = results("f", rows, experiment=experiment, machine={ESCAPES: [ESCAPES]})

    page = render([folder], tmp_path / "out")

    for file in (page, page.parent / "report.md", page.parent / "tables" / "summary.tex"):
        text = file.read_text(encoding="utf-8")
        assert "\\x1b" in text or "textbackslash{}x1b" in text
        assert not {c for c in text if not c.isprintable()} & set(ESCAPES)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"radius": 0.0}, "radius is 0.0; expected above 0"),
        ({"target_x": math.nan}, "target_x is not finite"),
        ({"target_x": None}, "target_x is missing"),
        ({"solver": None}, "solver is missing"),
        ({"length": math.inf}, "length is not finite"),
        ({"wall_s": -1.0}, "wall_s is -1.0; expected a number from 0 to 1e+09"),
        ({"wall_s": 1e308}, "wall_s is 1e+308"),
        ({"jobs": -3}, "jobs is -3"),
        ({"lengths": [1.0]}, "differ in number"),
        ({"lengths": None}, "differ in number"),
        ({"lengths": [None, 1.0]}, "lengths holds what is no finite number"),
        ({"curvatures": [math.inf, 1.0]}, "curvatures holds what is no finite number"),
    ],
)
def test_rows_that_no_run_writes_are_refused(results, changes, message):
    scenario = paper_scenarios()[0]
    rows = [attempt(scenario), attempt(scenario, branch="LS") | changes]
    folder = results("f", rows)

    with pytest.raises(ResultsError) as error:
        load([folder])

    assert message in str(error.value)
    assert "1.parquet, rows from 0 on" in str(error.value)

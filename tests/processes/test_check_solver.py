"""`new solver` and `check-solver`, as an author of a plug-in uses them."""

from __future__ import annotations

import json
import re

import pytest
from typer.testing import CliRunner

from dubins_study.cli.app import app
from dubins_study.cli.arguments import CommandError
from dubins_study.conformance import CHECKS


def called(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.slow
def test_the_new_solver_passes_as_it_is(tmp_path, monkeypatch):
    """Its longer paths in the discs are notes."""
    monkeypatch.chdir(tmp_path)
    assert called("new", "solver", "my_solver.py").exit_code == 0

    checked = called("check-solver", "my_solver.py:MySolver", "--json")
    report = json.loads(checked.stdout)

    assert checked.exit_code == 0, checked.stdout
    assert report["passed"]
    assert [check["name"] for check in report["checks"]] == list(CHECKS)
    assert report["counts"]["note"] == 2


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mine.txt", r"expected a name ending in \.py; did you mean mine\.py"),
        ("my-solver.py", "letters, digits and underscores, .*did you mean my_solver.py"),
        ("class.py", "did you mean class_solver.py"),
        ("nowhere/mine.py", "cannot write nowhere/mine.py: No such file"),
    ],
)
def test_files_that_no_solver_is_written_into(tmp_path, monkeypatch, name, message):
    monkeypatch.chdir(tmp_path)
    ended = called("new", "solver", name)

    assert isinstance(ended.exception, CommandError)
    assert re.search(message, str(ended.exception))
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_exists_is_not_overwritten(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("x = 1")

    assert "mine.py exists" in str(called("new", "solver", "mine.py").exception)
    assert (tmp_path / "mine.py").read_text() == "x = 1"

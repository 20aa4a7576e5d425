"""`new solver` and `check-solver`, as an author of a plug-in uses them."""

from __future__ import annotations

import json
import re

import pytest
from typer.testing import CliRunner

from dubins_study import DubinsStudyError
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


@pytest.mark.slow
def test_from_a_new_file_to_a_page(tmp_path, monkeypatch):
    """The way that CONTRIBUTING shows: written, asked, run beside another solver, reported."""
    monkeypatch.chdir(tmp_path)
    mine = "my_solver.py:MySolver"
    commands = (
        ("new", "solver", "my_solver.py"),
        ("solve", 10, 5, "--from", 0, 0, "120deg", "--solver", f"{mine}[guesses=8]", "--strict"),
        ("run", "paper", "--solver", mine, "--solver", "slsqp", "--out", "results/mine"),
        ("report", "results/mine"),
    )
    for command in commands:
        ended = called(*command)
        assert ended.exit_code == 0, (command, ended.output, ended.exception)

    page = (tmp_path / "results" / "mine" / "report" / "index.html").read_text()
    assert mine in page


BAD = {
    "my_solver.py": r"is a file; expected my_solver\.py:Class",
    "my_solver.py:Mine": "no class 'Mine'; it has: MySolver",
    "my_solver.py:MySolvr": "did you mean 'MySolver'",
    "my_solver.py:Path": "does not extend dubins_study.Solver",
    "other.py:Mine": "no file",
    "my_solver.py:MySolver[guess=3]": "did you mean 'guesses'",
    "slqsp": "did you mean 'slsqp'",
}


@pytest.mark.parametrize("spec", BAD)
def test_solvers_that_there_are_not(tmp_path, monkeypatch, spec):
    """A bad request, exit code 2, and no finding about anybody's solver."""
    monkeypatch.chdir(tmp_path)
    called("new", "solver", "my_solver.py")
    ended = called("check-solver", spec)

    assert isinstance(ended.exception, DubinsStudyError)
    assert re.search(BAD[spec], str(ended.exception)), ended.exception


def test_a_file_that_does_not_load_is_a_finding_with_its_traceback(tmp_path, monkeypatch):
    """The author's own frames, and nothing else is asked."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("import dubins_study\n\nx = dubins_study.Nothing\n")
    ended = called("check-solver", "mine.py:Mine")

    assert ended.exit_code == 1
    assert "FAIL  loading" in ended.stdout
    assert 'mine.py", line 3, in <module>' in ended.stdout
    assert "has no attribute 'Nothing'" in ended.stdout
    assert "it does not load" in ended.stdout


def test_a_file_that_exists_is_not_overwritten(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text("x = 1")

    assert "mine.py exists" in str(called("new", "solver", "mine.py").exception)
    assert (tmp_path / "mine.py").read_text() == "x = 1"

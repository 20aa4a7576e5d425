"""`dubins-study solve`: exit codes, and the results that are printed beside a refused drawing."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from dubins_study.cli.app import app

FIELDS = {
    *("word", "length", "travel_time", "segments", "gap", "verdict", "claim", "proof", "solver"),
    *("branch", "miss", "region", "margin", "build_s", "solve_s"),
}
PATH, NO_PATH = ("solve", "10", "5"), ("solve", "0", "1", "--branch", "LS")


def asked(*arguments):
    return CliRunner().invoke(app, arguments)


@pytest.mark.parametrize("question", [PATH, NO_PATH])
def test_the_json_object(question):
    """Every field is there, with or without a path."""
    answer = json.loads(asked(*question, "--json").stdout)

    assert answer.keys() >= FIELDS
    for segment in answer["segments"]:
        assert segment["turn"] in ("L", "S", "R")
        assert segment["length"] > 0
    assert answer["build_s"] >= 0
    assert answer["solve_s"] >= 0


@pytest.mark.parametrize("form", [("--json",), ()])
def test_a_plot_of_no_path(form, tmp_path):
    """The answer is printed all the same; one line says that nothing is drawn; exit code 1."""
    file = tmp_path / "path.svg"
    done = asked(*NO_PATH, *form, "--plot", str(file))

    assert done.exit_code == 1
    assert "none exists" in done.stdout
    assert done.stderr == f"dubins-study: {file} is not drawn: there is no path\n"
    assert not file.exists()


def test_strict():
    """Exit code 1 unless the verdict is optimal."""
    assert asked(*PATH, "--strict").exit_code == 0
    assert asked(*NO_PATH, "--strict").exit_code == 1
    assert asked(*NO_PATH).exit_code == 0


def test_experiments():
    """Name and title of what `run` knows by name."""
    listed = json.loads(asked("experiments", "--json").stdout)

    assert {"name": "paper", "title": "The paper's five test problems"} in listed
    assert "The paper's five test problems" in asked("experiments").stdout

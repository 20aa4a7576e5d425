"""`dubins-study audit`: text, JSON and exit codes."""

from __future__ import annotations

import json

import pytest
from typer.testing import CliRunner

from dubins_study.cli.app import app
from dubins_study.cli.terminal.arguments import CommandError
from dubins_study.report.paper import printed, routes


@pytest.fixture
def asked():
    return lambda *arguments: CliRunner().invoke(app, ["audit", *arguments])


def test_json_is_the_committed_file(asked):
    """Byte for byte, so that the command can write it."""
    done = asked("--json")

    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert len(found["cells"]) == 33
    right = [cell for cell in found["cells"] if cell["verdict"] == "correct rounding"]
    assert len(right) == 26
    assert all(len(c["exact"].replace(".", "").lstrip("0")) == 40 for c in found["cells"])
    committed = (
        printed.files("dubins_study.report.paper")
        .joinpath("audit.json")
        .read_text(encoding="utf-8")
    )
    assert done.stdout == committed


def test_text_has_every_part(asked):
    shown = asked().stdout

    assert "33 printed lengths: 26 correct rounding, 1 double rounding" in shown
    assert "1.734999854667528017769085812802804636586" in shown
    assert "3 printed paths miss by more than rounding allows, 4 do not add up" in shown
    assert "34.1 %" in shown
    assert "237.749430" in shown
    assert "9 of 9 printed solve times" in shown
    assert "14 of the 14 exact LS and RS qualify" in shown


def test_a_contradiction_is_exit_code_1(asked, monkeypatch):
    """The cell is named on stderr; what was computed is printed all the same."""
    changed = json.loads(asked("--json").stdout)
    changed["cells"][12]["exact"] = "0.79"
    monkeypatch.setattr(printed, "committed", lambda: changed)

    done = asked("--json")

    assert done.exit_code == 1
    assert "contradiction: cells[6.3, problem 3, optimal, z1].exact" in done.stderr
    assert "the closed form has 0.777354" in done.stderr
    assert json.loads(done.stdout)["cells"][12]["exact"].startswith("0.777354264")


def test_published_routes(asked, monkeypatch):
    """The published length that is not the shortest is named; another verdict is exit code 1."""
    done = asked("kaya")
    records = json.loads(asked("kaya", "--json").stdout)

    assert done.exit_code == 0
    assert "MPDP, example 4: printed 7.46756219733842652175326293218, +1.54e-08" in done.stdout
    assert "example 1: RSL LSR RSR" in done.stdout
    assert len(records) == 8
    lines = (routes.PrintedRoute("here", "example 1", "3.5"),)
    monkeypatch.setattr(routes, "PRINTED_ROUTES", lines)
    done = asked("kaya")
    assert done.exit_code == 1
    assert "contradiction: here, example 1: longer, not shortest" in done.stderr


def test_an_unknown_source_is_refused():
    with pytest.raises(CommandError, match="no audit of 'nonesuch'; choose one of: paper, kaya"):
        CliRunner().invoke(app, ["audit", "nonesuch"], catch_exceptions=False)

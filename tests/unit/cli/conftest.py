"""Commands without a terminal.

A test that needs one sets it up.
"""

import pytest
from typer.testing import CliRunner

from dubins_study.cli.app import app


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch):
    """Values and table rows are one line everywhere."""
    monkeypatch.delenv("COLUMNS", raising=False)


def asked(*words, raises=True):
    """Result of `dubins-study` with these words.

    An error that is no exit is raised, or ends the command if not `raises`.
    """
    return CliRunner().invoke(app, words, catch_exceptions=not raises)


def line_of(name, text):
    """The value that a command prints under a name."""
    return next(line for line in text.splitlines() if line.startswith(name))[12:]

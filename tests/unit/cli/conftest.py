"""Commands are tested without a terminal, unless a test sets one up."""

import pytest
from typer.testing import CliRunner

from dubins_study.cli.app import app


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch):
    """Values and rows of tables are one line, wherever the tests run."""
    monkeypatch.delenv("COLUMNS", raising=False)


def asked(*words, raises=True):
    """What `dubins-study` with these words did; an error of its own is raised, or ended it."""
    return CliRunner().invoke(app, words, catch_exceptions=not raises)


def line_of(name, text):
    """The value that a command prints under a name."""
    return next(line for line in text.splitlines() if line.startswith(name))[12:]

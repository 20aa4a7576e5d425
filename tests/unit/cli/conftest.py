"""Commands are tested without a terminal, unless a test sets one up."""

import pytest


@pytest.fixture(autouse=True)
def no_terminal(monkeypatch):
    """Values and rows of tables are one line, wherever the tests run."""
    monkeypatch.delenv("COLUMNS", raising=False)

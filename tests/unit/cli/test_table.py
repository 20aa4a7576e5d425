"""Tables of the terminal: as wide as it is, with every number whole."""

from __future__ import annotations

import re

import pytest

from dubins_study.cli.terminal.table import listing, table

HEAD = ("solver", "right of n, 95 %", "longer", "misses", "none", "false claims", "median ms")
ROWS = [
    ("analytic", "100 % of 341, 98.9 to 100 %", "0", "0", "0", "0", "0.0961"),
    (
        "ipopt[model=joint,order=LRS,initial_guess=zero,capped=False,bound_relax=1e-08]",
        "33.3 % of 21, 17.2 to 54.6 %",
        *("20", "0", "50", "50", "4.04"),
    ),
    ("x" * 70, "", "1", "2", "3", "4", "123456.789"),
]


def squeezed(text):
    return re.sub(r"\s", "", text)


@pytest.mark.parametrize("width", [30, 40, 60, 79, 80, 100, 120, 200])
def test_a_table_fits(width):
    """No line is longer than the terminal, and no number is broken or cut off."""
    shown = table(HEAD, ROWS, width=width)

    assert max(map(len, shown.splitlines())) <= width
    for row in ROWS:
        for number in row[2:]:
            assert re.search(rf"(?<![\d.]){re.escape(number)}(?![\d.])", shown)


@pytest.mark.parametrize("width", [40, 80])
def test_every_character_of_a_spec_is_there(width):
    """Its lines stand below one another, beside the number of the first."""
    shown = table(("solver", "n"), [(row[0], row[2]) for row in ROWS], width=width)

    specs = squeezed("".join(re.sub(r"\s\d+$", "", line) for line in shown.splitlines()))
    assert all(row[0] in specs for row in ROWS)


def test_specs_break_between_settings():
    lines = table(("solver", "n"), [(ROWS[1][0], "20")], width=50).splitlines()

    assert lines[2].split() == ["ipopt[model=joint,order=LRS,", "20"]
    assert lines[3].strip() == "initial_guess=zero,capped=False,"


def test_without_a_terminal_a_row_is_a_line(monkeypatch):
    """For programs that read it; COLUMNS says otherwise."""
    monkeypatch.delenv("COLUMNS", raising=False)
    assert len(table(HEAD, ROWS).splitlines()) == 2 + len(ROWS)
    monkeypatch.setenv("COLUMNS", "60")
    assert max(map(len, table(HEAD, ROWS).splitlines())) <= 60


def test_a_narrow_terminal_gets_lists():
    """One block a row, with the name of each column that is not empty."""
    blocks = table(HEAD, ROWS, width=40).split("\n\n")

    assert len(blocks) == len(ROWS)
    assert blocks[0].splitlines()[0].split() == ["solver", "analytic"]
    assert "right of n" not in blocks[2]


def test_an_empty_table_has_a_head():
    assert table(("a", "b"), []).split()[:2] == ["a", "b"]
    assert listing({}) == ""

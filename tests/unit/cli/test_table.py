"""Tables of the terminal: as wide as it is, with every number whole."""

from __future__ import annotations

import re

import pytest

from dubins_study.cli.terminal.output import listing, table

HEAD = ("solver", "right of n, 95 %", "longer", "misses", "median ms")
ROWS = [
    ("analytic", "100 % of 341, 98.9 to 100 %", "0", "0", "0.0961"),
    (
        "ipopt[model=joint,order=LRS,initial_guess=zero,capped=False,bound_relax=1e-08]",
        "33.3 % of 21, 17.2 to 54.6 %",
        *("20", "50", "4.04"),
    ),
    ("x" * 70, "", "1", "4", "123456.789"),
]


@pytest.mark.parametrize("width", [60, 80, 120, 200])
def test_a_table_fits(width, monkeypatch):
    """No line is longer than the terminal, no number is broken, and no character of a text lost."""
    monkeypatch.setenv("COLUMNS", str(width))
    shown = table(HEAD, ROWS)

    assert max(map(len, shown.splitlines())) <= width
    for row in ROWS:
        for number in row[2:]:
            assert re.search(rf"(?<![\d.]){re.escape(number)}(?![\d.])", shown)
    lines = shown[shown.rindex("─") :].splitlines()[1:]
    below = "".join(line.split("  ")[0].rstrip() for line in lines)
    assert below == "".join(row[0] for row in ROWS)


def test_without_a_terminal_a_row_is_a_line(monkeypatch):
    """For programs that read it."""
    monkeypatch.delenv("COLUMNS", raising=False)
    assert len(table(HEAD, ROWS).splitlines()) == 2 + len(ROWS)


def test_brackets_are_no_markup_and_an_empty_table_has_a_head():
    """Names come from folders."""
    head, _, row = table(("[/red]", "n"), [("[bold]x", "1")]).splitlines()
    assert head.split() == ["[/red]", "n"]
    assert row.split() == ["[bold]x", "1"]
    assert table(("a", "b"), []).split()[:2] == ["a", "b"]
    assert listing({}) == ""
    assert listing({"a": "[b]", "none": "", "long": "x"}) == "a     [b]\nlong  x"

"""Output on a terminal, and plain lines elsewhere.

A terminal gets progress in one line, and tables as wide as it is.
"""

import io
import re
import sys

import pytest

from dubins_study.cli.terminal import output
from dubins_study.cli.terminal.output import Verbosity, listing, set_verbosity, table


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture(autouse=True)
def _normal_again():
    yield
    set_verbosity(Verbosity.NORMAL)


@pytest.fixture
def clock(monkeypatch):
    """A clock that the test sets."""
    now = [0.0]
    monkeypatch.setattr(output.time, "monotonic", lambda: now[0])
    return now


def shown(monkeypatch, clock, stream, seconds=(0, 10, 31, 40, 62)):
    monkeypatch.setattr(sys, "stderr", stream)
    counts = []
    with output.progress("paper\x1b[31m", counts) as move:
        for place, second in enumerate(seconds):
            clock[0] = float(second)
            move(10 * place, 100)
    assert counts == [10 * (len(seconds) - 1), 100]
    return stream.getvalue()


def test_plain_lines(monkeypatch, clock):
    """Two lines in a minute."""
    lines = shown(monkeypatch, clock, io.StringIO()).splitlines()

    assert lines == [
        "dubins-study: paper\\x1b[31m: 20 of 100 done",
        "dubins-study: paper\\x1b[31m: 40 of 100 done",
    ]


@pytest.mark.parametrize("stream", [io.StringIO, Terminal])
def test_a_quiet_command_says_nothing(stream, monkeypatch, clock):
    set_verbosity(Verbosity.QUIET)

    assert shown(monkeypatch, clock, stream()) == ""


@pytest.mark.parametrize("colours", [True, False])
def test_one_line_in_a_terminal(monkeypatch, colours):
    """NO_COLOR keeps the line and takes its colours."""
    for name, value in {"TERM": "xterm", "COLUMNS": "60", "NO_COLOR": ""}.items():
        monkeypatch.setenv(name, value if colours or value else "1")
    monkeypatch.setattr(sys, "stderr", Terminal())
    with output.progress("paper", []) as move:
        move(1, 4)
        move(3, 4)
    assert sys.stderr.getvalue().count("\n") == 1
    assert "3/4" in sys.stderr.getvalue()
    assert ("\x1b[3" in sys.stderr.getvalue()) == colours


def test_a_terminal_that_does_not_move_its_cursor_is_none(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setenv("TERM", "dumb")

    assert not output.is_terminal()


@pytest.mark.parametrize(
    ("seconds", "text"), [(1.234, "1.2 s"), (90, "90 s"), (150, "2.5 min"), (7300, "2.03 h")]
)
def test_durations(seconds, text):
    assert output.duration(seconds) == text


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
    """A table fits.

    No line is longer than the terminal, no number is broken, and no character of a text lost.
    """
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
    """Without a terminal a row is a line.

    Programs read it.
    """
    monkeypatch.delenv("COLUMNS", raising=False)
    assert len(table(HEAD, ROWS).splitlines()) == 2 + len(ROWS)


def test_brackets_are_no_markup_and_an_empty_table_has_a_head():
    """Names come from folders."""
    head, _, row = table(("[/red]", "n"), [("[bold]x", "1")]).splitlines()
    assert head.split() == ["[/red]", "n"]
    assert row.split() == ["[bold]x", "1"]
    assert table(("a", "b"), []).split()[:2] == ["a", "b"]
    assert listing({}) == ""
    assert listing({"a": "[b]", "none": "", "long": "x"}) == "a           [b]\nlong        x"

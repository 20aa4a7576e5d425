"""Requests that cannot be read: one sentence each, of one shape, whoever found the mistake."""

from __future__ import annotations

import re
import sys

import pytest

from dubins_study.cli import app

COMMANDS = (
    "solve, solvers, experiments, run, status, merge, report, compare, audit, export, "
    "check-solver, new"
)
SOLVE = "expected dubins-study solve X Y, such as: dubins-study solve 10 5 --from 0 0 120deg"
COMPARE = "expected dubins-study compare BASE NEW, such as: dubins-study compare results/paper both"
# words after `dubins-study` -> the beginning of the refusal
REFUSALS = {
    "slove": f"no such command: slove; did you mean 'solve'? expected one of: {COMMANDS}",
    "solv 1 2": f"no such command: solv; did you mean 'solve'? expected one of: {COMMANDS}",
    "zzz": f"no such command: zzz; expected one of: {COMMANDS}",
    "version": "no such command: version; did you mean '--version'? expected one of: ",
    "new slover a.py": "no such command: new slover; did you mean 'solver'? expected one of: sol",
    "--vresion": "no such option: --vresion; did you mean '--version'? see dubins-study --help",
    "--quite solve 1 2": "no such option: --quite; did you mean '--quiet'? see dubins-study --help",
    "run paper --job 2": "no such option: --job; did you mean '--jobs'? see dubins-study run",
    "run -jobs 2": "no such option: -j; expected one of: --scenarios, --out, ",
    "run -3": "no such option: -3; expected one of: --scenarios, --out, ",
    "new solver --fil a": "no such option: --fil; expected one of: --quiet, --verbose, --help; see "
    "dubins-study new solver --help",
    "solve 1 2 -x": "no such option: -x; expected one of: --from, --radius, ",
    "solve 1 2 --jsn=1": "no such option: --jsn; did you mean '--json'? see dubins-study solve",
    "solve": f"X is missing: target position; {SOLVE}",
    "solve 10 --radius 3": f"Y is missing: target position; {SOLVE}",
    "solve --from 0 0 1 2": "Y is missing: target position; expected dubins-study solve X Y",
    "solve 1 2 3": f"unexpected argument '3'; {SOLVE}",
    "solve -1 -2 -3": f"unexpected argument '-3'; {SOLVE}",
    "solve x 5": "target_x is 'x'; expected a number",
    "solve -x 2": "no such option: -x; expected one of: --from, --radius, ",
    "solve 1 2 --from 0 0": "option '--from' requires 3 arguments; expected --from X Y HEADING (st",
    "solve 1 2 --from 0 0 --json": "--from is '0 0 --json'; expected --from X Y HEADING (start ",
    "solve 1 2 --radius": "option '--radius' requires an argument; expected --radius NUMBER (mini",
    "solve 1 2 --json=yes": "option '--json' does not take a value; expected --json alone",
    "run paper --jobs": "option '--jobs' requires an argument; expected --jobs N (processes; 1 ",
    "run paper --jobs 1.5": "--jobs is '1.5'; expected a whole number",
    "run paper --out --json": "--out is '--json'; expected --out DIR (default: results/<exp",
    "run paper --solver slsqp --solver --json": "--solver is 'slsqp --json'; expected --solver",
    "run paper slsqp": "unexpected argument 'slsqp'; expected dubins-study run [EXPERIMENT], such",
    "report": "DIR is missing: results folders; expected dubins-study report DIR..., such as: ",
    "compare a": f"NEW is missing: results folder; {COMPARE}",
    "compare a b c": f"unexpected argument 'c'; {COMPARE}",
    "compare a b --slower x": "--slower is 'x'; expected a number",
    "merge a b": "--out is missing; expected dubins-study merge DIR... --out DIR, such as: ",
    "audit x": "unexpected argument 'x'; expected dubins-study audit",
    "status a --json 3": "unexpected argument '3'; expected dubins-study status DIR, such as: ",
}


@pytest.fixture
def refusal(monkeypatch, capsys):
    """The exit code and the text on stderr of a command line; nothing is on stdout."""
    monkeypatch.delenv("COLUMNS", raising=False)

    def ask(line):
        monkeypatch.setattr(sys, "argv", ["dubins-study", *line.split()])
        with pytest.raises(SystemExit) as end:
            app.main()
        written = capsys.readouterr()
        assert written.out == ""
        return end.value.code, written.err

    return ask


@pytest.mark.parametrize("line", REFUSALS)
def test_every_refusal_has_one_shape(line, refusal):
    """What is wrong, what was expected, the nearest name; in one line, with exit code 2."""
    code, text = refusal(line)

    assert code == 2
    assert text.startswith(f"dubins-study: {REFUSALS[line]}")
    assert text.count("\n") == 1


@pytest.mark.parametrize("width", [30, 40, 80, 200])
@pytest.mark.parametrize("line", ["slove", "solve 10", "run --job 2", "solve 1 2 -x"])
def test_a_refusal_fits_the_terminal(line, width, refusal, monkeypatch):
    """Lines are broken between words, and nothing is lost; a file gets one line."""
    whole = refusal(line)[1]
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", str(width))
    _, text = refusal(line)

    first, *others = text.splitlines()
    assert all(len(part) <= width for part in (first, *others))
    assert all(re.match(r"  \S", part) for part in others)
    assert text.split() == whole.split()


def test_what_no_space_parts_stays_whole(refusal, monkeypatch):
    """A path can be copied, however narrow the terminal is."""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    monkeypatch.setenv("COLUMNS", "30")
    path = "a" * 50

    assert f"{path} is no" in " ".join(refusal(f"status {path}")[1].split())


@pytest.mark.parametrize("words", ["run -h --jobs x", "solve -h", "new solver a b --help"])
def test_help_is_given_though_values_are_wrong_or_missing(words, monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["dubins-study", *words.split()])
    with pytest.raises(SystemExit, match="0"):
        app.main()

    assert capsys.readouterr().out.startswith("Usage: dubins-study")


@pytest.mark.parametrize("words", [("-qv",), ("-v", "-v"), ("--", "-2", "-5")])
def test_what_is_no_mistake(words, monkeypatch, capsys):
    """Two options of one letter, a flag twice, and targets behind `--`."""
    target = () if "--" in words else ("1", "2")
    monkeypatch.setattr(sys, "argv", ["dubins-study", "solve", *target, *words])
    with pytest.raises(SystemExit, match="0"):
        app.main()

    assert "length" in capsys.readouterr().out

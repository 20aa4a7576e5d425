"""Every command's help has examples that run."""

import shlex
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from dubins_study.cli.app import EXAMPLES, app, examples

DRIVE = """\
target_x,target_y,x,y,heading,radius,label
10,5,0,0,120deg,1,ahead
-3,-2,0,0,pi/3,2,"behind, left"
"""


def commands(group, words=()):
    """The words of every command and group of commands."""
    yield " ".join(words)
    for name, command in getattr(group, "commands", {}).items():
        yield from commands(command, (*words, name))


FEW = "--solver analytic --solver ipopt --solver 'slsqp[presolve=true]'"
ALL = sorted(commands(typer.main.get_command(app)))


@pytest.mark.parametrize("words", ALL)
def test_every_help_ends_with_examples(words):
    """Every help ends with examples.

    `-h` and `--help` are one, no line is cut off, and each example fits 80 columns.
    """
    arguments = words.split()
    short, long = (CliRunner().invoke(app, [*arguments, name]) for name in ("-h", "--help"))

    assert short.exit_code == long.exit_code == 0
    assert short.stdout == long.stdout
    assert all(f"  {line}\n" in short.stdout for line in examples(words))
    assert examples(words)
    assert not any(line.endswith("...") for line in short.stdout.splitlines()[1:])
    assert max(map(len, short.stdout.splitlines())) <= 80


def test_no_example_is_of_a_command_that_does_not_exist():
    assert {line for words in ALL for line in examples(words)} == set(EXAMPLES)


@pytest.mark.slow
def test_the_examples_run(tmp_path, monkeypatch):
    """The examples run in their order.

    They run in one folder; only a comparison may find something to say.

    The paper's experiment is run with one repeat of five, and three solvers of all.
    """
    monkeypatch.chdir(tmp_path)
    Path("drive.csv").write_text(DRIVE)
    for line in EXAMPLES:
        program, *words = shlex.split(line)
        if words[:2] == ["run", "paper"]:
            words += ["--repeats", "1"]
            words += [] if "--solver" in words else shlex.split(FEW)
        done = CliRunner().invoke(app, words, catch_exceptions=False)
        allowed = (0, 1) if words[0] in ("compare", "check-solver") else (0,)
        assert program == "dubins-study"
        assert done.exit_code in allowed, f"{line}: {done.stderr}"
        assert done.stdout or "--out" in words, line

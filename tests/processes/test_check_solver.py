"""`new solver` and `check-solver`, as used by an author."""

import json
import re

import pytest
from typer.testing import CliRunner

from dubins_study import DubinsStudyError
from dubins_study.cli.app import app
from dubins_study.cli.terminal.arguments import CommandError
from dubins_study.conformance import CHECKS
from dubins_study.solvers.registry import load


@pytest.fixture(autouse=True)
def _here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def called(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.mark.slow
def test_the_new_solver_passes_as_it_is():
    """The new solver passes as it is.

    Its longer paths in the discs are notes.
    """
    assert called("new", "solver", "my_solver.py").exit_code == 0

    checked = called("check-solver", "my_solver.py:MySolver", "--json")
    report = json.loads(checked.stdout)

    assert checked.exit_code == 0, checked.stdout
    assert report["passed"]
    assert [check["name"] for check in report["checks"]] == list(CHECKS)
    # on a busy machine a limit is not kept to the millisecond, which is a note as well
    notes = {check["name"] for check in report["checks"] if check["status"] == "note"}
    assert notes - {"limits"} == {"discs", "circles"}


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("mine.txt", r"expected a name of plain characters, such as my_solver\.py"),
        ("my-solver.py", "expected a name of plain characters"),
        ("12.py", "expected a name of plain characters"),
        ("class.py", "hides no module"),
        ("numpy.py", "hides no module"),
        ("math.py", "hides no module"),
        ("nowhere/mine.py", "cannot write nowhere/mine.py: No such file"),
    ],
)
def test_files_that_no_solver_is_written_into(tmp_path, name, message):
    ended = called("new", "solver", name)

    assert isinstance(ended.exception, CommandError)
    assert re.search(message, str(ended.exception))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_from_a_new_file_to_a_page(tmp_path):
    """A new file becomes a page.

    The way is that of CONTRIBUTING: written, asked, run beside another solver, reported.
    """
    mine = "my_solver.py:MySolver"
    commands = (
        ("new", "solver", "my_solver.py"),
        ("solve", 10, 5, "--from", 0, 0, "120deg", "--solver", f"{mine}[guesses=8]", "--strict"),
        ("run", "paper", "--solver", mine, "--solver", "slsqp", "--out", "results/mine"),
        ("report", "results/mine"),
    )
    for command in commands:
        ended = called(*command)
        assert ended.exit_code == 0, (command, ended.output, ended.exception)

    page = (tmp_path / "results" / "mine" / "report" / "index.html").read_text()
    assert mine in page


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ("my_solver.py", r"is a file; expected my_solver\.py:Class"),
        ("my_solver.py:MySolver[guess=3]", "did you mean 'guesses'"),
    ],
)
def test_solvers_that_there_are_not(spec, message):
    """Solvers that do not exist are bad requests.

    The exit code is 2, and there is no finding about anybody's solver.
    """
    called("new", "solver", "my_solver.py")
    ended = called("check-solver", spec)

    assert isinstance(ended.exception, DubinsStudyError)
    assert re.search(message, str(ended.exception)), ended.exception


def test_a_file_that_does_not_load_is_a_finding_with_its_traceback(tmp_path):
    """The author's own frames, and nothing else is asked."""
    (tmp_path / "mine.py").write_text("import dubins_study\n\nx = dubins_study.Nothing\n")
    ended = called("check-solver", "mine.py:Mine")

    assert ended.exit_code == 1
    assert "FAIL  loading" in ended.stdout
    assert 'mine.py", line 3, in <module>' in ended.stdout
    assert "has no attribute 'Nothing'" in ended.stdout
    assert "it does not load" in " ".join(ended.stdout.split())


@pytest.mark.smoke
def test_a_syntax_error_is_shown_where_it_is(tmp_path):
    """A syntax error is shown where it is.

    Both commands show file, line and caret; what to do names the author's own file.
    """
    (tmp_path / "mine.py").write_text("class Mine:\n    n = 1 +\n")
    checked = called("check-solver", "mine.py:Mine")
    solved = called("solve", "1", "2", "--solver", "mine.py:Mine")

    assert checked.exit_code == 1
    for shown in (checked.stdout, f"{solved.exception}\n"):
        assert 'mine.py", line 2\n' in shown, shown
        assert re.search(r"n = 1 \+\n +\^\n", shown), shown
        assert "\\n" not in shown
    assert "python mine.py must not raise" in " ".join(checked.stdout.split())


SOLVER = """
from dataclasses import dataclass
from dubins_study import Claim, Solution, Solver

{head}
class Mine(Solver):
    name, summary, method = "mine", "a line", {method}
    {setting}

    def solve(self, question, limit):
        return Solution(Claim.FAILED)
"""
FROZEN = "@dataclass(frozen=True)"
METHOD = '("penalty", "mine")'
# what is wrong -> how the solver differs, the status of `loading`, and words of the report
LOADING = {
    "no default": ({"setting": "n: int"}, "fail", "give each setting a default, such as `n: int"),
    "no settings": ({"head": ""}, "note", "it is no frozen dataclass write @dataclass"),
    "no dataclass": ({"head": "", "setting": "n: int = 4"}, "note", "it is no frozen dataclass"),
    "a tuple": ({"setting": "a: tuple = ()"}, "note", "a: its default () is a tuple give each"),
    "nothing": ({"setting": "a: object = None"}, "note", "a: its default None is a NoneType give"),
    "raising": (
        {"setting": "def __post_init__(self): raise OSError"},
        "fail",
        "its class is called with no arguments",
    ),
    "nothing wrong": ({"setting": "n: int = 4"}, "pass", "mine: penalty, mine"),
}


@pytest.mark.parametrize("wrong", LOADING)
def test_what_a_solver_says_of_itself_is_explained(tmp_path, wrong):
    """A mistake in a declaration has its own advice."""
    difference, status, words = LOADING[wrong]
    values = {"head": FROZEN, "method": METHOD, "setting": ""} | difference
    (tmp_path / "mine.py").write_text(SOLVER.format(**values))
    ended = called("check-solver", "mine.py:Mine", "--check", "loading", "--json")
    [check] = json.loads(ended.stdout)["checks"]

    assert check["status"] == status, check
    assert ended.exit_code == (status == "fail")
    messages = [f"{one['observed']} {one['advice']}" for one in check["findings"]]
    assert words in " ".join([check["summary"], *messages]), check


def test_a_setting_of_a_solver_that_cannot_be_made_is_refused(tmp_path):
    """A wrong setting of an impossible solver is refused.

    There is no traceback of this package: a spec with settings asks the class for its defaults.
    """
    text = SOLVER.format(head=FROZEN, method=METHOD, setting="n: int")
    (tmp_path / "mine.py").write_text(text)

    with pytest.raises(DubinsStudyError, match=r"cannot be made: .*required positional argument"):
        load("mine.py:Mine[n=3]")


@pytest.mark.smoke
def test_a_file_that_exists_is_not_overwritten(tmp_path):
    (tmp_path / "mine.py").write_text("x = 1")

    assert "mine.py exists" in str(called("new", "solver", "mine.py").exception)
    assert (tmp_path / "mine.py").read_text() == "x = 1"

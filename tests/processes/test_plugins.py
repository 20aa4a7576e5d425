"""The example plug-ins in the conformance kit.

The honest ones pass it, the lying one does not.
"""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import venv
from pathlib import Path

import pytest

from dubins_study import check_solver
from dubins_study.conformance import CHECKS
from dubins_study.conformance.report import Status
from tests.live_run import finished, interpreted, output

EXAMPLES = Path(__file__).parents[2] / "examples"
LYING = EXAMPLES / "plugin-lying" / "src" / "lying_dubins"

# lie -> the check that finds it, and words of what it says
LIES = {
    "radius as curvature": ("controls", "5.25 / R beyond.*is your radius a curvature"),
    "lengths in radii": ("controls", "R from the target"),
    "path of radius 1": ("controls", "is your path that of radius 1"),
    "angles": ("controls", "lengths of your turns angles in rad"),
    "turn rates": ("controls", "2 / R beyond"),
    "positions": ("controls", "are these positions. A path is its controls"),
    "left is right": ("controls", "left and right are swapped"),
    "one turn to the wrong side": ("discs", "R from the target"),
    "from the target": ("controls", "the path starts elsewhere.*give question.scenario.start"),
    "swapped arrays": ("controls", "R beyond what the branch allows|a length below 0"),
    "negative length": ("controls", "a length below 0.*other sign of curvature"),
    "not a number": ("controls", "a number that is not finite"),
    "nearly there": ("controls", "ends 0.000412 R from the target.*tighten the tolerance"),
    "start in degrees": ("controls", "the path starts elsewhere.*its heading to the last bit"),
    "heading in degrees": ("controls", "arrives if the heading is taken for degrees"),
    "diameter": ("controls", "1 / R beyond.*keep the curvature between"),
    "wide turns": ("claims", "2 times as wide as the radius allows"),
    "radius times speed": ("claims", "3 times as wide"),
    "no start": ("controls", "starts at .0, 0. with heading 0: is question.scenario.start used"),
    "any word": ("branches", "asked for LS, and its path is RS"),
    "skips the last via point": (
        "routes",
        "R from a via point.*never passes .4, 7.*Leave `via points`",
    ),
    "sorts the via points": ("routes", "passes the via points in another order"),
    "any final heading": (
        "poses",
        "claims optimal, but the path is .* rad from the final heading.*leaves it free",
    ),
    "denies routes": ("routes", "claims infeasible, that no path exists; there is one, RSR RS, of"),
    "always optimal": ("discs", "claims optimal, but its path, RS, is 27.4 % longer.*claim LOCAL"),
    "needless turns": ("claims", "172 % longer.*turns by more than a full turn"),
    "infeasible": ("discs", "there is one, RL.*A path exists for every target"),
    "no path": ("claims", "it claims local and returns no path"),
    "high bound": ("claims", "lies above the shortest length.*must hold for the question itself"),
    "raises": ("outcome", "raised KeyError: 'the target is behind'.*Claim.FAILED"),
    "raises behind": ("outcome", "LinAlgError: Matrix is not positive definite"),
    "returns a dict": ("outcome", "solve returned dict; expected a Solution"),
    "crashes": ("outcome", "its process was ended by SIGABRT"),
    "hangs": ("outcome", "the limit is 1 s, beyond which 11.5 s were allowed.*look at `limit`"),
}
# class -> the check that finds its habit, and words of what it says
HABITS = {
    "Moves": ("state", "working directory"),
    "Tells": ("state", "it prints: iteration 1 of 1"),
    "Litters": ("state", "leaves files in the working directory: model.lp.*TemporaryDirectory"),
    "Shouts": ("state", "numpy's error handling.*np.errstate"),
    "Sets": ("state", "environment variables.*env="),
    "Leaves": ("state", "threads.*end your threads"),
    "Spawns": ("state", "child processes.*wait for your processes"),
    "Late": ("limits", "does not return within.*look at `limit`.*do not promise keeps_limit"),
    "Remembers": ("determinism", "keep nothing between questions"),
    "Keeps": ("symmetries", "its answer to an earlier question, all at once: does it keep answers"),
    "KeepsSets": (
        "routes",
        "its answer to an earlier question, 3 legs of 2 R to 4 R: does it keep.*order of via",
    ),
    "Gambles": ("determinism", "its answer differs by .*a generator of the solver's own"),
    "Unsure": ("loading", r"no licence server.*unavailable\(\) does not raise"),
    "Breaks": ("loading", "branches names 'LSLS'.*expected some of: best, LS"),
}


@pytest.fixture
def beside(monkeypatch):
    """Put the plug-ins' folders on the path.

    They are then found as if installed.
    """
    for name in ("plugin-honest", "plugin-lying"):
        monkeypatch.syspath_prepend(EXAMPLES / name / "src")


def text_of(result) -> str:
    """Text of a check's result, in one line."""
    return " ".join(f"{one.observed} {one.advice}" for one in result.findings)


def report_of(spec: str, check: str):
    """Report of one check and of `outcome`.

    `outcome` finds a solver that never answers.
    """
    before = [] if check == "limits" else ["outcome"]
    return check_solver(spec, checks=[*before, check], time_limit=1)


def failed(spec: str, check: str, words: str):
    """Report of a plug-in that fails one check.

    It has to fail for the reason that is said.
    """
    report = report_of(spec, check)
    assert not report.passed
    assert report[check].status is Status.FAIL, report
    assert re.search(words, text_of(report[check])), report
    return report


@pytest.mark.slow
@pytest.mark.parametrize("lie", LIES)
def test_every_lie_is_found_in_the_right_words(beside, lie):
    """Every lie is found in the right words.

    They say what was seen and what to do, with a command that asks again.
    """
    check, words = LIES[lie]
    report = failed(f"{LYING}/lies.py:Lying[lie={lie}]", check, words)

    for finding in report[check].findings:
        assert finding.command.startswith("dubins-study solve ")
        assert " --time-limit 1 --solver " in finding.command
        assert shlex.quote(report.solver) in finding.command


@pytest.mark.slow
@pytest.mark.parametrize("habit", HABITS)
def test_every_bad_habit_is_found_in_the_right_words(beside, habit):
    assert failed(f"{LYING}/habits.py:{habit}", *HABITS[habit]).solver


def test_every_lie_is_in_the_tables(beside):
    """Every lie is in the tables.

    A lie that no test expects would be found by nobody.
    """
    import lying_dubins
    from lying_dubins import habits

    classes = {name for name, kind in vars(habits).items() if isinstance(kind, type)}
    habit_classes = {name for name in classes if issubclass(getattr(habits, name), habits.Habit)}
    assert set(lying_dubins.LIES) - {"claimed time"} == set(LIES)
    assert habit_classes - {"Habit"} == set(HABITS)


@pytest.mark.slow
def test_what_does_no_harm_is_a_note(beside):
    report = report_of(f"{LYING}/lies.py:Lying[lie=claimed time]", "claims")

    assert report.passed, report
    assert report["claims"].status is Status.NOTE
    assert "is a length, not a travel time" in text_of(report["claims"])


@pytest.mark.slow
def test_an_exception_has_the_plugins_own_frames(beside):
    """An exception has the plug-in's own frames.

    They are the line that called the library and the library's own lines, and none of ours.
    """
    report = report_of(f"{LYING}/lies.py:Lying[lie=raises behind]", "outcome")
    trace = report["outcome"].findings[0].traceback

    assert "np.linalg.cholesky(-np.eye(2))" in trace
    assert "raise LinAlgError" in trace
    assert "reply.py" not in trace


@pytest.mark.slow
def test_a_command_of_a_finding_asks_the_same_question(beside):
    """It is copied from the report into a shell."""
    report = report_of(f"{LYING}/lies.py:Lying[lie=left is right]", "controls")
    [finding] = report["controls"].findings
    path = os.pathsep.join(
        str(EXAMPLES / name / "src") for name in ("plugin-honest", "plugin-lying")
    )
    command = finding.command.replace("dubins-study solve", "dubins_study solve --json", 1)
    process = subprocess.run(
        f"{sys.executable} -m {command}",
        shell=True,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": path},
    )
    answer = json.loads(process.stdout)

    assert answer["verdict"] == "misses"
    assert f"{answer['miss']:.3g} R from" in finding.observed


@pytest.mark.slow
def test_the_solver_in_eight_lines():
    """The solver in eight lines passes.

    It claims no more than it knows; where it finds nothing are notes.
    """
    lines = (EXAMPLES / "eight_lines.py").read_text().partition("class ")[2].splitlines()
    assert len([line for line in lines if line.strip()]) == 8

    report = check_solver(f"{EXAMPLES}/eight_lines.py:EightLines")

    assert report.passed, report
    assert report.answers["optimal"] > 25


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """An environment with both plug-ins installed.

    pip installs them offline, as a user would.
    """
    folder = tmp_path_factory.mktemp("installed")
    venv.create(folder / "env", with_pip=True, system_site_packages=True)
    libraries = os.pathsep.join(entry for entry in sys.path if "site-packages" in entry)
    options = ("--quiet", "--no-index", "--no-deps", "--no-build-isolation", "--target")
    pip = (folder / "env" / "bin" / "python", "-m", "pip", "--disable-pip-version-check", "install")
    for name in ("plugin-honest", "plugin-lying"):
        copy = folder / name
        shutil.copytree(EXAMPLES / name, copy)
        done = subprocess.run(
            [*pip, *options, folder / "site", copy],
            capture_output=True,
            text=True,
            env=os.environ | {"PYTHONPATH": libraries},
        )
        assert done.returncode == 0, done.stdout + done.stderr
    return {"PYTHONPATH": str(folder / "site")}


@pytest.mark.slow
def test_an_installed_plugin_is_one_of_the_solvers(installed, tmp_path):
    """Listed, checked, run and reported under its name."""
    commands = {
        "solvers": ("solvers",),
        "checked": ("check-solver", "two-arcs", "--json"),
        "run": ("run", "paper", "--solver", "two-arcs"),
        "report": ("report", "results/paper"),
    }
    shown = {
        name: output(finished(*words, cwd=tmp_path, **installed))
        for name, words in commands.items()
    }

    assert "two-arcs" in shown["solvers"]
    report = json.loads(shown["checked"])
    assert report["passed"]
    assert {check["name"] for check in report["checks"]} == set(CHECKS)
    assert (tmp_path / "results" / "paper" / "report" / "index.html").is_file()


@pytest.mark.slow
def test_the_tests_of_the_honest_plugin(installed, tmp_path):
    """The tests of the honest plug-in pass.

    They run as its author runs them: one test for each check.
    """
    shutil.copytree(EXAMPLES / "plugin-honest" / "tests", tmp_path / "tests")
    program = "import pytest; raise SystemExit(pytest.main(['-q', '-p', 'no:cacheprovider']))"
    shown = output(interpreted(program, cwd=tmp_path, **installed))

    assert f"{len(CHECKS) + 1} passed" in shown

"""Rules for every command.

Lists, new experiments and the audit are tested too.
"""

import json
import re

import pytest

from dubins_study import DubinsStudyError
from dubins_study.cli.terminal.output import Verbosity, set_verbosity, verbosity
from dubins_study.experiments.definition.experiment import packaged
from dubins_study.experiments.plan.run_plan import Request, plan_run
from dubins_study.report.paper import printed, routes
from tests.unit.cli.conftest import asked, line_of

PATH = ("solve", "10", "5")


@pytest.mark.parametrize("place", ["before", "after"])
@pytest.mark.parametrize("flag", ["-q", "--quiet", "-v", "--verbose"])
def test_quiet_and_verbose_are_options_of_every_command(flag, place):
    """Every command has the options quiet and verbose.

    They stand before the command's name or after it; the answer is the same.
    """
    words = (flag, *PATH) if place == "before" else (*PATH, flag)
    done = asked(*words)
    level = verbosity()
    set_verbosity(Verbosity.NORMAL)

    assert line_of("length", done.stdout) == line_of("length", asked(*PATH).stdout)
    assert level == (Verbosity.QUIET if "q" in flag else Verbosity.VERBOSE)


def test_one_solver_and_its_settings():
    text = asked("solvers", "turn-rate-qp[n=7]").stdout

    assert "n=7, " in text
    assert "best, LS, RS" in text
    [listed] = json.loads(asked("solvers", "ipopt", "--json").stdout)
    assert listed["settings"]["model"] == "words"


@pytest.mark.slow
def test_experiments():
    """Experiments that `run` knows by name.

    The list has what each asks, and how to use one's own.
    """
    listed = {each["name"]: each for each in json.loads(asked("experiments", "--json").stdout)}

    assert set(listed) == set(packaged())
    assert listed["paper"]["title"] == "The paper's five test problems"
    assert all(each["question"] and each["solvers"] for each in listed.values())
    shown = asked("experiments").stdout
    assert "The paper's five test problems" in shown
    assert "dubins-study new experiment my.toml" in shown
    assert "dubins-study run --scenarios my.csv --solver ipopt" in shown


@pytest.mark.parametrize("name", ["paper", "ladder", "convergence"])
def test_the_cells_of_an_experiment_are_those_of_a_run(name):
    """Counted without listing them, against the list."""
    [listed] = json.loads(asked("experiments", name, "--json").stdout)
    plan = plan_run(Request(name))

    assert listed["cells"] == len(plan.keys)
    assert listed["solvers"] == plan.solver_specs
    assert f"cells       {len(plan.keys)}" in asked("experiments", name).stdout


def test_a_new_experiment_is_one_that_runs(tmp_path, monkeypatch):
    """A new experiment is one that runs.

    Its commented keys are keys, its scenarios are what the comments say.
    """
    monkeypatch.chdir(tmp_path)
    done = asked("new", "experiment", "my-first.toml")

    assert done.exit_code == 0
    assert "dubins-study run my-first.toml" in done.stdout
    with pytest.raises(DubinsStudyError, match=r"my-first\.toml exists; expected the name of a"):
        asked("new", "experiment", "my-first.toml")
    plan = plan_run(Request("my-first.toml"))
    assert str(plan.folder) == "results/my-first"
    assert plan.experiment_file.experiment.title == "My first"
    scenarios = {cell.scenario for chain in plan.chains for cell in chain}
    assert len(scenarios) == 2 + 8 + 16
    assert len(plan.solver_specs) == 4
    text = (tmp_path / "my-first.toml").read_text()
    uncommented = re.sub(r"(?m)^# (?=(repeats|time_limit_s|memory_limit_gib|profile) =)", "", text)
    assert uncommented.count("# ") < text.count("# ")
    (tmp_path / "all.toml").write_text(uncommented)
    experiment = plan_run(Request("all.toml")).experiment_file.experiment
    assert (experiment.repeats, experiment.time_limit_s, experiment.profile) == (5, 10, "accurate")


def test_the_audit_is_the_committed_file():
    """The audit is the committed file.

    It is equal byte for byte, so that the command can write it.
    """
    done = asked("audit", "--json")
    folder = printed.files("dubins_study.report.paper")

    assert done.exit_code == 0
    assert done.stdout == folder.joinpath("audit.json").read_text(encoding="utf-8")
    shown = asked("audit").stdout
    assert "33 printed lengths: 26 correct rounding, 4 wrong" in shown
    assert "1.734999855" in shown


def test_a_contradiction_is_exit_code_1(monkeypatch):
    """A contradiction is exit code 1.

    The cell is shown on stderr; what was computed is printed all the same.
    """
    computed = asked("audit", "--json").stdout
    changed = json.loads(computed)
    changed["cells"][12].update(exact="0.79")
    monkeypatch.setattr(printed, "committed", lambda: changed)

    done = asked("audit", "--json")

    assert done.exit_code == 1
    assert done.stderr.startswith("dubins-study: the code contradicts the committed audit:")
    assert '-   "exact": "0.79"' in done.stderr
    assert '   "label": "problem 3"' in done.stderr
    assert done.stdout == computed


@pytest.mark.slow
def test_published_routes(monkeypatch):
    """Published routes are judged.

    The published length that is not the shortest is named; another verdict is exit code 1.
    """
    done = asked("audit", "kaya")
    records = json.loads(asked("audit", "kaya", "--json").stdout)

    assert done.exit_code == 0
    assert "MPDP, example 4: printed 7.46756219733842652175326293218, +1.54e-08" in done.stdout
    assert "example 1: RSL LSR RSR" in done.stdout
    assert len(records) == 8
    lines = (routes.PrintedRoute("here", "example 1", "3.5"),)
    monkeypatch.setattr(routes, "PRINTED_ROUTES", lines)
    done = asked("audit", "kaya")
    assert done.exit_code == 1
    assert "here, example 1: longer, not shortest" in done.stderr

"""What holds for every command: the nearest name in refusals, verbosity, lists."""

from __future__ import annotations

import json
import re

import pytest
from typer.testing import CliRunner

from dubins_study import DubinsStudyError
from dubins_study.cli.app import app
from dubins_study.cli.terminal.output import Verbosity, set_verbosity, verbosity
from dubins_study.experiments.definition.experiment import packaged
from dubins_study.experiments.plan.run_plan import Request, plan_run

PATH = ("solve", "10", "5")


def asked(*arguments):
    return CliRunner().invoke(app, arguments)


def line_of(name, text):
    return next(line for line in text.splitlines() if line.startswith(name))[12:]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ("--solver", "iptop"),
            "no solver named 'iptop'; did you mean 'ipopt'? choose one of: ana",
        ),
        (("--solver", "ipopt[modl=words]"), "no setting 'modl'; did you mean 'model'? it has: mod"),
        (("--solver", "ipopt[model=jiont]"), "is 'jiont'; did you mean 'joint'? expected one of: "),
        (("--solver", "turn-rate-qp[engine=piq]"), "is 'piq'; did you mean 'piqp'? expected one o"),
        (("--branch", "ls"), "no branch named 'ls'; did you mean 'LS'? choose one of: best, LS"),
        (("--profile", "acurate"), "no profile named 'acurate'; did you mean 'accurate'? choose"),
    ],
)
def test_the_nearest_name(arguments, message):
    with pytest.raises(DubinsStudyError) as refusal:
        CliRunner().invoke(app, (*PATH, *arguments), catch_exceptions=False)
    assert message in str(refusal.value)


@pytest.mark.parametrize("place", ["before", "after"])
@pytest.mark.parametrize("flag", ["-q", "--quiet", "-v", "--verbose"])
def test_quiet_and_verbose_are_options_of_every_command(flag, place):
    """Before the command's name or after it; the answer is the same."""
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


def test_experiments():
    """What `run` knows by name, what each asks, and how to use one's own."""
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
    """Its commented keys are keys, its scenarios are what the comments say."""
    monkeypatch.chdir(tmp_path)
    done = asked("new", "experiment", "my-first.toml")

    assert done.exit_code == 0
    assert "dubins-study run my-first.toml" in done.stdout
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


@pytest.mark.parametrize(
    ("name", "message"),
    [
        (
            "my.tml",
            "my.tml: expected a name of letters, .* that ends in .toml, such as",
        ),
        ("a b.toml", "a b.toml: expected a name of letters"),
        ("there.toml", "there.toml exists; expected the name of a new file"),
        ("no/where.toml", "cannot write no/where.toml: No such file or directory"),
    ],
)
def test_a_new_experiment_has_a_name_that_is_free(name, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "there.toml").write_text("mine")
    with pytest.raises(DubinsStudyError, match=message):
        CliRunner().invoke(app, ("new", "experiment", name), catch_exceptions=False)
    assert [file.name for file in tmp_path.iterdir()] == ["there.toml"]
    assert (tmp_path / "there.toml").read_text() == "mine"

"""Descriptions of solvers that load no foreign code."""

import os
import sys

import pytest

from dubins_study import run
from dubins_study.experiments.code_digest import code_digest
from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.solvers.registry import SolverError, canonical, load, registered

pytestmark = pytest.mark.smoke

PLUGIN = """
import os
from pathlib import Path
from dubins_study.solvers.paper_nlp.nlp import Slsqp
Path(__file__).with_name(f"loaded-{os.getpid()}").touch()
class Plain(Slsqp):
    pass
"""


@pytest.mark.parametrize("spec", [*registered(), "slsqp[count=3]"])
def test_our_own_are_described_as_they_are(spec):
    description = describe_solver(spec)
    solver = load(spec)

    assert description.spec == canonical(spec)
    assert description.code_digest == code_digest(spec)
    assert description.warm == solver.warm
    assert description.packages == solver.packages
    assert description.runs is None


def test_a_program_on_path_is_told():
    assert describe_solver("nlp[engine=couenne]").runs == "couenne"


def test_a_plugin_is_loaded_by_another_process(tmp_path):
    (tmp_path / "plain.py").write_text(PLUGIN)
    description = describe_solver(f"{tmp_path}/plain.py:Plain[count=2]")

    loaders = {file.name for file in tmp_path.glob("loaded-*")}
    assert description.settings["count"] == 2
    assert len(loaders) == 1
    assert f"loaded-{os.getpid()}" not in loaders
    assert not [name for name in sys.modules if name.startswith("dubins_study_plugin_plain")]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("import os; os._exit(3)", "while it was loaded, its process ended itself with code 3"),
        ("import os; os.abort()", "while it was loaded, its process was ended by SIGABRT"),
        ("class Own(BaseException): pass\nraise Own('x')", "cannot be described: Own: x"),
        ("X = 1", "is no solver; expected"),
    ],
)
def test_a_plugin_that_breaks_where_it_is_loaded_is_a_message(tmp_path, text, message):
    file = tmp_path / "broken.py"
    file.write_text(text)
    with pytest.raises(SolverError, match=message):
        describe_solver(f"{file}:X")


@pytest.mark.many(2)
@pytest.mark.parametrize(
    ("where", "spec"),
    [
        ("experiment", "{here}/plain.py:Plain"),
        ("block", "nlp[engine=touch]"),
        ("block", "slsqp[count={{2,3}}]"),
    ],
)
def test_an_experiment_does_not_choose_what_is_run(tmp_path, spec, where):
    """An experiment does not choose the code.

    It does if it is trusted. What the caller names himself always runs.
    """
    (tmp_path / "plain.py").write_text(PLUGIN)
    named = f'solvers = ["{spec.format(here=tmp_path)}"]\n'
    file = tmp_path / "theirs.toml"
    file.write_text(
        'title = "theirs"\nquestion = "?"\n'
        + (named if where == "experiment" else 'solvers = ["analytic"]\n')
        + "[[scenarios]]\ntarget_x = 3\ntarget_y = 1\n"
        + (named if where == "block" else "")
    )
    if spec.startswith("slsqp"):
        run(file, tmp_path / "out")
        return
    with pytest.raises(ExperimentError, match="expected --trust-plugins"):
        run(file, tmp_path / "out")

    assert not list(tmp_path.glob("loaded-*"))
    assert not (tmp_path / "out").exists()
    run(file, tmp_path / "out", trust_plugins=True)
    run(file, tmp_path / "own", solvers=[spec.format(here=tmp_path)])

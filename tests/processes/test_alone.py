"""Behaviour of a single interpreter.

Tested are what it loads, what it prints, and what a forked child of it can do.
"""

import os
import platform
import re
import subprocess
import sys
from pathlib import Path

import pytest

from dubins_study.experiments.solve import solve
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES
from dubins_study.solvers.export import export
from dubins_study.study.words import Claim, Outcome, Verdict
from tests.cases import PAPER
from tests.live_run import interpreted, output
from tests.unit.solvers.test_export import CASES, KINDS
from tests.unit.solvers.test_global_minlp import INSTALLED
from tests.unit.solvers.test_nlp_engines import ALONE

FORK = """
import os, numpy as np
from dubins_study.study.closed_form.kernel import shortest_rows
from dubins_study.study.closed_form.kernel_compile import SMALL
data = np.ones((6, SMALL))
before = shortest_rows(*data).length
child = os.fork()
if child == 0:
    os._exit(0 if (shortest_rows(*data).length == before).all() else 1)
raise SystemExit(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
"""


ASK_ALL = """
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load, registered
from dubins_study.asking.reply import ask
from dubins_study.study.scenario import Scenario

know_a_leg = {"analytic", "headings", "heading-grid", "heading-milp", "route-nlp"}
know_a_leg |= {"tour-circuit", "tour-milp", "tour-order", "tour-routing"}
for name in registered():
    if name not in know_a_leg:
        for branch in ("best", "LS"):
            ask(load(name), Question(Scenario(target_x=0.2, target_y=0.7), branch), 10.0)
"""


def loaded_by(program: str) -> set[str]:
    """Modules that a fresh interpreter holds after a program."""
    shown = output(interpreted(f"{program}\nimport sys; print(*sys.modules)"))
    return set(shown.splitlines()[-1].split())


@pytest.mark.smoke
def test_the_registry_imports_no_backend():
    """The registry imports no backend.

    Names can be listed without loading one backend or its libraries.
    """
    loaded = loaded_by("from dubins_study.solvers.registry import registered; assert registered()")

    assert not loaded & {"casadi", "cvxpy", "pyomo", "scipy", "numba", "pandas"}
    assert not {m for m in loaded if m.startswith("dubins_study.solvers.")} - {
        "dubins_study.solvers.registry",
        "dubins_study.solvers.protocol",
        "dubins_study.solvers.setting_checks",
    }


ONE_LEG = "from dubins_study.study.closed_form import pose; pose.pose_shortest(1, 2, 0, 1, 0)"
SOLVE = "from dubins_study import Scenario, solve; solve(Scenario(0, 0, 0, 10, 5, 1))"
PENALTY = "import dubins_study.solvers.stochastic.penalty as p; p.Penalty().unavailable()"


@pytest.mark.parametrize(
    ("program", "heavy"),
    [
        ("import dubins_study.cli.app", {"numpy", "pandas", "numba", "matplotlib"}),
        # numba takes longer to load than a solve, its judgement and its certificate
        (f"{SOLVE}; {ONE_LEG}", {"numba"}),
        (PENALTY, {"cma", "scipy.optimize"}),
    ],
)
def test_what_loads_nothing_heavy(program, heavy):
    assert not loaded_by(program) & heavy


@pytest.mark.slow
def test_every_public_name_is_there_when_asked_for():
    loaded_by("import dubins_study as d; [getattr(d, name) for name in d.__all__]")


@pytest.mark.slow
def test_a_run_without_streams_loads_no_numba(tmp_path):
    """A run without streams loads no numba.

    Rows are judged one at a time; the compiled kernels take half a second to load.
    """
    program = f"run('paper', {str(tmp_path / 'out')!r}, solvers=['slsqp'])"

    assert "numba" not in loaded_by(f"from dubins_study import run; {program}")


@pytest.mark.slow
def test_no_solver_but_the_closed_form_loads_the_answer_or_the_check():
    """Only the closed form loads answer or check.

    Other solvers do not, not even by an import that no source names, on a question without a path.
    """
    answers = ("dubins_study.study.closed_form", "dubins_study.study.check")

    assert [name for name in loaded_by(ASK_ALL) if name.startswith(answers)] == []


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slsqp", "ipopt", "nlopt-slsqp"])
def test_an_engine_loads_no_other_engines_package(name):
    """An engine loads no other engine's package.

    Of the packages of all engines, a question loads those of the engine that answers it.
    """
    packages = {package for entry in NLP_ENGINES for package in ENGINES[entry].packages}
    program = (
        "from dubins_study.solvers.registry import load;"
        "from dubins_study.solvers.protocol import Question;"
        "from dubins_study.study.scenario import Scenario;"
        f"solver = load('nlp[engine={name}]');"
        "solver.solve(solver.build(Question(Scenario(0, 0, 0.3, 3, 2, 1), 'LS')), 5.0)"
    )

    loaded = {module.partition(".")[0] for module in loaded_by(program)}
    assert loaded & packages == set(ENGINES[name].packages)


@pytest.mark.slow
@pytest.mark.parametrize("name", ALONE)
def test_an_engine_in_a_process_of_its_own(name):
    """An engine runs in a process of its own.

    It solves a word, by (4.12) and by multiple shooting; its library enters no other process.
    """
    for spec in (f"nlp[engine={name}]", f"multiple-shooting[engine={name},n=3]"):
        answer = solve(PAPER["problem 1"], spec, "RS", limit=10.0, isolated=True)

        assert answer.outcome is Outcome.RETURNED, answer.message
        assert (answer.claim, answer.verdict) == (Claim.LOCAL, Verdict.OPTIMAL)
    assert f"libcasadi_nlpsol_{name}" not in Path("/proc/self/maps").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("name", INSTALLED)
def test_a_process_that_asks_an_engine_prints_nothing(name):
    """Warnings too: pytest catches those of its own process."""
    question = "Question(Scenario(0, 0, 0, 3, 2, 1))"
    code = f"""
from dubins_study.asking.attempt import attempt
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.study.scenario import Scenario
assert attempt(load("disjunctive[engine={name}]"), {question}).outcome == "returned"
"""
    process = interpreted(code)

    assert (process.returncode, process.stdout, process.stderr) == (0, "", "")


@pytest.mark.slow
@pytest.mark.parametrize(("model", "format", "order"), KINDS)
def test_files_tell_nothing_of_the_machine(model, format, order, tmp_path):
    """Files tell nothing of the machine.

    Another process in another folder writes the same text, with no path of either in it.
    """
    text = export(CASES["problem 1"], model, format, order)
    call = (
        "from dubins_study.solvers.export import export;"
        "from dubins_study.study.scenario import Scenario; import math;"
        "problem = Scenario(0, 0, 2 * math.pi / 3, 10, 5, 1);"
        f"print(export(problem, {model!r}, {format!r}, {order!r}), end='')"
    )

    assert interpreted(call, cwd=tmp_path).stdout == text
    assert text.endswith("\n")
    assert not re.search(r"/\w+/\w|\\", text)  # `/all/` is GAMS's own
    assert platform.node() not in text.split()


COMPILED = """
import pandas as pd
from numba.core import event
from dubins_study import Scenario, solve, solve_frame
from dubins_study.asking.compile_loops import compile_loops
from dubins_study.study.closed_form.kernel_compile import SMALL

compile_loops()
compiled = event.install_recorder("numba:compile").__enter__()
for rows in (3, SMALL + 1):
    legs = pd.DataFrame({"target_x": [4.0] * rows, "target_y": 1.0, "radius": 1.0})
    legs = legs.assign(x=0.0, y=0.0, heading=0.0)
    for frame, word in ((legs, "RS"), (legs.assign(final_heading=1.0), "RSR")):
        for branch in ("best", word):
            solve_frame(frame, branch=branch)
solve(Scenario(target_x=9, target_y=1, via=[(1, 2), (3, 0)]))
print([each.data["dispatcher"].py_func.__qualname__ for _, each in compiled.buffer])
"""


@pytest.mark.smoke
def test_what_set_up_compiles_is_all():
    """Set-up compiles every loop.

    No frame of few or many rows, and no route, compiles a loop for another kind of array.
    """
    assert output(interpreted(COMPILED)).splitlines()[-1] == "[]"


SAID = """
from dubins_study import Scenario, solve
solve(Scenario(target_x=9, target_y=1, via=[(1, 2)]))
"""


@pytest.mark.slow
def test_a_call_says_what_it_compiles_and_compiles_no_more(tmp_path):
    """A call says what it compiles, and only that.

    A route compiles the search alone; asked again, it says nothing.
    """
    for expected in (
        ["compiling the search for routes: about 15 s, once after each installation"],
        [],
    ):
        done = interpreted(SAID, NUMBA_CACHE_DIR=str(tmp_path))
        assert done.stderr.splitlines() == expected


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")
def test_a_forked_child_can_go_on():
    """A forked child can go on.

    A child of a process whose loops ran in threads runs its own in threads.
    """
    assert subprocess.run([sys.executable, "-W", "ignore", "-c", FORK], check=False).returncode == 0

"""No solver's changed state shows in others' rows.

The solvers change what a process shares.
"""

import os
import re

import numpy as np
import pytest

from dubins_study.experiments.isolation.worker_process import Allowance
from dubins_study.experiments.plan import solver_description
from dubins_study.solvers.protocol import MAX_ARCS
from dubins_study.solvers.registry import SolverError
from tests.faults.experiments import experiment, lasting, rows
from tests.live_run import study
from tests.plugin_files import spec
from tests.plugins.hostile_state import STATES

TAINTING = spec("hostile_state", "Tainting")
WITNESS = spec("hostile_state", "Witness")
SOMETIMES = spec("hostile", "SomeTimes")
N = len(STATES)


@pytest.fixture(
    scope="module", params=[1, pytest.param(2, marks=pytest.mark.slow)], ids=lambda n: f"{n} jobs"
)
def tainted(request, tmp_path_factory):
    """A run of every changed state.

    Witnesses are in between, in a drawn order.
    """
    folder = tmp_path_factory.mktemp("tainted")
    asking = experiment(folder, ([TAINTING, SOMETIMES], N), ([WITNESS], 2 * N))
    options = ("--jobs", request.param, "--time-limit", 1, "--out", folder / "out")
    ended = study("run", asking, "--trust-plugins", *options)
    assert ended.code == 0, ended.err
    return ended, rows(folder / "out")


@pytest.mark.smoke
@pytest.mark.parametrize("name", STATES)
def test_the_witness_would_see_it(name):
    """The witness sees each change.

    Each change, made in a process of its own, is told apart from its absence.
    """
    change, changed = STATES[name]
    child = os.fork()
    if child == 0:
        code = 9
        try:
            before = changed()
            change()
            code = 0 if changed() and not before else 1
        finally:
            os._exit(code)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0


@pytest.mark.slow
def test_every_row_is_there(tainted):
    ended, found = tainted

    assert found["plugin"].value_counts().to_dict() == {
        "Tainting": N,
        "SomeTimes": N,
        "Witness": 2 * N,
    }
    assert ended.alive == []


def test_who_changes_things_is_still_judged(tainted):
    table = tainted[1]
    table = table[table["plugin"] == "Tainting"]

    assert set(table["outcome"]) == {"returned"}, set(table["message"])
    assert set(table["verdict"]) == {"optimal"}


def test_nobody_else_notices(tainted):
    table = tainted[1]
    table = table[table["plugin"] == "Witness"]

    assert set(table["message"]) == {""}
    assert set(table["verdict"]) == {"optimal"}


def test_one_that_dies_now_and_then_dies_exactly_there(tainted):
    table = tainted[1]
    table = table[table["plugin"] == "SomeTimes"].sort_values("target_x")
    dies = [round(x * 1000) % 3 == 0 for x in np.linspace(2.0, 9.0, N)]

    assert 0 < sum(dies) < N
    assert list(table["outcome"]) == ["crashed" if dead else "returned" for dead in dies]
    assert list(table["native_status"] == "SIGABRT") == dies


@pytest.mark.slow
def test_a_path_of_as_many_arcs_as_allowed_is_a_row_like_any_other(tmp_path, clean):
    huge = spec("hostile_answers", "Huge", pieces=MAX_ARCS // 2)
    asking = experiment(tmp_path, ([huge], 1), ([spec("honest", "Honest")], 8))
    ended = study("run", asking, "--trust-plugins", "--out", tmp_path / "out", "--jobs", 2)

    assert ended.code == 0, ended.err
    table = rows(tmp_path / "out").sort_values("plugin")
    assert len(table) == 9
    assert table["curvatures"].iloc[-1].size == MAX_ARCS
    assert set(table["verdict"]) == {"optimal"}
    assert lasting(table[table["plugin"] == "Honest"]).equals(lasting(clean))


# What a plug-in does as its file is read or its class is made, always and in workers only.
LINES = {
    "raises": "raise OSError('no library')",
    "exits": "raise SystemExit(5)",
    "dies": "os.abort()",
    "leaves": "os._exit(0)",
}
PLUGIN = """
import os, sys
from dubins_study.solvers.analytic import Analytic
{imported}
class Plugin(Analytic):
    def __init__(self):
        {made}
"""


BEFORE = [
    pytest.param(what, where, marks=[pytest.mark.slow] * (what != "dies"))
    for what in LINES
    for where in ("imported", "made")
]


@pytest.mark.many(1)
@pytest.mark.parametrize(("what", "where"), BEFORE)
def test_plugins_that_go_wrong_before_they_are_asked(tmp_path, clean, what, where):
    """Plug-ins that go wrong early are refused.

    They are refused with one message, or have a row of each cell. A run never dies or hangs.
    """
    lines = {"imported": "", "made": "pass"} | {where: LINES[what]}
    file = tmp_path / "plugin.py"
    file.write_text(PLUGIN.format(**lines))
    refused(tmp_path, file, clean)


def refused(folder, file, clean):
    honest = spec("honest", "Honest")
    asking = experiment(folder, ([f"{file}:Plugin"], 1), ([honest], 8))
    ended = study("run", asking, "--trust-plugins", "--out", folder / "out", "--time-limit", 1)

    assert ended.alive == []
    assert "Traceback" not in ended.err
    if ended.code == 2:
        assert re.search(r"^dubins-study: .*plugin\.py", ended.err, re.MULTILINE), ended.err
        assert not (folder / "out").exists()
        return
    assert ended.code == 0, (ended.code, ended.err)
    table = rows(folder / "out")
    assert len(table) == 9
    assert set(table[table["plugin"] == "Plugin"]["outcome"]) <= {
        *("unavailable", "crashed", "raised", "timeout", "returned")
    }
    assert lasting(table[table["plugin"] == "Honest"]).equals(lasting(clean))


def test_a_plugin_that_never_ends_to_load_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(solver_description, "_LOADING", Allowance(2.0, activity="loading it"))
    file = tmp_path / "plugin.py"
    file.write_text("while True: pass")

    with pytest.raises(SolverError, match="while it was loaded, stopped after 2 s of loading it"):
        solver_description.describe_solver(f"{file}:Plugin")


@pytest.mark.slow
@pytest.mark.parametrize("what", ["dies", "raises"])
def test_plugins_that_go_wrong_only_in_a_worker(tmp_path, clean, what):
    """Plug-ins that fail only in a worker give rows.

    The class was read once without harm; then each of its cells is a row.
    """
    file = tmp_path / "plugin.py"
    seen = tmp_path / "seen"
    guard = f"if os.path.exists({str(seen)!r}): {LINES[what]}\nopen({str(seen)!r}, 'w').close()"
    file.write_text(PLUGIN.format(imported=guard, made="pass"))
    refused(tmp_path, file, clean)


@pytest.mark.smoke
def test_state_of_the_caller_is_left_alone(tmp_path):
    """The caller's state is left alone.

    A run from Python changes nothing of the process that asks for it.
    """
    from dubins_study import run

    before = os.getcwd(), dict(os.environ), np.geterr()  # noqa: PTH109
    changes = {name for name, (_, changed) in STATES.items() if changed()}  # pytest's alarm, say
    asking = experiment(tmp_path, ([TAINTING], N))
    run(asking, tmp_path / "out", time_limit=5, trust_plugins=True)

    assert (os.getcwd(), dict(os.environ), np.geterr()) == before  # noqa: PTH109
    assert {name for name, (_, changed) in STATES.items() if changed()} == changes
    assert changes <= {"alarm"}

"""One solver's process never affects others' rows."""

import os
import signal

import pytest

from dubins_study import Scenario, load_results, run
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import AHEAD_S, Job, WorkerPool
from dubins_study.experiments.store.folder import read_rows
from dubins_study.solvers.protocol import Question

PLUGINS = """
import os
import scipy.optimize
from dubins_study.solvers.analytic import Analytic
KEPT = []
class Patches(Analytic):
    def solve(self, model, limit):
        scipy.optimize.minimize = None
        return super().solve(model, limit)
class Slips(Analytic):
    def solve(self, model, limit):
        if os.fork() == 0:
            os.execv("/nonexistent", ["x"])  # the child falls out of solve
        os.wait()
        return super().solve(model, limit)
class Forgets(Analytic):
    def solve(self, model, limit):
        solution = super().solve(model, limit)
        os.fork()  # both go on
        return solution
class Leaks(Analytic):
    def solve(self, model, limit):
        KEPT.append(bytearray(150 * 2**20))
        return super().solve(model, limit)
class OpensFiles(Analytic):
    def solve(self, model, limit):
        KEPT.extend(open(os.devnull) for _ in range(40))
        return super().solve(model, limit)
"""
# libraries for tests with time (freezegun) replace the clocks in every module that is loaded
CLOCKS = """
import itertools, sys, time
from dubins_study.solvers.analytic import Analytic
def replace(name, values):
    clock = itertools.cycle(values).__next__
    for module in list(sys.modules.values()):
        if name in vars(module) and module is not time:
            setattr(module, name, clock)
class Backwards(Analytic):
    def solve(self, model, limit):
        time.sleep(0.2)  # so that the machine's speed is measured meanwhile
        replace("perf_counter", [5.0, 3.0, 1.0])
        return super().solve(model, limit)
"""
TEXT = """
title = "isolation"
question = "?"
solvers = ["slsqp"]
time_limit_s = 2
memory_limit_gib = 1.0
repeats = 6
[[scenarios]]
target_x = 3
target_y = [1, 2]
"""


def asked(folder, plugins, name, *others):
    """Results folder of a run with a plug-in.

    Other solvers are in the run too.
    """
    (folder / "plugins.py").write_text(plugins)
    (folder / "isolation.toml").write_text(TEXT)
    spec = f"{folder}/plugins.py:{name}"
    return run(folder / "isolation.toml", folder / "out", solvers=[spec, *others])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Patches", "Slips", "Forgets", "Leaks", "OpensFiles"])
def test_every_row_is_right(tmp_path, name):
    rows = read_rows(asked(tmp_path, PLUGINS, name, "slsqp")).to_pandas()

    assert len(rows) == 24
    assert set(rows["outcome"]) == {"returned"}
    assert set(rows["verdict"]) == {"optimal"}


@pytest.mark.slow
def test_times_that_cannot_be_are_refused(tmp_path):
    """Impossible times are refused.

    The row is `raised`, and the rows of others can be read and compared.
    """
    rows = load_results(asked(tmp_path, CLOCKS, "Backwards", "slsqp"))
    assert set(rows[rows["solver"] == "slsqp"]["outcome"]) == {"returned"}
    refused = rows[rows["solver"] != "slsqp"]
    assert len(refused) == 12
    assert set(refused["outcome"]) == {"raised"}
    assert refused["message"].str.contains("_s is ").all(), set(refused["message"])


HELD_UP = """
import os, time
from dataclasses import replace
from dubins_study.solvers.analytic import Analytic
class HeldUp(Analytic):
    def solve(self, model, limit):
        if model.scenario.label == "slow":
            time.sleep(1)
        solution = super().solve(model, limit)
        return replace(solution, message=str(os.getpid()))
"""


@pytest.fixture
def jobs(tmp_path):
    """Jobs of a solver that names its process.

    It is slow where the label says so.
    """
    (tmp_path / "held_up.py").write_text(HELD_UP)

    def ask(*labels):
        scenarios = [Scenario(target_x=3, target_y=1, label=label) for label in labels]
        spec = f"{tmp_path}/held_up.py:HeldUp"
        return [Job(spec, "default", Question(scenario), 10.0) for scenario in scenarios]

    return ask


@pytest.mark.smoke
def test_one_slow_solve_does_not_end_working_ahead(jobs):
    """One slow solve does not end working ahead.

    Soon after it a solve is expected to be quick again.
    """
    asked = jobs("slow", *["quick"] * 60)
    with WorkerPool(1) as pool:
        answered = sum(map(len, pool.solve(asked, Interruption())))

    assert answered == 61
    assert pool._expected_s[asked[0].solver_key] < AHEAD_S


@pytest.mark.smoke
def test_a_worker_killed_between_two_jobs_costs_no_row(jobs):
    with WorkerPool(1) as pool:
        for _ in range(5):
            [[(_, answer)]] = filter(None, pool.solve(jobs("quick"), Interruption()))
            assert answer.outcome == "returned"
            os.kill(int(answer.solution.message), signal.SIGKILL)

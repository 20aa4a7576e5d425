"""One solver's process never affects others' rows."""

import os
import signal

import pytest

from dubins_study import Scenario, load_results, run
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import AHEAD_S, Job, WorkerPool
from dubins_study.experiments.store.folder import read_rows
from dubins_study.solvers.protocol import Question
from tests.plugin_files import spec

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


def asked(folder, name):
    """Results folder of a run with a careless plug-in.

    slsqp is in the run too.
    """
    (folder / "isolation.toml").write_text(TEXT)
    solvers = [spec("careless", name), "slsqp"]
    return run(folder / "isolation.toml", folder / "out", solvers=solvers)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["Patches", "Slips", "Forgets", "Leaks", "OpensFiles"])
def test_every_row_is_right(tmp_path, name):
    rows = read_rows(asked(tmp_path, name)).to_pandas()

    assert len(rows) == 24
    assert set(rows["outcome"]) == {"returned"}
    assert set(rows["verdict"]) == {"optimal"}


@pytest.mark.slow
def test_times_that_cannot_be_are_refused(tmp_path):
    """Impossible times are refused.

    The row is `raised`, and the rows of others can be read and compared.
    """
    rows = load_results(asked(tmp_path, "Backwards"))
    assert set(rows[rows["solver"] == "slsqp"]["outcome"]) == {"returned"}
    refused = rows[rows["solver"] != "slsqp"]
    assert len(refused) == 12
    assert set(refused["outcome"]) == {"raised"}
    assert refused["message"].str.contains("_s is ").all(), set(refused["message"])


@pytest.fixture
def jobs():
    """Jobs of a solver that names its process.

    It is slow where the label says so.
    """

    def ask(*labels):
        scenarios = [Scenario(target_x=3, target_y=1, label=label) for label in labels]
        held_up = spec("careless", "HeldUp")
        return [Job(held_up, "default", Question(scenario), 10.0) for scenario in scenarios]

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

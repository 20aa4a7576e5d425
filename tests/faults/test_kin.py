"""Solvers and others that kill processes around them."""

import os
import signal
import time

import pytest

from tests.faults.experiments import experiment, lasting, rows
from tests.live_run import started, wait_for
from tests.marked import left_behind
from tests.plugin_files import spec

HONEST = spec("honest", "Honest")


def noted(file):
    """Process ids that a plug-in wrote so far."""
    return [int(line) for line in file.read_text().split()] if file.exists() else []


def slow_run(folder, nap, count, file="pids"):
    napping = spec("honest", "Napping", nap=nap, note=folder / file)
    return experiment(folder, ([napping], count), ([HONEST], 8)), folder / file


@pytest.mark.slow
@pytest.mark.parametrize(
    ("number", "limit", "nap", "outcome", "status"),
    [
        (signal.SIGKILL, 20, 1.0, "crashed", "SIGKILL"),
        (signal.SIGSTOP, 2, 0.7, "timeout", ""),  # killed at the limit
    ],
)
def test_a_worker_that_gets_a_signal_from_outside_is_one_row(
    tmp_path, clean, number, limit, nap, outcome, status
):
    """A worker that gets a signal is one row.

    The row is of the cell that it was at; the others know nothing of it.
    """
    asking, file = slow_run(tmp_path, nap, 4)
    options = ("--out", tmp_path / "out", "--jobs", 2, "--time-limit", limit)
    with started("run", asking, "--trust-plugins", *options) as run:
        os.kill(wait_for(lambda: noted(file), run)[0], number)
        ended = run.wait()

    assert ended.code == 0, ended.err
    assert ended.alive == []
    every = rows(tmp_path / "out")
    assert lasting(every[every["plugin"] == "Honest"]).equals(lasting(clean))
    naps = every[every["plugin"] == "Napping"]
    assert sorted(naps["outcome"]) == sorted([outcome, "returned", "returned", "returned"])
    assert set(naps[naps["outcome"] == outcome]["native_status"]) == {status}


@pytest.mark.slow
def test_a_run_that_is_stopped_for_a_while_refuses_no_honest_time(tmp_path):
    """A stopped run refuses no honest time.

    Solves go on while the run stands still, so they take longer than the run saw pass.
    """
    asking, file = slow_run(tmp_path, 0.7, 6)
    options = ("--out", tmp_path / "out", "--time-limit", 20)
    with started("run", asking, "--trust-plugins", *options) as run:
        for naps in (1, 3):
            wait_for(lambda naps=naps: len(noted(file)) >= naps, run)
            os.kill(run.process.pid, signal.SIGSTOP)
            time.sleep(1.5)
            os.kill(run.process.pid, signal.SIGCONT)
        ended = run.wait()

    assert ended.code == 0, ended.err
    assert set(rows(tmp_path / "out")["outcome"]) == {"returned"}


@pytest.mark.slow
def test_an_idle_worker_killed_from_outside_costs_no_row(tmp_path):
    """Idle workers killed from outside cost no row.

    Every process of the run but the first is killed in between; whatever they did, each cell has
    one row.
    """
    asking, file = slow_run(tmp_path, 0.3, 12)
    options = ("--out", tmp_path / "out", "--jobs", 2, "--time-limit", 20)
    with started("run", asking, "--trust-plugins", *options) as run:
        for n in (1, 4, 8):
            wait_for(lambda n=n: len(noted(file)) >= n or run.process.poll() is not None)
            for process in run.workers():
                process.kill()
        ended = run.wait()

    assert ended.code == 0, ended.err
    table = rows(tmp_path / "out")
    assert len(table) == 20
    assert not table.duplicated(["solver", "target_x", "label"]).any()
    assert set(table["outcome"]) <= {"returned", "crashed"}
    assert set(table[table["outcome"] == "returned"]["verdict"]) == {"optimal"}
    assert ended.alive == []


@pytest.mark.parametrize("name", ["OwnSession", pytest.param("Stopped", marks=pytest.mark.slow)])
def test_workers_die_with_their_supervisor(tmp_path, name):
    """Workers die with their supervisor.

    Only the supervisor is killed, and its workers answer to nobody.
    """
    napping = spec("honest", "Napping", nap=600, note=tmp_path / "pids")
    asking = experiment(tmp_path, ([spec("hostile_endless", name), napping], 1))
    options = ("--jobs", 2, "--time-limit", 600, "--out", tmp_path / "out")
    with started("run", asking, "--trust-plugins", *options) as run:
        # the napping one is under way; a moment later the hostile one beside it is as well
        wait_for(lambda: noted(tmp_path / "pids"), run)
        time.sleep(1.0)
        assert len(run.workers()) >= 2
        os.kill(run.process.pid, signal.SIGKILL)
        run.process.wait()
        assert left_behind(run.mark) == []

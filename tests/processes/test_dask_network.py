"""Dask's machines: permitted workers and their ends.

Nothing is left of them.
"""

import os
import shutil
import signal
import time
from pathlib import Path

import pytest

pytest.importorskip("distributed", reason="Dask's distributed is not installed")

from dubins_study import run
from dubins_study.experiments.isolation.pool import RunError
from dubins_study.experiments.store.folder import done, read_rows
from tests import dask_here as here
from tests.live_run import finished, started, wait_for
from tests.marked import wait_until_handled
from tests.plugin_files import copied

ROOT = Path(__file__).parents[2]
EXPERIMENT = """
title = "machines"
question = "who is asked?"
solvers = ["slsqp[presolve=true]"]
[[scenarios]]
target_x = { linear = [1, 9, 30] }
target_y = 3
"""

pytestmark = pytest.mark.slow


@pytest.fixture
def experiment(tmp_path):
    file = tmp_path / "machines.toml"
    file.write_text(EXPERIMENT)
    return str(file)


def solving(worker):
    """Fork server of a worker and its processes."""
    return [p for p in here.family(worker.pid) if "fork_server" in " ".join(p.cmdline())]


def test_a_cluster_of_users_own_is_found_by_its_address(experiment, tmp_path):
    """A user's own cluster is found by address.

    Its nannies' workers are daemons, which may have no children by themselves; they have two
    threads.
    """
    one = run(experiment, tmp_path / "one")
    with here.scheduler(tmp_path) as address, here.worker(address, "--nthreads", "2") as worker:
        other = here.asked_of(address, experiment, tmp_path / "other")
        assert set(read_rows(other, ["jobs"])["jobs"].to_pylist()) <= {1, 2}
        assert set(read_rows(other, ["executor"])["executor"].to_pylist()) == {"dask"}
        # the run is over: no solver's process is left in the cluster, which lives on
        assert len(solving(worker)) == 1  # the fork server itself

    here.assert_same(one, other)


def test_a_worker_that_comes_late_is_waited_for(experiment, tmp_path, caplog):
    steps = []
    with here.scheduler(tmp_path) as address:
        late = []

        def come(done, total):
            steps.append(done)
            if not late:
                late.append(here.worker(address, "--nthreads", "1"))
                late[0].__enter__()

        try:
            here.asked_of(address, experiment, tmp_path / "out", progress=come)
        finally:
            late[0].__exit__(None, None, None)

    assert steps[-1] == 30
    waiting = [line for line in caplog.messages if "has no workers" in line]
    assert waiting == ["dubins-study: the Dask scheduler has no workers; waiting for the first"]


def test_other_code_is_refused(experiment, tmp_path):
    """Other code is refused.

    A worker whose dubins-study is of another version makes no row.
    """
    copy = tmp_path / "copy"
    shutil.copytree(ROOT / "src" / "dubins_study", copy / "dubins_study")
    with (copy / "dubins_study" / "solvers" / "paper_nlp" / "nlp.py").open("a") as file:
        file.write("\nLATER_VERSION = True\n")
    with (
        here.scheduler(tmp_path) as address,
        here.worker(address, "--nthreads", "1", PYTHONPATH=str(copy)),
        pytest.raises(
            RunError, match=r"the code of slsqp\[presolve=True\] is not what was asked: .* and is"
        ),
    ):
        here.asked_of(address, experiment, tmp_path / "out")
    assert done(tmp_path / "out") == set()


def test_workers_without_our_packages_are_told(experiment, tmp_path):
    """Workers without our packages are named.

    A package of the same name, which has nothing to offer, stands in for ours.
    """
    (tmp_path / "copy" / "dubins_study").mkdir(parents=True)
    (tmp_path / "copy" / "dubins_study" / "__init__.py").touch()
    with (
        here.scheduler(tmp_path) as address,
        here.worker(address, "--nthreads", "1", PYTHONPATH=str(tmp_path / "copy")),
        pytest.raises(RunError, match=r"^dubins-study is not on a Dask worker, or of"),
    ):
        here.asked_of(address, experiment, tmp_path / "out")


def test_a_plugin_that_is_not_there_is_told(experiment, tmp_path):
    """A missing plug-in is named.

    A relative path means another file where the worker has another folder.
    """
    copied("slow", tmp_path)
    before = Path.cwd()
    with here.scheduler(tmp_path) as address, here.worker(address, "--nthreads", "1"):
        os.chdir(tmp_path)
        try:
            with pytest.raises(
                RunError, match=r"slow\.py:Telling is not what was asked: .* does not load"
            ):
                here.asked_of(address, experiment, tmp_path / "out", solvers=["slow.py:Telling"])
        finally:
            os.chdir(before)


def test_a_scheduler_that_does_not_answer(experiment, tmp_path):
    arguments = ("--executor", "dask", "--scheduler", "tcp://127.0.0.1:1")
    refused = finished("run", experiment, *arguments, "--out", tmp_path / "out")

    assert refused.returncode == 2
    assert refused.stderr.startswith(
        "dubins-study: no Dask scheduler answers at 'tcp://127.0.0.1:1' ("
    )
    assert (refused.stderr.count("\n"), refused.stdout) == (1, "")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("signals", [1, 2])
def test_ctrl_c(experiment, tmp_path, signals):
    """Ctrl-C finishes a solve; twice, it stops.

    No solver and no noise is left.
    """
    spec = f"{copied('slow', tmp_path)}:Telling"
    nap = "0.5" if signals == 1 else "1000"
    with (
        here.scheduler(tmp_path) as address,
        here.worker(address, "--nthreads", "2", NAP=nap) as worker,
    ):
        options = ("--executor", "dask", "--scheduler", address, "--time-limit", "4000")
        out = tmp_path / "out"
        with started("run", experiment, *options, "--solver", spec, "--out", out) as live:
            wait_for(lambda: (tmp_path / "asked").exists())
            began = time.monotonic()
            for _ in range(signals):
                os.killpg(live.process.pid, signal.SIGINT)
                wait_until_handled(live.process.pid, signal.SIGINT)
            ended = live.wait()
        wait_for(lambda: len(solving(worker)) == 1)  # the fork server itself

    count = len(done(out))
    assert ended.code == 130, ended.err
    assert time.monotonic() - began < 300  # long before the nap is over, on a busy machine too
    assert f"interrupted; {count} of 30 cells are done and kept; run the same command" in ended.err
    assert (0 < count < 30) if signals == 1 else count == 0
    assert "Traceback" not in ended.err
    assert "distributed" not in ended.err
    assert ended.out == ""

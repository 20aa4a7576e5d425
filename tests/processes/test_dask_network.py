"""Dask's machines: who may be asked, over which lines, and what is left of them."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path

import psutil
import pytest

pytest.importorskip("distributed", reason="Dask's distributed is not installed")

import dask_here as here
from live_run import TELLS_AND_NAPS, finished, started, wait_for
from marked import wait_until_handled

from dubins_study import run
from dubins_study.experiments.executors.dask_cluster import local_cluster
from dubins_study.experiments.isolation.pool import RunError
from dubins_study.experiments.store.folder import done, read_rows

ROOT = Path(__file__).parents[2]
EXPERIMENT = """
title = "machines"
question = "who is asked?"
solvers = ["slsqp"]
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


def test_a_cluster_of_users_own_is_found_by_its_address(experiment, tmp_path):
    """Its nannies' workers are daemons, which may have no children by themselves; two threads."""
    one = run(experiment, tmp_path / "one")
    with here.scheduler(tmp_path) as address, here.worker(address, "--nthreads", "2") as worker:
        other = here.asked_of(address, experiment, tmp_path / "other")
        assert set(read_rows(other, ["jobs"])["jobs"].to_pylist()) <= {1, 2}
        assert set(read_rows(other, ["executor"])["executor"].to_pylist()) == {"dask"}
        # the run is over: no solver's process is left in the cluster, which lives on
        forks = [p for p in here.family(worker.pid) if "fork_server" in " ".join(p.cmdline())]
        assert len(forks) == 1  # the server itself

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


def test_nothing_listens_beyond_the_loopback():
    """Scheduler, workers and their pages, as they are while a run is on."""
    with local_cluster(2) as host:
        processes_before = [
            p for p in psutil.Process().children() if "dask_cluster" in " ".join(p.cmdline())
        ]
        processes = here.family(processes_before[0].pid)
        addresses = [
            connection.laddr.ip
            for process in processes
            for connection in process.net_connections("inet")
            if connection.status == psutil.CONN_LISTEN
        ]
        assert host.address.startswith("tcp://127.0.0.1:")
        assert host.dashboard.startswith("http://127.0.0.1:")

    assert len(addresses) >= 4  # scheduler and its page, two workers and their nannies
    assert set(addresses) == {"127.0.0.1"}
    wait_for(lambda: here.gone([process.pid for process in processes]))


def test_other_code_is_refused(experiment, tmp_path):
    """A worker whose dubins-study is of another version makes no row."""
    copy = tmp_path / "copy"
    shutil.copytree(ROOT / "src" / "dubins_study", copy / "dubins_study")
    with (copy / "dubins_study" / "solvers" / "paper_nlp" / "slsqp.py").open("a") as file:
        file.write("\n# a later version\n")
    with (
        here.scheduler(tmp_path) as address,
        here.worker(address, "--nthreads", "1", PYTHONPATH=str(copy)),
        pytest.raises(RunError, match=r"the code of slsqp is not what was asked: .* and is"),
    ):
        here.asked_of(address, experiment, tmp_path / "out")
    assert done(tmp_path / "out") == set()


def test_workers_without_our_packages_are_told(experiment, tmp_path):
    """What stands in for them is a package of the same name that has nothing to offer."""
    (tmp_path / "copy" / "dubins_study").mkdir(parents=True)
    (tmp_path / "copy" / "dubins_study" / "__init__.py").touch()
    with (
        here.scheduler(tmp_path) as address,
        here.worker(address, "--nthreads", "1", PYTHONPATH=str(tmp_path / "copy")),
        pytest.raises(RunError, match=r"^dubins-study is not on a Dask worker, or of"),
    ):
        here.asked_of(address, experiment, tmp_path / "out")


def test_a_plugin_that_is_not_there_is_told(experiment, tmp_path):
    """A relative path means another file where the worker has another folder."""
    (tmp_path / "slow.py").write_text(TELLS_AND_NAPS)
    before = Path.cwd()
    with here.scheduler(tmp_path) as address, here.worker(address, "--nthreads", "1"):
        os.chdir(tmp_path)
        try:
            with pytest.raises(
                RunError, match=r"slow\.py:Slow is not what was asked: .* does not load"
            ):
                here.asked_of(address, experiment, tmp_path / "out", solvers=["slow.py:Slow"])
        finally:
            os.chdir(before)


def test_a_scheduler_that_does_not_answer(experiment, tmp_path):
    arguments = ("--engine", "dask", "--scheduler", "tcp://127.0.0.1:1")
    refused = finished("run", experiment, *arguments, "--out", tmp_path / "out")

    assert refused.returncode == 2
    assert refused.stderr.startswith(
        "dubins-study: no Dask scheduler answers at 'tcp://127.0.0.1:1' ("
    )
    assert (refused.stderr.count("\n"), refused.stdout) == (1, "")
    assert not (tmp_path / "out").exists()


def slow_run(folder: Path, experiment: str) -> list[object]:
    """Arguments of a run by Dask of a solver that naps, and says that it is asked."""
    (folder / "slow.py").write_text(TELLS_AND_NAPS)
    solver = f"{folder}/slow.py:Slow"
    engine = ("--engine", "dask", "--jobs", "2", "--time-limit", "4000")
    return ["run", experiment, *engine, "--solver", solver, "--out", folder / "out"]


@pytest.mark.parametrize("signals", [1, 2])
def test_ctrl_c(experiment, tmp_path, signals):
    """Once: what is being solved is finished. Twice: at once. No process and no noise is left."""
    nap = "0.5" if signals == 1 else "1000"
    with started(*slow_run(tmp_path, experiment), NAP=nap) as process:
        wait_for(lambda: (tmp_path / "asked").exists())
        processes_before = [one.pid for one in here.family(process.pid)]
        assert len(processes_before) > 5
        began = time.monotonic()
        for _ in range(signals):
            os.killpg(process.pid, signal.SIGINT)
            wait_until_handled(process.pid, signal.SIGINT)
        printed, err = process.communicate(timeout=120)
        wait_for(lambda: here.gone(processes_before))

    kept = len(done(tmp_path / "out"))
    assert process.returncode == 130, err
    assert time.monotonic() - began < 300  # long before the nap is over, on a busy machine too
    assert f"interrupted; what was done is kept, run the same command to go on ({kept} of" in err
    assert (0 < kept < 30) if signals == 1 else kept == 0
    assert "Traceback" not in err
    assert "distributed" not in err
    assert printed == ""


def test_nothing_outlives_a_run_that_is_killed(experiment, tmp_path):
    """Its cluster, their fork servers and their solvers end by themselves."""
    with started(*slow_run(tmp_path, experiment), NAP="3600") as process:
        wait_for(lambda: (tmp_path / "asked").exists())
        processes_before = [one.pid for one in here.family(process.pid)]
        process.kill()
        wait_for(lambda: here.gone(processes_before))


def certificates(folder: Path) -> dict[str, str]:
    """Files of an authority and of one certificate by it for all."""
    ca, key, request, certificate = (folder / f"{n}.pem" for n in ("ca", "key", "request", "cert"))
    ca_key = folder / "ca-key.pem"
    new = ("openssl", "req", "-newkey", "rsa:2048", "-nodes")
    by = ("openssl", "x509", "-req", "-in", request, "-CA", ca, "-CAkey", ca_key, "-days", "1")
    for command in (
        (*new, "-subj", "/CN=study-ca", "-x509", "-days", "1", "-keyout", ca_key, "-out", ca),
        (*new, "-subj", "/CN=study", "-keyout", key, "-out", request),
        (*by, "-CAcreateserial", "-out", certificate),
    ):
        subprocess.run(command, check=True, capture_output=True)
    return {"ca-file": str(ca), "cert": str(certificate), "key": str(key)}


@pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl makes the certificates")
def test_over_tls(experiment, tmp_path):
    """With Dask's own configuration; without certificates nobody is let in."""
    import dask

    files = certificates(tmp_path)
    options = [word for name, file in files.items() for word in (f"--tls-{name}", file)]
    known = {
        "distributed.comm.tls.ca-file": files["ca-file"],
        "distributed.comm.tls.client.cert": files["cert"],
        "distributed.comm.tls.client.key": files["key"],
    }
    one = run(experiment, tmp_path / "one")
    with here.scheduler(tmp_path, "--protocol", "tls", *options) as address:
        assert address.startswith("tls://")
        with pytest.raises(RunError, match="no Dask scheduler answers at 'tls://"):
            here.asked_of(address, experiment, tmp_path / "refused")
        with here.worker(address, "--nthreads", "1", *options), dask.config.set(known):
            other = here.asked_of(address, experiment, tmp_path / "other")

    here.assert_same(one, other)

"""Dask's rows are those of a serial run.

That holds whatever happens to its workers.
"""

import json
import pickle
import re
import socket
from pathlib import Path

import psutil
import pyarrow.parquet as pq
import pytest

pytest.importorskip("distributed", reason="Dask's distributed is not installed")

from distributed import Client

from dubins_study import run
from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.executors import dask_worker
from dubins_study.experiments.executors.executor import WorkUnit
from dubins_study.experiments.isolation.pool import RunError
from dubins_study.experiments.plan.cells import chains
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.experiments.store.folder import read_rows
from tests import dask_here as here
from tests.live_run import manifest, wait_for
from tests.plugin_files import copied

EXPERIMENT = """
title = "dask"
question = "are the rows the same?"
time_limit_s = 60.0
solvers = ["analytic", "slsqp[presolve=true]", "ipopt[presolve=true]"]
branches = ["best", "LS"]
initial_guesses = ["cold", "warm"]
[[scenarios]]
target_x = 0
target_y = 3
radius = { linear = [1.0, 2.0, 6] }
"""


@pytest.fixture
def experiment(tmp_path):
    file = tmp_path / "dask.toml"
    file.write_text(EXPERIMENT)
    return str(file)


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    """Two workers that several runs use one after another."""
    two = ("--nworkers", "2", "--nthreads", "1")
    with here.scheduler(tmp_path_factory.mktemp("dask")) as at, here.worker(at, *two):
        with Client(at) as client:  # a run takes the workers that are there when it begins
            client.wait_for_workers(2, timeout=60)
        yield at


def plugin(folder: Path, name: str) -> str:
    """A solver with slsqp's answers.

    Something happens before.
    """
    (folder / "executor").write_text("local")
    return f"{copied('on_dask', folder)}:{name}"


@pytest.mark.slow
def test_the_rows_are_those_of_a_serial_run(experiment, tmp_path, address):
    """The rows are those of a serial run.

    Compared is every column that is not about time or run, warm sweeps among them. The manifest
    says who made them.
    """
    one = run(experiment, tmp_path / "one")
    other = here.asked_of(address, experiment, tmp_path / "other")

    here.assert_same(one, other)
    rows = read_rows(other, ["executor", "jobs"]).to_pandas()
    assert set(rows["executor"]) == {"dask"}
    assert set(rows["jobs"]) == {2}
    entry = manifest(other)["runs"][-1]
    assert (entry["executor"], entry["jobs"], entry["workers"]) == ("dask", 2, 2)
    assert address not in (other / "manifest.json").read_text()


@pytest.mark.slow
def test_probes_come_from_the_machines_that_solve(experiment, tmp_path, address):
    """Known by a number; their names are recorded nowhere."""
    solver = plugin(tmp_path, "Naps")
    out = here.asked_of(address, experiment, tmp_path / "out", solvers=[solver])
    text = (out / "manifest.json").read_text()
    entry = json.loads(text)["runs"][-1]

    assert entry["probes"]
    assert {machine for _, _, machine in entry["probes"]} == {1}
    assert all(0 <= when <= entry["seconds"] and 0 < took < 1 for when, took, _ in entry["probes"])
    assert json.dumps(socket.gethostname()) not in text


@pytest.mark.slow
def test_a_worker_killed_in_the_middle_of_a_work_unit_costs_no_row(experiment, tmp_path, address):
    """Killing a worker in a unit costs no row.

    What it had not delivered is solved again by others; none is there twice.
    """
    solver = plugin(tmp_path, "KillsOnce")
    arguments = {"solvers": [solver, "analytic"], "time_limit": 90.0}
    one = run(experiment, tmp_path / "one", **arguments)
    (tmp_path / "executor").write_text("dask")
    (tmp_path / "armed").touch()
    other = here.asked_of(address, experiment, tmp_path / "other", **arguments)

    assert not (tmp_path / "armed").exists()
    assert here.gone([int((tmp_path / "killed").read_text())])
    here.assert_same(one, other)
    parts = [pq.read_metadata(part).num_rows for part in (other / "parts").iterdir()]
    assert sum(parts) == len(read_rows(one))


@pytest.mark.slow
def test_what_a_dead_worker_was_solving_dies_with_it(experiment, tmp_path, address):
    """A dead worker's solves die with it.

    They are its fork server and the solver's process, though that is in a loop that nobody
    watches.
    """
    solver = plugin(tmp_path, "HangsOnce")
    (tmp_path / "executor").write_text("dask")
    (tmp_path / "armed").touch()
    pids: list[int] = []

    def kill(done, total):
        # a file that is there may be empty for another moment
        if (tmp_path / "pids").exists() and (tmp_path / "pids").read_text() and not pids:
            pids.extend(map(int, (tmp_path / "pids").read_text().split()))
            psutil.Process(pids[0]).kill()

    arguments = {"solvers": [solver, "analytic"], "time_limit": 3000.0, "progress": kill}
    here.asked_of(address, experiment, tmp_path / "out", **arguments)

    assert len(set(pids)) == 3
    wait_for(lambda: here.gone(pids))


@pytest.mark.slow
def test_a_work_unit_that_kills_every_worker_ends_the_run(experiment, tmp_path, address):
    """A unit that kills every worker ends the run.

    It ends after as many workers as Dask's `allowed-failures` permits; the rows so far are kept.
    """
    solver = plugin(tmp_path, "KillsEach")
    (tmp_path / "executor").write_text("dask")
    out = tmp_path / "out"
    with pytest.raises(
        RunError, match=r"^a Dask worker failed: KilledWorker: .* on 4 different workers"
    ):
        here.asked_of(address, experiment, out, solvers=[solver])

    entry = manifest(out)["runs"][-1]
    assert entry["state"] == "interrupted"


@pytest.mark.slow
def test_another_executor_goes_on_where_one_left_off(experiment, tmp_path, address):
    """Another executor goes on where one stopped.

    A sweep cut in the middle goes on from its last path.
    """
    one = run(experiment, tmp_path / "one", solvers=["slsqp[presolve=true]"])

    def enough(done, total):
        if done > 5:
            raise KeyboardInterrupt

    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        run(experiment, out, solvers=["slsqp[presolve=true]"], progress=enough)
    assert 0 < len(read_rows(out)) < len(read_rows(one))
    here.asked_of(address, experiment, out, solvers=["slsqp[presolve=true]"])

    here.assert_same(one, out)
    executors = set(read_rows(out, ["executor"])["executor"].to_pylist())
    assert executors == {"local", "dask"}


def test_a_worker_keeps_its_processes_until_the_run_ends(experiment, tmp_path):
    """A worker keeps its processes until the end.

    Units of a run are solved in the same process; then it is gone.
    """
    spec = plugin(tmp_path, "Notes")
    text = re.sub("(?m)^solvers = .*", f'solvers = ["{spec}"]', Path(experiment).read_text())
    Path(experiment).write_text(text)
    settings = RunSettings("kept", 60.0, executor="dask")
    units = chains(read(experiment).experiment)
    for chain in units[:3]:
        reply = dask_worker.solve_unit(pickle.dumps(WorkUnit(settings, [chain])))
        assert (len(reply.rows), reply.refusal) == (len(chain), "")
    pids = set(map(int, (tmp_path / "pids").read_text().split()))
    assert len(pids) == 1
    dask_worker.end_run("kept")

    assert here.gone([*pids])


def test_a_worker_whose_files_were_changed_is_to_be_restarted(monkeypatch):
    """A worker with changed files has to be restarted.

    What it has imported is not what is on disk, whose digest it would tell.
    """
    monkeypatch.setattr(dask_worker, "_IMPORTED", frozenset())
    reply = dask_worker.solve_unit(pickle.dumps(WorkUnit(RunSettings("r", 1.0), [])))

    assert len(reply.rows) == 0
    assert reply.refusal.endswith("dubins-study was changed since the worker started; restart it")

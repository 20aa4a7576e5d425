"""Records of where a row came from."""

import json
import os
import re
from pathlib import Path

import numpy as np
import pytest

from dubins_study import run
from dubins_study.experiments import provenance
from dubins_study.experiments.provenance import governor, machine
from dubins_study.experiments.store.folder import read_rows
from dubins_study.experiments.store.manifest_changes import RunRecord
from dubins_study.solvers.engines import ipopt_in_casadi, scip_in_pyscipopt
from dubins_study.solvers.registry import load, reported_versions
from dubins_study.study.rows.manifest import (
    Definition,
    Manifest,
    Probe,
    RunEntry,
    spread,
    varied,
)
from tests.live_run import manifest, quick_experiment

pytestmark = pytest.mark.smoke


def test_a_clock_that_is_set_back_changes_no_duration():
    """A clock set back changes no duration.

    Only `provenance.now` reads the wall clock, which names moments; durations are monotonic.
    """
    wall_clock = re.compile(r"datetime\.\w*now|time\.time\b|from time import .*\btime\b")
    package = Path(provenance.__file__).parents[1]
    readers = [file for file in package.rglob("*.py") if wall_clock.search(file.read_text("utf-8"))]

    assert [file.name for file in readers] == ["provenance.py"]


def test_the_governor_of_all_cores(tmp_path):
    """The governor of all cores.

    Where it is not known, the text says that; where cores differ, both are named.
    """
    assert governor(tmp_path) == "unknown"
    for number, name in enumerate(("performance", "performance", "powersave")):
        place = tmp_path / f"cpu{number}" / "cpufreq"
        place.mkdir(parents=True)
        (place / "scaling_governor").write_text(f"{name}\n")
        expected = "performance" if number < 2 else "performance, powersave"
        assert governor(tmp_path) == expected


def test_ipopt_inside_casadi_is_asked_itself():
    """Ipopt inside casadi names its own version.

    The name of the library's own file has it too.
    """
    import casadi

    names = [file.name for file in Path(casadi.__file__).parent.glob("libipopt.so.3.*")]
    if not names:
        pytest.skip("this wheel names its library without its version")
    assert ipopt_in_casadi() == {"ipopt": names[0].removeprefix("libipopt.so.")}


def test_scip_inside_pyscipopt_is_asked_itself():
    from pyscipopt import Model

    found = scip_in_pyscipopt()["scip"]
    assert float(".".join(found.split(".")[:2])) == Model().version()


def test_rows_hold_the_libraries_versions(tmp_path):
    """Rows hold their libraries' versions.

    The libraries are those of the worker that solved them.
    """
    folder = run(str(quick_experiment(tmp_path, 2, 'ipopt", "analytic')), tmp_path / "out")
    rows = read_rows(folder, ["versions"]).to_pylist()
    by_solver = {row["solver"]: json.loads(row["versions"]) for row in rows}

    assert by_solver["ipopt"] | ipopt_in_casadi() == by_solver["ipopt"]
    assert {"casadi", "pyomo", "dubins-study", "python", "numpy"} <= by_solver["ipopt"].keys()
    assert "ipopt" not in by_solver["analytic"]


class Untold:
    packages = ()

    def library_versions(self):
        raise RuntimeError("no")


def test_a_plugin_that_cannot_tell_its_versions_costs_no_row():
    assert reported_versions(Untold()) == {"library_versions": "raised RuntimeError"}
    assert reported_versions(load("analytic")) == {}


def test_a_run_leaves_an_entry(tmp_path):
    """A run leaves an entry.

    It has command, machine, threads, load, state of the source, start and end.
    """
    folder = run(str(quick_experiment(tmp_path, 3)), tmp_path / "out", time_limit=7.0)
    content = manifest(folder)
    (entry,) = content["runs"]

    assert entry["command"].startswith("dubins-study run ")
    assert "--time-limit 7.0" in entry["command"]
    assert (entry["jobs"], entry["time_limit_s"], entry["threads"]) == (1, 7.0, 1)
    assert entry["executor"] == "local"
    assert entry["memory_limit_gib"] > 0
    assert entry["machine"] == machine()
    assert 1 <= machine()["usable_cores"] <= machine()["cores"] == os.cpu_count()
    assert float(machine()["memory"].removesuffix(" GiB")) > 0
    assert entry["governor"] == governor()
    assert entry["git"] == provenance.source()
    assert entry["state"] == "finished"
    assert entry["started"] < entry["ended"]
    assert len(entry["load_start"]) == len(entry["load_end"]) == 3
    assert {entry["run_id"]} == set(read_rows(folder, ["run_id"])["run_id"].to_pylist())
    assert content["solvers"]["slsqp"]["packages"] == {"scipy": __import__("scipy").__version__}


def timed(probes):
    return [Probe(when, took) for when, took in enumerate(probes)]


def test_few_probes_say_nothing():
    assert spread([]) is None
    assert spread(timed([1.0, 2.0, 3.0, 4.0])) is None
    assert spread(timed([1.0] * 5)) == 0.0
    assert spread(timed(range(1, 22))) == pytest.approx(18 / 11)


def test_machines_are_not_compared_with_each_other():
    """Machines are not compared with each other.

    Two are steady, one twice as fast; a third that is not steady decides.
    """
    steady = [Probe(i, 1e-3 * machine, machine) for i in range(20) for machine in (1, 2)]
    loud = [Probe(i, 1e-3 * (1 + i % 2), 3) for i in range(20)]

    assert varied(steady) == 0
    assert varied(steady + loud) == spread(loud)
    assert varied([*steady, *loud[:4]]) == 0  # too few to tell
    listed = [[p.when, p.took, p.machine] for p in steady] + [[1.0, 2.0]]
    assert RunEntry(probes=listed).probes == [*steady, Probe(1.0, 2.0)]


def test_an_executor_is_read_under_its_old_name():
    """An executor is read under its old name.

    Manifests of the first benchmark have it; it is written under its own.
    """
    entry = RunEntry.model_validate({"engine": "dask"})

    assert entry.executor == "dask"
    assert RunEntry.model_validate(entry.model_dump()) == entry
    assert "engine" not in entry.model_dump()


def test_a_long_run_keeps_a_thousand_probes_at_most(tmp_path):
    """Evenly over the whole run."""
    empty = Manifest(experiment=Definition(name="n", text="t"), cells=0)
    with RunRecord(tmp_path, empty, RunEntry(run_id="r")) as record:
        for i in range(10_000):
            record.probe(1.0 + i)
    (entry,) = manifest(tmp_path)["runs"]
    took = [taken for _, taken, _ in entry["probes"]]

    assert 400 < len(took) <= 1000
    assert set(np.diff(took)) == {16.0}
    assert took[0] < 33
    assert took[-1] > 9980
    assert manifest(tmp_path)["finished"] is not None

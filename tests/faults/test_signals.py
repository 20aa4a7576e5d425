"""Ctrl-C and SIGTERM within a long cell."""

import os
import signal
import time

import pytest

from dubins_study.experiments.store.folder import done
from tests.faults.experiments import experiment, rows
from tests.live_run import started, study, wait_for
from tests.marked import wait_until_handled
from tests.plugin_files import spec

pytestmark = pytest.mark.slow
HONEST = spec("honest", "Honest")


def during_a_cell(tmp_path, numbers, jobs, limit, nap=600.0, under_way=1):
    """Signal the whole group during a long cell.

    A terminal sends such signals. They come once the long cells are under way.
    """
    file = tmp_path / "pids"
    out = tmp_path / "out"
    napping = spec("honest", "Napping", nap=nap, note=file)
    asking = experiment(tmp_path, ([napping], 4), ([HONEST], 8))
    options = ("--out", out, "--jobs", jobs, "--time-limit", limit)
    with started("run", asking, "--trust-plugins", *options) as run:
        wait_for(lambda: file.exists() and len(file.read_text().split()) >= under_way, run)
        time.sleep(0.3)
        for number in numbers:
            os.killpg(run.process.pid, number)
            wait_until_handled(run.process.pid, number)
        ended = run.wait()
    assert ended.alive == []
    assert "Traceback" not in ended.err
    assert ended.out == ""
    return ended, asking, out


def kept(out, ended):
    """Check that the folder holds the kept cells.

    The run says how many it kept.
    """
    count = len(done(out))
    assert f"interrupted; {count} of 12 cells are done and kept" in ended.err
    return rows(out)


@pytest.mark.parametrize(("number", "jobs"), [(signal.SIGINT, 1), (signal.SIGTERM, 2)])
def test_the_first_lets_the_cell_come_to_its_limit(tmp_path, number, jobs):
    """After the first signal the cell reaches its limit.

    A cell that never ends is a timeout like any other; then the run stops.

    SIGTERM is what a machine that shuts down sends, or a batch system.
    """
    ended, _, out = during_a_cell(tmp_path, [number], jobs, 3, under_way=jobs)

    assert ended.code in (130, 143), ended.err
    kept_rows = kept(out, ended)
    late = kept_rows[kept_rows["plugin"] == "Napping"]
    assert jobs <= len(late) < 4
    assert set(late["outcome"]) == {"timeout"}


@pytest.mark.parametrize("jobs", [1, 2])
def test_the_first_lets_the_cell_be_answered(tmp_path, jobs):
    ended, asking, out = during_a_cell(tmp_path, [signal.SIGINT], jobs, 60, nap=2.0, under_way=jobs)

    assert ended.code == 130, ended.err
    kept_rows = kept(out, ended)
    late = kept_rows[kept_rows["plugin"] == "Napping"]
    assert jobs <= len(late) < 4
    assert set(late["outcome"]) == {"returned"}

    # and the same command completes it
    options = ("--out", out, "--jobs", jobs, "--time-limit", 60)
    assert study("run", asking, "--trust-plugins", *options).code == 0
    assert len(rows(out)) == 12
    assert set(rows(out)["verdict"]) == {"optimal"}


def test_the_second_stops_at_once(tmp_path):
    """The second signal stops at once.

    That is long before the limit of ten minutes; the cell under way has no row.
    """
    ended, _, out = during_a_cell(tmp_path, [signal.SIGINT, signal.SIGINT], 2, 600)

    assert ended.code == 130, ended.err
    assert not (kept(out, ended)["plugin"] == "Napping").any()

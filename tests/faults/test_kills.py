"""Resume completes a run after kill -9.

The whole run is killed at any moment; exactly the missing rows are added.
"""

import time
from random import Random

import pytest

from dubins_study.experiments.store.folder import done
from tests.faults.experiments import experiment, lasting, rows
from tests.live_run import manifest, started, study, wait_for
from tests.marked import kill_all, left_behind
from tests.plugin_files import spec

MOMENTS = 4
CELLS = 80


@pytest.fixture
def asking(tmp_path):
    """An experiment of quick answers of every outcome.

    Some cells are in two blocks alike.
    """
    solvers = [
        spec("honest", "Honest"),
        spec("honest", "Napping", nap=0.3),
        spec("hostile", "SomeTimes"),
        spec("hostile_answers", "Elsewhere"),
    ]
    return experiment(tmp_path, (solvers, 20))


@pytest.mark.slow
@pytest.mark.timeout(1500)
def test_killed_at_random_moments(asking, tmp_path):
    """Killed runs are resumed at random moments.

    Each is killed some parts and a moment after its start: all of it, or its supervisor.

    A run that ends before it is killed does not count; the next one begins anew.
    """
    draw = Random(20260)
    cut = 0
    earlier = set()
    options = ("--trust-plugins", "--jobs", 2, "--time-limit", 10)
    folders = [tmp_path / "cut 0"]
    while cut < MOMENTS:
        with started("run", asking, "--out", folders[-1], *options) as run:
            wanted = len(parts(folders[-1])) + draw.randrange(3)
            wait_for(
                lambda n=wanted, run=run: len(parts(folders[-1])) >= n or run.process.poll() == 0
            )
            time.sleep(draw.uniform(0.0, 1.0))  # rows are written about every second
            cut += run.process.poll() is None
            run.process.kill()  # first: a worker killed before it would rightly be a crashed row
            if cut % 2:
                run.process.wait()
                assert left_behind(run.mark) == []
            else:
                kill_all(run.mark)
        if not (folders[-1] / "manifest.json").exists():
            continue  # so early that there is no folder yet
        cells = done(folders[-1])
        assert earlier <= cells  # what was written stays
        assert len(rows(folders[-1])) == len(cells)
        earlier = cells
        if len(cells) == CELLS and finished(folders[-1]):
            folders.append(tmp_path / f"cut {len(folders)}")
            earlier = set()

    whole = tmp_path / "whole"
    assert study("run", asking, "--out", whole, *options).code == 0
    expected = lasting(rows(whole))
    assert len(expected) == CELLS
    for folder in folders:
        ended = study("run", asking, "--out", folder, *options)
        assert ended.code == 0, ended.err
        assert finished(folder)
        assert lasting(rows(folder)).equals(expected)
        assert not [file for file in (folder / "parts").iterdir() if file.name.startswith(".")]


def parts(folder):
    return sorted((folder / "parts").glob("[!.]*.parquet"))


def finished(folder):
    return bool(manifest(folder)["finished"])

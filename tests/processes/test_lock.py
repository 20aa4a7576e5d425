"""One run at a time in a folder.

That holds whatever becomes of the run that holds it.
"""

import json
import os
import signal
import stat

import psutil
import pytest

from dubins_study import status
from dubins_study.experiments.store.folder import LOCK, done, is_locked, lock_holder
from tests.live_run import CELLS, finished, manifest, parts, slow_experiment, started, wait_for

pytestmark = pytest.mark.smoke


def contents(folder):
    """Every file of a folder and its bytes.

    The duration of the live run is left out: it changes.
    """
    contents_by_file = {
        file: file.read_bytes() for file in sorted(folder.rglob("*")) if file.is_file()
    }
    manifest = json.loads(contents_by_file.pop(folder / "manifest.json"))
    for entry in manifest["runs"]:
        del entry["seconds"]
    return contents_by_file, manifest


@pytest.mark.slow
def test_a_second_run_is_told_who_is_at_work_and_touches_nothing(tmp_path):
    experiment = slow_experiment(tmp_path, nap=30)
    out = tmp_path / "out"
    with started("run", experiment, "--trust-plugins", "--out", out) as first:
        wait_for(lambda: (out / "manifest.json").exists())
        since = lock_holder(out)["started"]
        before = contents(out)
        for extra in ((), ("--restart",)):
            second = finished("run", experiment, "--trust-plugins", "--out", out, *extra)

            assert second.returncode == 2
            assert second.stdout == ""
            (line,) = second.stderr.strip().splitlines()
            assert f"{out} is in use: process {first.process.pid} has been at work" in line
            assert f"since {since}" in line
            assert "choose another --out" in line
        assert contents(out) == before
        assert first.process.poll() is None


@pytest.mark.slow
def test_a_killed_run_holds_nothing_even_while_its_workers_live(tmp_path):
    """A killed run holds nothing.

    Only the run is killed, by kill -9: workers that nap on do not keep the next run out.
    """
    experiment = slow_experiment(tmp_path, nap=0.2, count=24)
    out = tmp_path / "out"
    with started("run", experiment, "--trust-plugins", "--out", out, "--jobs", "2") as first:
        wait_for(lambda: parts(out))
        supervisor = psutil.Process(first.process.pid)
        children = [child.pid for child in supervisor.children(recursive=True)]
        assert children
        for child in children:  # they outlive the run: the system wakes them for nothing
            os.kill(child, signal.SIGSTOP)
        os.kill(first.process.pid, signal.SIGKILL)
        first.process.wait()
        assert any(alive(child) for child in children)
        assert not is_locked(out)
        cells = done(out)
        assert status(out).runs[-1].state == "killed"

        again = finished("run", experiment, "--trust-plugins", "--out", out)
        for child in children:
            if alive(child):
                os.kill(child, signal.SIGKILL)

    assert again.returncode == 0, again.stderr
    assert cells <= done(out)
    assert len(done(out)) == 24
    assert [run["state"] for run in manifest(out)["runs"]] == ["running", "finished"]
    assert [run.state for run in status(out).runs] == ["killed", "finished"]


def alive(pid):
    return psutil.pid_exists(pid) and psutil.Process(pid).status() != psutil.STATUS_ZOMBIE


@pytest.mark.slow
def test_status_and_report_work_while_a_run_does(tmp_path):
    experiment = slow_experiment(tmp_path, nap=0.3, count=1000)
    out = tmp_path / "out"
    with started("run", experiment, "--trust-plugins", "--out", out) as first:
        wait_for(lambda: parts(out))
        process = finished("status", out)
        assert process.returncode == 0
        assert f"running: process {first.process.pid} is at work" in process.stdout
        assert process.stderr == ""
        page = finished("report", out, "--out", tmp_path / "page")
        assert page.returncode == 0, page.stderr
        assert "Not finished" in (tmp_path / "page" / "index.html").read_text()
        assert first.process.poll() is None


def test_status_writes_nothing(folder):
    """`status` writes nothing.

    A folder that may only be read can be looked at.
    """
    (folder / LOCK).unlink()
    before = {file: file.stat().st_mtime_ns for file in [folder, *folder.rglob("*")]}
    for file in before:
        file.chmod(file.stat().st_mode & ~(stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))

    assert status(folder).done == CELLS
    assert {file: file.stat().st_mtime_ns for file in [folder, *folder.rglob("*")]} == before
    for file in before:
        file.chmod(file.stat().st_mode | stat.S_IWUSR)

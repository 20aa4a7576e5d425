"""kill -9 of the whole run at any moment: resume completes exactly what is missing."""

from __future__ import annotations

import json
import time
from random import Random

import pytest

from dubins_study.experiments.store.folder import done
from tests.faults.launch import (
    experiment,
    kill_all,
    lasting,
    left_behind,
    rows,
    spec,
    started,
    study,
    until,
)

MOMENTS = 20
CELLS = 160


@pytest.fixture
def asking(tmp_path):
    """Answers of every outcome that takes no time to come, some cells in two blocks alike."""
    solvers = [
        spec("honest", "Honest"),
        spec("honest", "Napping", nap=0.15),
        spec("hostile", "SomeTimes"),
        spec("hostile_answers", "Elsewhere"),
    ]
    return experiment(tmp_path, (solvers, 40))


@pytest.mark.slow
@pytest.mark.timeout(1500)
def test_killed_at_twenty_random_moments(asking, tmp_path):
    """Each run is killed some parts and a moment after its start: all of it, or its supervisor.

    A run that ends before it is killed does not count; the next one begins anew.
    """
    draw, cut, kept = Random(20260), 0, set()
    options = ("--jobs", 2, "--time-limit", 10)
    folders = [tmp_path / "cut 0"]
    while cut < MOMENTS:
        with started("run", asking, "--out", folders[-1], *options) as run:
            wanted = len(parts(folders[-1])) + draw.randrange(3)
            until(lambda n=wanted, run=run: len(parts(folders[-1])) >= n or run.process.poll() == 0)
            time.sleep(draw.uniform(0.0, 1.0))  # rows are written about every second
            cut += run.process.poll() is None
            if cut % 2:
                run.process.kill()
                run.process.wait()
                assert left_behind(run.mark) == []
            else:
                kill_all(run.mark)
        if not (folders[-1] / "manifest.json").exists():
            continue  # so early that there is no folder yet
        found = done(folders[-1])
        assert kept <= found  # what was written stays
        assert len(rows(folders[-1])) == len(found)
        kept = found
        if len(found) == CELLS and finished(folders[-1]):
            folders.append(tmp_path / f"cut {len(folders)}")
            kept = set()

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
    return bool(json.loads((folder / "manifest.json").read_text())["finished"])


@pytest.mark.slow
@pytest.mark.parametrize("damage", ["truncated", "emptied", "overwritten"])
def test_a_damaged_part_is_repaired_or_named(asking, tmp_path, damage):
    """The run says which part it is, or solves its cells again: no wrong row, no traceback."""
    out = tmp_path / "out"
    options = ("--jobs", 2, "--time-limit", 10, "--out", out)
    with started("run", asking, *options) as run:
        until(lambda: len(parts(out)) >= 3, run)
        kill_all(run.mark)
    part = parts(out)[1]
    before, content = len(done(out)), part.read_bytes()
    changes = {"truncated": content[: len(content) // 2], "emptied": b"", "overwritten": b"x" * 99}
    part.write_bytes(changes[damage])

    ended = study("run", asking, *options)

    assert "Traceback" not in ended.err
    if ended.code == 2:
        assert part.name in ended.err
        part.unlink()  # as the message says
        ended = study("run", asking, *options)
    assert ended.code == 0, ended.err
    assert before < CELLS
    found = rows(out)
    assert len(found) == CELLS
    assert not found.duplicated(["solver", "target_x"]).any()


@pytest.mark.slow
def test_a_full_disk_is_a_message_and_loses_nothing_written(asking, small_disk, tmp_path):
    """A tmpfs fills up in the middle of a run; with room again, the same command completes it."""
    out, filler = small_disk / "out", small_disk / "filler"
    options = ("--jobs", 2, "--time-limit", 10, "--out", out)
    with started("run", asking, *options) as run:
        until(lambda: parts(out), run)
        fill(filler)
        ended = run.wait()

    assert ended.code == 2, (ended.code, ended.err)
    assert "Traceback" not in ended.err
    assert "No space left on device" in ended.err
    assert ended.alive == []
    filler.unlink()
    kept = done(out)
    assert 0 < len(kept) < CELLS

    ended = study("run", asking, *options)
    assert ended.code == 0, ended.err
    assert kept <= done(out)
    assert len(rows(out)) == CELLS


@pytest.fixture
def small_disk(tmp_path):
    """A file system of a megabyte in memory."""
    import subprocess

    disk = tmp_path / "disk"
    disk.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", "size=1M", "tmpfs", str(disk)]
    try:
        subprocess.run(command, check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("only root may mount a tmpfs")
    yield disk
    subprocess.run(["umount", "-l", str(disk)], check=True)


def fill(file):
    with file.open("wb", buffering=0) as stream:
        while True:
            try:
                stream.write(b"x" * 4096)
            except OSError:
                return


@pytest.mark.slow
def test_two_runs_in_one_folder(asking, tmp_path):
    """The second is refused and says who is there; the first does not notice."""
    out = tmp_path / "out"
    with started("run", asking, "--out", out, "--jobs", 2) as first:
        until(lambda: parts(out), first)
        second = study("run", asking, "--out", out)
        assert first.process.poll() is None
        ended = first.wait()

    assert second.code == 2
    assert str(first.process.pid) in second.err
    assert "Traceback" not in second.err
    assert ended.code == 0, ended.err
    assert len(rows(out)) == CELLS
    # the lock of a run that was killed holds nobody up
    assert study("run", asking, "--out", out).code == 0

"""Ctrl-C: what is being solved is finished, what is done is kept, and the run says so."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from live_run import TELLS_AND_NAPS
from marked import wait_until_handled

from dubins_study import run
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.store.folder import done, read_rows

EXPERIMENT = """
title = "interrupted"
question = "what is kept?"
solvers = ["slsqp"]
[[scenarios]]
target_x = { linear = [1, 9, 30] }
target_y = 3
"""


@pytest.fixture
def experiment(tmp_path):
    file = tmp_path / "interrupted.toml"
    file.write_text(EXPERIMENT)
    return str(file)


def test_the_first_sets_a_flag_and_the_second_raises():
    before, seen = signal.getsignal(signal.SIGINT), []

    def twice():
        with Interruption() as stop:
            signal.raise_signal(signal.SIGINT)
            seen.append(stop)
            assert not stop.immediate
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        twice()
    assert seen[0].requested
    assert seen[0].immediate
    assert signal.getsignal(signal.SIGINT) is before


def test_leaving_raises_what_was_asked_for_and_the_handler_is_back():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), Interruption():
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def test_one_within_another_knows_what_was_asked_before():
    """The command line enters one while it still loads, `run` its own."""
    seen = []

    def nested():
        with Interruption():
            signal.raise_signal(signal.SIGINT)
            with Interruption() as inner:
                seen.append(inner.requested)

    with pytest.raises(KeyboardInterrupt):
        nested()
    assert seen == [True]


def test_other_threads_are_left_alone(experiment, tmp_path):
    """Python handles no signals there; a run must not try."""
    before, folders = signal.getsignal(signal.SIGINT), []
    thread = threading.Thread(target=lambda: folders.append(run(experiment, tmp_path / "out")))
    thread.start()
    thread.join()

    assert len(done(folders[0])) == 30
    assert signal.getsignal(signal.SIGINT) is before


def test_a_run_interrupted_after_its_last_cell_is_finished_by_the_next(experiment, tmp_path):
    def last(cells, total):
        if cells == total:
            signal.raise_signal(signal.SIGINT)

    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        run(experiment, out, progress=last)
    assert not json.loads((out / "manifest.json").read_text())["finished"]

    run(experiment, out)

    assert json.loads((out / "manifest.json").read_text())["finished"]


MAIN = "from dubins_study.cli.app import main; main()"


def interrupted(*arguments: str, after: Path, signals: int = 1, **environment: str):
    """Run the command, and send its whole group SIGINT once there are such files."""
    process = subprocess.Popen(
        [sys.executable, "-c", MAIN, "run", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, **environment},
    )
    give_up = time.monotonic() + 120
    while not [*after.parent.glob(after.name)] and process.poll() is None:
        assert time.monotonic() < give_up
        time.sleep(0.02)
    for _ in range(signals):
        os.killpg(process.pid, signal.SIGINT)
        wait_until_handled(process.pid, signal.SIGINT)
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


@pytest.mark.slow
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_the_command_says_what_is_kept(experiment, tmp_path, jobs):
    """Exit code 130, one line with the count, no traceback of any process; a rerun completes."""
    (tmp_path / "slow.py").write_text(TELLS_AND_NAPS)
    out = tmp_path / "out"
    solver = f"{tmp_path}/slow.py:Slow"
    asked = ("--out", str(out), "--jobs", jobs, "--solver", solver)
    code, printed, err = interrupted(
        experiment, *asked, after=tmp_path / "asked", NAP="1" if jobs == "1" else "0.5"
    )

    kept = len(done(out))
    assert code == 130, err
    assert 0 < kept < 30
    assert "interrupted; what was done is kept, run the same command to go on" in err
    assert f"({kept} of 30 cells done)" in err
    assert "Traceback" not in err
    assert printed == ""


@pytest.mark.slow
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_second_stops_at_once(experiment, tmp_path, jobs):
    (tmp_path / "slow.py").write_text(TELLS_AND_NAPS)
    out, began = tmp_path / "out", time.monotonic()
    words = ("--out", str(out), "--jobs", jobs, "--solver", f"{tmp_path}/slow.py:Slow")
    words += ("--time-limit", "2000")
    code, _, err = interrupted(experiment, *words, after=tmp_path / "asked", signals=2, NAP="1000")

    assert time.monotonic() - began < 300  # long before the nap is over, on a busy machine too
    assert code == 130
    assert "interrupted; what was done is kept" in err
    assert "Traceback" not in err


@pytest.mark.slow
def test_after_a_fresh_run_the_same_command_would_throw_away(experiment, tmp_path):
    """So the message names the other one."""
    out = tmp_path / "out"
    code, _, err = interrupted(
        *(experiment, "--out", str(out), "--repeats", "100", "--restart"),
        after=out / "parts" / "*.parquet",
    )

    assert code == 130, err
    assert "what was done is kept, run the same command without --restart to go on (" in err


@pytest.mark.slow
def test_ipopt_does_not_swallow_it(experiment, tmp_path):
    """casadi turns a KeyboardInterrupt into a warning and a failed solve; neither is recorded."""
    out = tmp_path / "out"
    code, _, err = interrupted(
        *(experiment, "--out", str(out), "--solver", "ipopt", "--repeats", "100"),
        after=out / "parts" / "*.parquet",
    )

    assert code == 130, err
    assert "interrupted; what was done is kept" in err
    assert "KeyboardInterrupt" not in err
    rows = read_rows(out, ["claim"])
    assert 0 < len(rows) < 3000
    assert set(rows["claim"].to_pylist()) == {"local"}

"""Ctrl-C finishes a solve and keeps the rows.

The run says so.
"""

import os
import signal
import threading
from pathlib import Path

import pytest
from typer.testing import CliRunner

from dubins_study import Question, Scenario, run
from dubins_study.asking.reply import ask
from dubins_study.cli.app import app
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.store.folder import done
from dubins_study.solvers.registry import load
from tests.live_run import Ended, manifest, quick_experiment, started, wait_for


@pytest.fixture
def experiment(tmp_path):
    return str(quick_experiment(tmp_path))


def test_the_first_sets_a_flag_and_the_second_raises():
    before = signal.getsignal(signal.SIGINT)
    seen = []

    def twice():
        with Interruption() as stop:
            signal.raise_signal(signal.SIGINT)
            seen.append(stop.requested)
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        twice()
    assert seen == [True]
    assert signal.getsignal(signal.SIGINT) is before


def test_leaving_raises_what_was_asked_for_and_the_handler_is_back():
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt), Interruption():
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before


def test_one_within_another_knows_what_was_asked_before():
    """A nested interruption knows earlier requests.

    The command line enters one while it still loads, `run` its own.
    """
    seen = []

    def nested():
        with Interruption():
            signal.raise_signal(signal.SIGINT)
            with Interruption() as inner:
                seen.append(inner.requested)

    with pytest.raises(KeyboardInterrupt):
        nested()
    assert seen == [True]


@pytest.mark.slow
def test_other_threads_are_left_alone(experiment, tmp_path):
    """Other threads are left alone.

    Python handles no signals there; a run must not try.
    """
    before = signal.getsignal(signal.SIGINT)
    folders = []
    thread = threading.Thread(target=lambda: folders.append(run(experiment, tmp_path / "out")))
    thread.start()
    thread.join()

    assert len(done(folders[0])) == 30
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.slow
def test_a_run_interrupted_after_its_last_cell_is_finished_by_the_next(experiment, tmp_path):
    def last(cells, total):
        if cells == total:
            signal.raise_signal(signal.SIGINT)

    out = tmp_path / "out"
    with pytest.raises(KeyboardInterrupt):
        run(experiment, out, progress=last)
    assert not manifest(out)["finished"]

    run(experiment, out)

    assert manifest(out)["finished"]


def interrupted(*arguments: str, after: Path) -> Ended:
    """Run the command and interrupt its group.

    SIGINT is sent once there are such files.
    """
    with started("run", *arguments) as live:
        wait_for(lambda: [*after.parent.glob(after.name)], live)
        os.killpg(live.process.pid, signal.SIGINT)
        return live.wait()


@pytest.mark.slow
def test_after_a_fresh_run_the_same_command_would_throw_away(experiment, tmp_path):
    """The message names the command that resumes."""
    out = tmp_path / "out"
    ended = interrupted(
        *(experiment, "--out", str(out), "--repeats", "100", "--restart"),
        after=out / "parts" / "*.parquet",
    )

    assert ended.code == 130, ended.err
    assert "cells are done and kept; run the same command without --restart to go on" in ended.err
    (entry,) = manifest(out)["runs"]
    assert entry["state"] == "interrupted"
    assert entry["ended"] >= entry["started"]
    assert 0 < entry["seconds"] < 120


def test_an_interruption_of_a_compiled_loop_is_one(monkeypatch):
    """A compiled loop that is interrupted ends with a SystemError."""

    def solve(*_):
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    monkeypatch.setattr("dubins_study.solvers.analytic.Analytic.solve", solve)

    with pytest.raises(KeyboardInterrupt):
        ask(load("analytic"), Question(Scenario(target_x=4, target_y=1)))
    assert CliRunner().invoke(app, ["solve", "4", "1"]).exit_code == 130

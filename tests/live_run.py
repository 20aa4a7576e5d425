"""Runs of `dubins-study` in their own processes.

Tests wait for them, kill them and look at them.
"""

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any, NamedTuple

import psutil

from tests.marked import alive, kill_all, left_behind, marked
from tests.plugin_files import spec

# s, far above what any run here takes; only a run that hangs gets there
PATIENCE_S = 150.0
CELLS = 8  # of the run that is made once
TARGETS = """
title = "slow"
question = "is it kept?"
solvers = ["{solver}"]
[[scenarios]]
target_x = {{ linear = [2, 5, {count}] }}
target_y = 3
"""


def slow_experiment(folder: Path, nap: float = 0.1, count: int = 30) -> Path:
    """An experiment of one solver that naps.

    The solver has to be trusted. It naps before each of its solves.
    """
    file = folder / "slow.toml"
    file.write_text(TARGETS.format(solver=spec("slow", "Slow", nap=nap), count=count))
    return file


def quick_experiment(folder: Path, count: int = 30, solver: str = "slsqp") -> Path:
    """An experiment whose cells take a few milliseconds each."""
    file = folder / "quick.toml"
    file.write_text(TARGETS.format(solver=solver, count=count))
    return file


def command(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "dubins_study", *map(str, arguments)]


def finished(
    *arguments: object, cwd: Path | None = None, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run the command to its end.

    Its output is text.
    """
    return _run(command(*arguments), cwd, environment)


def interpreted(
    program: str, cwd: Path | None = None, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a program in a new interpreter.

    It runs to its end; its output is text.
    """
    return _run([sys.executable, "-c", program], cwd, environment)


def output(done: subprocess.CompletedProcess[str]) -> str:
    """Output of a command that must succeed."""
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def _run(
    line: list[str], cwd: Path | None, environment: dict[str, str]
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        line,
        capture_output=True,
        text=True,
        timeout=300,
        cwd=cwd,
        env={**os.environ, **environment},
    )


class Ended(NamedTuple):
    """A run that ended by itself.

    It has the exit code, what was printed, and what was left alive.
    """

    code: int
    out: str
    err: str
    alive: list[str]


class Started(NamedTuple):
    """A run under way.

    It prints to files, which no child of it can hold open.
    """

    process: subprocess.Popen[bytes]
    mark: str
    streams: tuple[IO[bytes], IO[bytes]]

    def wait(self) -> Ended:
        """Wait for the end.

        A run that hangs is killed and fails the test.
        """
        try:
            code = self.process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            trees = [f"{p.pid} {p.ppid()} {p.status()}" for p in alive(self.mark)]
            raise AssertionError(f"the run hangs\n{self.printed(1)}\n{trees}") from None
        return Ended(code, self.printed(0), self.printed(1), left_behind(self.mark))

    def printed(self, stream: int) -> str:
        """Text printed so far; 0 is stdout, 1 stderr."""
        file = self.streams[stream]
        return os.pread(file.fileno(), 2**24, 0).decode(errors="replace")

    def workers(self) -> list[psutil.Process]:
        """Every process of the run but the first."""
        return [process for process in alive(self.mark) if process.pid != self.process.pid]


@contextmanager
def started(*arguments: object, cwd: Path | None = None, **environment: str) -> Iterator[Started]:
    """Start the command in a session of its own.

    Whatever is left of it at the end is killed.
    """
    mark, marking = marked()
    with TemporaryFile() as out, TemporaryFile() as err:
        process = subprocess.Popen(
            command(*arguments),
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            start_new_session=True,
            cwd=cwd,
            env={**os.environ, **environment, **marking},
        )
        try:
            yield Started(process, mark, (out, err))
        finally:
            kill_all(mark)  # its orphans too, stopped ones among them
            process.wait()


def study(*arguments: object, cwd: Path | None = None, **environment: str) -> Ended:
    """Run the command to its end, and see what is left."""
    with started(*arguments, cwd=cwd, **environment) as run:
        return run.wait()


def wait_for(condition: Callable[[], Any], run: Started | None = None) -> Any:
    """Wait until a condition holds while a run lives.

    Returns the condition's value.
    """
    give_up = time.monotonic() + PATIENCE_S
    while not (value := condition()):
        if run is not None and run.process.poll() is not None:
            raise AssertionError(f"the run ended early:\n{run.printed(1)}")
        assert time.monotonic() < give_up, "waited in vain"
        time.sleep(0.02)
    return value


def parts(folder: Path) -> list[Path]:
    return sorted((folder / "parts").glob("*.parquet"))


def manifest(folder: Path) -> dict[str, object]:
    content: dict[str, object] = json.loads((folder / "manifest.json").read_text())
    return content

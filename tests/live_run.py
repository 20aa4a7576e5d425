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

from tests.marked import kill_all, marked

SLOW = """
import time
from pathlib import Path
from dubins_study.solvers.paper_nlp.nlp import Slsqp

class Slow(Slsqp):
    def solve(self, model, limit):
        time.sleep({nap})
        return super().solve(model, limit)
"""
# leaves the file `asked` beside itself when it is asked, and takes NAP seconds to answer
TELLS_AND_NAPS = """
import os, time
from pathlib import Path
from dubins_study.solvers.paper_nlp.nlp import Slsqp
class Slow(Slsqp):
    def solve(self, model, limit):
        if model.leg.question.scenario.label != "warm-up":
            Path(__file__).with_name("asked").touch()
            time.sleep(float(os.environ["NAP"]))
        return super().solve(model, limit)
"""
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
    (folder / "slow.py").write_text(SLOW.format(nap=nap))
    file = folder / "slow.toml"
    file.write_text(TARGETS.format(solver=f"{folder}/slow.py:Slow", count=count))
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


@contextmanager
def started(*arguments: object, **environment: str) -> Iterator[subprocess.Popen[str]]:
    """Start the command in a session of its own.

    Whatever is left of it at the end is killed.
    """
    mark, marking = marked()
    process = subprocess.Popen(
        command(*arguments),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, **environment, **marking},
    )
    try:
        yield process
    finally:
        kill_all(mark)  # its orphans too, stopped ones among them: they hold its pipes open
        process.communicate()


def wait_for(condition: Callable[[], object], seconds: float = 120) -> None:
    """Come back as soon as the condition holds."""
    until = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < until, "waited in vain"
        time.sleep(0.02)


def parts(folder: Path) -> list[Path]:
    return sorted((folder / "parts").glob("*.parquet"))


def manifest(folder: Path) -> dict[str, object]:
    content: dict[str, object] = json.loads((folder / "manifest.json").read_text())
    return content

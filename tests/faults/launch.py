"""Marked runs of the command in their own processes.

The marks leave no process behind unseen.
"""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO, Any, NamedTuple

import pandas as pd
import psutil

from dubins_study.experiments.store.folder import read_rows
from dubins_study.study.rows.schema import KEY, names
from tests.marked import alive, kill_all, left_behind, marked

ROOT = Path(__file__).parents[2]
PLUGINS = ROOT / "tests" / "plugins"
# far above what any run here takes; only a run that hangs gets there
PATIENCE = 150.0
# what differs between two runs that find the same
MEASURED = ["build_s", "solve_s", "wall_s", "subproblem_s", "best_run_s"]
MEASURED += ["floor_s", "memory_mib"]
MEASURED += ["machine", "jobs", "limit_s", "executor", "run_id", "started"]


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
            code = self.process.wait(PATIENCE)
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
def started(*arguments: object, **options: Any) -> Iterator[Started]:
    """Start `dubins-study ARGUMENTS`.

    Whatever is left of it at the end is killed.
    """
    mark, marking = marked()
    if arguments[0] == "run":
        arguments += ("--trust-plugins",)  # the experiments here name plug-ins
    paths = os.pathsep.join(filter(None, (str(ROOT), os.environ.get("PYTHONPATH"))))
    environment = {**os.environ, "PYTHONPATH": paths, **options.pop("env", {}), **marking}
    with TemporaryFile() as out, TemporaryFile() as err:
        process = subprocess.Popen(
            [sys.executable, "-m", "dubins_study", *map(str, arguments)],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            start_new_session=True,
            **options,
        )
        try:
            yield Started(process, mark, (out, err))
        finally:
            kill_all(mark)
            process.wait()


def study(*arguments: object, **options: Any) -> Ended:
    """Run `dubins-study ARGUMENTS` to its end."""
    with started(*arguments, **options) as run:
        return run.wait()


def until(condition: Callable[[], Any], run: Started | None = None) -> Any:
    """Wait until a condition holds while a run lives.

    Returns the condition's value.
    """
    give_up = time.monotonic() + PATIENCE
    while not (value := condition()):
        if run is not None and run.process.poll() is not None:
            raise AssertionError(f"the run ended early:\n{run.printed(1)}")
        assert time.monotonic() < give_up
        time.sleep(0.02)
    return value


def spec(file: str, name: str, **settings: object) -> str:
    """Spec of a plug-in in `tests/plugins`.

    It has the path that rows show as well.
    """
    given = ",".join(f"{key}={value}" for key, value in settings.items())
    return f"{PLUGINS / file}.py:{name}" + (f"[{given}]" if given else "")


def experiment(folder: Path, *blocks: tuple[list[str], int], name: str = "faults") -> Path:
    """An experiment that asks solvers some questions.

    Each list of solvers has its own number of questions.
    """
    lines = [f'title = "{name}"', 'question = "is every row there?"', 'solvers = ["analytic"]']
    for number, (solvers, count) in enumerate(blocks):
        lines += [
            "[[scenarios]]",
            f'label = "block {number}"',
            f"target_x = {{ linear = [2.0, 9.0, {count}] }}",
            "target_y = 3.0",
            f"solvers = {solvers!r}",
        ]
    file = folder / f"{name}.toml"
    file.write_text("\n".join(lines) + "\n")
    return file


def rows(folder: Path) -> pd.DataFrame:
    """All rows of a folder with the plug-in's class."""
    table = read_rows(folder).to_pandas()
    table["plugin"] = table["solver"].str.extract(r":(\w+)", expand=False)
    return table


def lasting(table: pd.DataFrame) -> pd.DataFrame:
    """Columns in which two runs must agree.

    Rows are sorted by the key.
    """
    columns = table.drop(columns=MEASURED, errors="ignore")
    for column in ("curvatures", "lengths"):
        columns[column] = columns[column].map(lambda v: None if v is None else tuple(v))
    return columns.sort_values(names(KEY), ignore_index=True)

"""Dask on this machine, for tests.

It starts schedulers and workers, and has experiments small enough for them.
"""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pandas as pd
import psutil

from dubins_study import run
from dubins_study.experiments.store.folder import read_rows
from tests.faults.experiments import lasting
from tests.live_run import wait_for


def assert_same(one: Path, other: Path) -> None:
    """Both folders hold the same rows, each once."""
    rows = (lasting(read_rows(folder).to_pandas()) for folder in (one, other))
    pd.testing.assert_frame_equal(*rows, check_exact=True)


def family(pid: int) -> list[psutil.Process]:
    """A process and its descendants."""
    with suppress(psutil.NoSuchProcess):
        process = psutil.Process(pid)
        return [process, *process.children(recursive=True)]
    return []


def gone(pids: list[int]) -> bool:
    """Whether all of some processes have ended.

    A process that only waits to be reaped has ended.
    """
    for pid in pids:
        with suppress(psutil.NoSuchProcess):
            if psutil.Process(pid).status() != psutil.STATUS_ZOMBIE:
                return False
    return True


def asked_of(address: str, experiment: str, out: Path, **options: Any) -> Path:
    """Folder of a run on a scheduler's workers."""
    return run(experiment, out, executor="dask", scheduler=address, **options)


@contextmanager
def scheduler(folder: Path, *options: str, **environment: str) -> Iterator[str]:
    """Start a scheduler as users do; its address."""
    file = folder / "scheduler.json"
    arguments = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file")
    with _running(
        "distributed.cli.dask_scheduler", *arguments, str(file), *options, **environment
    ) as process:
        wait_for(lambda: file.is_file() or process.poll() is not None)
        wait_for(lambda: bool(file.read_text()))
        yield json.loads(file.read_text())["address"]


@contextmanager
def worker(address: str, *options: str, **environment: str) -> Iterator[subprocess.Popen[str]]:
    """Start a worker as users do.

    It is a nanny and its process.
    """
    arguments = (address, "--host", "127.0.0.1", "--no-dashboard", *options)
    with _running("distributed.cli.dask_worker", *arguments, **environment) as process:
        yield process


@contextmanager
def _running(module: str, *options: str, **environment: str) -> Iterator[subprocess.Popen[str]]:
    process = subprocess.Popen(
        [sys.executable, "-m", module, *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
        cwd="/",  # -m looks for packages where it is first
        env={**os.environ, **environment},
    )
    try:
        yield process
    finally:
        for member in reversed(family(process.pid)):
            with suppress(psutil.NoSuchProcess):
                member.kill()
        process.wait()

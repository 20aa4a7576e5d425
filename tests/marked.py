"""Marks by which every process of a run is found, and ended, whatever became of the run itself.

A mark is an environment variable. A process shows the environment that it was started with for as
long as it lives, whatever it does to its session, group, parent or `os.environ`.
"""

from __future__ import annotations

import signal
import time
from uuid import uuid4

import psutil

_NAME = "TESTED_RUN"


def marked() -> tuple[str, dict[str, str]]:
    """A new mark, and the environment that a process and its descendants carry it in."""
    mark = uuid4().hex
    return mark, {_NAME: mark}


def alive(mark: str) -> list[psutil.Process]:
    """The processes of a run that are still there; one that only waits to be reaped is not."""
    found = []
    for process in psutil.process_iter():
        try:
            if process.status() == psutil.STATUS_ZOMBIE:
                continue
            if process.environ().get(_NAME) == mark:
                found.append(process)
        except psutil.Error:
            continue
    return found


def left_behind(mark: str, within: float = 5.0) -> list[str]:
    """What is alive of a run after its end, given a moment to go."""
    give_up = time.monotonic() + within
    while found := alive(mark):
        if time.monotonic() > give_up:
            break
        time.sleep(0.02)
    return [f"{process.pid} of {process.ppid()}: {process.cmdline()}" for process in found]


def kill_all(mark: str) -> None:
    """SIGKILL every process of a run."""
    for _ in range(50):
        found = alive(mark)
        if not found:
            return
        for process in found:
            try:
                process.send_signal(signal.SIGKILL)
            except psutil.Error:
                continue
        time.sleep(0.02)

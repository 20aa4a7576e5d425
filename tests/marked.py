"""Marks that find every process of a run.

Its processes are found and ended, whatever became of the run itself.

A mark is an environment variable. A process shows the environment that it was started with for as
long as it lives, whatever it does to its session, group, parent or `os.environ`.
"""

import signal
import time
from pathlib import Path
from uuid import uuid4

import psutil

_NAME = "TESTED_RUN"


def marked() -> tuple[str, dict[str, str]]:
    """A new mark and its environment.

    A process and its descendants carry the mark in that environment.
    """
    mark = uuid4().hex
    return mark, {_NAME: mark}


def alive(mark: str) -> list[psutil.Process]:
    """Processes of a run that are still there.

    A process that only waits to be reaped is not.
    """
    processes = []
    for process in psutil.process_iter():
        try:
            if process.status() == psutil.STATUS_ZOMBIE:
                continue
            if process.environ().get(_NAME) == mark:
                processes.append(process)
        except psutil.Error:
            continue
    return processes


def left_behind(mark: str, within: float = 30.0) -> list[str]:
    """Processes alive after a run's end.

    They are given a moment to go.
    """
    give_up = time.monotonic() + within
    while processes := alive(mark):
        if time.monotonic() > give_up:
            break
        time.sleep(0.02)
    return [f"{process.pid} of {process.ppid()}: {process.cmdline()}" for process in processes]


def wait_until_handled(pid: int, number: signal.Signals, seconds: float = 60.0) -> None:
    """Wait until a process has handled a signal.

    Two signals at once would count as one.
    """
    fields = {}
    give_up = time.monotonic() + seconds
    while time.monotonic() < give_up:
        time.sleep(
            0.3
        )  # the time that a process needs for it on a machine at rest, many times over
        try:
            text = Path(f"/proc/{pid}/status").read_text()
        except OSError:
            return  # it has ended
        fields = dict(line.split(":\t", 1) for line in text.splitlines() if ":\t" in line)
        pending = int(fields["SigPnd"], 16) | int(fields["ShdPnd"], 16)
        if not pending >> (number - 1) & 1 and fields["State"][0] != "R":
            return


def kill_all(mark: str) -> None:
    """SIGKILL every process of a run."""
    for _ in range(50):
        processes = alive(mark)
        if not processes:
            return
        for process in processes:
            try:
                process.send_signal(signal.SIGKILL)
            except psutil.Error:
                continue
        time.sleep(0.02)

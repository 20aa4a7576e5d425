"""Processes seen from outside: what a worker and its descendants hold, and their end."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import suppress
from time import monotonic, sleep

import psutil

# a process that the kernel cannot end at once (in uninterruptible sleep) is not waited for longer
_PATIENCE = 2.0


def resident(pid: int, whole: bool) -> int:
    """Bytes that a process holds in memory, with its children and theirs if `whole`; 0 if gone."""
    total = 0
    for process in _family(pid) if whole else _one(pid):
        with suppress(psutil.Error):
            total += process.memory_info().rss
    return total


def proportional(pid: int) -> int:
    """The same for a process and its descendants, what they share counted once (Linux)."""
    total = 0
    for process in _family(pid):
        with suppress(psutil.Error):
            held = process.memory_full_info()
            total += getattr(held, "pss", held.rss)
    return total


def halt(pid: int) -> None:
    """Stop a process where it is; it may be resumed."""
    with suppress(OSError):
        os.kill(pid, signal.SIGSTOP)
    sleep(0.001)  # it is delivered at the process's next step


def resume(pid: int) -> None:
    """Let a process that was halted go on."""
    with suppress(OSError):
        os.kill(pid, signal.SIGCONT)


def alive(pid: int) -> bool:
    """Whether a process exists and still runs."""
    with suppress(psutil.Error):
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    return False


def _one(pid: int) -> Iterator[psutil.Process]:
    with suppress(psutil.Error):
        yield psutil.Process(pid)


def _family(pid: int) -> list[psutil.Process]:
    with suppress(psutil.Error):
        process = psutil.Process(pid)
        return [process, *process.children(recursive=True)]
    return []


def end(pid: int) -> None:
    """Kill a worker and everything that it started.

    Its descendants, and who is left of its session once it has gone. A process that has left both
    (two forks and a session of its own) before the worker ended is out of reach.
    """
    doomed = {process.pid for process in _family(pid)}
    _kill({pid})  # it starts no more
    until = monotonic() + _PATIENCE
    while doomed and monotonic() < until:
        doomed |= _session(pid) | {child for one in doomed for child in _descendants(one)}
        doomed = {one for one in doomed if alive(one)}
        _kill(doomed)
        sleep(0.001)


def end_session(pid: int) -> None:
    """Kill what is left of the session of a worker that has ended."""
    _kill(_session(pid))


def _descendants(pid: int) -> set[int]:
    return {process.pid for process in _family(pid)}


def _session(pid: int) -> set[int]:
    found = set()
    for other in psutil.pids():
        with suppress(OSError):
            if os.getsid(other) == pid:
                found.add(other)
    return found


def _kill(pids: set[int]) -> None:
    for pid in pids:
        if pid > 1:  # 0 would be our own group
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)

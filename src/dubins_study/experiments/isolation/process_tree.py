"""Processes seen from outside: the memory of a worker and its descendants, and their end."""

from __future__ import annotations

import os
import signal
from contextlib import suppress
from time import monotonic, sleep

import psutil

# a process that the kernel cannot end at once (in uninterruptible sleep) is not waited for longer
_EXIT_WAIT_S = 2.0


def resident_bytes(pid: int) -> int:
    """Bytes that a process holds in memory; 0 if it is gone."""
    with suppress(psutil.Error):
        return int(psutil.Process(pid).memory_info().rss)
    return 0


def family_bytes(pid: int) -> int:
    """Bytes that a process and its descendants hold, what they share counted for each."""
    return sum(resident_bytes(process.pid) for process in _family(pid))


def proportional_bytes(pid: int) -> int:
    """Bytes that a process and its descendants hold, what they share counted once (Linux)."""
    total = 0
    for process in _family(pid):
        with suppress(psutil.Error):
            memory = process.memory_full_info()
            total += getattr(memory, "pss", memory.rss)
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


def children(pid: int) -> list[int]:
    """The living children of a process."""
    with suppress(psutil.Error):
        return [child.pid for child in psutil.Process(pid).children() if _alive(child.pid)]
    return []


def kill_family(pid: int) -> None:
    """Kill a process and its descendants, as far as they can be seen now."""
    kill({process.pid for process in _family(pid)})


def end(pid: int) -> None:
    """Kill a process, its descendants and its session, and wait for their end."""
    doomed = {process.pid for process in _family(pid)}
    kill({pid})  # it starts no more
    give_up = monotonic() + _EXIT_WAIT_S
    while doomed and monotonic() < give_up:
        doomed |= _session(pid) | {child.pid for one in doomed for child in _family(one)}
        doomed = {one for one in doomed if _alive(one)}
        kill(doomed)
        sleep(0.001)


def end_session(pid: int) -> None:
    """Kill what is left of the session of a process that has ended."""
    kill(_session(pid))


def kill(pids: set[int]) -> None:
    """Send SIGKILL to processes; those that are gone are passed over."""
    for pid in pids:
        if pid > 1:  # 0 would be our own group
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)


def _alive(pid: int) -> bool:
    with suppress(psutil.Error):
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    return False


def _family(pid: int) -> list[psutil.Process]:
    with suppress(psutil.Error):
        process = psutil.Process(pid)
        return [process, *process.children(recursive=True)]
    return []


def _session(pid: int) -> set[int]:
    members = set()
    for other in psutil.pids():
        with suppress(OSError):
            if os.getsid(other) == pid:
                members.add(other)
    return members

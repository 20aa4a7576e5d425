"""The global state of a worker process: put back after every solve to what it was before the
first one, so that no solver finds it changed by another."""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import decimal
import faulthandler
import gc
import locale
import os
import random
import resource
import signal
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path as FilePath
from time import monotonic
from typing import Any

import numpy as np

# every solve begins here, so that one which draws from the global generators can be repeated
SEED = 0

_SIGNALS = [int(s) for s in signal.Signals if s not in (signal.SIGKILL, signal.SIGSTOP)]
# without the enumerations that `signal` makes of numbers
_handler = _signal.getsignal


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


_ENVIRON, _ENVIRONB = os.environ, os.environb
# as the interpreter holds it: to decode every name and value takes longer than a quick solve
_ENVIRONMENT: dict[bytes, bytes] = os.environ._data  # type: ignore[attr-defined]


def _set_environment(kept: dict[bytes, bytes]) -> None:
    os.environ, os.environb = _ENVIRON, _ENVIRONB
    if kept != _ENVIRONMENT:
        for name in _ENVIRONMENT.keys() - kept.keys():
            del os.environb[name]
        os.environb.update(kept)


def _set_signals(kept: list[Any]) -> None:
    for number, handler in zip(_SIGNALS, kept, strict=True):
        if _handler(number) is not handler and handler is not None:
            signal.signal(number, handler)


def _set_streams(kept: tuple[Any, ...]) -> None:
    sys.stdin, sys.stdout, sys.stderr = kept


def _set_hooks(kept: tuple[Any, ...]) -> None:
    sys.excepthook, sys.unraisablehook, threading.excepthook, trace, profile = kept
    sys.settrace(trace)
    sys.setprofile(profile)


def _descriptors() -> list[int | None]:
    """Copies of stdin, stdout and stderr; None for one that is closed."""
    copies: list[int | None] = [None] * 3
    for number in range(3):
        with suppress(OSError):
            copies[number] = os.dup(number)
    return copies


def _set_descriptors(kept: list[int | None]) -> None:
    for number, copy in enumerate(kept):
        if copy is not None:
            with suppress(OSError):
                os.dup2(copy, number)
                os.close(copy)


def _disarm() -> None:
    """No timer goes off, and ends the process, in a later solve."""
    for timer in (signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF):
        signal.setitimer(timer, 0)
    faulthandler.cancel_dump_traceback_later()


# how a piece of state is read, and how it is put back
_STATE: tuple[tuple[Callable[[], Any], Callable[[Any], object]], ...] = (
    (os.getcwd, os.chdir),
    (_ENVIRONMENT.copy, _set_environment),
    (lambda: list(warnings.filters), lambda kept: warnings.filters.__setitem__(slice(None), kept)),  # type: ignore[index]
    (np.geterr, lambda kept: np.seterr(**kept)),
    (decimal.getcontext, decimal.setcontext),
    (lambda: decimal.getcontext().copy(), lambda kept: decimal.setcontext(kept.copy())),
    (lambda: locale.setlocale(locale.LC_ALL), lambda kept: locale.setlocale(locale.LC_ALL, kept)),
    (lambda: list(sys.path), lambda kept: sys.path.__setitem__(slice(None), kept)),
    (sys.getrecursionlimit, sys.setrecursionlimit),
    (sys.getswitchinterval, sys.setswitchinterval),
    (gc.isenabled, lambda kept: gc.enable() if kept else gc.disable()),
    (
        lambda: (
            *(sys.excepthook, sys.unraisablehook, threading.excepthook),
            *(sys.gettrace(), sys.getprofile()),
        ),
        _set_hooks,
    ),
    (_umask, os.umask),
    (lambda: [_handler(number) for number in _SIGNALS], _set_signals),
    (
        lambda: signal.pthread_sigmask(signal.SIG_BLOCK, ()),
        lambda kept: signal.pthread_sigmask(signal.SIG_SETMASK, kept),
    ),
    (lambda: (sys.stdin, sys.stdout, sys.stderr), _set_streams),
)


def _limits() -> list[tuple[int, int]]:
    return [resource.getrlimit(number) for number in _LIMITS]


def _set_limits(kept: list[tuple[int, int]]) -> None:
    for number, limits in zip(_LIMITS, kept, strict=True):
        resource.setrlimit(number, limits)


_LIMITS = sorted({getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")})

# the same for what a process may be refused to put back
_GRANTED: tuple[tuple[Callable[[], Any], Callable[[Any], object]], ...] = (
    (_limits, _set_limits),
    (lambda: os.getpriority(os.PRIO_PROCESS, 0), lambda n: os.setpriority(os.PRIO_PROCESS, 0, n)),
)
if hasattr(os, "sched_getaffinity"):
    _GRANTED += ((lambda: os.sched_getaffinity(0), lambda kept: os.sched_setaffinity(0, kept)),)


@cache
def _at_first() -> tuple[list[Any], list[Any]]:
    """What `_STATE` and `_GRANTED` hold before the first solve, and then before every one."""
    return [read() for read, _ in _STATE], [read() for read, _ in _GRANTED]


_PAGE = os.sysconf("SC_PAGE_SIZE")
# of its memory that a worker may have lost to what its solvers leave, and files left open
_LEAKED, _LEFT_OPEN = 0.25, 64
_LOOK_EVERY = 0.02  # s
_next_look = 0.0
_bound = float("inf")
_held = {"bytes": 0, "files": 0}  # at the start, and by the libraries that were loaded since


def bound(memory: int) -> None:
    """Say how many bytes the process may hold."""
    global _bound
    _bound = memory
    _held.update(_holds())


def _holds() -> dict[str, int]:
    """Resident bytes and open files of this process; none where /proc does not tell."""
    with suppress(OSError, ValueError, IndexError):
        resident = int(FilePath("/proc/self/statm").read_bytes().split()[1])
        return {"bytes": resident * _PAGE, "files": len(os.listdir("/proc/self/fd"))}  # noqa: PTH208
    return {"bytes": 0, "files": 0}


def _leaks() -> bool:
    """Whether too much was left behind; looked at now and then, since reading /proc takes time."""
    global _next_look
    if monotonic() < _next_look:
        return False
    _next_look = monotonic() + _LOOK_EVERY
    lost = {what: now - _held[what] for what, now in _holds().items()}
    return lost["bytes"] > _LEAKED * _bound or lost["files"] > _LEFT_OPEN


def _granted_again(value: Any, read: Callable[[], Any], put_back: Callable[[Any], object]) -> bool:
    if read() == value:
        return True
    with suppress(Exception):  # it was refused
        put_back(value)
    return bool(read() == value)


class Containment:
    """Whether a solver has left what cannot be undone.

    That is a thread, less than it had been given, files open or much memory taken: other solvers
    would run into limits in its place.
    """

    def __init__(self) -> None:
        self.worn = False
        self._threads = set(threading.enumerate())

    def pardon(self, loaded: bool) -> None:
        """Threads that are there by now are a library's own, and may stay."""
        self._threads.update(threading.enumerate())
        if loaded:
            _held.update(_holds())

    def check(self, granted: list[Any]) -> None:
        """Put back what may be refused, and look for what is left behind; worn if that fails."""
        self.worn = True
        with suppress(Exception):  # the answer is there: it is not to blame for what comes after
            pairs = zip(granted, _GRANTED, strict=True)
            kept = [_granted_again(value, *state) for value, state in pairs]
            _one_thread()  # which may open files: limits come before
            new = not self._threads.issuperset(threading.enumerate())
            self.worn = new or not all(kept) or _leaks()


@contextmanager
def contained() -> Iterator[Containment]:
    """Global generators seeded; on leaving, state that others rely on is what it was."""
    random.seed(SEED)
    np.random.seed(SEED)  # noqa: NPY002
    found = Containment()
    kept, granted = _at_first()
    descriptors = _descriptors()
    try:
        yield found
    finally:
        _disarm()
        _set_descriptors(descriptors)
        for value, (_, put_back) in zip(kept, _STATE, strict=True):
            with suppress(Exception):  # e.g. a directory that is gone: the rest is put back still
                put_back(value)
        found.check(granted)


_libraries: tuple[int, Any] = (0, None)


def _one_thread() -> None:
    """Pin the thread pools again, those of libraries that were loaded meanwhile too."""
    global _libraries
    from threadpoolctl import ThreadpoolController

    if _libraries[0] != len(sys.modules):
        _libraries = (len(sys.modules), ThreadpoolController())
    _libraries[1].limit(limits=1)

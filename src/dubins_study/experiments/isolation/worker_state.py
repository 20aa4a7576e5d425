"""What a worker process shares with whatever it runs: a solve that changes it costs the worker.

Nothing is put back, since what one forgets to put back would reach another solver's answer.
"""

from __future__ import annotations

import _signal  # type: ignore[import-not-found]
import decimal
import gc
import locale
import os
import random
import resource
import signal
import sys
import threading
import warnings
from contextlib import suppress
from pathlib import Path as FilePath
from time import monotonic
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from dubins_study.experiments.isolation.sandbox import THREADS

# every solve begins here, so that one which draws from the global generators can be repeated
SEED = 0

_SIGNALS = [int(s) for s in signal.Signals if s not in (signal.SIGKILL, signal.SIGSTOP)]
_RLIMITS = sorted({getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")})
_TIMERS = signal.ITIMER_REAL, signal.ITIMER_VIRTUAL, signal.ITIMER_PROF
# as the interpreter holds it: to decode every name and value takes longer than a quick solve
_ENVIRONMENT: dict[bytes, bytes] = os.environ._data  # type: ignore[attr-defined]
# share of the memory limit that solves may leave behind, and files that they may leave open
_MAX_LEAK_SHARE, _MAX_OPEN_FILES = 0.25, 64
# between two looks at memory and files, which take longer than the others
_LEAK_INTERVAL_S = 0.02
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


def _state() -> tuple[Any, ...]:
    """What a solve must leave as it is; the threads of numerical libraries are looked at apart."""
    context, mask = decimal.getcontext(), os.umask(0)
    os.umask(mask)
    return (
        *(os.getcwd(), mask, os.getpriority(os.PRIO_PROCESS, 0)),  # noqa: PTH109
        *(id(os.environ), _ENVIRONMENT.copy(), id(sys.path), sys.path.copy()),
        *(warnings.filters[:], np.geterr(), locale.setlocale(locale.LC_ALL)),
        *(id(context), context.prec, context.rounding, context.Emin, context.Emax),
        *(sys.getrecursionlimit(), sys.getswitchinterval(), gc.isenabled()),
        *(sys.excepthook, sys.unraisablehook, threading.excepthook),
        *(sys.gettrace(), sys.getprofile(), threading.enumerate()),
        # without the enumerations that `signal` makes of numbers
        [_signal.getsignal(number) for number in _SIGNALS],
        _signal.pthread_sigmask(signal.SIG_BLOCK, ()),
        [signal.getitimer(timer)[0] > 0 for timer in _TIMERS],
        [resource.getrlimit(number) for number in _RLIMITS],
        *(sys.stdin, sys.stdout, sys.stderr, *map(_file, range(3))),
        os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None,
    )


def _file(number: int) -> tuple[int, int] | None:
    """The device and the number of the file that a descriptor leads to."""
    with suppress(OSError):
        status = os.fstat(number)
        return status.st_dev, status.st_ino
    return None


def seed() -> None:
    """Seed the global generators as before every solve."""
    random.seed(SEED)
    np.random.seed(SEED)  # noqa: NPY002


class WorkerState:
    """The state of this process as it is accepted; see `changed`.

    Args:
        memory_limit: bytes that the process may hold.
    """

    def __init__(self, memory_limit: float):
        self._max_leak = _MAX_LEAK_SHARE * memory_limit
        self._modules, self._libraries = 0, ThreadpoolController()
        self._next_leak_check = 0.0
        self.accept()

    def accept(self) -> None:
        """Take the state as it is now: what a solver's libraries do while they are loaded stays."""
        self._pin_new_libraries()
        self._accepted = _state()
        self._resident, self._files = _leakable()

    def changed(self) -> bool:
        """Whether the state is no longer as it was accepted: another solve could not rely on it."""
        try:
            state = _state()
        except Exception:  # e.g. the working directory was removed
            return True
        return state != self._accepted or self._threads_changed() or self._leaks()

    def _pin_new_libraries(self) -> None:
        """Keep the libraries that were loaded since to one thread."""
        if self._modules != len(sys.modules):
            self._modules, self._libraries = len(sys.modules), ThreadpoolController()
            self._libraries.limit(limits=THREADS)

    def _threads_changed(self) -> bool:
        known = self._libraries.lib_controllers
        changed = any((library.num_threads or THREADS) != THREADS for library in known)
        self._pin_new_libraries()  # of a library that a solve has loaded, nothing is expected yet
        return changed

    def _leaks(self) -> bool:
        if monotonic() < self._next_leak_check:
            return False
        self._next_leak_check = monotonic() + _LEAK_INTERVAL_S
        resident, files = _leakable()
        return resident - self._resident > self._max_leak or files - self._files > _MAX_OPEN_FILES


def _leakable() -> tuple[int, int]:
    """Resident bytes and open files of this process; zeros where /proc does not tell."""
    with suppress(OSError, ValueError, IndexError):
        resident = int(FilePath("/proc/self/statm").read_bytes().split()[1])
        return resident * _PAGE_BYTES, len(os.listdir("/proc/self/fd"))  # noqa: PTH208
    return 0, 0

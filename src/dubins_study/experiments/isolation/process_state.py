"""Limits of a worker process, and its shared state.

The process sets the limits itself; all its solves share the state.

If a plug-in's solve changes the state, the worker ends. The state is not restored instead: a part
that we forget to restore would affect later answers. Our own solvers are not watched in a run:
`check-solver` tests that they change nothing.
"""

from __future__ import annotations

import gc
import locale
import os
import random
import resource
import signal
import sys
import threading
import time
import warnings
from contextlib import suppress
from operator import attrgetter
from pathlib import Path as FilePath
from typing import Any

import numpy as np
import psutil
from threadpoolctl import ThreadpoolController, threadpool_limits

THREADS = 1
# Environment in which numerical libraries start no threads.
ONE_THREAD = dict.fromkeys(
    (f"{library}_NUM_THREADS" for library in ("OMP", "OPENBLAS", "MKL")), str(THREADS)
)
# Bytes beyond the memory limit at which a solver's own allocations fail. The pool checks the limit
# every few hundredths of a second; a solver may take more memory between two checks.
_MARGIN_BYTES = 512 * 2**20
# Seed of the global random generators before every solve, so that a solve can be repeated.
SEED = 0

_SIGNALS = [s for s in signal.Signals if s not in (signal.SIGKILL, signal.SIGSTOP)]
# Share of the memory limit that solves may leave allocated.
_MAX_LEAK_SHARE = 0.25
# Number of files that solves may leave open.
_MAX_OPEN_FILES = 64
# Functions that a solver must not replace.
_clocks = attrgetter("time", "monotonic", "perf_counter", "process_time", "perf_counter_ns")


def bound_process(memory_bytes: int) -> None:
    """Limit this process: memory, core dumps and threads.

    Allocations fail far beyond the memory limit, no core dumps are written, and each library uses
    one thread.
    """
    # The least of our limit and those in force: an outer limit is never raised.
    bounds = [memory_bytes + _MARGIN_BYTES, *resource.getrlimit(resource.RLIMIT_DATA)]
    soft = min(bound for bound in bounds if bound != resource.RLIM_INFINITY)
    resource.setrlimit(resource.RLIMIT_DATA, (soft, bounds[-1]))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    # NUMBA_NUM_THREADS is set only here: Numba reads it at once and fails if its threads run.
    os.environ.update(ONE_THREAD | {"NUMBA_NUM_THREADS": str(THREADS)})
    threadpool_limits(THREADS)  # also of libraries that are loaded already


def _state() -> dict[str, Any]:
    """Name -> value of state that libraries may change.

    Messages show the names. The thread counts of libraries are checked apart.
    """
    return {
        "working directory": os.getcwd(),  # noqa: PTH109
        "environment variables": os.environ.copy(),
        "sys.path": sys.path.copy(),
        "warnings filters": warnings.filters[:],
        "numpy's error handling": np.geterr(),
        "locale": locale.setlocale(locale.LC_ALL),
        "recursion limit": sys.getrecursionlimit(),
        "garbage collector": gc.isenabled(),
        "threads": threading.enumerate(),
        "signal handlers": [signal.getsignal(number) for number in _SIGNALS],
        "clock": _clocks(time),
        "timers": signal.getitimer(signal.ITIMER_REAL)[0] > 0,
        "standard streams": (sys.stdin, sys.stdout, sys.stderr, *map(_file, range(3))),
        "processor affinity": (
            os.sched_getaffinity(0) if hasattr(os, "sched_getaffinity") else None
        ),
    }


def _file(number: int) -> tuple[int, int] | None:
    """Device and inode of a descriptor's file, or None.

    None means that the descriptor is closed.
    """
    with suppress(OSError):
        status = os.fstat(number)
        return status.st_dev, status.st_ino
    return None


def seed() -> None:
    """Seed the global random generators; called before every solve."""
    random.seed(SEED)
    np.random.seed(SEED)  # noqa: NPY002


class ProcessState:
    """Detects changes of this process since `accept`."""

    def __init__(self, memory_limit: float):
        self._max_leak = _MAX_LEAK_SHARE * memory_limit
        self._process = psutil.Process()
        self._modules = 0
        self.accept()

    def accept(self) -> None:
        """Take the current state as the accepted one.

        Called after a solver is loaded: what its libraries changed then is no fault.
        """
        self._pin_new_libraries()
        self._accepted = _state()
        self._resident, self._files = self._leakable()

    def changes(self) -> list[str]:
        """Names of the state that differs from the accepted.

        Empty if nothing differs. Thread counts are compared only if the named state is the same;
        memory and open files only if the thread counts are, too.
        """
        try:
            state = _state()
        except Exception:  # e.g. the working directory was removed
            return ["state that can be read"]
        if state != self._accepted:
            return [name for name, value in state.items() if value != self._accepted[name]]
        if self._threads_changed():
            return ["thread counts of numerical libraries"]
        resident, files = self._leakable()
        if resident - self._resident > self._max_leak or files - self._files > _MAX_OPEN_FILES:
            return ["memory or files"]
        return []

    def _pin_new_libraries(self) -> None:
        """Limit newly loaded libraries to one thread.

        Nothing is done if no module was imported since the last call.
        """
        if self._modules != len(sys.modules):
            self._modules = len(sys.modules)
            self._libraries = ThreadpoolController()
            self._libraries.limit(limits=THREADS)

    def _threads_changed(self) -> bool:
        libraries = self._libraries.lib_controllers
        changed = any((library.num_threads or THREADS) != THREADS for library in libraries)
        self._pin_new_libraries()  # only now: a library that the solve loaded may use any number
        return changed

    def _leakable(self) -> tuple[int, int]:
        """Resident bytes and open files of this process.

        Both are 0 if the system does not tell them.
        """
        with suppress(OSError):
            return self._process.memory_info().rss, self._process.num_fds()
        return 0, 0


def peak_kib(*, reset: bool = False) -> int:
    """Peak of resident memory since the last reset (KiB).

    With `reset` the measurement begins anew before the peak is read. The peak is 0 on systems other
    than Linux, where it cannot be known.
    """
    with suppress(OSError):
        if reset:
            FilePath("/proc/self/clear_refs").write_bytes(b"5")
        status = FilePath("/proc/self/status").read_bytes()
        return int(status.partition(b"VmHWM:")[2].split()[0])
    return 0

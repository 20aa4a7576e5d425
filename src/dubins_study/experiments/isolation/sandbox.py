"""Limits that a process sets itself before it runs other people's code. POSIX; best on Linux."""

from __future__ import annotations

import os
import resource
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits

THREADS = 1
_VARIABLES = tuple(f"{library}_NUM_THREADS" for library in ("OMP", "OPENBLAS", "MKL"))
# environment in which numerical libraries start no threads
ONE_THREAD = dict.fromkeys(_VARIABLES, str(THREADS))
# Bytes beyond the memory limit at which a solver's own allocations fail. The pool checks the limit
# every few hundredths of a second; the margin is for what a solver takes between two checks.
_MARGIN_BYTES = 512 * 2**20


def bound_memory(memory_bytes: int) -> None:
    """Make allocations fail that go far beyond a limit; switch core dumps off."""
    if not hasattr(resource, "RLIMIT_DATA"):
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    bounds = [limit for limit in (soft, hard) if limit != resource.RLIM_INFINITY]
    wanted = min([memory_bytes + _MARGIN_BYTES, *bounds])
    resource.setrlimit(resource.RLIMIT_DATA, (wanted, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


def pin_threads() -> None:
    """Limit every numerical library of this process, loaded or not, to one thread permanently."""
    # NUMBA_NUM_THREADS is set only here: Numba reads it at once and fails if its threads run.
    os.environ.update(dict.fromkeys((*_VARIABLES, "NUMBA_NUM_THREADS"), str(THREADS)))
    threadpool_limits(THREADS)


_pinning = threading.Lock()
_pinned_count = 0
_environment_before: dict[str, str | None] = {}


@contextmanager
def pinned_threads() -> Iterator[None]:
    """Pin the thread counts inside the `with` block; restore the caller's settings afterwards."""
    global _pinned_count
    with _pinning:
        if not _pinned_count:
            _environment_before.update({name: os.environ.get(name) for name in _VARIABLES})
        _pinned_count += 1
        os.environ.update(ONE_THREAD)
    try:
        with threadpool_limits(THREADS):
            yield
    finally:
        with _pinning:
            _pinned_count -= 1
            # If several threads run at the same time, the last one restores the environment.
            for name, value in () if _pinned_count else _environment_before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value

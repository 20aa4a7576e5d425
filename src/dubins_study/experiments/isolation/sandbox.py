"""What a worker process does to itself before it runs other people's code. POSIX; best on Linux."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing import forkserver
from multiprocessing.connection import Connection
from typing import Any

THREADS = 1
_VARIABLES = tuple(f"{library}_NUM_THREADS" for library in ("OMP", "OPENBLAS", "MKL"))
_PR_SET_PDEATHSIG = 1
# beyond the memory limit, which the supervisor reads every few hundredths of a second: as much as
# a solver may take between two readings before its own allocations fail
_MARGIN = 512 * 2**20


def isolate(output: Connection, memory: int) -> None:
    """Make this process one that can be killed whole, and that hurts nobody else.

    It leads a session of its own, so that Ctrl-C in a terminal passes it by and its children can
    be told; what it and its solvers print goes to `output`; each numerical
    library has one thread; allocations far beyond `memory` bytes fail.
    """
    with suppress(OSError):  # it leads one already
        os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    _redirect(output)
    _bound_memory(memory)
    pin_threads()


def depend() -> None:
    """Make this process end with its supervisor, even in an endless loop.

    The kernel ends it with the server that it was forked from, and that ends once nobody holds a
    line to it but the supervisor: a worker's own copy of the line is closed.
    """
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    server: Any = forkserver._forkserver
    if server._forkserver_alive_fd is not None:
        os.close(server._forkserver_alive_fd)
        server._forkserver_alive_fd = server._forkserver_address = None


def _redirect(output: Connection) -> None:
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    for number in (1, 2):
        os.dup2(output.fileno(), number)
    output.close()
    # the parent may have had none, or captured ones
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = open(  # noqa: SIM115
            number, "w", encoding="utf-8", errors="replace", buffering=1, closefd=False
        )
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def _bound_memory(memory: int) -> None:
    import resource

    if not hasattr(resource, "RLIMIT_DATA"):
        return
    wanted = memory + _MARGIN
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    lower = [wanted, *(limit for limit in (soft, hard) if limit != resource.RLIM_INFINITY)]
    resource.setrlimit(resource.RLIMIT_DATA, (min(lower), hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


def pin_threads() -> None:
    """Keep every numerical library of this process, loaded or not, to one thread for good."""
    from threadpoolctl import threadpool_limits

    # Numba follows its variable at once, and fails where its threads run already: only here
    os.environ.update(dict.fromkeys((*_VARIABLES, "NUMBA_NUM_THREADS"), str(THREADS)))
    threadpool_limits(THREADS)


_pinning, _pinned = threading.Lock(), list[int]()
_before: dict[str, str | None] = {}


@contextmanager
def pinned_threads() -> Iterator[None]:
    """The same for a while: the caller's own settings come back."""
    from threadpoolctl import threadpool_limits

    with _pinning:
        if not _pinned:
            _before.update({name: os.environ.get(name) for name in _VARIABLES})
        _pinned.append(1)
        os.environ.update(dict.fromkeys(_VARIABLES, str(THREADS)))
    try:
        with threadpool_limits(THREADS):
            yield
    finally:
        with _pinning:
            _pinned.pop()
            # the last of several threads that run something at once
            for name, value in () if _pinned else _before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value

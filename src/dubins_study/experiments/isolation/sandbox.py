"""What a process does to itself before it runs other people's code. POSIX; best on Linux."""

from __future__ import annotations

import ctypes
import os
import resource
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from threadpoolctl import threadpool_limits

THREADS = 1
_VARIABLES = tuple(f"{library}_NUM_THREADS" for library in ("OMP", "OPENBLAS", "MKL"))
_PR_SET_PDEATHSIG = 1
# beyond the memory limit, which the pool checks every few hundredths of a second: as much as a
# solver may take between two checks before its own allocations fail
_MARGIN_BYTES = 512 * 2**20


def die_with_parent() -> None:
    """Have the kernel end this process with its parent, even in an endless loop (Linux)."""
    parent = os.getppid()
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended just now
        os._exit(1)


def lead_session() -> None:
    """Make this process the leader of a session: Ctrl-C in a terminal passes it by."""
    with suppress(OSError):  # it leads one already
        os.setsid()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def redirect(output: int) -> None:
    """Read stdin from nowhere, and write stdout and stderr to a pipe, which is closed here."""
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    for number in (1, 2):
        os.dup2(output, number)
    os.close(output)
    # the caller may have had none, or captured ones
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = open(  # noqa: SIM115
            number, "w", encoding="utf-8", errors="replace", buffering=1, closefd=False
        )
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def bound_memory(memory_bytes: int) -> None:
    """Let allocations fail that go far beyond a limit, and write no core dumps."""
    if not hasattr(resource, "RLIMIT_DATA"):
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    bounds = [limit for limit in (soft, hard) if limit != resource.RLIM_INFINITY]
    wanted = min([memory_bytes + _MARGIN_BYTES, *bounds])
    resource.setrlimit(resource.RLIMIT_DATA, (wanted, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))


def pin_threads() -> None:
    """Keep every numerical library of this process, loaded or not, to one thread for good."""
    # Numba follows its variable at once, and fails where its threads run already: only here
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
        os.environ.update(dict.fromkeys(_VARIABLES, str(THREADS)))
    try:
        with threadpool_limits(THREADS):
            yield
    finally:
        with _pinning:
            _pinned_count -= 1
            # the last of several threads that run something at once restores them
            for name, value in () if _pinned_count else _environment_before.items():
                if value is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = value

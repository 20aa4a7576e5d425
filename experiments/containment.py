"""The global state of a worker process: put back after every solve, so that no solver finds it
changed by the one before."""

from __future__ import annotations

import decimal
import locale
import os
import random
import signal
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np

# every solve begins here, so that one which draws from the global generators can be repeated
SEED = 0

_SIGNALS = [s for s in signal.Signals if s not in (signal.SIGKILL, signal.SIGSTOP)]


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _set_environment(kept: dict[Any, Any]) -> None:
    if dict(os.environ) != kept:
        for name in set(os.environ) - set(kept):
            del os.environ[name]
        os.environ.update(kept)


def _set_signals(kept: list[Any]) -> None:
    for number, handler in zip(_SIGNALS, kept, strict=True):
        if signal.getsignal(number) is not handler and handler is not None:
            signal.signal(number, handler)


def _set_streams(kept: tuple[Any, ...]) -> None:
    sys.stdin, sys.stdout, sys.stderr = kept


# how a piece of state is read, and how it is put back
_STATE: tuple[tuple[Callable[[], Any], Callable[[Any], object]], ...] = (
    (os.getcwd, os.chdir),
    (lambda: dict(os.environ), _set_environment),
    (lambda: list(warnings.filters), lambda kept: warnings.filters.__setitem__(slice(None), kept)),  # type: ignore[index]
    (np.geterr, lambda kept: np.seterr(**kept)),
    (decimal.getcontext, decimal.setcontext),
    (lambda: decimal.getcontext().copy(), decimal.setcontext),
    (lambda: locale.setlocale(locale.LC_ALL), lambda kept: locale.setlocale(locale.LC_ALL, kept)),
    (lambda: list(sys.path), lambda kept: sys.path.__setitem__(slice(None), kept)),
    (sys.getrecursionlimit, sys.setrecursionlimit),
    (_umask, os.umask),
    (lambda: [signal.getsignal(number) for number in _SIGNALS], _set_signals),
    (lambda: (sys.stdin, sys.stdout, sys.stderr), _set_streams),
)


@contextmanager
def contained() -> Iterator[None]:
    """Global generators seeded; on leaving, state that others rely on is what it was."""
    random.seed(SEED)
    np.random.seed(SEED)  # noqa: NPY002
    kept = [read() for read, _ in _STATE]
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        for value, (_, put_back) in zip(kept, _STATE, strict=True):
            with suppress(Exception):  # e.g. a directory that is gone: the rest is put back still
                put_back(value)
        _one_thread()


_libraries: tuple[int, Any] = (0, None)


def _one_thread() -> None:
    """Pin the thread pools again, those of libraries that were loaded meanwhile too."""
    global _libraries
    from threadpoolctl import ThreadpoolController

    if _libraries[0] != len(sys.modules):
        _libraries = (len(sys.modules), ThreadpoolController())
    _libraries[1].limit(limits=1)

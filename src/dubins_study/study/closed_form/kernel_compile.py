"""How loops over rows are compiled, kept between sessions and run in threads.

Strict IEEE arithmetic, no `fastmath`; a division by zero is an infinity, as in NumPy.
"""

from __future__ import annotations

import hashlib
import logging
import os
from collections.abc import Callable
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import event
from numba.extending import register_jitable
from numpy.typing import ArrayLike

from dubins_study.study.path import FloatArray

_PACKAGE = __package__.split(".")[0]
SMALL = 32768  # rows; below, waking a thread costs more than it saves

Function = TypeVar("Function", bound=Callable[..., Any])
Loop = Callable[..., Any]  # over arrays that callers unpack: no checker could count them


# What is compiled, by the module of its caller, and how long that takes (s of one core of a
# server of 2026): only what a call needs, once after each installation.
_COMPILED = {
    "route.": "the search of routes: some 15 s",
    "closed_form.kernel": "the closed form of frames: some 4 s",
    "closed_form.pose_kernel": "the closed form of frames with final headings: some 6 s",
    "check.verdict_frame": "the check of frames: some 5 s",
    "check.": "certificates of frames: some 10 s",
}


class _Announcement(event.Listener):
    """Logs a warning before each group of loops that no cache holds is compiled."""

    def __init__(self) -> None:
        self.announced: set[str] = set()
        self.depth = 0  # a function's callees are compiled while it is

    def on_start(self, compiling: event.Event) -> None:
        self.depth += 1
        module = compiling.data["dispatcher"].py_func.__module__
        within = module.removeprefix(f"{_PACKAGE}.study.")
        text = next((text for start, text in _COMPILED.items() if within.startswith(start)), None)
        if text is None or text in self.announced or self.depth > 1:
            return
        self.announced.add(text)
        # on stderr where logging is not set up: some seconds of silence look like a fault
        logging.getLogger(__name__).warning("compiling %s, once after each installation", text)

    def on_end(self, compiled: event.Event) -> None:
        self.depth -= 1


event.register("numba:compile", _Announcement())  # type: ignore[no-untyped-call]

_FILES = sorted(Path(__file__).parents[1].rglob("*.py"))
_SOURCES = hashlib.sha256(b"".join(file.read_bytes() for file in _FILES)).hexdigest()[:12]


def loop_input(values: ArrayLike) -> FloatArray:
    """The values as every loop reads them: contiguous doubles in an array that is read-only.

    Numba compiles a loop anew, for seconds, for every mix of writable, read-only and strided
    arrays that it is called with.
    """
    array = np.ascontiguousarray(values, np.float64).view()
    array.flags.writeable = False
    return array


_callable: set[FunctionType] = set()


def _with_callees(function: Function) -> Function:
    """The function, after Numba was told to compile the plain functions that it calls by name.

    They stay plain for Python, which runs them for one row without loading Numba.
    """
    named = map(function.__globals__.get, function.__code__.co_names)
    for called in {value for value in named if isinstance(value, FunctionType)} - _callable:
        if called.__module__.startswith(_PACKAGE):
            _callable.add(called)
            register_jitable(_with_callees(called))
    return function


def inlined(function: Function) -> Function:
    """Compiled by Numba into its caller, so that the caller's loop can be vectorised."""
    compile_it = numba.njit(error_model="numpy", forceinline=True)
    return cast(Function, compile_it(_with_callees(function)))


def separate(function: Function) -> Function:
    """Compiled by Numba as a function of its own: for rows that a vector loop leaves."""
    return cast(Function, numba.njit(error_model="numpy")(_with_callees(function)))


def compiled(function: Loop) -> Loop:
    """Compiled by Numba for one thread."""
    return _kept(function, {})


def threaded(function: Loop) -> Callable[[int], Loop]:
    """Compiled by Numba with its `numba.prange` shared out among threads, and for one thread.

    Returns the function that chooses between the two by the number of rows.
    """
    threads, alone = _kept(function, {"parallel": True}), _kept(function, {})
    return lambda n: threads if n >= SMALL and may_use_threads() else alone


def _kept(function: Loop, options: dict[str, Any]) -> Loop:
    # Numba's cache is keyed by this name and by the function's own file. What is inlined,
    # and every constant, may come from another: without a digest of them a change would go unseen.
    function.__qualname__ += f"_{_SOURCES}"
    options |= {"error_model": "numpy", "nogil": True}
    function = _with_callees(function)
    try:
        return cast(Loop, numba.njit(cache=True, **options)(function))
    except RuntimeError:  # no folder that a cache could be written to: compile every time
        return cast(Loop, numba.njit(**options)(function))


class _Threads:
    ran = False
    lost = False


def _after_fork() -> None:
    _Threads.lost = _Threads.ran


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)


def may_use_threads() -> bool:
    """Whether loops may run in several threads; to be asked right before running one.

    Not in a child forked from a process whose threads ran: GNU OpenMP ends it on the spot.
    """
    _Threads.ran = True
    return not _Threads.lost

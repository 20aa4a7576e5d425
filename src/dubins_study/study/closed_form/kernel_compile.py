"""Compile loops over rows.

It also keeps them between sessions and runs them in threads. Arithmetic is strict IEEE, without
`fastmath`; a division by zero is an infinity, as in NumPy.
"""

from __future__ import annotations

import hashlib
import logging
import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar, cast

import numba
import numpy as np
from numba.core import event
from numba.extending import register_jitable
from numpy.typing import ArrayLike

from dubins_study.study.arrays import FloatArray

_PACKAGE = __package__.split(".")[0]
SMALL = 32768  # rows; below, starting a thread costs more than it saves
PIECE = 4096  # rows: a thread gets a multiple of this
PIECES = 4  # pieces a thread, so that all threads end at nearly the same time

Function = TypeVar("Function", bound=Callable[..., Any])
Loop = Callable[..., Any]  # takes arrays that callers unpack, which no type checker can count


# Compiled parts by package or module, and about how many seconds each takes to compile. A warning
# on stderr says so before the first loop that no cache holds: silence looks like a fault.
_PARTS = {
    "study.route": ("the search for routes", 15),
    "study.closed_form.pose_kernel": ("the loops over legs with a final heading", 15),
    "study": ("the loops over legs with a free final heading", 15),
}


class _Announcement(event.Listener):
    """Logs a warning before a part's loops are compiled."""

    def __init__(self) -> None:
        self.announced: set[str] = set()
        self.depth = 0  # a loop's callees are compiled during its own compilation

    def on_start(self, compiling: event.Event) -> None:
        self.depth += 1
        module = compiling.data["dispatcher"].py_func.__module__
        part = next((part for part in _PARTS if module.startswith(f"{_PACKAGE}.{part}")), None)
        announced = self.announced & {part}
        if part == "study":
            # the loops of the check are compiled after those over legs of either kind: one warning
            announced = self.announced - {"study.route"}
        if part is None or announced or self.depth > 1:
            return
        self.announced.add(part)
        loops, seconds = _PARTS[part]
        logging.getLogger(__name__).warning(
            f"compiling {loops}: about {seconds} s, once after each installation"
        )

    def on_end(self, compiled: event.Event) -> None:
        self.depth -= 1


event.register("numba:compile", _Announcement())  # type: ignore[no-untyped-call]

# the sources that a loop can call or take a constant from
_STUDY = Path(__file__).parents[1]
_FOLDERS = ("", "closed_form", "route", "tour", "check", "judging")
_FILES = sorted(chain.from_iterable((_STUDY / folder).glob("*.py") for folder in _FOLDERS))
_SOURCES = hashlib.sha256(b"".join(file.read_bytes() for file in _FILES)).hexdigest()[:12]


def loop_input(values: ArrayLike) -> FloatArray:
    """Values as every loop reads them.

    They are contiguous doubles in a read-only array. Numba compiles a loop anew, for seconds, for
    every mix of writable, read-only and strided arrays that it is called with.
    """
    array = np.ascontiguousarray(values, np.float64).view()
    array.flags.writeable = False
    return array


_callable: set[FunctionType] = set()


def _with_callees(function: Function) -> Function:
    """Register a function's plain callees with Numba.

    Numba compiles the plain functions that it calls by name. They stay plain for Python, which runs
    them for one row without loading Numba. The function itself is returned.
    """
    values = map(function.__globals__.get, function.__code__.co_names)
    for callee in {value for value in values if isinstance(value, FunctionType)} - _callable:
        if callee.__module__.startswith(_PACKAGE):
            _callable.add(callee)
            register_jitable(_with_callees(callee))
    return function


def inlined(function: Function) -> Function:
    """Compile a function into its caller.

    Numba does so, and the caller's loop can then be vectorised.
    """
    compile_it = numba.njit(error_model="numpy", forceinline=True)
    return cast(Function, compile_it(_with_callees(function)))


def separate(function: Function) -> Function:
    """Compile a function separately, by Numba.

    Compiled loops call it, and it is not inlined: for the few rows that a vector loop leaves, and
    for long functions.
    """
    return cast(Function, numba.njit(error_model="numpy")(_with_callees(function)))


def compiled(function: Loop) -> Loop:
    """Compile a loop by Numba, for one thread."""
    # Numba's cache is keyed by this name and by the function's own file. Inlined functions and
    # constants may come from other files: without a digest of them a change would go unseen.
    function.__qualname__ += f"_{_SOURCES}"
    options: dict[str, Any] = {"error_model": "numpy", "nogil": True}
    function = _with_callees(function)
    try:
        return cast(Loop, numba.njit(cache=True, **options)(function))
    except RuntimeError:  # no folder that a cache could be written to: compile every time
        return cast(Loop, numba.njit(**options)(function))


def threaded(function: Loop) -> Loop:
    """Compile a loop whose rows threads share.

    The function's first arguments are the first row and the row after the last; the first is a
    multiple of `PIECE`. The function that is returned takes the number of rows and the other
    arguments. Threads of Python's own need no second version of the loop, and a forked child may
    start them.
    """
    loop = compiled(function)

    def run(n: int, *arguments: Any) -> None:
        threads = int(vars(numba.config)["NUMBA_NUM_THREADS"])
        if n < SMALL or threads == 1:
            loop(0, n, *arguments)
            return
        rows = PIECE * math.ceil(n / (PIECE * PIECES * threads))
        with ThreadPoolExecutor(threads) as pool:
            pieces = [
                pool.submit(loop, begin, min(begin + rows, n), *arguments)
                for begin in range(0, n, rows)
            ]
            for piece in pieces:
                piece.result()

    return run

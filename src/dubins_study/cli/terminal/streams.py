"""Output to stderr: progress, and everything that a solver prints."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, redirect_stdout
from typing import Any

from dubins_study.cli.terminal.verbosity import Verbosity, verbosity
from dubins_study.study.values import plain

_INTERVAL_S, _VERBOSE_INTERVAL_S = 30.0, 5.0  # between lines of progress, without a terminal


@contextmanager
def solvers_to_stderr() -> Iterator[None]:
    """Keep stdout for results: what solvers and their processes print goes to stderr."""
    if sys.stdout is None or sys.stderr is None:  # our parent process closed one of them
        yield
        return
    sys.stdout.flush()
    saved_stdout = os.dup(1)
    os.dup2(2, 1)
    try:
        with redirect_stdout(sys.stderr):
            yield
    finally:
        os.dup2(saved_stdout, 1)
        os.close(saved_stdout)


@contextmanager
def progress(what: str, counts: list[int]) -> Iterator[Callable[[int, int], None]]:
    """One line on stderr about what is done and the time left.

    Without a terminal it is a plain line every half minute, every few seconds if the command is
    verbose. Nothing is written if it is quiet.

    Args:
        what: the name of what goes on.
        counts: set to the numbers done and to do, whenever they change.

    Yields:
        A function of both numbers.
    """
    moved = _bar(what) if is_terminal() else _lines(what)
    with nullcontext(_ignored) if verbosity() == Verbosity.QUIET else moved as move:

        def note(done: int, total: int) -> None:
            counts[:] = done, total
            move(done, total)

        yield note


def is_terminal() -> bool:
    """Whether stderr is a terminal that moves its cursor."""
    return sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"


def _ignored(done: int, total: int) -> None:
    """Progress of a quiet command."""


@contextmanager
def _bar(what: str) -> Iterator[Callable[[int, int], None]]:
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Remaining

    # No markup: a file's name may hold brackets. It gives way where the terminal is narrow.
    name = TextColumn("{task.description}", markup=False, table_column=_shrinking())
    columns = (name, BarColumn(bar_width=20), MofNCompleteColumn(), Remaining(compact=True))
    bar = Progress(*columns, TextColumn("left"), console=Console(stderr=True))
    task = bar.add_task(plain(what), total=None)

    def move(done: int, total: int) -> None:
        bar.start()  # not earlier: the request may still be refused
        bar.update(task, completed=done, total=total)

    try:
        yield move
    finally:
        if bar.live.is_started:  # stopping would leave an empty line before an error
            bar.stop()


def _shrinking() -> Any:
    from rich.table import Column

    return Column(no_wrap=True, overflow="ellipsis", ratio=1)


@contextmanager
def _lines(what: str) -> Iterator[Callable[[int, int], None]]:
    interval_s = _VERBOSE_INTERVAL_S if verbosity() == Verbosity.VERBOSE else _INTERVAL_S
    started = written = time.monotonic()
    first: int | None = None

    def move(done: int, total: int) -> None:
        nonlocal first, written
        now = time.monotonic()
        if first is None:
            first = done
        if now - written < interval_s or done >= total or sys.stderr is None:
            return
        written = now
        left = (now - started) / (done - first) * (total - done) if done > first else None
        text = "" if left is None else f", about {duration(left)} left"
        print(f"dubins-study: {plain(what)}: {done} of {total} done{text}", file=sys.stderr)

    yield move


def duration(seconds: float) -> str:
    """A duration in the largest unit of which it has at least two, rounded to a few digits."""
    for unit, length in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.3g} {unit}"
    return f"{seconds:.2g} s" if seconds < 10 else f"{seconds:.0f} s"


@contextmanager
def steps(what: str) -> Iterator[Callable[[str], None]]:
    """One line on stderr that names the step of a command which cannot count; nothing if quiet.

    Without a terminal the steps are lines of a verbose command only.
    """
    quiet, verbose = (verbosity() == level for level in (Verbosity.QUIET, Verbosity.VERBOSE))
    if quiet or not is_terminal():

        def step(text: str) -> None:
            if verbose and sys.stderr is not None:
                print(f"dubins-study: {plain(what)}: {plain(text)}", file=sys.stderr)

        yield step
        return
    from rich.console import Console
    from rich.text import Text

    with Console(stderr=True).status(Text(plain(what))) as status:
        yield lambda text: status.update(Text(f"{plain(what)}: {plain(text)}"))

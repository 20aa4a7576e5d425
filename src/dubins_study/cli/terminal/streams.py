"""Output to stderr: progress, and everything that a solver prints."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout


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
    """A progress bar on stderr. Yields a function (done, total) that moves it and sets `counts`."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Remaining

    from dubins_study.study.printable import plain

    # No markup: a file's name may hold brackets.
    name = TextColumn("{task.description}", markup=False)
    columns = (name, BarColumn(), MofNCompleteColumn(), Remaining())
    bar = Progress(*columns, console=Console(stderr=True))
    task = bar.add_task(plain(what), total=None)

    def move(done: int, total: int) -> None:
        counts[:] = done, total
        bar.start()  # not earlier: the request may still be refused
        bar.update(task, completed=done, total=total)

    try:
        yield move
    finally:
        if counts:  # a bar that was never started would leave an empty line before the error
            bar.stop()


@contextmanager
def spinner(what: str) -> Iterator[None]:
    """A spinner on stderr while the block runs."""
    from rich.console import Console

    with Console(stderr=True).status(what):
        yield

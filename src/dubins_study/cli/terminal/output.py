"""Output of commands: results, progress and the log.

Tables go to stdout; progress, the log and output of solvers go to stderr.
"""

from __future__ import annotations

import logging
import os
import re
import shutil
import sys
import textwrap
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, redirect_stdout
from enum import IntEnum
from io import StringIO

_INTERVAL_S = 30.0  # between lines of progress, without a terminal
_MOMENT_S = 2.0  # a command that ends sooner shows no steps
# Characters in a line: without a terminal, so that a row of a table is one line, and at least.
_NO_TERMINAL_WIDTH = 100_000
_LEAST_WIDTH = 40
_NAME_WIDTH = 12  # of a name in a listing, with the space behind it
_NUMBER = re.compile(r"[-+−]?\d[\d.]*(e[-+]?\d+)?\s?%?")


class Verbosity(IntEnum):
    """How much a command tells on stderr.

    Quiet: no progress. Normal: progress. Verbose: progress and the log of every step.
    """

    QUIET = -1
    NORMAL = 0
    VERBOSE = 1


_level = Verbosity.NORMAL
_LOG = logging.getLogger("dubins_study")


def verbosity() -> Verbosity:
    """The verbosity of the command that runs."""
    return _level


def set_verbosity(level: Verbosity) -> None:
    """Set the verbosity of the command.

    A verbose command writes this package's log to stderr.
    """
    global _level
    _level = level
    verbose = level == Verbosity.VERBOSE
    _LOG.handlers = [handler for handler in _LOG.handlers if not isinstance(handler, _ToStderr)]
    _LOG.setLevel(logging.NOTSET)
    _LOG.propagate = not verbose
    if verbose:
        _LOG.setLevel(logging.INFO)
        _LOG.addHandler(_ToStderr())


class _ToStderr(logging.StreamHandler):  # type: ignore[type-arg]
    """Writes records to stderr, with visible control characters."""

    def format(self, record: logging.LogRecord) -> str:
        text = plain(super().format(record))
        if text.startswith("dubins-study:"):
            return text
        return f"dubins-study: {text}"


def note(message: str, always: bool = True) -> None:
    """Print a note on stderr.

    The note tells what a command left out, or how it understood the request. A quiet command prints
    it only if `always` is set.
    """
    if always or verbosity() > Verbosity.QUIET:
        print(f"dubins-study: {plain(message)}", file=sys.stderr)


def plain(text: str) -> str:
    """The text on one line.

    Line ends and control characters are replaced by their escapes.
    """
    from dubins_study.study.values import plain as written_out  # numpy, which no help waits for

    return written_out(text)


def terminal_width() -> int | None:
    """Characters in a line of the terminal, or None.

    None if stdout is no terminal: lines may then have any length. If the variable COLUMNS is set,
    that counts as a terminal.
    """
    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    if is_terminal or os.environ.get("COLUMNS"):
        return shutil.get_terminal_size().columns
    return None


def table(head: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """Rows as aligned text, numbers on the right.

    Texts are broken where the terminal ends.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    lines = [[_cell(value) for value in row] for row in rows]
    grid = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False)
    for place, name in enumerate(head):
        has_numbers = all(_NUMBER.fullmatch(line[place]) for line in lines if line[place])
        title = Text(plain(name))  # a name from a results folder may look like markup
        if has_numbers:
            grid.add_column(title, justify="right", no_wrap=True, overflow="ellipsis")
        else:
            grid.add_column(title, overflow="fold")
    for line in lines:
        grid.add_row(*map(Text, line))
    text = StringIO()
    width = terminal_width() or _NO_TERMINAL_WIDTH
    Console(file=text, width=width, highlight=False, no_color=True).print(grid)
    return "\n".join(line.rstrip() for line in text.getvalue().splitlines()).strip("\n")


def _cell(value: object) -> str:
    """A value as a table shows it.

    A missing value is shown as nothing.
    """
    if value is None or value != value:
        return ""
    if value is True:
        return "yes"
    if value is False:
        return "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    return plain(str(value))


def listing(fields: Mapping[str, object]) -> str:
    """Lines of names and values, without empty values.

    A value that is wider than the terminal goes on in the next line, below its beginning.
    """
    width = max(terminal_width() or _NO_TERMINAL_WIDTH, _LEAST_WIDTH)
    indent = " " * _NAME_WIDTH
    lines = []
    for name, value in fields.items():
        if text := _cell(value):
            line = f"{name + ' ':<{_NAME_WIDTH}}{text}"
            lines.append(textwrap.fill(line, width, subsequent_indent=indent))
    return "\n".join(lines)


@contextmanager
def solvers_to_stderr() -> Iterator[None]:
    """Send what solvers print to stderr.

    The output of their processes goes there too: stdout is for results.
    """
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
    """Show progress in one line on stderr.

    The block gets a function that is called with the number done and the number of all. The list
    `counts` is set to these two numbers at each call.

    Without a terminal it is a plain line every half minute. Nothing is written if the command is
    quiet.
    """
    with _display(what) as show:

        def update(done: int, total: int) -> None:
            counts[:] = done, total
            show(done, total)

        yield update


def _display(what: str) -> AbstractContextManager[Callable[[int, int], None]]:
    """A context with the function that shows progress.

    On a terminal the function moves a bar, elsewhere it prints lines. For a quiet command it does
    nothing.
    """
    if verbosity() == Verbosity.QUIET:
        return nullcontext(lambda done, total: None)
    if is_terminal():
        return _bar(what)
    return nullcontext(_lines(what))


def is_terminal() -> bool:
    """Whether stderr is a terminal that moves its cursor."""
    return sys.stderr is not None and sys.stderr.isatty() and os.environ.get("TERM") != "dumb"


@contextmanager
def _bar(what: str) -> Iterator[Callable[[int, int], None]]:
    """Show a bar; yield the function that moves it."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn
    from rich.progress import TimeRemainingColumn as Remaining
    from rich.table import Column

    # No markup: a file's name may hold brackets. The name is cut where the terminal is narrow.
    shrinking = Column(no_wrap=True, overflow="ellipsis", ratio=1)
    name = TextColumn("{task.description}", markup=False, table_column=shrinking)
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


def _lines(what: str) -> Callable[[int, int], None]:
    """A function that prints a line every half minute."""
    last_line_s = time.monotonic()

    def move(done: int, total: int) -> None:
        nonlocal last_line_s
        now_s = time.monotonic()
        if now_s - last_line_s >= _INTERVAL_S and done < total and sys.stderr is not None:
            last_line_s = now_s
            print(f"dubins-study: {plain(what)}: {done} of {total} done", file=sys.stderr)

    return move


def duration(seconds: float) -> str:
    """A duration in a unit that suits it.

    The unit is the largest of which the duration has at least two: 7200 s are `2 h`, 7000 s are
    `117 min`.
    """
    for unit, length in (("d", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2 * length:
            return f"{seconds / length:.3g} {unit}"
    if seconds < 10:
        return f"{seconds:.2g} s"
    return f"{seconds:.0f} s"


@contextmanager
def steps(what: str) -> Iterator[Callable[[str], None]]:
    """Show the steps of a long command.

    Yields a function that shows the name of the next step, in one line on stderr. The line appears
    only if the command takes longer than a moment. Without a terminal, a verbose command prints a
    line for each step.
    """
    if verbosity() == Verbosity.QUIET or not is_terminal():

        def step(text: str) -> None:
            if verbosity() == Verbosity.VERBOSE and sys.stderr is not None:
                print(f"dubins-study: {plain(what)}: {plain(text)}", file=sys.stderr)

        yield step
        return
    from rich.console import Console
    from rich.text import Text

    status = Console(stderr=True).status(Text(plain(what)))
    timer = threading.Timer(_MOMENT_S, status.start)
    timer.start()
    try:
        yield lambda text: status.update(Text(f"{plain(what)}: {plain(text)}"))
    finally:
        timer.cancel()
        timer.join()
        status.stop()

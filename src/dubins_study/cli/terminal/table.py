"""Tables for the terminal, as wide as it is."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from io import StringIO

_GAPS = (3, 2)  # characters between two columns: where they fit, and where room is scarce
_LEAST_TEXT = (8, 14)  # characters that a column of texts keeps: as its longest word, but within
_LEAST_VALUE = 8  # characters beside the name of a column, where every row is a list
_LEAST_WIDTH = 20  # characters that any terminal has
_NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?\s?%?")
_BREAKS = re.compile(r"(?<=[\s,;\[\]])")  # a text is broken behind these,
_BREAKS_IN_A_WORD = re.compile(r"(?<=[/=_-])")  # and where that does not do, behind these


def terminal_width() -> int | None:
    """Characters in a line of the terminal; None without one, where lines may be of any length.

    The variable COLUMNS, where it is set, counts as a terminal.
    """
    is_terminal = sys.stdout is not None and sys.stdout.isatty()
    if not (is_terminal or os.environ.get("COLUMNS")):
        return None
    return max(shutil.get_terminal_size().columns, _LEAST_WIDTH)


def table(head: Sequence[str], rows: Sequence[Sequence[str]], width: int | None = None) -> str:
    """Rows as aligned text with numbers on the right.

    Where the table is wider than the terminal, columns of texts are broken into lines; numbers
    never are. Where even that does not fit, every row becomes a list of its columns.

    Args:
        head: names of the columns.
        rows: one text a column.
        width: characters of a line; None: those of the terminal.
    """
    width = terminal_width() if width is None else width
    columns = [[row[place] for row in rows] for place in range(len(head))]
    numeric = [all(_NUMBER.fullmatch(cell) for cell in column if cell) for column in columns]
    natural = [_widest([name, *cells]) for name, cells in zip(head, columns, strict=True)]
    least = [
        max(_widest(name.split()), _widest(cells) if number else _least_text(cells))
        for name, cells, number in zip(head, columns, numeric, strict=True)
    ]
    for gap in _GAPS:
        room = sum(natural) if width is None else width - gap * (len(head) - 1) - 2
        if sum(least) <= room:
            return _aligned(head, rows, numeric, _column_widths(natural, least, room), gap)
    return "\n\n".join(listing(dict(zip(head, row, strict=True)), width) for row in rows)


def _least_text(cells: Sequence[str]) -> int:
    """The width in which a column of texts can still be read."""
    low, high = _LEAST_TEXT
    words = [piece.rstrip() for cell in cells for piece in _BREAKS.split(cell)]
    return min(_widest(cells), max(low, min(_widest(words), high)))


def _column_widths(natural: list[int], least: list[int], room: int) -> list[int]:
    """The width of each column between its least and its natural one; all of them fit the room."""
    widths, cap = natural, max(natural, default=0)
    while sum(widths) > room:  # the widest columns give way first
        cap -= 1
        widths = [max(low, min(high, cap)) for low, high in zip(least, natural, strict=True)]
    return widths


def _aligned(
    head: Sequence[str],
    rows: Sequence[Sequence[str]],
    numeric: list[bool],
    widths: list[int],
    gap: int,
) -> str:
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    # the box has a space between two columns; the rest is theirs
    shown = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, gap - 2, 0, 1))
    for name, is_number, size in zip(head, numeric, widths, strict=True):
        title = Text(_broken(name, size))  # a name from a results folder may look like markup
        shown.add_column(title, no_wrap=True, justify="right" if is_number else "left")
    for row in rows:
        shown.add_row(*(Text(_broken(cell, size)) for cell, size in zip(row, widths, strict=True)))
    written = StringIO()
    roomy = 2 * sum(widths) + gap * len(widths) + 2  # a character may be two columns wide
    Console(file=written, width=roomy, highlight=False, no_color=True).print(shown)
    lines = [line.rstrip() for line in written.getvalue().splitlines()]
    return "\n".join(lines).strip("\n")


def listing(fields: Mapping[str, str], width: int | None = None) -> str:
    """Lines of a name and its value, which is broken where the terminal ends.

    Empty values are left out.
    """
    width = terminal_width() if width is None else width
    indent = _widest(list(fields)) + 2
    room = _widest(list(fields.values())) if width is None else max(width - indent, _LEAST_VALUE)
    lines = []
    for name, value in fields.items():
        if value:
            first, *others = _broken(value, room).splitlines() or [""]
            lines += [f"{name:<{indent}}{first}", *(" " * indent + line for line in others)]
    return "\n".join(lines)


def _broken(text: str, size: int) -> str:
    """A text in lines of a size, broken behind spaces, commas and brackets where possible."""
    return "\n".join(line.rstrip() for line in _lines(text, size))


def _lines(text: str, size: int) -> Iterator[str]:
    line = ""
    for piece in _pieces(text, size):
        if line and len((line + piece).rstrip()) > size:
            yield line
            line = ""
        line += piece
        while len(line.rstrip()) > size:
            yield line[:size]
            line = line[size:]
    yield line


def _pieces(text: str, size: int) -> Iterator[str]:
    for piece in _BREAKS.split(text):
        yield from [piece] if len(piece) <= size else _BREAKS_IN_A_WORD.split(piece)


def _widest(texts: Sequence[str]) -> int:
    return max(map(len, texts), default=0)

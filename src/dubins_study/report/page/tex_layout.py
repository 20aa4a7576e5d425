"""How a table fits on a page of TeX: size of letters, widths of columns, one page or more."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass

from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.content import Table

# mm: what is printed of a page of A4. The width is that of two columns of a journal.
PAGE_WIDTH, PAGE_HEIGHT = 180.0, 250.0
GAP = 2.2  # mm between two columns
ROW_GAP = 0.7  # mm between two rows of several lines
RIGHT = ("number", "cell")  # kinds of columns that are aligned right
_PT = 0.3515  # mm
# Commands of TeX -> width of a digit and height of a line (pt), the largest letters first. Of the
# fonts lmr8, lmr7 and lmr5; typewriter letters are hardly wider, other letters are narrower.
_SIZES = {"footnotesize": (4.25, 9.5), "scriptsize": (3.99, 8.0), "tiny": (3.41, 6.0)}
_BROAD, _MORE = frozenset("%∞−×✗✓→mwMW@"), 0.6  # letters broader than a digit, and by how much
_CAPTION = 25.0  # mm that the caption may take
_NARROWEST = 14  # letters of a column whose lines may break


@dataclass(frozen=True)
class Layout:
    """How a table fits on a page.

    Args:
        size: of the letters, a command of TeX without its backslash.
        widths: of the columns whose lines break (mm); None for a column as wide as its text.
        turned: whether the page is turned by a quarter.
        long: whether the table may go over several pages.
    """

    size: str
    widths: tuple[float | None, ...]
    turned: bool
    long: bool


def printed_texts(table: Table) -> list[list[str]]:
    """Every cell as text, row by row, solvers by their short names."""
    short = [column.kind == "solver" for column in table.columns]
    return [
        [table.labels.get(t, t) if s else t for t, s in zip(row, short, strict=True)]
        for row in table.texts()
    ]


def layout_of(table: Table) -> Layout:
    """The layout with the largest letters that fits, on an upright page if there is one."""
    texts = printed_texts(table)
    digits = [_width(column, texts, i) for i, column in enumerate(table.columns)]
    breaks = [column.kind not in RIGHT for column in table.columns]
    for turned in (False, True):
        across, down = (PAGE_HEIGHT, PAGE_WIDTH) if turned else (PAGE_WIDTH, PAGE_HEIGHT)
        for size, (digit, line) in _SIZES.items():
            widths = _fitted(digits, breaks, across, digit * _PT)
            if widths is not None:
                height = _lines(texts, widths, digit * _PT) * line * _PT + ROW_GAP * len(texts)
                return Layout(size, widths, turned, height > down - _CAPTION)
    # So many columns that the lines of all of them break.
    width = PAGE_HEIGHT / len(digits) - GAP
    return Layout("tiny", (width,) * len(digits), turned=True, long=True)


def _digits(text: str) -> float:
    """Width of a cell's widest line over that of a digit."""
    return max(
        len(line) + _MORE * sum(letter in _BROAD for letter in line) for line in text.split("\n")
    )


def heading_lines(column: Column, texts: Sequence[Sequence[str]], place: int) -> list[str]:
    """A heading in lines that are hardly wider than the column below it."""
    widest = max((_digits(row[place]) for row in texts), default=1)
    return textwrap.wrap(column.title, max(int(widest), 6), break_long_words=False) or [""]


def _width(column: Column, texts: Sequence[Sequence[str]], place: int) -> float:
    """Width of a column, its heading included, over that of a digit."""
    heading = "\n".join(heading_lines(column, texts, place))
    return max(_digits(heading), *(_digits(row[place]) for row in texts), 1)


def _fitted(
    digits: Sequence[float], breaks: Sequence[bool], across: float, digit: float
) -> tuple[float | None, ...] | None:
    """Widths (mm) of the columns; None if the table is wider than `across` however narrow they are.

    Args:
        digits: width of each column over that of a digit.
        breaks: whether a column's lines may break.
        across: width of the page (mm).
        digit: width of a digit (mm).
    """
    room = across - GAP * (len(digits) - 1)
    full = [digit * number for number in digits]
    if sum(full) <= room:
        return (None,) * len(digits)
    least = [
        digit * min(number, _NARROWEST + number / 12) if may_break else digit * number
        for number, may_break in zip(digits, breaks, strict=True)
    ]
    spare = room - sum(least)
    if spare < 0:
        return None
    share = spare / (sum(full) - sum(least))
    return tuple(
        low + share * (high - low) if low < high else None
        for low, high in zip(least, full, strict=True)
    )


def _lines(texts: list[list[str]], widths: tuple[float | None, ...], digit: float) -> int:
    """Lines of text in the body of a table."""
    return sum(
        max(
            text.count("\n") + 1 if width is None else math.ceil(len(text) * digit / width)
            for text, width in zip(row, widths, strict=True)
        )
        for row in texts
    )

"""What a report is made of: sections of text, tables and pictures."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import pandas as pd
from matplotlib.figure import Figure

Format: TypeAlias = Callable[[Any], str]
ABSENT = "–"


@dataclass(frozen=True)
class Column:
    """How one column of a frame is shown.

    Args:
        key: its name in the frame; the CSV file keeps it.
        title: its heading, with the unit.
        show: value to text; missing values never reach it: they are shown as a dash.
        kind: `number` (aligned right), `text`, `prose` (long text), or `code` (a name that a
            program knows).
    """

    key: str
    title: str
    show: Format = str
    kind: str = "number"

    def text(self, value: Any) -> str:
        """The value as it is shown."""
        missing = value is None or value is pd.NA or (isinstance(value, float) and value != value)
        return ABSENT if missing else self.show(value)


@dataclass(frozen=True, eq=False)
class Table:
    """A frame and how to show it.

    Args:
        name: stem of its files.
        caption: what to see in it, and units.
        frame: raw values.
        columns: which of them are shown, in order.
        marks: (row position, key) -> `good`, `bad` or `note`; the text says it too, so that no
            meaning rests on colour.
    """

    name: str
    caption: str
    frame: pd.DataFrame
    columns: tuple[Column, ...]
    marks: dict[tuple[int, str], str] | None = None

    def texts(self) -> list[list[str]]:
        """Every cell as text, row by row."""
        shown = [
            [column.text(value) for value in self.frame[column.key]] for column in self.columns
        ]
        return [list(row) for row in zip(*shown, strict=True)]

    def mark(self, row: int, column: Column) -> str:
        """The mark of a cell, empty if it has none."""
        return (self.marks or {}).get((row, column.key), "")


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure, its caption (what to see, units) and the words for those who cannot see it.

    Args:
        name: stem of its files.
        caption: what to see.
        figure: drawn, not yet saved.
        alt: what it shows, in a few words.
        half: whether two fit side by side.
    """

    name: str
    caption: str
    figure: Figure
    alt: str
    half: bool = False


Block: TypeAlias = Table | Picture


@dataclass(frozen=True, eq=False)
class Section:
    """A heading, a paragraph and what stands under it."""

    key: str
    title: str
    text: str
    blocks: tuple[Block, ...]


def slug(text: str) -> str:
    """A name from outside as part of a file's name: letters, digits, dashes."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:60] or "unnamed"


def digits(n: int) -> Format:
    """Shows `n` significant digits, in plain notation between 1e-3 and 1e6."""

    def show(value: Any) -> str:
        number = float(value)
        if number == 0:
            return "0"
        if not math.isfinite(number):
            return "∞" if number > 0 else ABSENT
        exponent = math.floor(math.log10(abs(float(f"{number:.{n - 1}e}"))))
        if -4 < exponent < 6:
            return f"{number:.{max(0, n - 1 - exponent)}f}".replace("-", "−")
        mantissa, _, power = f"{number:.{n - 1}e}".partition("e")
        return f"{mantissa}e{int(power)}".replace("-", "−")

    return show


def share(value: Any) -> str:
    """A share as a percentage; only all is 100 % and only none is 0 %."""
    percent = 100 * float(value)
    if 0 < percent < 0.1:
        return "<0.1 %"
    if 99.9 < percent < 100:
        return ">99.9 %"
    return f"{percent:.0f} %" if percent in (0, 100) else f"{percent:.1f} %"


def count(value: Any) -> str:
    """A whole number with thin spaces between thousands."""
    return f"{int(value):,}".replace(",", "\u202f")


def some(number: int, noun: str) -> str:
    """A number and what is counted, in the singular or the plural."""
    return f"{count(number)} {noun}{'' if number == 1 else 's'}"


def seconds(value: Any) -> str:
    """A duration with three digits and its own unit."""
    number = float(value)
    for factor, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "µs")):
        if number >= factor:
            return f"{digits(3)(number / factor)} {unit}"
    return f"{digits(3)(number / 1e-9)} ns"

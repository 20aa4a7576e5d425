"""What a report is made of: sections of text, tables and pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from dubins_study.report.elements.formats import ABSENT, Format
from dubins_study.report.elements.style import HALF, Style, new_figure


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


def columns(show: Format = str, /, kind: str = "number", **titles: str) -> tuple[Column, ...]:
    """Columns that are shown alike: a title for each key, in order."""
    return tuple(Column(key, title, show, kind) for key, title in titles.items())


SOLVER = Column("solver", "solver", kind="code")


def marks(frame: pd.DataFrame, *keys: str) -> dict[tuple[int, str], str]:
    """Mark the cells of these columns that are true or above zero as `bad`."""
    return {(row, key): "bad" for key in keys for row, bad in enumerate(frame[key]) if bad}


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


def picture(
    name: str,
    plot: Callable[..., list[Artist] | None],
    *data: object,
    caption: str,
    alt: str,
    height: float,
    width: float = HALF,
    legend: int = 0,
) -> Picture:
    """A figure of one panel, which `plot(ax, *data)` draws.

    Args:
        name, caption, alt: as in `Picture`.
        plot, data: the drawing function, and what it is given after the axes; it may return the
            legend's entries.
        height, width: inches.
        legend: columns of the legend below the panel; 0 for none.
    """
    figure = new_figure(width, height)
    entries = plot(figure.add_subplot(), *data)
    if legend:
        below: Style = {"loc": "outside lower left", "ncols": legend, "fontsize": 7.5}
        figure.legend(**below if entries is None else below | {"handles": entries})
    return Picture(name, caption, figure, alt, width == HALF)


Block: TypeAlias = Table | Picture


@dataclass(frozen=True, eq=False)
class Section:
    """A heading, a paragraph and what stands under it."""

    key: str
    title: str
    text: str
    blocks: tuple[Block, ...]

"""What a report is made of: sections of text, tables and pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import pandas as pd
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.style import HALF, Style, new_figure


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

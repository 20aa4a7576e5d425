"""The parts of a report: topics, sections and blocks.

A block is a table, a picture or a widget.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, StrEnum, auto
from typing import NamedTuple, TypeAlias

import pandas as pd
from markupsafe import Markup
from matplotlib.figure import Figure
from pandas.api.types import is_numeric_dtype

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import Column
from dubins_study.report.elements.style import HALF, new_figure


class Place(StrEnum):
    """Where a section stands.

    It is open on the front page, folded below on the front page, or on the page about the paper.
    """

    FRONT = "front"
    DETAILS = "details"
    PAPER = "paper"


@dataclass(frozen=True, eq=False)
class Table:
    """A frame and how to show it."""

    name: str  # stem of its file names
    caption: str  # what the table shows, with units
    frame: pd.DataFrame  # raw values
    columns: tuple[Column, ...]  # those that are shown, in order
    # (row position, key) -> `good`, `bad` or `note`. The cell's text says the same, for readers who
    # do not see the colour.
    marks: Mapping[tuple[int, str], str] = field(default_factory=dict)
    # more columns for the CSV file, such as the ends of an interval that is shown as text
    numbers: tuple[str, ...] = ()
    dense: bool = False  # whether it has so many columns that its letters are smaller
    stacked: bool = False  # whether a narrow screen shows every line as a list of its cells
    # spec -> the solver's short name, which columns of the kind `solver` show
    labels: Mapping[str, str] = field(default_factory=dict)

    def texts(self) -> list[list[str]]:
        """Every cell as text, row by row."""
        by_column = [
            [column.text(value) for value in self.frame[column.key]] for column in self.columns
        ]
        return [list(row) for row in zip(*by_column, strict=True)]

    def values(self) -> list[list[float | None]]:
        """The numbers behind the cells, row by row.

        A cell without a number has None. For a column `x_text`, whose texts end in an interval, the
        number is that of column `x_share` or `x`.
        """
        by_column = [_numbers_of(self.frame, column.key) for column in self.columns]
        return [list(row) for row in zip(*by_column, strict=True)]


def _numbers_of(frame: pd.DataFrame, key: str) -> list[float | None]:
    """The numbers of a column; None without numbers."""
    # `x_text` shows the number of `x_share` if there is such a column, else that of `x`.
    stem = key.removesuffix("_text")
    names = [key]
    if stem != key:
        names = [f"{stem}_share", stem]
    for name in names:
        if name in frame and is_numeric_dtype(frame[name]):
            numbers = frame[name].astype(object)
            return numbers.where(numbers.notna(), None).tolist()
    return [None] * len(frame)


@dataclass(frozen=True, eq=False)
class Picture:
    """A figure with its caption and alternative text."""

    name: str  # stem of its file names
    caption: str  # what the figure shows, with units
    figure: Figure  # drawn, not yet saved
    alt: str  # what the figure shows, in a few words
    half: bool = False  # whether it takes half of the page's width
    # the same for a narrow screen, half as wide, its panels one below the other
    narrow: Figure | None = None


def picture(
    name: str,
    plot: Callable[..., None],
    *data: object,
    caption: str,
    alt: str,
    height: float,
    legend: int = 0,
) -> Picture:
    """Draw a figure of half the page's width.

    It has one panel, drawn by `plot(ax, *data)`. `height` is in inches. `legend` is the number of
    columns of the legend below the panel; 0 for no legend.
    """
    figure = new_figure(HALF, height)
    plot(figure.add_subplot(), *data)
    if legend:
        figure.legend(loc="outside lower left", ncols=legend, fontsize=7.5)
    return Picture(name, caption, figure, alt, half=True)


def panels_picture(
    name: str, caption: str, plot: Callable[..., Figure], alt: str, *data: object, **options: object
) -> Picture:
    """Draw a figure of several panels in both widths.

    `plot(*data, **options, narrow=...)` is called twice: for the wide figure and for the narrow
    one.
    """
    wide = plot(*data, **options, narrow=False)
    narrow = plot(*data, **options, narrow=True)
    return Picture(name, caption, wide, alt, narrow=narrow)


@dataclass(frozen=True, eq=False)
class Widget:
    """A part of the page that needs scripts.

    Only the HTML page shows it.
    """

    name: str  # its anchor is `widget-NAME`
    caption: str  # what it shows, with units
    # HTML that is clear without scripts. Text from outside must be escaped, as by
    # `markupsafe.Markup.format`.
    body: Markup
    # name -> bytes, embedded as `data-NAME-gz`: compressed by gzip, in base64
    packed: Mapping[str, bytes] = field(default_factory=dict)


Block: TypeAlias = Table | Picture | Widget


@dataclass(frozen=True, eq=False)
class Section:
    """A heading with its text and its blocks.

    The lead stands first, then the text, then the blocks.
    """

    key: str  # its anchor
    title: str  # its heading
    text: str  # how the numbers are computed, and what follows from them
    blocks: tuple[Block, ...]  # the most important one first: the page folds the others
    lead: str = ""  # the sentence at its top that says what to see
    place: Place = Place.FRONT


BENCHMARK = "benchmark"  # the key of the experiment on which methods are compared


class General(Enum):
    """The kinds of sections that pool experiments.

    Such a section is not about a single experiment. Each kind says which attempts its sections
    count.
    """

    EVERY = auto()  # all attempts
    POOLED = auto()  # counted together: without studies of variants and of extreme questions
    COMPARED = auto()  # attempts at questions on which solvers are compared
    BENCHMARKED = auto()  # those of all suites of a benchmark, counted together
    FOUND = auto()  # those of the suites that findings are of
    DECIDED = auto()  # those of benchmarks, else those compared, else all


class Topic(NamedTuple):
    """A function that writes one section, and its attempts."""

    title: str  # its name in progress reports
    write: Callable[[Results], Section | None]  # None if there is nothing to show
    # its attempts: a general kind, or the key that experiments give as `section = "..."` in their
    # TOML file
    about: General | str
    enters: tuple[General, ...] = ()  # the general kinds that include those experiments too
    # A study's place is the details on a page about a benchmark, and else the front.
    place: Place = Place.DETAILS

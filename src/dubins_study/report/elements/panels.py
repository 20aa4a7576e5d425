"""Figures of many small panels, one per formulation, no higher than a screen.

Their places are computed from the widths of the names, so that a figure needs no layout engine.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from itertools import combinations, pairwise

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.patches import Patch
from matplotlib.textpath import TextToPath

from dubins_study.report.elements.axes import only_grid, percent_axis
from dubins_study.report.elements.names import distinct, one_line
from dubins_study.report.elements.style import INK, MUTED, WIDE, Style
from dubins_study.report.statistics.methods import MOST_ENGINES

# For captions of figures that show `statistics.methods.drawn_methods`.
DRAWN_TEXT = (
    "A panel per formulation: of each engine the guess and settings that are most surely right, "
    f"and at most {MOST_ENGINES} engines."
)
HIGHEST = 6.2  # inches: on the page a screen of 900 pixels, the caption not counted
_ACROSS = 3
_NAME, _TITLE, _SMALL = 6.0, 7.5, 6.5  # points: names of lines, of panels, of axes
# Inches: a line with its gap, a panel's title, its tick labels, the legend, the axis' name, a gap.
_LINE, _HEAD, _TICKS, _LEGEND, _LABEL, _GAP = 0.135, 0.26, 0.17, 0.28, 0.2, 0.1
_BOLD = 1.22  # width of a bold text over that of the same text in the usual weight
_PERCENT = 0.36  # inches: the labels of an axis of shares
_HANDLE = 0.32  # inches: from the end of a curve to its name
_CURVES = 1.35  # inches: the highest panel of curves
_NAMES_APART = 0.1  # inches: names of curves, of which a panel holds as many as it is high

_MOST_CHARACTERS = 36  # of a name beside a small panel
_USUAL_START = "bearing start"
_FONTS = TextToPath()


@lru_cache(maxsize=2000)
def text_width(text: str, size: float) -> float:
    """The width of a line of text (inches) at a size (points)."""
    font = FontProperties(family=["DejaVu Sans"], size=size)
    width, _, _ = _FONTS.get_text_width_height_descent(text, font, False)
    return float(width) / 72


def split_columns(heights: Sequence[float], across: int) -> list[range]:
    """Panels in order, as columns of which the highest is as low as possible.

    Args:
        heights: of the panels, in any unit.
        across: the number of columns.
    """
    count = len(heights)
    ends = [0, *np.cumsum(heights).tolist()]
    cuts = min(
        combinations(range(1, count), min(across, count) - 1),
        key=lambda cut: max(ends[b] - ends[a] for a, b in pairwise((0, *cut, count))),
    )
    return [range(a, b) for a, b in pairwise((0, *cuts, count))]


def named_panels(
    table: pd.DataFrame, label: str, notes: pd.Series[str] | None = None, legend: bool = True
) -> tuple[Figure, dict[str, Axes]]:
    """A figure as wide as the page: one panel per formulation, in it a named line per method.

    The first method is at the top, at the height of its number from below, counted from 0.

    Args:
        table: one row per method; columns formulation and short (its name).
        label: of the horizontal axes.
        notes: texts to the right of the lines.
        legend: whether there is room for a legend above the panels.
    """
    groups = {str(name): rows for name, rows in table.groupby("formulation", sort=False)}
    columns = split_columns([_HEAD + _LINE * len(rows) for rows in groups.values()], _ACROSS)
    titles = list(groups)
    top, foot = (_LEGEND if legend else 0.05), _TICKS + _LABEL
    largest = max(sum(len(groups[titles[i]]) for i in column) for column in columns)
    deepest = max(map(len, columns))
    line = min(_LINE, (HIGHEST - top - foot - deepest * _HEAD) / largest)
    height = (
        top
        + foot
        + max(sum(_HEAD + line * len(groups[titles[i]]) for i in column) for column in columns)
    )
    figure = Figure(figsize=(WIDE, height))
    names = {title: common_part(rows["short"].tolist()) for title, rows in groups.items()}
    before = [max(text_width(n, _NAME) for i in c for n in names[titles[i]][1]) for c in columns]
    after = [
        max(text_width(note, _NAME) for i in c for note in notes[groups[titles[i]].index])
        if notes is not None
        else 0.0
        for c in columns
    ]
    margins = [left + right + 2.4 * _GAP for left, right in zip(before, after, strict=True)]
    width = max(0.4, (WIDE - sum(margins)) / len(columns))
    panels, x = {}, 0.0
    for column, left, margin in zip(columns, before, margins, strict=True):
        y = height - top
        for i in column:
            rows, (shared, short) = groups[titles[i]], names[titles[i]]
            y -= _HEAD + line * len(rows)
            box = (x + left + 0.6 * _GAP, y, width, line * len(rows))
            ax = figure.add_axes(_share_of(box, height))
            # The title begins above the names, or a long one would not fit above the lines.
            names_width = max(text_width(name, _NAME) for name in short)
            title = f"{one_line(titles[i])}{shared}"
            space = names_width + width + margin - left
            size = _TITLE * min(1.0, space / (_BOLD * text_width(title, _TITLE)))
            ax.set_title(title, fontsize=size, pad=3, x=-names_width / width)
            _name_lines(ax, short)
            ax.xaxis.set_tick_params(labelsize=_SMALL, labelbottom=i == column[-1], pad=1.5)
            if notes is not None:
                for place, note in zip(range(len(rows))[::-1], notes[rows.index], strict=True):
                    at: Style = {"transform": ax.get_yaxis_transform(), "color": MUTED}
                    ax.text(1.03, place, note, va="center", fontsize=_NAME, **at)
            panels[titles[i]] = ax
        x += margin + width
    figure.text(0.5, 0.05 / height, label, ha="center", fontsize=8, color=MUTED)
    return figure, panels


def _share_of(
    box: tuple[float, float, float, float], height: float
) -> tuple[float, float, float, float]:
    """Left, bottom, width and height as shares of the figure; `box` is in inches."""
    x, y, width, tall = box
    return x / WIDE, y / height, width / WIDE, tall / height


def common_part(names: Sequence[str]) -> tuple[str, list[str]]:
    """What all names but the engine share, for a title, e.g. ` (presolve)`; the names without it.

    Args:
        names: engine, guess and settings, with commas between them.
    """
    plain = [one_line(name, _MOST_CHARACTERS) for name in names]
    names = list(distinct([str(place) for place in range(len(plain))], plain).values())
    tails = {name.partition(", ")[2] for name in names}
    # An engine of which only the usual guess is known, or that needs none, does not name it.
    shared = tails - {""} if tails > {_USUAL_START} else tails
    if len(names) < 2 or len(shared) > 1 or shared == {""}:
        return "", names
    return f" ({shared.pop()})", [name.partition(", ")[0] for name in names]


def _name_lines(ax: Axes, names: Sequence[str]) -> None:
    ax.set_yticks(range(len(names))[::-1], names, color=INK, fontsize=_NAME)
    ax.set_ylim(-0.55, len(names) - 0.45)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0, pad=2)


def plot_stacked_shares(
    table: pd.DataFrame,
    looks: Mapping[str, tuple[str, str]],
    label: str,
    notes: Sequence[str] | None = None,
) -> Figure:
    """One bar per method, stacked of shares, in one panel per formulation.

    Args:
        table: one row per method; columns formulation, short (its name), and a share for each name
            in `looks`.
        looks: column -> colour and hatch, in the order of the stack.
        label: of the horizontal axes.
        notes: texts to the right of the bars, one per row.
    """
    beside = None if notes is None else pd.Series(list(notes), table.index)
    figure, panels = named_panels(table, label, beside)
    for name, ax in panels.items():
        _plot_bars(ax, table[table["formulation"] == name], looks)
        ax.set(xlim=(0, 1), xticks=(0, 0.5, 1))
        percent_axis(ax.xaxis)
    handles = [
        Patch(facecolor=colour, hatch=hatch, edgecolor="white", linewidth=0, label=kind)
        for kind, (colour, hatch) in looks.items()
    ]
    place: Style = {"loc": "upper left", "borderaxespad": 0.2, "fontsize": 7, "columnspacing": 1.2}
    figure.legend(handles=handles, ncols=len(looks), **place)
    return figure


# A bar that is thinner than this share of its axis cannot be seen.
_THIN = 1e-3


def _plot_bars(ax: Axes, rows: pd.DataFrame, looks: Mapping[str, tuple[str, str]]) -> None:
    places = np.arange(len(rows))[::-1]
    left = np.zeros(len(rows))
    for kind, (colour, hatch) in looks.items():
        width = rows[kind].fillna(0).to_numpy(dtype=np.float64)
        shown = width > _THIN
        style: Style = {"color": colour, "hatch": hatch, "edgecolor": "white", "linewidth": 0}
        ax.barh(places[shown], width[shown], left=left[shown], height=0.7, **style)
        left += width


def most_per_formulation(table: pd.DataFrame, most: int) -> pd.DataFrame:
    """The first methods of each formulation, so that no panel has more than `most`."""
    return table.groupby("formulation", sort=False).head(most)


def curve_panels(
    names: Mapping[str, Sequence[str]], xlabel: str, ylabel: str, same_x: bool = True
) -> tuple[Figure, dict[str, Axes]]:
    """A figure as wide as the page, with small panels side by side, one per title.

    To the right of each panel there is room for the names of its curves (`axes.label_curves`).

    Args:
        names: title -> the names of the curves of its panel.
        xlabel, ylabel: of all panels.
        same_x: whether all panels share the horizontal axis, which the lowest then label.
    """
    titles = list(names)
    ticks = 0.0 if same_x else _TICKS
    foot = _LABEL + _TICKS - ticks
    most = max(map(len, names.values()))
    for across in range(min(2, len(titles)), _ACROSS + 1):
        down = -(-len(titles) // across)
        tall = min(_CURVES, (HIGHEST - foot) / down - _HEAD - ticks)
        if tall >= most * _NAMES_APART:
            break
    height = foot + down * (tall + _HEAD + ticks)
    figure = Figure(figsize=(WIDE, height))
    after = [
        _HANDLE + max(text_width(name, _NAME) for t in titles[c::across] for name in names[t])
        for c in range(across)
    ]
    left = _LABEL + _PERCENT
    width = (WIDE - left - sum(after) - across * _GAP) / across
    panels = {}
    for number, title in enumerate(titles):
        row, column = divmod(number, across)
        x = left + column * (width + _GAP) + sum(after[:column])
        y = height - (row + 1) * (_HEAD + tall) - row * ticks
        ax = panels[title] = figure.add_axes(_share_of((x, y, width, tall), height))
        ax.set_title(one_line(title), fontsize=_TITLE, pad=3)
        lowest = number + across >= len(titles)
        ax.tick_params(labelsize=_SMALL, pad=1.5)
        ax.xaxis.set_tick_params(labelbottom=lowest or not same_x)
        ax.yaxis.set_tick_params(labelleft=column == 0)
    figure.text(0.5, 0.05 / height, xlabel, ha="center", fontsize=8, color=MUTED)
    side: Style = {"rotation": "vertical", "va": "center", "fontsize": 8, "color": MUTED}
    figure.text(0.05 / WIDE, 0.5, ylabel, **side)
    return figure, panels


def curve_panel(
    names: Sequence[str], xlabel: str, ylabel: str, height: float = 2.9
) -> tuple[Figure, Axes]:
    """One panel as wide as the page, with room for the names of its curves at its right.

    Args:
        names: of the curves.
        xlabel, ylabel: of the axes.
        height: of the figure (inches).
    """
    figure = Figure(figsize=(WIDE, height))
    left, foot = _LABEL + 1.3 * _PERCENT, _LABEL + 0.25
    right = _HANDLE + max(text_width(name, _TITLE) for name in names)
    box = (left, foot, max(2.0, WIDE - left - right - _GAP), height - foot - 0.2)
    ax = figure.add_axes(_share_of(box, height))
    ax.set(xlabel=xlabel, ylabel=ylabel)
    return figure, ax

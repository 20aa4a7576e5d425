"""Figures of many small panels, one per formulation, no higher than a screen.

Their places are computed from the widths of the names, so that a figure needs no layout engine.
"""

from __future__ import annotations

import textwrap
from collections.abc import Hashable, Iterable, Mapping, Sequence
from itertools import combinations, pairwise
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import ArrayLike

from dubins_study.report.elements.axes import only_grid, percent_axis
from dubins_study.report.elements.looks import Look, Palette, name_of
from dubins_study.report.elements.names import common_part, one_line
from dubins_study.report.elements.plots import HIGHEST
from dubins_study.report.elements.style import INK, MUTED, WIDE, Style, add_panel, text_width

_ACROSS = 3
_NAME, _TITLE, _SMALL = 6.0, 7.5, 6.5  # points: names of lines, of panels, of axes
# Inches: a line with its gap, a panel's title, its tick labels, the legend, the axis' name, a gap.
_LINE, _HEAD, _TICKS, _LEGEND, _LABEL, _GAP = 0.135, 0.26, 0.17, 0.28, 0.2, 0.1
_COLUMN_GAP = 2.4 * _GAP  # inches: between the notes of a column and the names of the next one
_LEAST = 0.4  # inches: a panel beside names that leave no room
_BOLD = 1.22  # width of a bold text over that of the same text in the usual weight


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
    parts = {name: common_part(rows["short"].tolist()) for name, rows in groups.items()}
    beside = {
        name: [] if notes is None else notes[rows.index].tolist() for name, rows in groups.items()
    }
    titles = list(groups)
    cuts = split_columns([_HEAD + _LINE * len(rows) for rows in groups.values()], _ACROSS)
    columns = [[titles[place] for place in cut] for cut in cuts]
    counts = [sum(len(groups[name]) for name in column) for column in columns]
    top, foot = (_LEGEND if legend else 0.05), _TICKS + _LABEL
    line = min(_LINE, (HIGHEST - top - foot - max(map(len, columns)) * _HEAD) / max(counts))
    sizes = zip(columns, counts, strict=True)
    height = top + foot + max(_HEAD * len(column) + line * count for column, count in sizes)
    figure = Figure(figsize=(WIDE, height))
    before = [_widest(name for title in column for name in parts[title][1]) for column in columns]
    after = [_widest(note for title in column for note in beside[title]) for column in columns]
    width = (WIDE - sum(before) - sum(after)) / len(columns) - _COLUMN_GAP
    panels, x = {}, 0.0
    for column, left, right in zip(columns, before, after, strict=True):
        y = height - top
        for title in column:
            names = parts[title][1]
            y -= _HEAD + line * len(names)
            box = (x + left + 0.6 * _GAP, y, max(_LEAST, width), line * len(names))
            ax = panels[title] = add_panel(figure, box)
            ax.xaxis.set_tick_params(labelsize=_SMALL, labelbottom=title == column[-1], pad=1.5)
            _name_lines(ax, names, beside[title])
            _set_title(ax, f"{one_line(title)}{parts[title][0]}", _widest(names), width, right)
        x += left + right + width + _COLUMN_GAP
    figure.text(0.5, 0.05 / height, label, ha="center", fontsize=8, color=MUTED)
    return figure, panels


def _widest(texts: Iterable[str]) -> float:
    """The width of the widest text beside a panel (inches)."""
    return max((text_width(text, _NAME) for text in texts), default=0.0)


def _set_title(ax: Axes, title: str, before: float, width: float, after: float) -> None:
    """A title that begins above the names, in smaller letters if it needs more room than is left.

    `before`, `width` and `after` are those of the names, the panel and the notes, in inches.
    """
    room = before + width + after + _COLUMN_GAP
    size = _TITLE * min(1.0, room / (_BOLD * text_width(title, _TITLE)))
    # With no y, matplotlib looks for room among all labels of the axes, each time that it draws.
    ax.set_title(title, fontsize=size, pad=3, x=-before / max(_LEAST, width), y=1.0)


def _name_lines(ax: Axes, names: Sequence[str], notes: Sequence[str]) -> None:
    ax.set_yticks(range(len(names))[::-1], names, color=INK, fontsize=_NAME)
    ax.set_ylim(-0.55, len(names) - 0.45)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0, pad=2)
    for place, note in zip(range(len(names))[::-1], notes, strict=False):
        at: Style = {"transform": ax.get_yaxis_transform(), "color": MUTED}
        ax.text(1.03, place, note, va="center", fontsize=_NAME, **at)


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


_PERCENT = 0.36  # inches: the labels of an axis of shares
_HANDLE = 0.32  # inches: from the end of a curve to its name
_HIGHEST_PANEL = 1.35  # inches
_NAMES_APART = 0.095  # inches: names of curves, of which a panel holds as many as it is high


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
        tall = min(_HIGHEST_PANEL, (HIGHEST - foot) / down - _HEAD - ticks)
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
        ax = panels[title] = add_panel(figure, (x, y, width, tall))
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
    ax = add_panel(figure, box)
    ax.set(xlabel=xlabel, ylabel=ylabel)
    return figure, ax


def label_lines(
    ax: Axes, solvers: Iterable[str], places: ArrayLike, palette: Palette | None = None
) -> None:
    """Write the solvers' names to the left of their lines; draw grid lines for the values only.

    The names are the page's short ones if its palette is given, else the specs.
    """
    names = [wrapped(palette.label(solver)) if palette else name_of(solver) for solver in solvers]
    ax.set_yticks(np.asarray(places), names, color=INK)
    ax.set_ylim(-0.6, len(names) - 0.4)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def wrapped(name: str) -> str:
    """A short name over several lines if it is long."""
    return "\n".join(textwrap.wrap(name, _WRAPPED, break_long_words=False))


_WRAPPED = 32


def plot_quartiles(
    ax: Axes, row: Mapping[Hashable, Any], key: str, place: float, look: Look, fill: str = ""
) -> None:
    """Draw a duration's median as a mark and its quartiles as a bar, on the line at `place`.

    `row` holds the median (s) under `key`, and the quartiles under `key` with `_q1` and `_q3`.
    `fill` is the colour inside the mark; if it is empty, the solver's colour.
    """
    ends = [max(row[f"{key}_q1"], 1e-9), row[f"{key}_q3"]]
    bar: Style = {"color": look.colour, "linewidth": 2.4, "alpha": 0.45, "solid_capstyle": "butt"}
    ax.plot(ends, [place] * 2, **bar)
    ax.plot(row[key], place, **(look.dots | {"markerfacecolor": fill or look.colour}))


def plot_shares(
    ax: Axes,
    table: pd.DataFrame,
    look: Mapping[str, tuple[str, str]],
    notes: Sequence[str],
    palette: Palette | None = None,
) -> None:
    """Draw one stacked bar per solver: each column of `look` as a share of `attempts`.

    Args:
        ax: where to draw.
        table: columns solver, attempts, and a count for each name in `look`.
        look: column -> colour and hatch, in the order of the stack.
        notes: texts to the right of the bars, one per row.
        palette: of the page, for its short names.
    """
    places = np.arange(len(table))[::-1]
    left = np.zeros(len(table))
    for name, (colour, hatch) in look.items():
        width = table[name].to_numpy() / table["attempts"].to_numpy()
        if not width.any():
            continue
        style: Style = {"color": colour, "hatch": hatch, "edgecolor": "white", "linewidth": 0}
        ax.barh(places, width, left=left, height=0.62, label=name, **style)
        left += width
    for place, note in zip(places, notes, strict=True):
        ax.text(1.015, place, note, va="center", fontsize=7.5, color=MUTED)
    label_lines(ax, table["solver"], places, palette)
    ax.set(xlim=(0, 1), xlabel="share of all attempts")
    percent_axis(ax.xaxis)

"""Figures with one panel per formulation: a heading, then one line per method."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from dubins_study.report.elements.axes import only_grid, percent_axis
from dubins_study.report.elements.style import INK, MUTED, WIDE, Style, new_figure
from dubins_study.report.statistics.methods import MOST_ENGINES

# For captions of figures that show `statistics.methods.drawn_methods`.
DRAWN_TEXT = (
    "A panel per formulation: of each engine the guess and settings that are most surely right, "
    f"and at most {MOST_ENGINES} engines."
)
_LINE, _HEADING = 0.21, 0.42  # inches: a bar with its gap, a panel's title with its gap
_SMALL_HEADING = 0.3
_MARGINS = 0.75  # inches: the legend above, the axis below


def formulation_panels(table: pd.DataFrame) -> tuple[Figure, dict[str, Axes]]:
    """A figure as wide as the page, with one panel per formulation, one below the other.

    Args:
        table: one row per method; the column formulation decides the panel. Panels are as high as
            their methods need.
    """
    sizes = table.groupby("formulation", sort=False).size()
    heights = [_HEADING + _LINE * size for size in sizes]
    figure = new_figure(WIDE, _MARGINS + sum(heights))
    axes = figure.subplots(len(sizes), 1, sharex=True, height_ratios=heights, squeeze=False)
    panels = dict(zip(map(str, sizes.index), axes[:, 0], strict=True))
    for name, ax in panels.items():
        ax.set_title(name)
    return figure, panels


def plot_stacked_shares(
    table: pd.DataFrame,
    looks: Mapping[str, tuple[str, str]],
    notes: Sequence[str],
    label: str,
) -> Figure:
    """One bar per method, stacked of shares, in one panel per formulation.

    Args:
        table: one row per method; columns formulation, short (its name), and a share for each name
            in `looks`.
        looks: column -> colour and hatch, in the order of the stack.
        notes: texts to the right of the bars, one per row.
        label: of the horizontal axis.
    """
    beside = pd.Series(list(notes), table.index)
    figure, panels = formulation_panels(table)
    for name, ax in panels.items():
        rows = table[table["formulation"] == name]
        _plot_bars(ax, rows, looks, beside)
    last = list(panels.values())[-1]
    last.set(xlim=(0, 1), xlabel=label)
    percent_axis(last.xaxis)
    handles, _ = last.get_legend_handles_labels()
    figure.legend(handles=handles, loc="outside upper left", ncols=len(looks), fontsize=7.5)
    return figure


def plot_share_grid(
    table: pd.DataFrame, looks: Mapping[str, tuple[str, str]], label: str
) -> Figure:
    """As `plot_stacked_shares`, but with small panels side by side and without notes."""
    figure, panels = formulation_grid(table, line=0.115)
    for name, (ax, lines) in panels.items():
        _plot_bars(ax, table[table["formulation"] == name], looks, None, lines)
        ax.set_xlim(0, 1)
        percent_axis(ax.xaxis)
    figure.supxlabel(label, fontsize=8, color=MUTED)
    handles, _ = next(iter(panels.values())).ax.get_legend_handles_labels()
    figure.legend(handles=handles, loc="outside upper left", ncols=len(looks), fontsize=7.5)
    return figure


def _plot_bars(
    ax: Axes,
    rows: pd.DataFrame,
    looks: Mapping[str, tuple[str, str]],
    notes: Mapping[Hashable, str] | pd.Series[str] | None,
    lines: int = 0,
) -> None:
    places = name_lines(ax, rows["short"].tolist(), 7 if notes is not None else 6, lines)
    left = np.zeros(len(rows))
    for kind, (colour, hatch) in looks.items():
        width = rows[kind].to_numpy(dtype=np.float64)
        style: Style = {"color": colour, "hatch": hatch, "edgecolor": "white", "linewidth": 0}
        ax.barh(places, width, left=left, height=0.68, label=kind, **style)
        left += width
    if notes is not None:
        for place, key in zip(places, rows.index, strict=True):
            ax.text(1.01, place, notes[key], va="center", fontsize=7, color=MUTED)


def name_lines(ax: Axes, names: Sequence[str], size: float, lines: int = 0) -> NDArray[np.intp]:
    """Write methods' names beside their lines, the first at the top; returns the lines' places.

    The panel has room for `lines` lines if there are more of them than names.
    """
    places = np.arange(len(names))[::-1]
    ax.set_yticks(places, names, color=INK, fontsize=size)
    ax.set_ylim(len(names) - 0.6 - max(lines, len(names)), len(names) - 0.4)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)
    return places


def most_per_formulation(table: pd.DataFrame, most: int) -> pd.DataFrame:
    """The first methods of each formulation, so that no panel has more than `most`."""
    return table.groupby("formulation", sort=False).head(most)


class Panel(NamedTuple):
    """A panel, and how many methods the largest of the panels beside it holds."""

    ax: Axes
    lines: int


def formulation_grid(
    table: pd.DataFrame, line: float = 0.0, height: float = 0.0, across: int = 3
) -> tuple[Figure, dict[str, Panel]]:
    """A figure as wide as the page, with a few panels side by side, one per formulation.

    Args:
        table: one row per method; the column formulation decides the panel.
        line: inches that each method takes in its panel.
        height: inches that a panel takes besides, its title included.
        across: how many panels stand side by side, at most.
    """
    sizes = table.groupby("formulation", sort=False).size()
    across = min(across, len(sizes))
    down = -(-len(sizes) // across)
    largest = [max(sizes.iloc[row * across : (row + 1) * across]) for row in range(down)]
    heights = [_SMALL_HEADING + height + line * size for size in largest]
    figure = new_figure(WIDE, _MARGINS + sum(heights))
    axes = figure.subplots(down, across, sharex=True, height_ratios=heights, squeeze=False)
    room = np.repeat(largest, across)
    panels = {
        str(name): Panel(ax, int(lines))
        for name, ax, lines in zip(sizes.index, axes.flat, room, strict=False)
    }
    for name, (ax, _) in panels.items():
        ax.set_title(name, fontsize=7.5, pad=3)
        ax.tick_params(labelsize=6.5)
    for ax in axes.flat[len(panels) :]:
        ax.set_visible(False)
    for ax in axes.flat[max(0, len(panels) - across) : len(panels)]:
        ax.xaxis.set_tick_params(labelbottom=True)  # the last panel of each column
    return figure, panels

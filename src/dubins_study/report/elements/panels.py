"""Figures with one panel per formulation: a heading, then one line per method."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dubins_study.report.elements.axes import only_grid, percent_axis
from dubins_study.report.elements.style import INK, MUTED, WIDE, Style, new_figure

_LINE, _HEADING = 0.21, 0.42  # inches: a bar with its gap, a panel's title with its gap
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


def _plot_bars(
    ax: Axes,
    rows: pd.DataFrame,
    looks: Mapping[str, tuple[str, str]],
    notes: Mapping[Hashable, str] | pd.Series[str],
) -> None:
    places = np.arange(len(rows))[::-1]
    left = np.zeros(len(rows))
    for kind, (colour, hatch) in looks.items():
        width = rows[kind].to_numpy(dtype=np.float64)
        style: Style = {"color": colour, "hatch": hatch, "edgecolor": "white", "linewidth": 0}
        ax.barh(places, width, left=left, height=0.68, label=kind, **style)
        left += width
    for place, key in zip(places, rows.index, strict=True):
        ax.text(1.01, place, notes[key], va="center", fontsize=7, color=MUTED)
    ax.set_yticks(places, rows["short"], color=INK, fontsize=7)
    ax.set_ylim(-0.6, len(rows) - 0.4)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def most_per_formulation(table: pd.DataFrame, most: int) -> pd.DataFrame:
    """The first methods of each formulation, so that no panel has more than `most`."""
    return table.groupby("formulation", sort=False).head(most)

"""Maps of kinds: one colour per kind of result.

All topics with a map draw it by these functions.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dubins_study.report.elements.plots import Mark, draw_cells
from dubins_study.report.elements.style import HALF, ON_MAP, WIDE, Style, new_figure
from dubins_study.study.arrays import FloatArray


def kind_maps(
    panels: Mapping[str, pd.DataFrame],
    marks: Sequence[Mark],
    dress: Callable[[Axes, pd.DataFrame], None],
    *,
    high: float,
    narrow: bool,
) -> Figure:
    """Draw maps with titles and a common legend.

    `panels` maps a title to its table, with the columns of `draw_kinds`. The maps stand side by
    side, or one below the other if `narrow`. Each map is `high` inches high. `dress(ax, table)` is
    called after a map is drawn, to add labels and lines.
    """
    down = 1
    across = len(panels)
    width = WIDE
    characters = 110  # in a line of the legend
    if narrow:
        down = len(panels)
        across = 1
        width = HALF
        characters = 50
    kinds = pd.concat(panels.values())["kind"]
    present = [mark for mark in marks if kinds.eq(mark.key).any()]
    letters = max(len(mark.label or mark.key) for mark in present)
    columns = max(1, characters // (letters + 6))
    legend = 0.2 + 0.17 * -(-len(present) // columns)
    figure = new_figure(width, high * down + legend)
    axes = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
    for ax, (title, table) in zip(axes.ravel(), panels.items(), strict=True):
        draw_kinds(ax, table, marks)
        dress(ax, table)
        ax.set_title(title, fontsize=8.5)
        ax.label_outer()
    handles = [Line2D([], [], label=mark.label or mark.key, **_dots(mark)) for mark in present]
    figure.legend(handles=handles, loc="outside lower left", fontsize=7.5, ncols=columns)
    return figure


def draw_kinds(ax: Axes, table: pd.DataFrame, marks: Sequence[Mark]) -> None:
    """Fill each cell with its kind's colour.

    A kind with a marker is marked too. Columns: x and y (on a grid), kind (the key of a mark).
    """
    codes = {mark.key: code for code, mark in enumerate(marks)}
    x, y, values = grid_of(table.assign(code=table["kind"].map(codes)), "code")
    draw_cells(ax, values, x, y, [mark.colour for mark in marks])
    for mark in marks:
        group = table[table["kind"] == mark.key]
        if mark.marker:
            ax.plot(group["x"], group["y"], **_dots(mark))
    ax.set_aspect("auto")


def grid_of(table: pd.DataFrame, column: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A column on a grid: x, y and values.

    x has shape (n,), y has (m,), and the values have (m, n), with NaN where no row is. The table
    has the columns x and y; of several rows at one place the first counts.
    """
    grid = table.drop_duplicates(["x", "y"]).pivot(index="y", columns="x", values=column)
    return (
        grid.columns.to_numpy(dtype=np.float64),
        grid.index.to_numpy(dtype=np.float64),
        grid.to_numpy(dtype=np.float64),
    )


def _dots(mark: Mark) -> Style:
    """Keywords of matplotlib for a kind's marker.

    The marker is drawn on cells and in the legend. A kind without a marker has a square with the
    cells' colour in the legend.
    """
    edge = {"markeredgecolor": ON_MAP, "markeredgewidth": 0.7, "markersize": 4}
    face = {"linestyle": "none", "markerfacecolor": mark.colour}
    return {"marker": mark.marker or "s"} | edge | face

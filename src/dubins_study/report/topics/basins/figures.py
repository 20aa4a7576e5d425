"""Maps over the plane of initial guesses: the end that each guess leads to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from dubins_study.report.elements.style import MAP_PAPER, ON_MAP
from dubins_study.report.topics.basins import numbers

# From light to dark, so that grey print distinguishes the ends; refuted claims are marks on white.
_FILL = {
    numbers.OPTIMUM: "#d9ecdf",
    numbers.TURNS: "#6fb6dd",
    numbers.OTHER: "#d68a1c",
    numbers.FALSE_MINIMUM: MAP_PAPER,
    numbers.INFEASIBLE: MAP_PAPER,
    numbers.FALSE_PATH: MAP_PAPER,
    numbers.GIVES_UP: "#5d636b",
}
_MARK: dict[str, dict[str, Any]] = {
    numbers.TURNS: {"marker": ".", "markersize": 1.8},
    numbers.FALSE_MINIMUM: {"marker": "^", "markersize": 4, "markerfacecolor": "none"},
    numbers.INFEASIBLE: {"marker": "x", "markersize": 4},
    numbers.FALSE_PATH: {"marker": "s", "markersize": 3.5, "markerfacecolor": "none"},
    numbers.GIVES_UP: {"marker": "_", "markersize": 3, "color": MAP_PAPER},
}
_HATCH = {numbers.TURNS: "..."}  # in the legend, instead of marks
_TICKS = np.arange(5) * np.pi / 2
_TICK_TEXTS = ("0", "π/2", "π", "3π/2", "2π")


_DOTS: dict[str, Any] = {"linestyle": "none", "color": ON_MAP, "markeredgewidth": 0.7}


def plot_ends(ax: Axes, table: pd.DataFrame, title: str, listed: Sequence[str]) -> None:
    """Draw one solver's ends over the two turns of its guesses.

    Columns: z1, z2 (rad, on a grid), end. `title` is the panel's title; `listed` holds the ends
    that have marks.
    """
    codes = {end: float(i) for i, end in enumerate(numbers.ENDS)}
    grid = table.assign(code=table["end"].map(codes)).pivot_table(
        index="z2", columns="z1", values="code", aggfunc="first"
    )
    x, y = grid.columns.to_numpy(dtype=np.float64), grid.index.to_numpy(dtype=np.float64)
    dx, dy = _half_step(x), _half_step(y)
    ax.imshow(
        grid.to_numpy(dtype=np.float64),
        origin="lower",
        extent=(x[0] - dx, x[-1] + dx, y[0] - dy, y[-1] + dy),
        cmap=ListedColormap(list(_FILL.values())),
        vmin=-0.5,
        vmax=len(numbers.ENDS) - 0.5,
        interpolation="nearest",
    )
    for end in listed:
        group = table[table["end"] == end]
        if end in _MARK and len(group):
            ax.plot(group["z1"], group["z2"], **_DOTS | _MARK[end])
    ax.set(xlabel="left turn of the guess (rad)", ylabel="right turn of the guess (rad)")
    ax.set_title(title, fontsize=8.5, fontweight="normal")
    ax.set_xticks(_TICKS, _TICK_TEXTS)
    ax.set_yticks(_TICKS, _TICK_TEXTS)
    ax.grid(False)


def _half_step(values: np.ndarray) -> float:
    return float(np.diff(values).min()) / 2 if values.size > 1 else 0.5


def legend_entries(listed: Sequence[str]) -> list[Artist]:
    """The legend's entries for some ends."""
    return [_entry(end) for end in listed]


def _entry(end: str) -> Artist:
    if end in _MARK and _FILL[end] == MAP_PAPER:
        return Line2D([], [], **_DOTS | _MARK[end], label=end)
    style: dict[str, Any] = {"hatch": _HATCH.get(end, ""), "edgecolor": ON_MAP, "linewidth": 0.4}
    return Patch(facecolor=_FILL[end], **style, label=end)

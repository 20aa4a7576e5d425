"""Shares as a map of cells, each with its number: readable in grey and without colours."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap

from dubins_study.report.elements.style import (
    BLUE,
    INK,
    MAP_PAPER,
    MUTED,
    ON_MAP,
    PAPER,
    Style,
)

# One hue from light to dark, so that the order stays visible in grey print.
DEPTH = LinearSegmentedColormap.from_list("depth", ["#f4f7fa", "#9cc6e0", BLUE, "#0b2f47"])
# From this share on, a cell is so dark that its number is written in white.
_DARK = 0.5


def plot_share_map(
    ax: Axes, shares: pd.DataFrame, notes: pd.DataFrame | None = None, size: float = 7.0
) -> None:
    """Draw a table of shares as a map; each cell has its share in percent.

    Args:
        ax: where to draw.
        shares: lines by columns, both named as on the page; NaN for an empty cell.
        notes: texts of the empty cells, and what follows the number in the others; in the same
            shape.
        size: of the letters (points).
    """
    values = shares.to_numpy(dtype=np.float64)
    lines, columns = values.shape
    flat: Style = {"interpolation": "nearest", "aspect": "auto"}
    ax.imshow(np.ma.masked_invalid(values), cmap=DEPTH, vmin=0, vmax=1, **flat)
    gaps: Style = {"colors": PAPER, "linewidth": 1.2}
    ax.hlines(np.arange(1, lines) - 0.5, -0.5, columns - 0.5, **gaps)
    ax.vlines(np.arange(1, columns) - 0.5, -0.5, lines - 0.5, **gaps)
    for i, j in np.ndindex(lines, columns):
        text, ink = "" if notes is None else str(notes.iat[i, j]), MUTED
        if np.isfinite(values[i, j]):
            text = whole_percent(float(values[i, j])) + text
            ink = MAP_PAPER if values[i, j] > _DARK else ON_MAP
        if text:
            # the layout need not measure what lies inside the axes
            ax.text(
                *(j, i, text), ha="center", va="center", fontsize=size, color=ink, in_layout=False
            )
    ax.set_yticks(range(lines), shares.index, color=INK, fontsize=size)
    ax.set_xticks(range(columns), shares.columns, color=INK, fontsize=size)
    ax.tick_params(length=0)
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set_visible(False)


def whole_percent(share: float) -> str:
    """A share in whole percent, 100 only for 1 and 0 only for 0."""
    if share in (0, 1):
        return f"{100 * share:.0f}"
    return f"{min(max(100 * share, 1), 99):.0f}"

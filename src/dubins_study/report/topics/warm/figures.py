"""Cold against warm starts, drawn."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import only_grid, plain_log_axis
from dubins_study.report.elements.looks import name_of
from dubins_study.report.elements.style import BLUE, INK, MUTED, VERMILION

_PARTS = (("ratio", "time", BLUE, "o", 0.14), ("work", "iterations", VERMILION, "s", -0.14))


def plot_warm(ax: Axes, table: pd.DataFrame) -> None:
    """Median and quartiles of warm over cold, time and iterations. Columns of `warm_starts`."""
    places = np.arange(len(table))[::-1]
    for key, label, colour, marker, lift in _PARTS:
        positive = (table[key] > 0).to_numpy()
        if not positive.any():
            continue
        group, at = table[positive], places[positive] + lift
        low = group[f"{key}_q1"].clip(lower=1e-3)
        ax.hlines(at, low, group[f"{key}_q3"], color=colour, linewidth=2.4, alpha=0.45)
        ax.plot(group[key], at, linestyle="none", marker=marker, color=colour, label=label)
    ax.axvline(1.0, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)))
    ax.set_yticks(places, [name_of(solver) for solver in table["solver"]], color=INK)
    ax.set(xscale="log", ylim=(-0.6, len(table) - 0.4), xlabel="warm / cold")
    left, right = ax.get_xlim()
    ax.set_xlim(min(left, 0.45), max(right, 2.2))  # or 1 would be the only number on the axis
    plain_log_axis(ax.xaxis)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)

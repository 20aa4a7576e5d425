"""A figure of cold against warm starts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import mark_limit, plain_log_axis
from dubins_study.report.elements.plots import label_lines
from dubins_study.report.elements.style import BLUE, VERMILION

_PARTS = (("ratio", "time", BLUE, "o", 0.14), ("work", "iterations", VERMILION, "s", -0.14))


def plot_warm(ax: Axes, table: pd.DataFrame, names: Sequence[str]) -> None:
    """Median and quartiles of warm over cold, time and iterations, one line per solver.

    `table` has the columns of `warm_starts`, `names` the names of its solvers.
    """
    places = np.arange(len(table))[::-1]
    for key, label, colour, marker, lift in _PARTS:
        positive = (table[key] > 0).to_numpy()
        if not positive.any():
            continue
        group, at = table[positive], places[positive] + lift
        low = group[f"{key}_q1"].clip(lower=1e-3)
        ax.hlines(at, low, group[f"{key}_q3"], color=colour, linewidth=2.4, alpha=0.45)
        ax.plot(group[key], at, linestyle="none", marker=marker, color=colour, label=label)
    mark_limit(ax, 1.0)
    ax.set(xscale="log", xlabel="warm / cold")
    left, right = ax.get_xlim()
    ax.set_xlim(min(left, 0.45), max(right, 2.2))  # or 1 would be the only number on the axis
    plain_log_axis(ax.xaxis)
    label_lines(ax, names, places)
    ax.figure.legend(loc="outside lower left", ncols=2)

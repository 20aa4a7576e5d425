"""Figures of the cost of a proof."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis, mark_limit
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.panels import label_lines, plot_quartiles
from dubins_study.report.elements.style import BLUE, GREEN, MUTED, VERMILION, Style
from dubins_study.report.statistics.metrics import solver_order

_GROUPS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"))


def plot_wall(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Draw median and quartiles of the total time; write the share of proven answers next to it.

    Columns solver, wall_s, wall_s_q1, wall_s_q3 (s), own_bound (share), proved and attempts
    (counts).
    """
    places = np.arange(len(table))[::-1]
    looks = palette.looks(table["solver"])
    beside: dict[str, Any] = {"fontsize": 7.5, "color": MUTED}
    for place, row in zip(places, table.to_dict("records"), strict=True):
        shares = f"{_percent(row['own_bound'])}, {_percent(row['proved'] / row['attempts'])}"
        across = ax.get_yaxis_transform()
        ax.text(1.01, place, shares, transform=across, va="center", **beside)
        if row["wall_s"] > 0:
            plot_quartiles(ax, row, "wall_s", place, looks[row["solver"]])
    heading = "own bound, certificate"
    ax.text(1.01, 1.0, heading, transform=ax.transAxes, va="bottom", **beside)
    ax.set(xscale="log", xlabel="time of one attempt")
    log_axis(ax.xaxis, duration)
    label_lines(ax, palette.names(table["solver"]).values(), places)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def plot_prices(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Ratio of times by group, median and quartiles.

    Columns group, solver, ratio, ratio_q1, ratio_q3; `palette` names the solvers.
    """
    solvers = solver_order(table["solver"].tolist())[::-1]
    names = list(dict.fromkeys(table["group"]))
    for number, name in enumerate(names):
        colour, marker = _GROUPS[number % len(_GROUPS)]
        group = table[table["group"] == name].set_index("solver")
        lift = 0.22 * ((len(names) - 1) / 2 - number)
        places = np.array([solvers.index(solver) for solver in group.index]) + lift
        bar: Style = {"color": colour, "linewidth": 2, "alpha": 0.45}
        ax.hlines(places, group["ratio_q1"], group["ratio_q3"], **bar)
        ax.plot(group["ratio"], places, linestyle="none", marker=marker, color=colour, label=name)
    mark_limit(ax, 1.0)
    ax.set(xscale="log", xlabel="time / fastest right answer without a proof")
    log_axis(ax.xaxis)
    label_lines(ax, palette.names(solvers).values(), range(len(solvers)))
    figure = ax.figure
    figure.legend(loc="outside lower left", ncols=3)

"""What a proof costs, drawn."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis, only_grid
from dubins_study.report.elements.looks import Palette, name_of
from dubins_study.report.elements.style import BLUE, GREEN, INK, MUTED, VERMILION
from dubins_study.report.statistics.metrics import solver_order

_GROUPS = ((BLUE, "o"), (VERMILION, "s"), (GREEN, "^"))


def plot_wall(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Median and quartiles of the whole time, and beside them how much is proven.

    Columns solver, wall_s, wall_s_q1, wall_s_q3 (s), own (share), proved and attempts (counts).
    """
    places = np.arange(len(table))[::-1]
    looks = palette.looks(table["solver"])
    for place, row in zip(places, table.to_dict("records"), strict=True):
        shares = f"{_percent(row['own'])}\n{_percent(row['proved'] / row['attempts'])}"
        ax.text(
            1.02,
            place,
            shares,
            transform=ax.get_yaxis_transform(),
            va="center",
            fontsize=7.5,
            color=MUTED,
        )
        if not row["wall_s"] > 0:
            continue
        look = looks[row["solver"]]
        ax.plot(
            [row["wall_s_q1"], row["wall_s_q3"]],
            [place] * 2,
            color=look.colour,
            linewidth=2.4,
            alpha=0.45,
            solid_capstyle="butt",
        )
        ax.plot(row["wall_s"], place, **look.dots)
    ax.set_yticks(places, [name_of(solver) for solver in table["solver"]], color=INK)
    ax.text(
        1.02,
        1.0,
        "own bound,\ncertificate",
        transform=ax.transAxes,
        va="bottom",
        fontsize=7.5,
        color=MUTED,
    )
    ax.set(xscale="log", ylim=(-0.6, len(table) - 0.4), xlabel="time of one attempt")
    log_axis(ax.xaxis, duration)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def plot_prices(ax: Axes, table: pd.DataFrame) -> None:
    """Ratio of times by group, median and quartiles.

    Columns group, solver, ratio, ratio_q1, ratio_q3.
    """
    solvers = solver_order(table["solver"].tolist())[::-1]
    names = list(dict.fromkeys(table["group"]))
    for number, name in enumerate(names):
        colour, marker = _GROUPS[number % len(_GROUPS)]
        group = table[table["group"] == name].set_index("solver")
        lift = 0.22 * ((len(names) - 1) / 2 - number)
        places = np.array([solvers.index(solver) for solver in group.index]) + lift
        ax.hlines(
            places, group["ratio_q1"], group["ratio_q3"], color=colour, linewidth=2, alpha=0.45
        )
        ax.plot(group["ratio"], places, linestyle="none", marker=marker, color=colour, label=name)
    ax.axvline(1.0, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)))
    ax.set_yticks(range(len(solvers)), [name_of(solver) for solver in solvers], color=INK)
    ax.set(xscale="log", ylim=(-0.6, len(solvers) - 0.4))
    ax.set_xlabel("time / fastest right answer without a proof")
    log_axis(ax.xaxis)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)

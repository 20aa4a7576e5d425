"""Work against precision, and the order with which the gap falls, engine by engine."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis
from dubins_study.report.elements.content import digits
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import MUTED


def plot_work_precision(ax: Axes, table: pd.DataFrame) -> None:
    """Median time against median gap, one line an engine, n beside its marks.

    Columns: engine, n, gap (finite and positive), wall_s (s).
    """
    looks = Palette.of(table["engine"]).looks(table["engine"])
    for engine, group in table.groupby("engine", sort=True):
        look = looks[str(engine)]
        group = group.sort_values("n")
        ax.plot(group["wall_s"], group["gap"], marker=look.marker, label=str(engine), **look.lines)
    fastest = table.sort_values("wall_s").drop_duplicates("n")
    for row in fastest.to_dict("records"):
        ax.annotate(
            str(row["n"]),
            (row["wall_s"], row["gap"]),
            xytext=(-6, 0),
            textcoords="offset points",
            ha="right",
            va="center",
            fontsize=7.5,
            color=MUTED,
        )
    ax.set(xscale="log", yscale="log", xlabel="median time of one attempt", ylabel="median gap")
    log_axis(ax.xaxis, duration)
    log_axis(ax.yaxis)
    ax.margins(x=0.14)


def plot_gap_order(ax: Axes, table: pd.DataFrame) -> None:
    """Median gap against n with the fitted order.

    Columns: engine, n, gap (finite and positive), order.
    """
    looks = Palette.of(table["engine"]).looks(table["engine"])
    for engine, group in table.groupby("engine", sort=True):
        look = looks[str(engine)]
        group = group.sort_values("n")
        order = group["order"].iloc[0]
        text = str(engine) if np.isnan(order) else f"{engine}: n⁻ᵖ, p = {digits(3)(order)}"
        ax.plot(group["n"], group["gap"], marker=look.marker, label=text, **look.lines)
    steps = sorted(table["n"].unique())
    ax.set(xscale="log", yscale="log", xlabel="steps n", ylabel="median gap")
    log_axis(ax.yaxis)
    ax.set_xticks(steps, [str(n) for n in steps])
    ax.minorticks_off()

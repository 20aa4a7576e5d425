"""Figures of time, and of work against precision."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from report.content import digits
from report.style import (
    BLUE,
    GREEN,
    INK,
    LINES,
    MUTED,
    ORANGE,
    PURPLE,
    VERMILION,
    Look,
    duration,
    log_axis,
    looks,
    name_of,
    only_grid,
)

_ENGINES = {
    "piqp": Look(GREEN, "D", LINES[0]),
    "osqp": Look(ORANGE, "s", LINES[1]),
    "clarabel": Look(BLUE, "^", LINES[2]),
    "highs": Look(VERMILION, "v", LINES[3]),
}
_OTHER_ENGINE = Look(PURPLE, "P", LINES[0])


def plot_times(ax: Axes, table: pd.DataFrame) -> None:
    """Median and quartiles of building (open) and solving (filled). Columns of `timing.times`."""
    places = np.arange(len(table))[::-1]
    style = looks(table["solver"].tolist())
    for place, row in zip(places, table.to_dict("records"), strict=True):
        look = style[row["solver"]]
        for part, lift, fill in (("solve_s", 0.14, look.colour), ("build_s", -0.14, "none")):
            if not row[part] > 0:
                continue
            ax.plot(
                [max(row[f"{part}_q1"], 1e-9), row[f"{part}_q3"]],
                [place + lift] * 2,
                color=look.colour,
                linewidth=2.4,
                alpha=0.45,
                solid_capstyle="butt",
            )
            ax.plot(row[part], place + lift, **(look.dots | {"markerfacecolor": fill}))
    ax.set_yticks(places, [name_of(solver) for solver in table["solver"]], color=INK)
    ax.set(xscale="log", ylim=(-0.6, len(table) - 0.4), xlabel="time of one attempt")
    log_axis(ax.xaxis, duration)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def plot_work_precision(ax: Axes, table: pd.DataFrame) -> None:
    """Median time against median gap, one line an engine, n beside its marks.

    Columns: engine, n, gap, wall_s; gap is infinite where half the attempts do not arrive.
    """
    for engine, own in table.groupby("engine", sort=True):
        look = _ENGINES.get(str(engine), _OTHER_ENGINE)
        own = own[np.isfinite(own["gap"])].sort_values("n")
        ax.plot(own["wall_s"], own["gap"], marker=look.marker, label=str(engine), **look.lines)
    fastest = table[np.isfinite(table["gap"])].sort_values("wall_s").drop_duplicates("n")
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
    """Median gap against n with the fitted order. Columns: engine, n, gap, order."""
    for engine, own in table.groupby("engine", sort=True):
        look = _ENGINES.get(str(engine), _OTHER_ENGINE)
        own = own[np.isfinite(own["gap"]) & (own["gap"] > 0)].sort_values("n")
        if own.empty:
            continue
        order = own["order"].iloc[0]
        text = str(engine) if np.isnan(order) else f"{engine}: n⁻ᵖ, p = {digits(3)(order)}"
        ax.plot(own["n"], own["gap"], marker=look.marker, label=text, **look.lines)
    steps = sorted(table["n"].unique())
    ax.set(xscale="log", yscale="log", xlabel="steps n", ylabel="median gap")
    log_axis(ax.yaxis)
    ax.set_xticks(steps, [str(n) for n in steps])
    ax.minorticks_off()
    ax.legend(loc="upper right")

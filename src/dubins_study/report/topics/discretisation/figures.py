"""Figures of work against precision, and of the order of the gap, with one line per engine."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import LINES, Palette
from dubins_study.report.elements.style import MUTED, Style


def plot_work_precision(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Median gap against median time with the gap's quartiles as a band, one line per engine.

    Columns: label (of the engine), solver, n (written next to the marks), gap, gap_q25, gap_q75
    (finite and positive where drawn), wall_s (s).
    """
    _plot_engines(ax, table, "wall_s", palette)
    text: Style = {"textcoords": "offset points", "ha": "right", "va": "center", "fontsize": 7.5}
    fastest = table.sort_values("wall_s").drop_duplicates("n")
    for row in fastest.to_dict("records"):
        point = (row["wall_s"], row["gap"])
        ax.annotate(str(row["n"]), point, xytext=(-6, 0), color=MUTED, **text)
    ax.set_xlabel("median time of one attempt")
    log_axis(ax.xaxis, duration)
    ax.margins(x=0.14)


def plot_gap_order(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Median gap against n with its quartiles as a band, one line per engine.

    Columns: label (of the engine), solver, n, gap, gap_q25, gap_q75, order (of the fit).
    """
    orders = [
        f"{label}, p = {digits(3)(order)}" if order == order else label
        for label, order in zip(table["label"], table["order"], strict=True)
    ]
    _plot_engines(ax, table.assign(label=orders), "n", palette)
    steps = sorted(table["n"].unique())
    ax.set_xlabel("steps n")
    ax.set_xticks(steps, [str(n) for n in steps])
    ax.minorticks_off()


def _plot_engines(ax: Axes, table: pd.DataFrame, x: str, palette: Palette) -> None:
    """The engines' lines, later ones thinner: they coincide where only the steps decide."""
    looks = palette.looks(table["solver"])
    top = 3 * table["gap"].max()
    groups = table.sort_values("n").groupby("solver", sort=True)
    for place, (solver, group) in enumerate(groups):
        look = looks[str(solver)]
        high = group["gap_q75"].clip(upper=top).to_numpy(np.float64)
        low = group["gap_q25"].clip(lower=table["gap"].min() / 3).to_numpy(np.float64)
        ax.fill_between(group[x], low, high, color=look.colour, alpha=0.14, linewidth=0)
        line: Style = {"color": look.colour, "linestyle": LINES[place % len(LINES)]}
        mark: Style = {"marker": look.marker, "markersize": 4 + 1.2 * place}
        mark |= {"markerfacecolor": "none"}
        ax.plot(group[x], group["gap"], **line, **mark, label=group["label"].iloc[0])
    ax.set(xscale="log", yscale="log", ylabel="gap to the shortest length")
    log_axis(ax.yaxis)

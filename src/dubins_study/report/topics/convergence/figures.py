"""Figures of the order of convergence."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis, plain_log_axis
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import Style

_MARKERS = ("D", "s", "^", "v")  # open marks that can be seen inside each other


def plot_orders(
    ax: Axes, table: pd.DataFrame, names: pd.DataFrame, palette: Palette, ylabel: str
) -> None:
    """Median against size, with the order fitted to it.

    Args:
        ax: where to draw.
        table: columns series, size, value (infinite values are left out).
        names: indexed by series; columns solver, label, order (the fitted p, NaN if there is none).
        palette: of the page's solvers.
        ylabel: what `value` is.
    """
    fitted = [
        f"{label}: p = {digits(3)(order)}" if order == order else label
        for label, order in zip(names["label"], names["order"], strict=True)
    ]
    _plot_series(ax, table, names.assign(label=fitted), palette, "size")
    ax.set(xlabel="steps, headings or elements N", ylabel=ylabel)
    plain_log_axis(ax.xaxis)


def plot_cost(ax: Axes, table: pd.DataFrame, names: pd.DataFrame, palette: Palette) -> None:
    """Median gap against median time.

    Columns series, size, value, wall_s (s); `names` and `palette` as for `plot_orders`.
    """
    _plot_series(ax, table, names, palette, "wall_s")
    ax.set(xlabel="median time of one attempt", ylabel="median gap")
    log_axis(ax.xaxis, duration)


def _plot_series(
    ax: Axes, table: pd.DataFrame, names: pd.DataFrame, palette: Palette, x: str
) -> None:
    """Draw lines with open marks of growing size, so that coinciding lines are all visible."""
    looks = palette.looks(names["solver"])
    shown = table[np.isfinite(table["value"]) & (table["value"] > 0)]
    groups = shown.sort_values(["series", "size"], kind="stable").groupby("series", sort=False)
    for place, (name, group) in enumerate(groups):
        solver, label = map(str, names.loc[str(name), ["solver", "label"]])
        mark: Style = {"marker": _MARKERS[place % len(_MARKERS)], "markersize": 3.5 + 2.0 * place}
        mark |= {"markerfacecolor": "none", "label": label}
        ax.plot(group[x], group["value"], **looks[solver].lines, **mark)
    ax.set(xscale="log", yscale="log")
    log_axis(ax.yaxis)

"""Figures of the order of convergence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis, plain_log_axis
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import LINES, Look, Palette
from dubins_study.report.elements.style import Style
from dubins_study.report.statistics.metrics import parse_spec, solver_order

# The hue shows the method; marker and line style show the variant, also in grey print.
_VARIANTS = (("D", LINES[0]), ("s", LINES[1]), ("^", LINES[2]), ("v", LINES[3]))


def line_looks(series: Sequence[str], palette: Palette) -> dict[str, Look]:
    """A look for each series; the first variants of the methods differ too."""
    methods = solver_order([parse_spec(name)[0] for name in series])
    following = {method: place for place, method in enumerate(methods)}
    result: dict[str, Look] = {}
    for name in dict.fromkeys(series):
        method = parse_spec(name)[0]
        hue, _ = palette.hues[method]
        result[name] = Look(hue, *_VARIANTS[following[method] % len(_VARIANTS)])
        following[method] += 1
    return result


def plot_orders(
    ax: Axes, table: pd.DataFrame, palette: Palette, orders: dict[str, float], ylabel: str
) -> None:
    """Median against size, with the order fitted to it.

    Args:
        ax: where to draw.
        table: columns series, size, value (infinite values are left out).
        palette: of the page's solvers.
        orders: series -> its fitted p, NaN if there is none.
        ylabel: what `value` is.
    """
    fitted = {name: f"{name}: p = {digits(3)(p)}" for name, p in orders.items() if not np.isnan(p)}
    _plot_series(ax, table, palette, "size", fitted)
    ax.set(xlabel="steps, headings or elements N", ylabel=ylabel)
    plain_log_axis(ax.xaxis)


def plot_cost(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Median gap against median time. Columns series, size, value, wall_s (s)."""
    _plot_series(ax, table, palette, "wall_s", {})
    ax.set(xlabel="median time of one attempt", ylabel="median gap")
    log_axis(ax.xaxis, duration)


def _plot_series(
    ax: Axes, table: pd.DataFrame, palette: Palette, x: str, labels: dict[str, str]
) -> None:
    """Draw lines with open marks of growing size, so that coinciding lines are all visible."""
    looks = line_looks(table["series"].tolist(), palette)
    shown = table[np.isfinite(table["value"]) & (table["value"] > 0)]
    groups = shown.sort_values(["series", "size"], kind="stable").groupby("series", sort=False)
    for place, (name, group) in enumerate(groups):
        look, label = looks[str(name)], labels.get(str(name), str(name))
        mark: Style = {"marker": look.marker, "markersize": 3.5 + 2.0 * place, "label": label}
        ax.plot(group[x], group["value"], markerfacecolor="none", **look.lines, **mark)
    ax.set(xscale="log", yscale="log")
    log_axis(ax.yaxis)

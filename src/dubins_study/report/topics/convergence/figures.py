"""Figures of the order of convergence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis, plain_log_axis
from dubins_study.report.elements.content import digits
from dubins_study.report.elements.looks import LINES, Look, Palette
from dubins_study.report.statistics.metrics import parse_spec, solver_order

# The hue tells the method, marker and line style its variant: grey print keeps these two.
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
    looks = line_looks(table["series"].tolist(), palette)
    for place, (name, group) in enumerate(_drawable(table).groupby("series", sort=False)):
        look = looks[str(name)]
        order = orders.get(str(name), float("nan"))
        text = str(name) if np.isnan(order) else f"{name}: p = {digits(3)(order)}"
        ax.plot(group["size"], group["value"], label=text, **look.lines, **_mark(look, place))
    ax.set(xscale="log", yscale="log", xlabel="steps, headings or elements N", ylabel=ylabel)
    plain_log_axis(ax.xaxis)
    log_axis(ax.yaxis)


def plot_cost(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Median gap against median time. Columns series, size, value, wall_s (s)."""
    looks = line_looks(table["series"].tolist(), palette)
    for place, (name, group) in enumerate(_drawable(table).groupby("series", sort=False)):
        look = looks[str(name)]
        ax.plot(
            group["wall_s"], group["value"], label=str(name), **look.lines, **_mark(look, place)
        )
    ax.set(xscale="log", yscale="log", xlabel="median time of one attempt", ylabel="median gap")
    log_axis(ax.xaxis, duration)
    log_axis(ax.yaxis)


def _mark(look: Look, place: int) -> dict[str, Any]:
    """Open marks, each larger than the one before, so that lines that coincide are all seen."""
    size = 3.5 + 2.0 * place
    return {"marker": look.marker, "markersize": size, "markerfacecolor": "none"}


def _drawable(table: pd.DataFrame) -> pd.DataFrame:
    """Rows with a value that logarithmic axes can show, by size."""
    shown: pd.DataFrame = table[np.isfinite(table["value"]) & (table["value"] > 0)]
    return shown.sort_values(["series", "size"], kind="stable")

"""Figures of the order of convergence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.page.content import digits
from dubins_study.report.page.style import (
    BLUE,
    GREEN,
    LINES,
    VERMILION,
    Look,
    duration,
    log_axis,
    plain_log_axis,
)
from dubins_study.report.statistics.metrics import parse_spec

# hue by method, marker and dashes by variant: grey print keeps the latter two
_HUES = {"turn-rate-qp": GREEN, "heading-milp": VERMILION, "collocation": BLUE}
_VARIANTS = (("D", LINES[0]), ("s", LINES[1]), ("^", LINES[2]), ("v", LINES[3]))


def line_looks(series: list[str]) -> dict[str, Look]:
    """A look for each series; methods begin at variants of their own."""
    found: dict[str, Look] = {}
    seen: dict[str, int] = {}
    for name in dict.fromkeys(series):
        method = parse_spec(name)[0]
        variant = seen[method] = seen.get(method, list(_HUES).index(method) - 1) + 1
        found[name] = Look(_HUES[method], *_VARIANTS[variant % len(_VARIANTS)])
    return found


def plot_orders(ax: Axes, table: pd.DataFrame, orders: dict[str, float], ylabel: str) -> None:
    """Median against size, with the order fitted to it.

    Args:
        ax: where to draw.
        table: columns series, size, value (infinite values are left out).
        orders: series -> its fitted p, NaN if there is none.
        ylabel: what `value` is.
    """
    looks = line_looks(table["series"].tolist())
    for place, (name, own) in enumerate(_drawable(table).groupby("series", sort=False)):
        look = looks[str(name)]
        order = orders.get(str(name), float("nan"))
        text = str(name) if np.isnan(order) else f"{name}: p = {digits(3)(order)}"
        ax.plot(own["size"], own["value"], label=text, **look.lines, **_mark(look, place))
    ax.set(xscale="log", yscale="log", xlabel="steps, headings or elements N", ylabel=ylabel)
    plain_log_axis(ax.xaxis)
    log_axis(ax.yaxis)


def plot_cost(ax: Axes, table: pd.DataFrame) -> None:
    """Median gap against median time. Columns series, size, value, wall_s (s)."""
    looks = line_looks(table["series"].tolist())
    for place, (name, own) in enumerate(_drawable(table).groupby("series", sort=False)):
        look = looks[str(name)]
        ax.plot(own["wall_s"], own["value"], label=str(name), **look.lines, **_mark(look, place))
    ax.set(xscale="log", yscale="log", xlabel="median time of one attempt", ylabel="median gap")
    log_axis(ax.xaxis, duration)
    log_axis(ax.yaxis)


def _mark(look: Look, place: int) -> dict[str, Any]:
    """Open marks, each larger than the one before: lines that coincide are seen to."""
    size = 3.5 + 2.0 * place
    return {"marker": look.marker, "markersize": size, "markerfacecolor": "none"}


def _drawable(table: pd.DataFrame) -> pd.DataFrame:
    """What logarithmic axes can show, in the order of size."""
    shown: pd.DataFrame = table[np.isfinite(table["value"]) & (table["value"] > 0)]
    return shown.sort_values(["series", "size"], kind="stable")

"""Figures of work against precision, and of the order of the gap, with one line per engine."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import duration, log_axis
from dubins_study.report.elements.formats import digits
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.style import MUTED, Style


def plot_work_precision(ax: Axes, table: pd.DataFrame) -> None:
    """Median time against median gap, one line per engine, with n next to the marks.

    Columns: engine, n, gap (finite and positive), wall_s (s).
    """
    _plot_engines(ax, table, "wall_s", {})
    text: Style = {"textcoords": "offset points", "ha": "right", "va": "center", "fontsize": 7.5}
    fastest = table.sort_values("wall_s").drop_duplicates("n")
    for row in fastest.to_dict("records"):
        point = (row["wall_s"], row["gap"])
        ax.annotate(str(row["n"]), point, xytext=(-6, 0), color=MUTED, **text)
    ax.set_xlabel("median time of one attempt")
    log_axis(ax.xaxis, duration)
    ax.margins(x=0.14)


def plot_gap_order(ax: Axes, table: pd.DataFrame) -> None:
    """Median gap against n with the fitted order.

    Columns: engine, n, gap (finite and positive), order.
    """
    orders = table[table["order"].notna()].drop_duplicates("engine")
    pairs = zip(orders["engine"], orders["order"], strict=True)
    labels = {engine: f"{engine}: n⁻ᵖ, p = {digits(3)(order)}" for engine, order in pairs}
    _plot_engines(ax, table, "n", labels)
    steps = sorted(table["n"].unique())
    ax.set_xlabel("steps n")
    ax.set_xticks(steps, [str(n) for n in steps])
    ax.minorticks_off()


def _plot_engines(ax: Axes, table: pd.DataFrame, x: str, labels: dict[str, str]) -> None:
    looks = Palette.of(table["engine"]).looks(table["engine"])
    for engine, group in table.sort_values("n").groupby("engine", sort=True):
        look, label = looks[str(engine)], labels.get(str(engine), str(engine))
        ax.plot(group[x], group["gap"], marker=look.marker, label=label, **look.lines)
    ax.set(xscale="log", yscale="log", ylabel="median gap")
    log_axis(ax.yaxis)

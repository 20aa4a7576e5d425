"""Figures of time, and of work against precision."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.page.content import digits
from dubins_study.report.page.style import (
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
    plain_log_axis,
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
    low, high = np.log10(ax.get_xlim())
    if high - low < 1:  # an axis within a decade would have no ticks
        ax.set_xlim(10 ** np.floor(low), 10 ** np.ceil(high))
    log_axis(ax.xaxis, duration)
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def plot_performance(ax: Axes, ratios: pd.DataFrame) -> None:
    """Share of questions answered rightly within a factor of the fastest. Columns: solvers."""
    style = looks(list(ratios.columns))
    finite = ratios.to_numpy()[np.isfinite(ratios.to_numpy())]
    last = 1.3 * float(finite.max()) if finite.size else 10.0
    for place, solver in enumerate(ratios.columns):
        ordered = np.sort(ratios[solver].to_numpy(dtype=np.float64))
        solved = ordered[np.isfinite(ordered)]
        share = np.arange(solved.size + 1) / len(ratios)
        x, y = np.concatenate(([1.0], solved, [last])), np.append(share, share[-1])
        ax.step(x, y, where="post", label=name_of(solver), **style[solver].curve(place))
    ax.set(xscale="log", xlim=(1, last), ylim=(0, 1.02))
    plain_log_axis(ax.xaxis)
    ax.yaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    ax.set(xlabel="time / time of the fastest right answer", ylabel="share of questions")


def plot_work_precision(ax: Axes, table: pd.DataFrame) -> None:
    """Median time against median gap, one line an engine, n beside its marks.

    Columns: engine, n, gap (finite and positive), wall_s (s).
    """
    for engine, own in table.groupby("engine", sort=True):
        look = _ENGINES.get(str(engine), _OTHER_ENGINE)
        own = own.sort_values("n")
        ax.plot(own["wall_s"], own["gap"], marker=look.marker, label=str(engine), **look.lines)
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
    for engine, own in table.groupby("engine", sort=True):
        look = _ENGINES.get(str(engine), _OTHER_ENGINE)
        own = own.sort_values("n")
        order = own["order"].iloc[0]
        text = str(engine) if np.isnan(order) else f"{engine}: n⁻ᵖ, p = {digits(3)(order)}"
        ax.plot(own["n"], own["gap"], marker=look.marker, label=text, **look.lines)
    steps = sorted(table["n"].unique())
    ax.set(xscale="log", yscale="log", xlabel="steps n", ylabel="median gap")
    log_axis(ax.yaxis)
    ax.set_xticks(steps, [str(n) for n in steps])
    ax.minorticks_off()

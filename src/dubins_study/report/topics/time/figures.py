"""Times of solvers, and their performance profile."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from dubins_study.report.elements.axes import duration, log_axis, percent_axis, plain_log_axis
from dubins_study.report.elements.looks import Palette, name_of
from dubins_study.report.elements.panels import formulation_grid, name_lines
from dubins_study.report.elements.solver_lines import label_lines, plot_quartiles
from dubins_study.report.elements.style import MUTED


def plot_times(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Median and quartiles of building (open) and solving (filled). Columns of `Attempts.times`."""
    places = np.arange(len(table))[::-1]
    looks = palette.looks(table["solver"])
    for place, row in zip(places, table.to_dict("records"), strict=True):
        for part, lift, fill in (("solve_s", 0.14, ""), ("build_s", -0.14, "none")):
            if row[part] > 0:
                plot_quartiles(ax, row, part, place + lift, looks[row["solver"]], fill)
    ax.set(xscale="log", xlabel="time of one attempt")
    low, high = np.log10(ax.get_xlim())
    if high - low < 1:  # an axis shorter than a decade would have no ticks
        ax.set_xlim(10 ** np.floor(low), 10 ** np.ceil(high))
    log_axis(ax.xaxis, duration)
    label_lines(ax, table["solver"], places)


def plot_time_grid(methods: pd.DataFrame) -> Figure:
    """Median and quartiles of whole attempts, in one panel per formulation.

    Columns of `Attempts.times`, formulation, engine and short.
    """
    figure, panels = formulation_grid(methods, line=0.115)
    looks = Palette.of(methods["engine"]).looks(methods["engine"])
    for name, (ax, lines) in panels.items():
        rows = methods[methods["formulation"] == name]
        places = name_lines(ax, rows["short"].tolist(), 6, lines)
        for place, row in zip(places, rows.to_dict("records"), strict=True):
            plot_quartiles(ax, row, "wall_s", place, looks[row["engine"]])
        ax.set_xscale("log")
        log_axis(ax.xaxis, duration)
        ax.xaxis.set_major_locator(LogLocator(numticks=5))
    figure.supxlabel("time of one attempt", fontsize=8, color=MUTED)
    return figure


def plot_performance(ax: Axes, ratios: pd.DataFrame, palette: Palette) -> None:
    """Share of questions answered correctly within a factor of the fastest. Columns: solvers."""
    looks = palette.looks(ratios.columns)
    finite = ratios.to_numpy()[np.isfinite(ratios.to_numpy())]
    last = 1.3 * float(finite.max()) if finite.size else 10.0
    for place, solver in enumerate(ratios.columns):
        ordered = np.sort(ratios[solver].to_numpy(dtype=np.float64))
        solved = ordered[np.isfinite(ordered)]
        share = np.arange(solved.size + 1) / len(ratios)
        x, y = np.concatenate(([1.0], solved, [last])), np.append(share, share[-1])
        ax.step(x, y, where="post", label=name_of(solver), **looks[solver].curve(place))
    ax.set(xscale="log", xlim=(1, last), ylim=(0, 1.02))
    plain_log_axis(ax.xaxis)
    percent_axis(ax.yaxis)
    ax.set(xlabel="time / time of the fastest right answer", ylabel="share of questions")

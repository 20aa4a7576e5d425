"""Times of solvers, and their performance profile."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from dubins_study.report.elements.axes import (
    duration,
    label_curves,
    log_axis,
    percent_axis,
    plain_log_axis,
    step_curve,
)
from dubins_study.report.elements.looks import BEHIND, Palette
from dubins_study.report.elements.panels import curve_panel, named_panels
from dubins_study.report.elements.plots import label_lines, plot_quartiles
from dubins_study.report.statistics.methods import foremost


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
    label_lines(ax, table["solver"], places, palette)


def plot_time_grid(methods: pd.DataFrame, palette: Palette) -> Figure:
    """Median and quartiles of whole attempts, in one panel per formulation.

    Columns of `Attempts.times`, solver, formulation, engine and short.
    """
    figure, panels = named_panels(methods, "time of one attempt", legend=False)
    looks = palette.looks(methods["solver"])
    low, high = methods["wall_s_q1"].min(), methods["wall_s_q3"].max()
    for name, ax in panels.items():
        rows = methods[methods["formulation"] == name]
        for place, row in zip(range(len(rows))[::-1], rows.to_dict("records"), strict=True):
            plot_quartiles(ax, row, "wall_s", place, looks[row["solver"]])
        ax.set(xscale="log", xlim=(0.7 * low, 1.4 * high))
        log_axis(ax.xaxis, duration)
        ax.xaxis.set_major_locator(LogLocator(numticks=5))
    return figure


def plot_performance(ratios: pd.DataFrame, palette: Palette) -> Figure:
    """Share of questions answered correctly within a factor of the fastest. Columns: solvers."""
    values = ratios.to_numpy(dtype=np.float64)
    finite = values[np.isfinite(values)]
    factors = np.geomspace(1.0, max(float(finite.max()) if finite.size else 1.0, 2.0), 200)
    named = foremost(pd.Series(np.isfinite(values).mean(axis=0), ratios.columns))
    looks = palette.looks(named)
    labels = {solver: palette.label(solver) for solver in named}
    xlabel = "time / time of the fastest right answer"
    figure, ax = curve_panel(list(labels.values()), xlabel, "share of questions")
    lines = {}
    for solver in ratios.columns:
        times = np.sort(ratios[solver].to_numpy(dtype=np.float64))
        steps = step_curve(times, np.arange(1, len(times) + 1) / len(times), factors)
        style = looks[solver].lines if solver in looks else BEHIND
        (line,) = ax.step(*steps, where="post", **style)
        if solver in labels:
            lines[labels[solver]] = line
    ax.set(xscale="log", xlim=(1, factors[-1]), ylim=(0, 1.02))
    plain_log_axis(ax.xaxis)
    percent_axis(ax.yaxis)
    label_curves(ax, lines, 7)
    return figure

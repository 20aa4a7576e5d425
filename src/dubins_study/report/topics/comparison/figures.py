"""Profiles of methods: by formulation, of the best two, in evaluations, and over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dubins_study.report.elements.axes import (
    duration,
    label_curves,
    log_axis,
    percent_axis,
    plain_log_axis,
    step_curve,
)
from dubins_study.report.elements.looks import BEHIND, Palette
from dubins_study.report.elements.names import common_part
from dubins_study.report.elements.panels import curve_panel, curve_panels
from dubins_study.study.path import FloatArray

# Points of a curve: as fine as a panel can show.
_POINTS = 120
# Up to here an axis from 1 is labelled 1, 2, 5, 10, ...: decades alone would be too few.
_PLAIN_UP_TO = 60.0


def factors_up_to(largest: float) -> FloatArray:
    """Points of a logarithmic axis from 1 to a number, or to 2 if that is smaller."""
    return np.geomspace(1.0, max(largest, 2.0), _POINTS)


def plot_profiles(
    profiles: Mapping[str, pd.DataFrame],
    named: Mapping[str, Sequence[str]],
    methods: pd.DataFrame,
    palette: Palette,
) -> Figure:
    """Performance profiles, one panel per formulation.

    Args:
        profiles: formulation -> profile indexed by factor, a column per solver.
        named: formulation -> the solvers whose curves have colours and names; the others are grey.
        methods: indexed by solver; column short.
        palette: of the page.
    """
    parts = {n: common_part(methods["short"].reindex(list(s)).tolist()) for n, s in named.items()}
    titles = {name: f"{name}{shared}" for name, (shared, _) in parts.items()}
    labels = {titles[name]: short for name, (_, short) in parts.items()}
    xlabel = "time / time of the fastest right answer of the formulation"
    figure, panels = curve_panels(labels, xlabel, "share of questions", same_x=False)
    for name, profile in profiles.items():
        ax = panels[titles[name]]
        _plot_curves(ax, profile, dict(zip(named[name], parts[name][1], strict=True)), palette, 6)
        ax.set_yticks((0, 0.5, 1))
    return figure


def plot_wide(
    shares: pd.DataFrame, palette: Palette, xlabel: str, ylabel: str = "share of questions"
) -> Figure:
    """Rising shares in one panel as wide as the page; durations if the label says `time of`."""
    labels = {solver: palette.label(solver) for solver in map(str, shares.columns)}
    figure, ax = curve_panel(list(labels.values()), xlabel, ylabel)
    _plot_curves(ax, shares, labels, palette, 7)
    if xlabel.startswith("time of"):
        log_axis(ax.xaxis, duration)
    return figure


def _plot_curves(
    ax: Axes, shares: pd.DataFrame, labels: Mapping[str, str], palette: Palette, size: float
) -> None:
    """Rising shares over a logarithmic axis; those that have a label in colour, others in grey."""
    points = shares.index.to_numpy(dtype=np.float64)
    looks, lines = palette.looks(labels), {}
    for solver in map(str, shares.columns):
        steps = step_curve(points, shares[solver].to_numpy(dtype=np.float64), points)
        if solver in labels:
            style = looks[solver].lines | {"linewidth": 1.2}
            (lines[labels[solver]],) = ax.step(*steps, where="post", **style)
        else:
            ax.step(*steps, where="post", **BEHIND)
    ax.set(xscale="log", xlim=(points[0], points[-1]), ylim=(0, 1.02))
    percent_axis(ax.yaxis)
    plain_log_axis(ax.xaxis) if points[-1] < _PLAIN_UP_TO else log_axis(ax.xaxis)
    label_curves(ax, lines, size)

"""Profiles of methods: by formulation, of the best two, in evaluations, and over time."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dubins_study.report.elements.axes import duration, log_axis, percent_axis, plain_log_axis
from dubins_study.report.elements.looks import LINES, Look, Palette
from dubins_study.report.elements.style import WIDE, new_figure
from dubins_study.study.path import FloatArray

# Points of a curve: as fine as a panel can show.
_POINTS = 120
_PANEL_HEIGHT = 1.75  # inches
_LEGEND = 6.5  # points
# Up to here an axis from 1 is labelled 1, 2, 5, 10, ...: decades alone would be too few.
_PLAIN_UP_TO = 60.0


def method_looks(methods: pd.DataFrame, key: str, palette: Palette) -> dict[str, Look]:
    """A look for each method: hue and marker by a column, the line by its place among
    those of the same hue.

    Args:
        methods: indexed by solver.
        key: the column: `engine`, or `formulation` where there is one method of each.
        palette: of all values of that column on the page.
    """
    looks: dict[str, Look] = {}
    used: dict[str, int] = {}
    for solver, value in methods[key].items():
        colour, marker = palette.hues[value]
        place = used.get(colour, 0)
        looks[str(solver)] = Look(colour, marker, LINES[place % len(LINES)])
        used[colour] = place + 1
    return looks


def factors_up_to(largest: float) -> FloatArray:
    """Points of a logarithmic axis from 1 to beyond a number."""
    return np.geomspace(1.0, max(1.3 * largest, 2.0), _POINTS)


def plot_profiles(
    profiles: Mapping[str, pd.DataFrame], methods: pd.DataFrame, palette: Palette
) -> Figure:
    """Performance profiles, one panel per formulation, two beside each other.

    Args:
        profiles: formulation -> profile indexed by factor, a column per solver.
        methods: indexed by solver; columns engine and short.
        palette: of the engines.
    """
    lines = math.ceil(len(profiles) / 2)
    figure = new_figure(WIDE, _PANEL_HEIGHT * lines + 0.3)
    axes = figure.subplots(lines, 2, squeeze=False).ravel()
    for ax, (name, profile) in zip(axes, profiles.items(), strict=False):
        looks = method_looks(methods.loc[list(profile.columns)], "engine", palette)
        plot_curves(ax, profile, looks, methods["short"])
        few_decades = profile.index[-1] < _PLAIN_UP_TO
        plain_log_axis(ax.xaxis) if few_decades else log_axis(ax.xaxis)
        ax.set_title(name)
    for ax in axes[len(profiles) :]:
        ax.set_visible(False)
    figure.supxlabel("time / time of the fastest right answer of the formulation", fontsize=8)
    figure.supylabel("share of questions", fontsize=8)
    return figure


def plot_curves(
    ax: Axes,
    shares: pd.DataFrame,
    looks: Mapping[str, Look],
    labels: Mapping[str, str] | pd.Series[str],
) -> None:
    """Rising shares over a logarithmic axis, with a legend to the right of the panel."""
    points = shares.index.to_numpy(dtype=np.float64)
    for place, solver in enumerate(map(str, shares.columns)):
        curve = looks[solver].curve(place)
        ax.step(points, shares[solver], where="post", label=labels[solver], **curve)
    ax.set(xscale="log", xlim=(points[0], points[-1]), ylim=(0, 1.02))
    percent_axis(ax.yaxis)
    ax.tick_params(labelsize=7)
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.05), fontsize=_LEGEND, handlelength=1.8)


def plot_wide(
    shares: pd.DataFrame,
    looks: Mapping[str, Look],
    labels: Mapping[str, str] | pd.Series[str],
    xlabel: str,
    ylabel: str,
) -> Figure:
    """Rising shares in one panel as wide as the page; durations if the label says `time`."""
    figure = new_figure(WIDE, max(2.6, 0.4 + 0.27 * len(shares.columns)))
    ax = figure.subplots()
    plot_curves(ax, shares, looks, labels)
    if xlabel.startswith("time of"):
        log_axis(ax.xaxis, duration)
    elif shares.index[-1] < _PLAIN_UP_TO:
        plain_log_axis(ax.xaxis)
    else:
        log_axis(ax.xaxis)
    ax.set(xlabel=xlabel, ylabel=ylabel)
    return figure

"""Figures of the turn that remains in a solver's path though the shortest path has none."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import log_axis, power
from dubins_study.report.elements.looks import LINES, Palette
from dubins_study.report.elements.style import BLUE, INK, MUTED, VERMILION
from dubins_study.report.statistics.metrics import solver_order


def plot_bias(ax: Axes, table: pd.DataFrame) -> None:
    """Draw the remaining turn against its prediction, and the line where they are equal.

    Columns: predicted, z2 (length unit), barrier_set (whether a setting gives the barrier).
    """
    ends = np.array([0.5 * table["predicted"].min(), 2 * table["predicted"].max()])
    ax.plot(ends, ends, color=MUTED, linewidth=0.9, linestyle=LINES[1], label="equal")
    hollow: dict[str, Any] = {"linestyle": "none", "markerfacecolor": "none"}
    with_barrier, default = table[table["barrier_set"]], table[~table["barrier_set"]]
    if len(with_barrier):
        look = {"color": BLUE, "label": "Ipopt told to stop at μ", **hollow}
        ax.plot(with_barrier["predicted"], with_barrier["z2"], "o", **look)
    if len(default):
        look = {"color": VERMILION, "markersize": 6, "markeredgewidth": 1.4}
        ax.plot(default["predicted"], default["z2"], "x", label="Ipopt by its defaults", **look)
    ax.set(xscale="log", yscale="log", xlim=tuple(ends), ylim=tuple(ends))
    ax.set(xlabel="(μ R²)^(1/3)  (length unit)", ylabel="right turn left over, z₂ (length unit)")
    log_axis(ax.xaxis)
    log_axis(ax.yaxis)


def plot_left_over(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Draw the remaining turn in radii against the radius; a mark at the bottom means no turn.

    Columns: solver, radius, z2 (length unit).
    """
    looks, names = palette.looks(table["solver"]), palette.names(table["solver"])
    share = table["z2"] / table["radius"]
    foot = 10.0 ** np.floor(np.log10(share[share > 0].min()) - 1) if (share > 0).any() else 1e-8
    for place, solver in enumerate(solver_order(table["solver"].tolist())):
        group = table[table["solver"] == solver].sort_values("radius")
        left = (group["z2"] / group["radius"]).clip(lower=foot)
        # Shift each solver a little, since solvers without a turn all have marks at the bottom.
        at = group["radius"] * 1.06 ** (place - 2)
        look = looks[solver]
        ax.plot(at, left, marker=look.marker, markersize=4, **look.lines, label=names[solver])
    ax.set(xscale="log", yscale="log", ylim=(foot / 2, None))
    ax.set(xlabel="turning radius R (length unit)", ylabel="right turn left over, z₂ / R")
    log_axis(ax.xaxis)
    log_axis(ax.yaxis, lambda value, _=None: "none" if value < 1.5 * foot else power(value))
    ax.axhline(foot, color=INK, linewidth=0.5)

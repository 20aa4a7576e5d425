"""Figures of the verdicts, and of the gaps to the optimum."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dubins_study.report.data.attempts import PRESOLVED, VERDICTS
from dubins_study.report.elements.axes import log_axis, mark_limit, percent_axis
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette, name_of
from dubins_study.report.elements.panels import formulation_grid, plot_share_grid
from dubins_study.report.elements.solver_lines import plot_shares
from dubins_study.report.elements.style import BLUE, MUTED, ORANGE, RULE, VERMILION
from dubins_study.report.statistics.metrics import solver_order

# From dark to light, hatched if an answer is wrong, so that grey print keeps the order.
VERDICT_LOOK = {
    "optimal": (BLUE, ""),
    "none exists": ("#b9def3", ""),
    PRESOLVED: ("#e6f2fa", "|"),
    "longer": (ORANGE, "///"),
    "misses": (VERMILION, "xx"),
    "none": (RULE, "..."),
}
SMALLEST_GAP = 1e-16


def plot_verdicts(ax: Axes, table: pd.DataFrame) -> None:
    """Draw the share of each verdict, one bar per solver. Columns of `summary.numbers.summary`."""
    look = {verdict: VERDICT_LOOK[verdict] for verdict in VERDICTS}
    notes = [
        f"of {count(row['attempts'])}: {count(row['false_claims'])} false claims,\n"
        f"{count(row['wrong_basins'])} wrong basins"
        for row in table.to_dict("records")
    ]
    plot_shares(ax, table, look, notes)
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncols=5, borderaxespad=0.2)


def plot_verdict_grid(table: pd.DataFrame) -> Figure:
    """The same in one panel per formulation. Columns also formulation and short."""
    shares = table[list(VERDICTS)].div(table["attempts"], axis=0)
    look = {verdict: VERDICT_LOOK[verdict] for verdict in VERDICTS if shares[verdict].any()}
    return plot_share_grid(
        shares.join(table[["formulation", "short"]]), look, "share of all attempts"
    )


def plot_gap_profile(
    ax: Axes, shares: Mapping[str, pd.DataFrame], palette: Palette, tolerance: float | None
) -> None:
    """Share of attempts within each gap.

    Args:
        ax: where to draw.
        shares: from `gap_shares`.
        palette: the palette of the page's solvers.
        tolerance: largest gap that the check accepts as optimal, drawn as a line if given.
    """
    solvers = solver_order(list(shares))
    looks = palette.looks(solvers)
    for place, solver in enumerate(solvers):
        _plot_shares_within(ax, shares[solver], name_of(solver, 40), looks[solver].curve(place))
    if tolerance is not None:
        mark_limit(ax, tolerance)
        ax.text(tolerance, 1.03, "optimal up to here", ha="center", fontsize=7.5, color=MUTED)
    _set_gap_axes(ax)
    ax.set(xlabel="gap to the shortest length (relative)", ylabel="share of all attempts")


def plot_gap_profiles(
    methods: pd.DataFrame, shares: Mapping[str, pd.DataFrame], tolerance: float | None
) -> Figure:
    """Share of attempts within each gap, in one panel per formulation, an engine a curve.

    Args:
        methods: columns solver, formulation, engine.
        shares, tolerance: as for `plot_gap_profile`.
    """
    figure, panels = formulation_grid(methods, height=0.95)
    looks = Palette.of(methods["engine"]).looks(methods["engine"])
    curves: dict[str, Artist] = {}
    for name, (ax, _) in panels.items():
        rows = methods[methods["formulation"] == name]
        for place, (solver, engine) in enumerate(zip(rows["solver"], rows["engine"], strict=True)):
            curve = looks[engine].curve(place) | {"linewidth": 1.0}
            curves[engine] = _plot_shares_within(ax, shares[solver], engine, curve)
        if tolerance is not None:
            mark_limit(ax, tolerance)
        _set_gap_axes(ax)
    figure.supxlabel("gap to the shortest length (relative)", fontsize=8, color=MUTED)
    figure.supylabel("share of all attempts", fontsize=8, color=MUTED)
    entries = [curves[engine] for engine in sorted(curves, key=str.casefold)]
    figure.legend(handles=entries, loc="outside upper left", ncols=6, fontsize=6.5)
    return figure


def _plot_shares_within(
    ax: Axes, shares: pd.DataFrame, label: str, curve: Mapping[str, Any]
) -> Artist:
    within, share = (shares[name].to_numpy() for name in ("gap", "share"))
    x = np.concatenate(([SMALLEST_GAP], np.maximum(within, SMALLEST_GAP), [10.0]))
    y = np.concatenate(([0.0], share, share[-1:] if share.size else [0.0]))
    (line,) = ax.step(x, y, where="post", label=label, **curve)
    return line


def _set_gap_axes(ax: Axes) -> None:
    ax.set(xscale="log", xlim=(SMALLEST_GAP, 10), ylim=(0, 1.02))
    percent_axis(ax.yaxis)
    log_axis(ax.xaxis)

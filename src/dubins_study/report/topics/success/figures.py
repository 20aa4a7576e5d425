"""Figures of the verdicts, and of the gaps to the optimum."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dubins_study.report.data.attempts import PRESOLVED, VERDICTS
from dubins_study.report.elements.axes import (
    label_curves,
    log_axis,
    mark_limit,
    percent_axis,
    step_curve,
)
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import BEHIND, Look, Palette
from dubins_study.report.elements.names import common_part
from dubins_study.report.elements.panels import (
    curve_panel,
    curve_panels,
    plot_shares,
    plot_stacked_shares,
)
from dubins_study.report.elements.style import BLUE, ORANGE, RULE, VERMILION
from dubins_study.report.statistics.methods import foremost
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.study.path import FloatArray

# From dark to light, hatched if an answer is wrong, so that grey print keeps the order.
VERDICT_LOOK = {
    "optimal": (BLUE, ""),
    "none exists": ("#b9def3", ""),
    PRESOLVED: ("#e6f2fa", "|"),
    "longer": (ORANGE, "///"),
    "misses": (VERMILION, "xx"),
    "none": (RULE, ""),
}
SMALLEST_GAP = 1e-16


def plot_verdicts(ax: Axes, table: pd.DataFrame, palette: Palette) -> None:
    """Draw the share of each verdict, one bar per solver. Columns of `summary.numbers.summary`."""
    look = {verdict: VERDICT_LOOK[verdict] for verdict in VERDICTS}
    notes = [
        f"of {count(row['attempts'])}: {count(row['false_claims'])} false claims,\n"
        f"{count(row['wrong_basins'])} wrong basins"
        for row in table.to_dict("records")
    ]
    plot_shares(ax, table, look, notes, palette)
    if ax.get_legend_handles_labels()[0]:  # no bar has a label where no verdict is known
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1.0), ncols=5, borderaxespad=0.2)


def plot_verdict_grid(table: pd.DataFrame) -> Figure:
    """The same in one panel per formulation. Columns also formulation and short."""
    shares = table[list(VERDICTS)].div(table["attempts"], axis=0)
    look = {verdict: VERDICT_LOOK[verdict] for verdict in VERDICTS if shares[verdict].any()}
    return plot_stacked_shares(
        shares.join(table[["formulation", "short"]]), look, "share of all attempts"
    )


def plot_gap_profile(
    shares: Mapping[str, pd.DataFrame], palette: Palette, tolerance: float | None
) -> Figure:
    """Share of attempts within each gap, in one panel as wide as the page.

    Args:
        shares: from `gap_shares`.
        palette: the palette of the page's solvers.
        tolerance: largest gap that the check accepts as optimal, drawn as a line if given.
    """
    solvers = solver_order(list(shares))
    scores = pd.Series({solver: _share_within(shares[solver], tolerance) for solver in solvers})
    named = foremost(scores)
    looks = palette.looks(named)
    labels = {solver: palette.label(solver) for solver in named}
    figure, ax = curve_panel(list(labels.values()), *_GAP_AXES)
    for solver in scores.index.difference(named):
        ax.step(*_steps(shares[solver]), where="post", **BEHIND)
    _plot_gaps(ax, {labels[s]: (shares[s], looks[s]) for s in named}, tolerance)
    return figure


def _share_within(shares: pd.DataFrame, tolerance: float | None) -> float:
    """The share of attempts within the tolerance; without one, within any gap."""
    kept = shares if tolerance is None else shares[shares["gap"] <= tolerance]
    return float(kept["share"].max()) if len(kept) else 0.0


def plot_gap_profiles(
    methods: pd.DataFrame,
    shares: Mapping[str, pd.DataFrame],
    palette: Palette,
    tolerance: float | None,
) -> Figure:
    """Share of attempts within each gap, in one panel per formulation, a curve per method.

    Args:
        methods: columns solver, formulation, short.
        shares, palette, tolerance: as for `plot_gap_profile`.
    """
    groups = {str(name): rows for name, rows in methods.groupby("formulation", sort=False)}
    parts = {name: common_part(rows["short"].tolist()) for name, rows in groups.items()}
    titles = {name: f"{name}{shared}" for name, (shared, _) in parts.items()}
    figure, panels = curve_panels({titles[n]: names for n, (_, names) in parts.items()}, *_GAP_AXES)
    for name, rows in groups.items():
        looks = palette.looks(rows["solver"])
        pairs = zip(parts[name][1], rows["solver"], strict=True)
        curves = {label: (shares[solver], looks[solver]) for label, solver in pairs}
        _plot_gaps(panels[titles[name]], curves, tolerance)
    return figure


_GAP_AXES = ("gap to the shortest length (relative)", "share of all attempts")
_LARGEST_GAP = 10.0
_GAP_TICKS = (1e-15, 1e-10, 1e-5, 1.0)
# Points of a curve: as fine as a panel can show.
_GAPS = np.geomspace(SMALLEST_GAP, _LARGEST_GAP, 100)


def _plot_gaps(
    ax: Axes, curves: Mapping[str, tuple[pd.DataFrame, Look]], tolerance: float | None
) -> None:
    """Draw the shares of `gap_shares` with their names; the optimal ones left of a dotted line."""
    lines = {}
    for name, (shares, look) in curves.items():
        (lines[name],) = ax.step(*_steps(shares), where="post", linewidth=1.1, **look.lines)
    if tolerance is not None:
        mark_limit(ax, tolerance)
    ax.set(xscale="log", xlim=(SMALLEST_GAP, _LARGEST_GAP), ylim=(0, 1.02), yticks=(0, 0.5, 1))
    percent_axis(ax.yaxis)
    log_axis(ax.xaxis)
    ax.set_xticks(_GAP_TICKS)
    label_curves(ax, lines)


def _steps(shares: pd.DataFrame) -> tuple[FloatArray, FloatArray]:
    gaps = np.maximum(shares["gap"].to_numpy(dtype=np.float64), SMALLEST_GAP)
    return step_curve(gaps, shares["share"].to_numpy(dtype=np.float64), _GAPS)

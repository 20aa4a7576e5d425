"""Figures of the verdicts, and of the gaps to the optimum."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.attempts import PRESOLVED, VERDICTS
from dubins_study.report.elements.axes import log_axis, mark_limit, percent_axis
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette, name_of
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
        within, share = (shares[solver][name].to_numpy() for name in ("gap", "share"))
        x = np.concatenate(([SMALLEST_GAP], np.maximum(within, SMALLEST_GAP), [10.0]))
        y = np.concatenate(([0.0], share, share[-1:] if share.size else [0.0]))
        curve = looks[solver].curve(place)
        ax.step(x, y, where="post", label=name_of(solver, 40), **curve)
    if tolerance is not None:
        mark_limit(ax, tolerance)
        ax.text(tolerance, 1.03, "optimal up to here", ha="center", fontsize=7.5, color=MUTED)
    ax.set(xscale="log", xlim=(SMALLEST_GAP, 10), ylim=(0, 1.02))
    ax.set(xlabel="gap to the shortest length (relative)", ylabel="share of all attempts")
    percent_axis(ax.yaxis)
    log_axis(ax.xaxis)

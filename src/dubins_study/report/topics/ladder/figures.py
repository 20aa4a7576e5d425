"""The matrix of solvers and margins."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from dubins_study.report.elements.axes import power
from dubins_study.report.elements.looks import name_of
from dubins_study.report.elements.style import BLUE, INK, MUTED, ORANGE, RULE, VERMILION
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.ladder.numbers import FINDINGS

# colour, marker, filled: each tells the finding on its own
_LOOK = {
    "right": (BLUE, "s", True),
    "coarse": (BLUE, "s", False),
    "by its miss": (ORANGE, "^", True),
    "wrong basin": (VERMILION, "X", True),
    "no path": (INK, "_", True),
}


def plot_ladder(ax: Axes, table: pd.DataFrame, solvers: list[str], arrives: int) -> None:
    """What became of each rung, one line a solver.

    Args:
        ax: where to draw.
        table: columns solver, rung (power of ten), finding, false_claims.
        solvers: from the top.
        arrives: power of ten of the largest miss that the check allows, drawn as a line.
    """
    lines = {solver: i for i, solver in enumerate(solver_order(solvers)[::-1])}
    for finding in FINDINGS:
        colour, marker, filled = _LOOK[finding]
        group = table[table["finding"] == finding]
        ax.plot(
            group["rung"],
            group["solver"].map(lines),
            linestyle="none",
            marker=marker,
            color=colour,
            markersize=5,
            markerfacecolor=colour if filled else "none",
        )
    false = table[table["false_claims"] > 0]
    ax.plot(
        false["rung"],
        false["solver"].map(lines),
        linestyle="none",
        marker="o",
        markersize=9,
        markerfacecolor="none",
        color=VERMILION,
    )
    ax.axvline(arrives, color=MUTED, linewidth=0.8, linestyle=(0, (1, 2)), zorder=0)
    rungs = sorted(table["rung"].unique())
    ax.set_xticks(rungs, [power(10.0**r) if r % 3 == 0 else "" for r in rungs])
    ax.set_yticks(list(lines.values()), [name_of(solver) for solver in lines], color=INK)
    ax.set_xlabel("margin / R")
    ax.set(xlim=(max(rungs) + 0.6, min(rungs) - 0.6), ylim=(-0.6, len(lines) - 0.4))
    ax.grid(False)
    ax.grid(True, axis="y", color=RULE)
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)


def legend_entries(table: pd.DataFrame) -> list[Line2D]:
    """One entry for every finding that there is, and for false claims."""
    entries = []
    for finding in FINDINGS:
        if (table["finding"] == finding).any():
            colour, marker, filled = _LOOK[finding]
            face = colour if filled else "none"
            entries.append(_entry(finding, color=colour, marker=marker, markerfacecolor=face))
    if (table["false_claims"] > 0).any():
        entries.append(
            _entry("false claim", color=VERMILION, marker="o", markerfacecolor="none", markersize=9)
        )
    return entries


def _entry(label: str, **look: object) -> Line2D:
    return Line2D([], [], linestyle="none", label=label, **look)  # type: ignore[arg-type]

"""The matrix of solvers and margins."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from dubins_study.report.elements.axes import mark_limit, power
from dubins_study.report.elements.panels import label_lines
from dubins_study.report.elements.style import BLUE, INK, ORANGE, RULE, VERMILION
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.report.topics.ladder.numbers import FINDINGS

# Finding -> colour, marker, filled.
_LOOK = {
    "right": (BLUE, "s", True),
    "coarse": (BLUE, "s", False),
    "by its miss": (ORANGE, "^", True),
    "wrong basin": (VERMILION, "X", True),
    "no path": (INK, "_", True),
}


def plot_ladder(
    ax: Axes, table: pd.DataFrame, solvers: list[str], names: Mapping[str, str], arrives: int
) -> None:
    """Draw the finding at each rung, one line per solver.

    Args:
        ax: where to draw.
        table: columns solver, rung (power of ten), finding, false_claims.
        solvers: all that have a line.
        names: solver -> its short name.
        arrives: power of ten of the largest miss that the check allows, drawn as a line.
    """
    lines = {solver: i for i, solver in enumerate(solver_order(solvers)[::-1])}
    for finding in FINDINGS:
        group = table[table["finding"] == finding]
        look = {"markersize": 5, **_mark(*_LOOK[finding])}
        ax.plot(group["rung"], group["solver"].map(lines), **look)
    false = table[table["false_claims"] > 0]
    ax.plot(false["rung"], false["solver"].map(lines), **_FALSE_CLAIM)
    mark_limit(ax, arrives).set_zorder(0)
    rungs = sorted(table["rung"].unique())
    ax.set_xticks(rungs, [power(10.0**r) if r % 3 == 0 else "" for r in rungs])
    ax.set(xlabel="margin / R", xlim=(max(rungs) + 0.6, min(rungs) - 0.6))
    label_lines(ax, [names[solver] for solver in lines], list(lines.values()))
    ax.grid(False)
    ax.grid(True, axis="y", color=RULE)


def _mark(colour: str, marker: str, filled: bool) -> dict[str, Any]:
    face = colour if filled else "none"
    return {"linestyle": "none", "color": colour, "marker": marker, "markerfacecolor": face}


_FALSE_CLAIM = {**_mark(VERMILION, "o", False), "markersize": 9}


def legend_entries(table: pd.DataFrame) -> list[Line2D]:
    """Legend entries for the findings in the table, and for false claims."""
    looks = {
        finding: _mark(*_LOOK[finding])
        for finding in FINDINGS
        if (table["finding"] == finding).any()
    }
    if (table["false_claims"] > 0).any():
        looks["false claim"] = _FALSE_CLAIM
    return [Line2D([], [], label=label, **look) for label, look in looks.items()]

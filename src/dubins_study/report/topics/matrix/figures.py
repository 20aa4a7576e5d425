"""Figures of the shares of right answers: by formulation and engine, and by stratum."""

from __future__ import annotations

import textwrap

import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.style import INK, MUTED, Style
from dubins_study.report.topics.matrix.heatmap import plot_share_map
from dubins_study.report.topics.matrix.numbers import Matrix


def plot_matrix(ax: Axes, table: Matrix) -> None:
    """Shares of right answers, engines by formulations; an empty cell has its reason's number.

    A star follows the share of a method that was asked fewer questions than others.
    """
    names = [engine for _, engine in table.engines]
    stars = table.cells["few"].map({True: "*", False: ""})
    numbers = [f"[{note}]" if note else "" for note in table.cells["note"]]
    cells = table.cells.assign(text=stars.where(table.cells["filled"], numbers))
    wide = {
        key: cells.pivot(index="engine", columns="formulation", values=key).reindex(
            index=names, columns=table.formulations
        )
        for key in ("right_share", "text")
    }
    plot_share_map(ax, wide["right_share"], wide["text"])
    # Aslant, since a name is wider than its column.
    aslant: Style = {"rotation": 30, "ha": "left", "rotation_mode": "anchor", "fontsize": 7}
    ax.set_xticks(range(len(table.formulations)), table.formulations, **aslant)
    ax.xaxis.tick_top()
    _name_kinds(ax, table)


def _name_kinds(ax: Axes, table: Matrix) -> None:
    """Write the kinds of engines at the right, and a line between two kinds."""
    kinds = [kind for kind, _ in table.engines]
    starts = [place for place, kind in enumerate(kinds) if place == 0 or kind != kinds[place - 1]]
    for start in starts:
        right, name = len(table.formulations) - 0.4, textwrap.fill(kinds[start], 11)
        ax.text(right, start - 0.4, name, va="top", fontsize=6, color=MUTED)
        if start:
            ax.axhline(start - 0.5, color=INK, linewidth=0.6)


def plot_strata(ax: Axes, shares: pd.DataFrame) -> None:
    """Shares of right answers of one formulation: methods by strata."""
    plot_share_map(ax, shares, size=6)
    ax.set_xticks(range(len(shares.columns)), shares.columns, rotation=90, fontsize=6)

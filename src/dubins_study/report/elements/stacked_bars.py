"""Shares of attempts as stacked bars, one bar a solver."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.elements.axes import only_grid
from dubins_study.report.elements.looks import name_of
from dubins_study.report.elements.style import INK, MUTED


def plot_shares(
    ax: Axes, table: pd.DataFrame, look: Mapping[str, tuple[str, str]], notes: Sequence[str]
) -> None:
    """Stack the counts of `look`'s columns over the column `attempts`.

    Args:
        ax: where to draw.
        table: columns solver, attempts, and a count for each name in `look`.
        look: column -> colour and hatch, in the order of the stack.
        notes: what stands at the right of each bar, one for each row.
    """
    places = np.arange(len(table))[::-1]
    left = np.zeros(len(table))
    for name, (colour, hatch) in look.items():
        width = table[name].to_numpy() / table["attempts"].to_numpy()
        if not width.any():
            continue
        ax.barh(
            places,
            width,
            left=left,
            height=0.62,
            color=colour,
            hatch=hatch,
            edgecolor="white",
            linewidth=0,
            label=name,
        )
        left += width
    for place, note in zip(places, notes, strict=True):
        ax.text(1.015, place, note, va="center", fontsize=7.5, color=MUTED)
    ax.set_yticks(places, [name_of(solver) for solver in table["solver"]], color=INK)
    ax.set(xlim=(0, 1), ylim=(-0.6, len(table) - 0.4), xlabel="share of all attempts")
    ax.xaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)

"""How far proofs go, as stacked bars."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from report.certificates import PROOFS
from report.content import count
from report.style import BLUE, INK, MUTED, ORANGE, RULE, SKY, name_of, only_grid

# dark to light, the weaker ones hatched, so that the order survives grey printing
_LOOK = {
    "proved": (BLUE, ""),
    "bounded": (SKY, "..."),
    "extremal": (ORANGE, "///"),
    "none": (RULE, "xx"),
}


def plot_proofs(ax: Axes, table: pd.DataFrame) -> None:
    """Share of each proof, one bar a solver. Columns solver, attempts, one count per proof."""
    places = np.arange(len(table))[::-1]
    left = np.zeros(len(table))
    for name in PROOFS:
        width = table[name].to_numpy() / table["attempts"].to_numpy()
        if not width.any():
            continue
        colour, hatch = _LOOK[name]
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
    for place, attempts in zip(places, table["attempts"], strict=True):
        ax.text(1.015, place, f"of {count(attempts)}", va="center", fontsize=7.5, color=MUTED)
    ax.set_yticks(places, [name_of(solver) for solver in table["solver"]], color=INK)
    ax.set(xlim=(0, 1), ylim=(-0.6, len(table) - 0.4), xlabel="share of all attempts")
    ax.xaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    only_grid(ax, "x")
    ax.spines["left"].set_visible(False)
    ax.tick_params(axis="y", length=0)

"""How far proofs go, as stacked bars."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes

from dubins_study.report.data.attempts import PROOFS
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.solver_lines import plot_shares
from dubins_study.report.elements.style import BLUE, ORANGE, RULE, SKY

# dark to light, the weaker ones hatched, so that the order survives grey printing
_LOOK = {
    "proved": (BLUE, ""),
    "bounded": (SKY, "..."),
    "extremal": (ORANGE, "///"),
    "none": (RULE, "xx"),
}


def plot_proofs(ax: Axes, table: pd.DataFrame) -> None:
    """Share of each proof, one bar a solver. Columns solver, attempts, one count per proof."""
    look = {name: _LOOK[name] for name in PROOFS}
    plot_shares(ax, table, look, [f"of {count(attempts)}" for attempts in table["attempts"]])
    ax.figure.legend(loc="outside lower left", ncols=4)

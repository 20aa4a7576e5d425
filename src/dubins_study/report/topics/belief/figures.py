"""The figure of what claims are worth."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from dubins_study.report.elements.formats import count
from dubins_study.report.elements.panels import plot_stacked_shares
from dubins_study.report.elements.style import BLUE, RULE, VERMILION

# From dark to light with hatches, so that grey print keeps them apart.
LOOKS = {
    "true": (BLUE, ""),
    "true to its tolerance": ("#3f8fc4", "..."),
    "less than known": ("#86bce0", "///"),
    "says nothing": (RULE, ""),
    "false": (VERMILION, "xx"),
}


def plot_beliefs(table: pd.DataFrame) -> Figure:
    """The share of each worth of the claims, one bar per method; the number of false claims beside.

    Columns of `numbers.beliefs`, and formulation, short and attempts (number of false claims).
    """
    notes = [f"{count(n)} false" if n else "" for n in table["attempts"]]
    return plot_stacked_shares(table, LOOKS, notes, "share of questions")

"""The figure of what claims are worth."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from dubins_study.report.elements.formats import count
from dubins_study.report.elements.panels import plot_stacked_shares
from dubins_study.report.elements.style import BLUE, RULE, VERMILION

# Fewer than this share of the questions that others met is worth a note.
_FEW = 0.5
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

    Beside the bars of methods that met few questions stands their number too.

    Columns of `numbers.beliefs`, and formulation, short and attempts (number of false claims).
    """
    few = table["questions"] < _FEW * table["questions"].max()
    counts = zip(table["questions"], few, strict=True)
    asked = [f"(of {count(n)} questions)" if is_few else "" for n, is_few in counts]
    false = [f"{count(n)} false" if n else "" for n in table["attempts"]]
    notes = [" ".join(filter(None, pair)) for pair in zip(false, asked, strict=True)]
    return plot_stacked_shares(table, LOOKS, notes, "share of questions")

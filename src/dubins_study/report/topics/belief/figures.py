"""The figure of what claims are worth."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from dubins_study.report.elements.formats import count
from dubins_study.report.elements.panels import plot_stacked_shares
from dubins_study.report.elements.style import BLUE, RULE, VERMILION

# Fewer than this share of the questions that others met is worth a note.
FEW = 0.5
# From dark to light with hatches, so that grey print keeps them apart.
LOOKS = {
    "true": (BLUE, ""),
    "true to its tolerance": ("#3f8fc4", "||"),
    "less than known": ("#86bce0", "///"),
    "says nothing": (RULE, ""),
    "false": (VERMILION, "xx"),
}


def plot_beliefs(table: pd.DataFrame) -> Figure:
    """The share of each worth of the claims, one bar per method; the number of false claims beside.

    A star marks methods that met few questions.

    Columns of `numbers.beliefs`, and formulation, short and attempts (number of false claims).
    """
    few = table["questions"] < FEW * table["questions"].max()
    counts = zip(table["attempts"], few, strict=True)
    notes = [(count(n) if n else "") + ("*" if is_few else "") for n, is_few in counts]
    present = {kind: look for kind, look in LOOKS.items() if table[kind].any()}
    return plot_stacked_shares(table, present, "share of questions", notes)

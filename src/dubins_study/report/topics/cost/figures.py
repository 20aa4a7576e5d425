"""Figures of what evaluations and seconds go to."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from dubins_study.report.elements.formats import digits, seconds
from dubins_study.report.elements.panels import plot_stacked_shares
from dubins_study.report.elements.style import BLUE, GREEN, ORANGE, RULE, VERMILION

# From dark to light with hatches, so that neighbours differ in grey print.
LOOKS = {
    "winning run": (BLUE, ""),
    "restarts": ("#b9def3", "///"),
    "losing words": (ORANGE, "\\\\\\"),
    "words without a path": (VERMILION, "xx"),
    "building": (GREEN, "||"),
    "rest": (RULE, ""),
}


def plot_cost_shares(table: pd.DataFrame, amount: str) -> Figure:
    """What the evaluations, or the seconds, of right answers go to; the mean total beside it.

    Columns of `numbers.shares`.
    """
    show = digits(3) if amount == "evaluations" else seconds
    present = {kind: look for kind, look in LOOKS.items() if table[kind].any()}
    notes = [show(total) for total in table["total"]]
    label = f"share of {'evaluations' if amount == 'evaluations' else 'the time'}, right answers"
    return plot_stacked_shares(table, present, label, notes)

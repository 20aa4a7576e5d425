"""The section on where evaluations and seconds go."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import own
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    BENCHMARK,
    Picture,
    Section,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, digits, seconds
from dubins_study.report.elements.plots import Mark, stacked_shares
from dubins_study.report.elements.style import BLUE, GREEN, RULE
from dubins_study.report.statistics.costs import KINDS, split
from dubins_study.report.statistics.methods import Compared, compared

# From dark to light with hatches, so that neighbours differ in grey print.
MARKS = (
    Mark("winning run", colour=BLUE),
    Mark("other runs", colour="#b9def3", hatch="///"),
    Mark("building", colour=GREEN, hatch="||"),
    Mark("rest", colour=RULE),
)
_MOST = 8  # bars in a panel that can be read
_HARDLY = 0.005  # share of the cost up to which other runs are not shown
_RATIO = digits(3)


def shares(compared: Compared, parts: pd.DataFrame) -> pd.DataFrame:
    """The share of each kind in the cost.

    `parts` is a frame of `split`. A share is the mean amount of the kind over the mean total. The
    result has a row for each method that counts the amount: its columns, each of `KINDS` as a
    share, and total (mean over answers).
    """
    means = parts.groupby("solver").mean().dropna()
    kinds = means[list(KINDS)].div(means["total"], axis=0)
    return compared.methods.join(kinds.assign(total=means["total"]), how="inner")


def cost_section(results: Results) -> Section | None:
    """The section on where evaluations and seconds go.

    A cost is compared with one run of the engine.
    """
    attempts = compared(results)
    if attempts is None:
        return None
    tables = {amount: shares(attempts, parts) for amount, parts in split(attempts).items()}
    blocks = tuple(_picture(table, amount) for amount, table in tables.items() if len(table))
    if not blocks:
        return None
    text = (
        "The cost has four parts: the run that gives the answer, other runs (restarts and other "
        "words), building, and the rest. Only right answers at questions with a path count. The "
        "floor is the winning run: the same engine called once, from the same guess."
    )
    lead = "See how small a part of the cost is the run that gives the answer (plain blue)."
    return Section("cost", "Cost where it arises", text, blocks, lead)


def _picture(table: pd.DataFrame, amount: str) -> Picture:
    """Bars of the shares of each kind of cost.

    `amount` is `evaluations` or `seconds`. The mean total stands beside each bar.
    """
    shown = _bars(table)
    show, label = {
        "evaluations": (_RATIO, "share of evaluations, right answers"),
        "seconds": (seconds, "share of the time, right answers"),
    }[amount]
    left_out = len(table) - len(shown)
    in_all = ""
    if left_out:
        in_all = f", and {count(left_out)} methods in all"
    caption = (
        f"Where the {amount} of an answer go; at the right their mean number. Winning run: the "
        f"run that gives the answer. Methods of a single run are left out{in_all}."
    )
    alt = f"Stacked bars of the shares of {amount}, one per method, by formulation"
    noted = shown.assign(note=shown["total"].map(show))
    return panels_picture(f"cost-{amount}", caption, stacked_shares, alt, noted, MARKS, label)


def _bars(table: pd.DataFrame) -> pd.DataFrame:
    """The methods whose bars are drawn.

    They are the cheapest methods with more than one run, at most `_MOST` per formulation, and all
    of plug-ins. If all have a single run, those are drawn.
    """
    order = table.sort_values("total")
    several = order[order["other runs"] > _HARDLY]
    if several.empty:
        several = order
    chosen = several.groupby("formulation", sort=False).head(_MOST)
    return table[table.index.isin([*own(table.index), *chosen.index])]


TOPIC = Topic("cost where it arises", cost_section, BENCHMARK)

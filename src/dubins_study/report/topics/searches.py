"""Searches compared at equal numbers of evaluations.

The section shows how many targets they reach within a number of evaluations.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Section, Topic, panels_picture
from dubins_study.report.elements.formats import count, sentences, some
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.plots import share_curves
from dubins_study.report.statistics.metrics import gaps, parse_spec
from dubins_study.report.topics.routes import with_legs
from dubins_study.study.arrays import FloatArray

TARGETS = 10.0 ** -np.arange(1, 9)  # gaps
_A_DECADE = 8  # points of a curve


def reached(row: dict[Hashable, Any]) -> FloatArray:
    """The evaluations until each of `TARGETS` is reached.

    A target is reached once the attempt's best path is within it; infinite if never. An attempt
    without a trace counts with all its evaluations and the gap at its end. Shape (targets,).
    """
    if np.ndim(row["trace_evaluations"]) and len(row["trace_evaluations"]):
        spent = np.asarray(row["trace_evaluations"], np.float64)
        low = float(row["reference_low"])
        radius = float(row["radius"])
        off = (np.asarray(row["trace_lengths"], np.float64) - low) / max(low, radius)
    else:
        spent = np.array([row["evaluations"]], np.float64)
        off = np.array([row["end_gap"]], np.float64)
    # Rows are improvements, columns targets; argmax finds the first row within a target.
    within = off[:, None] <= TARGETS
    return np.where(within.any(axis=0), spent[within.argmax(axis=0)], np.inf)


def runtimes(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Shares of targets reached, by number of legs.

    The keys are titles such as `2 legs`. A table is indexed by evaluations and has a column per
    solver, the best first. A value is the share of targets that are reached within this number of
    evaluations, over all attempts and targets. The curves are empirical runtime distributions
    (Hansen, Auger, Ros, Mersmann, Tusar and Brockhoff 2021, Optim. Methods Softw. 36).
    """
    rows = with_legs(rows).assign(end_gap=gaps(rows))
    most = max(10.0, float(rows["evaluations"].max()))
    budgets = np.geomspace(1.0, most, 1 + round(_A_DECADE * np.log10(most)))
    ends = budgets * (1 + 1e-12)
    panels = {}
    for legs, group in rows.groupby(rows["legs"].astype(int)):
        shares = {}
        for solver, attempts in group.groupby("solver", observed=True):
            spent = np.sort([reached(row) for row in attempts.to_dict("records")], axis=None)
            shares[str(solver)] = np.searchsorted(spent, ends, "right") / spent.size
        best = sorted(shares, key=lambda name: -shares[name][-1])
        table = pd.DataFrame(shares, pd.Index(budgets, name="evaluations"))
        panels[some(int(str(legs)), "leg")] = table[best]
    return panels


def _name(solver: str, engines: pd.Series[str]) -> str:
    """A solver's engine, restarts and options as text."""
    settings = parse_spec(solver)[1]
    restarts = ""
    if settings.get("restarts") == "True":
        restarts = "begun anew"
    return ", ".join(filter(None, (engines[solver], restarts, settings.get("options", ""))))


def searches_section(results: Results) -> Section | None:
    """The section with curves by number of legs."""
    rows = results.rows[results.rows["evaluations"].notna()]
    if rows.empty:
        return None
    palette = Palette.of_page(results)
    engines = results.methods.set_index("solver")["engine"]
    seeds = int(rows["repeat"].nunique())
    questions = rows["scenario_id"].nunique()
    caption = (
        f"Share of {count(len(TARGETS))} targets (gaps of 1e-1 to 1e-8) over {count(questions)} "
        f"questions and {count(seeds)} seeds that are reached within a number of evaluations. "
        "Higher is better. A flat line has ended, or improves no more."
    )
    picture = panels_picture(
        "searches",
        caption,
        share_curves,
        "Rising curves of the share of targets reached against evaluations",
        runtimes(rows),
        {str(solver): _name(str(solver), engines) for solver in rows["solver"].unique()},
        palette,
        "evaluations",
        "share of targets",
    )
    text = sentences(
        "On several legs an engine varies the headings at the points: every path arrives, and the "
        "best path so far counts.",
        "On one leg it minimises the length and a penalty of the miss, and only its end counts.",
    )
    lead = "Read up from a budget of evaluations: which engine reaches most by then?"
    return Section("searches", "Searches at equal evaluations", text, (picture,), lead)


TOPIC = Topic("searches at equal evaluations", searches_section, "searches")

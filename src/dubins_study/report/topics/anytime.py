"""Anytime curves: the best path so far, by the check, against evaluations."""

from __future__ import annotations

import math
from collections.abc import Hashable
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Picture, Section, Topic
from dubins_study.report.elements.formats import count
from dubins_study.report.elements.looks import Palette, common_part, labels_of
from dubins_study.report.elements.plots import parameter_lines
from dubins_study.report.elements.style import WIDE
from dubins_study.report.topics.routes import with_legs
from dubins_study.study.arrays import FloatArray

FLOOR = 1e-9  # a smaller gap is drawn there: it is the reference's own width, or rounding
_A_DECADE = 8  # points of a curve


def anytime(rows: pd.DataFrame) -> pd.DataFrame:
    """Median gap of the best path so far, by solver, number of legs and evaluations.

    Columns legs, solver, evaluations and gap, (length - reference) / max(reference, radius);
    infinite where most attempts have no path yet. An attempt that has ended stays where it is.
    """
    traced = rows["trace_evaluations"].dropna()
    most = max([10.0, *(counts[-1] for counts in traced if len(counts))])
    budgets = np.geomspace(1.0, most, 1 + math.ceil(_A_DECADE * math.log10(most)))
    curves = []
    for (legs, solver), group in with_legs(rows).groupby(["legs", "solver"], observed=True):
        gaps = [_gaps(row, budgets) for row in group.to_dict("records")]
        median = np.median(np.array(gaps), axis=0)
        curve = {"legs": legs, "solver": solver, "evaluations": budgets, "gap": median}
        curves.append(pd.DataFrame(curve))
    return pd.concat(curves, ignore_index=True)


def _gaps(row: dict[Hashable, Any], budgets: FloatArray) -> FloatArray:
    """The gap of an attempt's best path after each number of evaluations."""
    if not np.ndim(row["trace_evaluations"]) or not len(row["trace_evaluations"]):
        return np.full(budgets.size, math.inf)
    evaluations = np.asarray(row["trace_evaluations"], np.float64)
    low, radius = float(row["reference_low"]), float(row["radius"])
    gaps = (np.asarray(row["trace_lengths"], np.float64) - low) / max(low, radius)
    place = np.searchsorted(evaluations, budgets * (1 + 1e-12), side="right") - 1
    best: FloatArray = np.where(place < 0, math.inf, np.maximum(gaps[place], FLOOR))
    return best


def anytime_section(results: Results) -> Section | None:
    """The curves, a panel for each number of legs."""
    rows = results.rows
    if rows.empty or rows["trace_evaluations"].isna().all():
        return None
    palette, labels = Palette.of_page(results), labels_of(results)
    table = anytime(rows)
    solvers = list(dict.fromkeys(table["solver"]))
    shared, names = common_part([labels[solver] for solver in solvers])
    panels = {legs: f"{legs} legs{shared}" for legs in sorted(set(table["legs"]))}
    table = table.assign(
        name=table["solver"].map(dict(zip(solvers, names, strict=True))),
        panel=pd.Categorical(table["legs"].map(panels), list(panels.values())),
    )
    questions = rows["scenario_id"].nunique()
    figure = parameter_lines(
        *(table, "evaluations", "gap", palette, "evaluations of the length", "median gap"),
        width=WIDE,
        height=4.2,
    )
    caption = (
        f"Median gap of the best path so far, as the check finds it, over {count(questions)} "
        "routes. Lower is better; a flat line has come to rest, most often in another basin."
    )
    alt = "Falling curves of the median gap against evaluations, one for each engine"
    text = (
        "Each engine varies the headings at the points, so that all it evaluates is a path that "
        "arrives. Only improvements count; an attempt that has ended keeps its last path."
    )
    lead = "Read down a budget of evaluations: which engine has the shortest path by then?"
    blocks = (Picture("anytime", caption, figure, alt),)
    return Section("anytime", "The best path so far", text, blocks, lead)


TOPIC = Topic("the best path so far", anytime_section, "anytime")

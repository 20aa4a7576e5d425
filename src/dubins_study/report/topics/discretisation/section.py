"""The section on the number of steps of `turn-rate-qp` and its engine."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, seconds, share
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.names import figure_names, labels_of
from dubins_study.report.elements.topic import Topic
from dubins_study.report.topics.convergence.numbers import label_without
from dubins_study.report.topics.discretisation.figures import plot_gap_order, plot_work_precision
from dubins_study.report.topics.discretisation.numbers import work_precision


def discretisation_section(results: Results) -> Section | None:
    """Time against gap by n and engine, gap against n with the fitted order."""
    table = work_precision(results.rows, results.settings)
    if table.empty:
        return None
    drawable = table[np.isfinite(table["gap"]) & (table["gap"] > 0)]  # the axes are logarithmic
    labels = labels_of(results)
    names = figure_names({spec: label_without(labels[spec], "n") for spec in drawable["solver"]})
    named = drawable.assign(label=[_engine(names[spec]) for spec in drawable["solver"]])
    pictures = _precision_pictures(named, Palette.of_page(results)) if len(named) else ()
    blocks = (*pictures, _precision_table(table))
    text = (
        "turn-rate-qp holds each of n turn rates over a step, so its best path is longer than the "
        "best of all. How fast that cost falls with n, what it takes, and which engine to use."
    )
    lead = (
        "Follow a curve down to the gap that you want and read off the steps and the time; the "
        "engine whose curve is farthest left is the one to use."
    )
    return Section("discretisation", "Work and precision", text, blocks, lead)


def _engine(name: str) -> str:
    """A solver's name without the formulation, which is the same for all."""
    return ", ".join(item for item in name.split(", ") if item != "turn rates")


_BAND = "a line of medians, with the quartiles over the targets as a band"


def _precision_pictures(table: pd.DataFrame, palette: Palette) -> tuple[Picture, Picture]:
    return (
        picture(
            "work-precision",
            plot_work_precision,
            *(table, palette),
            caption=f"Gap against median time: {_BAND}; the numbers are n. Lower left is better.",
            alt="Time against gap for each engine",
            height=3.7,
            legend=2,
        ),
        picture(
            "gap-order",
            plot_gap_order,
            *(table, palette),
            caption=f"Gap against the number of steps: {_BAND}, and the order p fitted to the "
            "medians as far as they fall: beyond their least value the engine's own accuracy "
            "decides.",
            alt="Gap against number of steps for each engine",
            height=3.7,
            legend=2,
        ),
    )


def _precision_table(frame: pd.DataFrame) -> Table:
    shown = (
        *columns(kind="code", engine="engine"),
        *columns(count, n="n", attempts="attempts"),
        *columns(share, arrived="arrive", success="success"),
        *columns(digits(3), gap="median gap", gap_q90="90 %"),
        *columns(seconds, wall_s="median time"),
        *columns(digits(3), iterations="QPs"),
    )
    caption = (
        "Every engine at every n. Gap quantiles count an attempt that does not arrive as ∞. QPs: "
        "median number of QPs solved in one attempt."
    )
    return Table("discretisation", caption, frame, shown)


TOPIC = Topic("work and precision", discretisation_section, "discretisation")

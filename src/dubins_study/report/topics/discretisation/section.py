"""The section on the number of steps of `turn-rate-qp` and its engine."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, digits, seconds, share
from dubins_study.report.topics.discretisation.figures import plot_gap_order, plot_work_precision
from dubins_study.report.topics.discretisation.numbers import work_precision


def discretisation_section(results: Results) -> Section | None:
    """Time against gap by n and engine, gap against n with the fitted order."""
    table = work_precision(results.rows, results.settings)
    if table.empty:
        return None
    drawable = table[np.isfinite(table["gap"]) & (table["gap"] > 0)]  # the axes are logarithmic
    pictures = _precision_pictures(drawable) if len(drawable) else ()
    blocks = (*pictures, _precision_table(table))
    text = (
        "turn-rate-qp holds each of n turn rates over a step, so its best path is longer than the "
        "best of all. How fast that cost falls with n, what it takes, and which engine to use."
    )
    return Section("discretisation", "Work and precision", text, blocks)


def _precision_pictures(table: pd.DataFrame) -> tuple[Picture, Picture]:
    return (
        picture(
            "work-precision",
            plot_work_precision,
            table,
            caption="Median time against median gap; the numbers are n. Lower left is better.",
            alt="Time against gap for each engine",
            height=3.7,
            legend=2,
        ),
        picture(
            "gap-order",
            plot_gap_order,
            table,
            caption="Median gap against the number of steps, and the order p fitted to it as far "
            "as it falls: beyond its least value the engine's own accuracy decides.",
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

"""The section on the number of steps of `turn-rate-qp` and its engine."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    Column,
    Picture,
    Section,
    Table,
    count,
    digits,
    seconds,
    share,
)
from dubins_study.report.elements.style import HALF, new_figure
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
    left, right = new_figure(HALF, 3.7), new_figure(HALF, 3.7)
    plot_work_precision(left.add_subplot(), table)
    plot_gap_order(right.add_subplot(), table)
    for figure in (left, right):
        figure.legend(loc="outside lower left", ncols=2, fontsize=7.5)
    return (
        Picture(
            "work-precision",
            "Median time against median gap; the numbers are n. Lower left is better.",
            left,
            "Time against gap for each engine",
            True,
        ),
        Picture(
            "gap-order",
            "Median gap against the number of steps, and the order p fitted to it as far as it "
            "falls: beyond its least value the engine's own accuracy decides.",
            right,
            "Gap against number of steps for each engine",
            True,
        ),
    )


def _precision_table(frame: pd.DataFrame) -> Table:
    columns = (
        Column("engine", "engine", kind="code"),
        Column("n", "n", count),
        Column("attempts", "attempts", count),
        Column("arrived", "arrive", share),
        Column("success", "success", share),
        Column("gap", "median gap", digits(3)),
        Column("gap_q90", "90 %", digits(3)),
        Column("wall_s", "median time", seconds),
        Column("iterations", "QPs", digits(3)),
    )
    caption = (
        "Every engine at every n. Gap quantiles count an attempt that does not arrive as ∞. QPs: "
        "median number of QPs solved in one attempt."
    )
    return Table("discretisation", caption, frame, columns)

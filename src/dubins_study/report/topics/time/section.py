"""The sections on time and on the discretisation."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.page.content import (
    Column,
    Picture,
    Section,
    Table,
    count,
    digits,
    seconds,
    share,
)
from dubins_study.report.page.style import HALF, WIDE, legend_lines, new_figure
from dubins_study.report.statistics.metrics import STUDIES, by_solver
from dubins_study.report.statistics.timing import mean_times, time_ratios
from dubins_study.report.topics.time.figures import (
    plot_gap_order,
    plot_performance,
    plot_times,
    plot_work_precision,
)
from dubins_study.report.topics.time.numbers import work_precision

EXACT = "analytic"
_ELSEWHERE = (*STUDIES, "plane")


def time_section(results: Results) -> Section | None:
    """Medians and quartiles; build and solve apart; shifted geometric means."""
    rows = results.rows[~results.rows["experiment"].isin(_ELSEWHERE)]
    cold = rows[rows["initial_guess"] == "cold"]
    found = results.attempts.without(_ELSEWHERE)
    frame = by_solver(found.times())
    if frame.empty:
        return None
    figure = new_figure(WIDE, 0.7 + 0.46 * len(frame))
    plot_times(figure.add_subplot(), frame)
    caption = (
        "Time of one cold attempt: median (mark) and quartiles (bar) of solving (filled, above) "
        "and of building the model (open, below)."
    )
    picture = Picture("times", caption, figure, "Median times and quartiles, one line a solver")
    blocks: list[Picture | Table] = [picture, _time_table(frame, found.precision)]
    plain = _not_variants(cold)
    ratios = time_ratios(plain[plain["solver"] != EXACT])
    if ratios.shape[0] > 1 and ratios.shape[1] > 1:
        blocks.append(_performance_picture(ratios))
    means, shift = mean_times(plain)
    if len(means) > 1:
        blocks.append(_mean_table(means, shift))
    jobs, threads = (", ".join(map(str, found.values(kind))) for kind in ("jobs", "threads"))
    text = (
        "Measured in the process that solves, after a warm-up that is not recorded; "
        f"threads: {threads}; jobs side by side: {jobs}. Judging is not timed. Compiled "
        "templates are kept between questions, so building is setting the data."
    )
    return Section("time", "Time", text, tuple(blocks))


def _not_variants(rows: pd.DataFrame) -> pd.DataFrame:
    """Without variants, if there are plain solvers: each variant would shrink the common set."""
    plain = ~rows["solver"].str.contains("[", regex=False)
    return rows[plain] if plain.any() else rows


def _performance_picture(ratios: pd.DataFrame) -> Picture:
    figure = new_figure(WIDE, 2.9 + 0.17 * legend_lines(ratios.columns, columns=3))
    plot_performance(figure.add_subplot(), ratios)
    figure.legend(loc="outside lower left", ncols=3, fontsize=7.5)
    caption = (
        "Performance profile: the share of questions that a solver answers rightly within a "
        f"factor of the fastest right answer, over the {count(len(ratios))} questions put to all "
        "of them. At 1: how often it is the fastest; at the right: how often it is right at all. "
        "The closed form is left out, since it would flatten every curve."
    )
    return Picture("performance", caption, figure, "Performance profile of the solvers")


def _time_table(frame: pd.DataFrame, precision: str) -> Table:
    parts = (("build_s", "build"), ("solve_s", "solve"), ("wall_s", "whole"))
    columns = [Column("solver", "solver", kind="code"), Column("timed", "timed", count)]
    for key, title in parts:
        columns += [
            Column(f"{key}_q1", f"{title} 25 %", seconds),
            Column(key, f"{title} median", seconds),
            Column(f"{key}_q3", "75 %", seconds),
        ]
    caption = f"Times of cold attempts, failures included: quartiles and medians.{precision}"
    return Table("times", caption, frame, tuple(columns))


def _mean_table(frame: pd.DataFrame, shift: float) -> Table:
    columns = (
        Column("solver", "solver", kind="code"),
        Column("questions", "questions", count),
        Column("mean_s", "shifted geometric mean", seconds),
        Column("rank", "rank", count),
        Column("rank_tenth", "rank, shift / 10", count),
        Column("rank_tenfold", "rank, shift × 10", count),
    )
    caption = (
        f"Shifted geometric mean over the questions that all of these answer rightly; shift "
        f"{seconds(shift)}, the lower quartile of the times that enter. A rank that changes with "
        "the shift is no finding."
    )
    return Table("mean-times", caption, frame, columns)


def discretisation_section(results: Results) -> Section | None:
    """Time against gap by n and engine, gap against n with the fitted order."""
    rows = results.rows[results.rows["experiment"] == "discretisation"]
    table = work_precision(rows, results.settings)
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

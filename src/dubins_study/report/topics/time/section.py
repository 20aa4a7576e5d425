"""The section on time."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import (
    Column,
    Picture,
    Section,
    Table,
    count,
    seconds,
)
from dubins_study.report.elements.looks import Palette, legend_lines, name_of
from dubins_study.report.elements.style import WIDE, new_figure
from dubins_study.report.statistics.metrics import by_solver
from dubins_study.report.topics.time.figures import plot_performance, plot_times
from dubins_study.report.topics.time.numbers import mean_times, time_ratios


def time_section(results: Results) -> Section | None:
    """Medians and quartiles; build and solve apart; shifted geometric means."""
    cold = results.rows[results.rows["initial_guess"] == "cold"]
    frame = by_solver(results.attempts.times())
    if frame.empty:
        return None
    lines = max(name_of(solver).count("\n") + 1 for solver in frame["solver"])
    figure = new_figure(WIDE, 0.7 + max(0.46, 0.13 * lines) * len(frame))
    palette = Palette.of(results.solvers)
    plot_times(figure.add_subplot(), frame, palette)
    caption = (
        "Time of one cold attempt: median (mark) and quartiles (bar) of solving (filled, above) "
        "and of building the model (open, below)."
    )
    picture = Picture("times", caption, figure, "Median times and quartiles, one line a solver")
    blocks: list[Picture | Table] = [picture, _time_table(frame, results.attempts.precision)]
    plain = _not_variants(cold)
    ratios = time_ratios(plain[plain["solver"] != EXACT])
    if ratios.shape[0] > 1 and ratios.shape[1] > 1:
        blocks.append(_performance_picture(ratios, palette))
    means, shift = mean_times(plain)
    if len(means) > 1:
        blocks.append(_mean_table(means, shift))
    jobs, threads = (
        ", ".join(map(str, results.attempts.values(kind))) for kind in ("jobs", "threads")
    )
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


def _performance_picture(ratios: pd.DataFrame, palette: Palette) -> Picture:
    figure = new_figure(WIDE, 2.9 + 0.17 * legend_lines(ratios.columns, columns=3))
    plot_performance(figure.add_subplot(), ratios, palette)
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

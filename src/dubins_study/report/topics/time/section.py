"""The section on time."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import Picture, Section, Table, picture
from dubins_study.report.elements.formats import count, seconds, sentences, some
from dubins_study.report.elements.identity import best_first
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.names import in_page_order
from dubins_study.report.elements.panels import DRAWN_TEXT, HIGHEST
from dubins_study.report.elements.style import WIDE
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.statistics.methods import (
    MOST_ENGINES,
    MOST_METHODS,
    best_of_formulations,
    drawn_methods,
)
from dubins_study.report.topics.summary.section import best_solvers, solver_summary
from dubins_study.report.topics.time.figures import plot_performance, plot_time_grid, plot_times
from dubins_study.report.topics.time.numbers import mean_times, time_ratios


def time_section(results: Results) -> Section | None:
    """Medians and quartiles; build and solve apart; shifted geometric means."""
    rows = results.rows
    cold = rows[(rows["initial_guess"] == "cold") & rows["answerable"]]
    frame = in_page_order(results.attempts.times(), results)
    if frame.empty:
        return None
    palette = Palette.of_page(results)
    several = len(frame) > MOST_METHODS
    methods = solver_summary(results.attempts).drop(columns="wall_s")
    timed = methods.merge(frame, on="solver")
    medians = _grid_picture(drawn_methods(timed), palette) if several else _picture(frame, palette)
    table = _time_table(frame, results.attempts.precision)
    blocks: list[Picture | Table] = [medians]
    blocks += [*best_first(table, frame["solver"], best_solvers(results))]
    if several:
        chosen = cold[cold["solver"].isin([EXACT, *best_of_formulations(timed)])]
    else:
        chosen = _not_variants(cold)
    which = " Of each formulation the method that is most surely right." if several else ""
    ratios = time_ratios(chosen[chosen["solver"] != EXACT])
    if ratios.shape[0] > 1 and ratios.shape[1] > 1:
        blocks.append(_performance_picture(ratios, palette, which))
    means, shift = mean_times(chosen)
    if len(means) > 1:
        blocks.append(_mean_table(means, shift, which))
    jobs, threads = (
        ", ".join(map(str, results.attempts.values(kind))) for kind in ("jobs", "threads")
    )
    text = (
        "Questions that have a path. Measured in the process that solves, after a warm-up that is "
        "not recorded; "
        f"threads: {threads}; jobs side by side: {jobs}. Judging is not timed. Compiled "
        "templates are kept between questions, so building is setting the data."
    )
    lead = "See who is fast, and at the right of the performance profile who is right."
    return Section("time", "Time", text, tuple(blocks), lead)


def _picture(frame: pd.DataFrame, palette: Palette) -> Picture:
    return picture(
        "times",
        plot_times,
        *(frame, palette),
        caption="Time of one cold attempt: median (mark) and quartiles (bar) of solving (filled, "
        "above) and of building the model (open, below).",
        alt="Median times and quartiles, one line per solver",
        height=min(HIGHEST, 0.7 + 0.4 * len(frame)),
        width=WIDE,
    )


def _grid_picture(methods: pd.DataFrame, palette: Palette) -> Picture:
    caption = (
        "Time of one cold attempt, building and solving: median (mark) and quartiles (bar). "
        f"{DRAWN_TEXT}"
    )
    alt = "Median times and quartiles, one line per method, in panels by formulation"
    return Picture("times", caption, plot_time_grid(methods, palette), alt)


def _not_variants(rows: pd.DataFrame) -> pd.DataFrame:
    """Rows of plain solvers, if there are any: each variant would reduce the common questions."""
    plain = ~rows["solver"].str.contains("[", regex=False)
    return rows[plain] if plain.any() else rows


def _performance_picture(ratios: pd.DataFrame, palette: Palette, which: str) -> Picture:
    grey = ratios.shape[1] - MOST_ENGINES
    caption = sentences(
        "Performance profile: the share of questions that a solver answers correctly within a "
        f"factor of the fastest right answer, over the {count(len(ratios))} questions put to all "
        "of them. At 1: how often it is the fastest; at the right: how often it is right at all. "
        "The closed form is left out, since it would flatten every curve.",
        which.strip(),
        f"Grey, without names: {some(grey, 'solver')}, right least often." if grey > 0 else "",
    )
    figure = plot_performance(ratios, palette)
    return Picture("performance", caption, figure, "Performance profile of the solvers")


def _time_table(frame: pd.DataFrame, precision: str) -> Table:
    shown = (
        SOLVER,
        *columns(count, timed="timed"),
        *columns(seconds, build_s_q1="build 25 %", build_s="build median", build_s_q3="75 %"),
        *columns(seconds, solve_s_q1="solve 25 %", solve_s="solve median", solve_s_q3="75 %"),
        *columns(seconds, wall_s_q1="whole 25 %", wall_s="whole median", wall_s_q3="75 %"),
    )
    caption = (
        "Times of cold attempts at questions that have a path, failures included: quartiles and "
        f"medians.{precision}"
    )
    return Table("times", caption, frame, shown)


def _mean_table(frame: pd.DataFrame, shift: float, which: str) -> Table:
    shown = (
        SOLVER,
        *columns(count, questions="questions"),
        *columns(seconds, mean_s="shifted geometric mean", mean_low_s="95 %: from"),
        *columns(seconds, mean_high_s="to"),
        *columns(
            count, rank="rank", rank_tenth="rank, shift / 10", rank_tenfold="rank, shift × 10"
        ),
    )
    caption = (
        f"Shifted geometric mean over the questions that all of these answer correctly; shift "
        f"{seconds(shift)}, the lower quartile of the times used. A rank that changes with "
        f"the shift is no finding. Intervals: bootstrap over scenarios.{which}"
    )
    return Table("mean-times", caption, frame, shown)


TOPIC = Topic("time", time_section, General.COMPARED)

"""Time: medians and quartiles, the performance profile, and shifted geometric means."""

from __future__ import annotations

import numpy as np
import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import General, Picture, Section, Table, Topic
from dubins_study.report.elements.formats import count, seconds, sentences, some
from dubins_study.report.elements.identity import best_first
from dubins_study.report.elements.looks import Palette, in_page_order
from dubins_study.report.elements.plots import DRAWN_TEXT, Mark, quartile_lines, share_curves
from dubins_study.report.statistics.costs import (
    SHIFT_FACTORS,
    chosen_shift,
    cost_table,
    performance_profile,
    performance_ratios,
    ranks_of,
    shifted_geometric_means,
    solved_by_all,
)
from dubins_study.report.statistics.intervals import bootstrap, geometric_means
from dubins_study.report.statistics.methods import (
    MOST_ENGINES,
    MOST_METHODS,
    best_of_formulations,
    drawn_methods,
    foremost,
)
from dubins_study.report.statistics.metrics import QUESTION, solver_order, success
from dubins_study.report.topics.summary import best_solvers, solver_summary

TIMES = (
    SOLVER,
    *columns(count, timed="timed"),
    *columns(seconds, build_s_q1="build 25 %", build_s="build median", build_s_q3="75 %"),
    *columns(seconds, solve_s_q1="solve 25 %", solve_s="solve median", solve_s_q3="75 %"),
    *columns(seconds, wall_s_q1="whole 25 %", wall_s="whole median", wall_s_q3="75 %"),
)
MEANS = (
    SOLVER,
    *columns(count, questions="questions"),
    *columns(seconds, mean_s="shifted geometric mean", mean_low_s="95 %: from", mean_high_s="to"),
    *columns(count, rank="rank", rank_tenth="rank, shift / 10", rank_tenfold="rank, shift × 10"),
)
PARTS = (Mark("solve_s", "solving"), Mark("build_s", "building the model", filled=False))
WHOLE = (Mark("wall_s"),)


def mean_times(rows: pd.DataFrame) -> tuple[pd.DataFrame, float]:
    """Shifted geometric means over the questions that every solver answered correctly.

    Returns:
        The columns `MEANS`: means (s) with their 95 % bootstrap intervals over scenarios, and ranks
        at the shift, at a tenth and at ten times of it; and the shift, the `chosen_shift` of all
        times used (s).
    """
    table = solved_by_all(right_times(rows))
    if table.empty:
        return pd.DataFrame(), 0.0
    shift = chosen_shift(table)
    means = shifted_geometric_means(table, shift)
    frame = pd.DataFrame({"questions": len(table), "mean_s": means})
    by_scenario = table.set_axis(table.index.get_level_values("scenario_id"))
    ends = bootstrap(by_scenario, geometric_means(shift))
    frame["mean_low_s"], frame["mean_high_s"] = ends["low"], ends["high"]
    for name, factor in zip(("rank_tenth", "rank", "rank_tenfold"), SHIFT_FACTORS, strict=True):
        frame[name] = ranks_of(shifted_geometric_means(table, shift * factor))
    return frame.reset_index(), shift


def right_times(rows: pd.DataFrame) -> pd.DataFrame:
    """Cost table of median total times (s): questions by solvers in the order of the report."""
    right = rows.assign(right=success(rows))
    table = cost_table(right, "wall_s", QUESTION)
    return table[solver_order(list(table.columns))]


def time_section(results: Results) -> Section | None:
    """Medians and quartiles; build and solve apart; shifted geometric means."""
    rows = results.rows
    cold = rows[(rows["initial_guess"] == "cold") & rows["answerable"]]
    frame = in_page_order(results.attempts.times(), results)
    if frame.empty:
        return None
    palette = Palette.of_page(results)
    several = len(frame) > MOST_METHODS
    timed = solver_summary(results.attempts).drop(columns="wall_s").merge(frame, on="solver")
    caption = (
        "Times of cold attempts at questions that have a path, failures included: quartiles and "
        "medians."
    )
    table = Table("times", caption, frame, TIMES)
    blocks: list[Picture | Table] = [
        _quartiles(drawn_methods(timed) if several else frame, palette, several),
        *best_first(table, frame["solver"], best_solvers(results)),
    ]
    if several:
        chosen = cold[cold["solver"].isin([EXACT, *best_of_formulations(timed)])]
    else:
        # Each variant would reduce the questions that all have in common.
        plain = ~cold["solver"].str.contains("[", regex=False)
        chosen = cold[plain] if plain.any() else cold
    which = " Of each formulation the method that is most surely right." if several else ""
    times = right_times(chosen[chosen["solver"] != EXACT])
    if times.shape[1] > 1 and len(performance_ratios(times)) > 1:
        blocks.append(_profile(times, palette, which))
    means, shift = mean_times(chosen)
    if len(means) > 1:
        blocks.append(_means(means, shift, which))
    jobs, threads = (
        ", ".join(map(str, results.attempts.values(kind))) for kind in ("jobs", "threads")
    )
    text = (
        "Questions that have a path. Measured in the process that solves, after a warm-up that is "
        f"not recorded; threads: {threads}; jobs side by side: {jobs}. Judging is not timed. "
        "Compiled templates are kept between questions, so building is setting the data."
    )
    lead = "See who is fast, and at the right of the performance profile who is right."
    return Section("time", "Time", text, tuple(blocks), lead)


def _quartiles(table: pd.DataFrame, palette: Palette, several: bool) -> Picture:
    """Building and solving apart; of several methods their sum, in a panel per formulation."""
    label = "time of one attempt"
    if several:
        caption = (
            "Time of one cold attempt, building and solving: median (mark) and quartiles (bar). "
            f"{DRAWN_TEXT}"
        )
        figure = quartile_lines(table, WHOLE, palette, label, panels=True)
    else:
        caption = "Time of one cold attempt: median (mark) and quartiles (bar)."
        named = table.assign(name=table["solver"].map(palette.label))
        figure = quartile_lines(named, PARTS, palette, label)
    return Picture("times", caption, figure, "Median times and quartiles, one line per method")


def _profile(times: pd.DataFrame, palette: Palette, which: str) -> Picture:
    """The performance profile of a table of `right_times`."""
    ratios = performance_ratios(times)
    known = np.isfinite(ratios.to_numpy(dtype=np.float64))
    named = foremost(pd.Series(known.mean(axis=0), ratios.columns))
    largest = float(np.max(ratios.to_numpy()[known], initial=2.0))
    grey = ratios.shape[1] - MOST_ENGINES
    caption = sentences(
        "Performance profile: the share of questions that a solver answers correctly within a "
        f"factor of the fastest right answer, over the {count(len(ratios))} questions put to all "
        "of them but the closed form. At 1: how often it is the fastest; at the right: how often "
        "it is right at all.",
        which.strip(),
        f"Grey, without names: {some(grey, 'solver')}, right least often." if grey > 0 else "",
    )
    figure = share_curves(
        {"": performance_profile(times, np.geomspace(1.0, largest, 200))},
        {solver: palette.label(solver) for solver in named},
        palette,
        "time / time of the fastest right answer",
    )
    return Picture("performance", caption, figure, "Performance profile of the solvers")


def _means(frame: pd.DataFrame, shift: float, which: str) -> Table:
    caption = (
        "Shifted geometric mean over the questions that all of these answer correctly; shift "
        f"{seconds(shift)}, the lower quartile of the times used. A rank that changes with "
        f"the shift is no finding. Intervals: bootstrap over scenarios.{which}"
    )
    return Table("mean-times", caption, frame, MEANS)


TOPIC = Topic("time", time_section, General.COMPARED)

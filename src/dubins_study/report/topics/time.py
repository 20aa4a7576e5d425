"""The section on times: quartiles, by solver.

A time is that of a whole attempt; building and solving are also shown apart.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import (
    General,
    Picture,
    Section,
    Table,
    Topic,
    panels_picture,
)
from dubins_study.report.elements.formats import count, seconds
from dubins_study.report.elements.looks import Palette, in_page_order
from dubins_study.report.elements.plots import DRAWN_TEXT, quartile_lines
from dubins_study.report.statistics.methods import drawn_methods
from dubins_study.report.topics.summary import solver_summary

TIMES = (
    SOLVER,
    *columns(count, timed="timed"),
    *columns(seconds, build_s_q1="build 25 %", build_s="build median", build_s_q3="75 %"),
    *columns(seconds, solve_s_q1="solve 25 %", solve_s="solve median", solve_s_q3="75 %"),
    *columns(seconds, wall_s_q1="whole 25 %", wall_s="whole median", wall_s_q3="75 %"),
)
_QUARTILES = ((0.25, "_q1"), (0.5, ""), (0.75, "_q3"))


def solver_times(attempts: pd.DataFrame) -> pd.DataFrame:
    """Median and quartiles of times, one row per solver.

    Only cold attempts at questions that have a path count; solvers without such attempts are left
    out. Columns: solver, timed (number of attempts), and the median (s) of build_s, solve_s and
    wall_s, with the lower quartile (`_q1`) and the upper quartile (`_q3`).
    """
    cold = attempts[attempts["answerable"] & attempts["initial_guess"].eq("cold")]
    groups = cold.groupby("solver")
    times = groups[["build_s", "solve_s", "wall_s"]]
    quartiles = [times.quantile(q).add_suffix(end) for q, end in _QUARTILES]
    frame = pd.concat([groups["wall_s"].count().rename("timed"), *quartiles], axis="columns")
    return frame[frame["timed"] > 0].reset_index()


def time_section(results: Results) -> Section | None:
    """The section with medians and quartiles of times."""
    frame = in_page_order(solver_times(results.attempts), results)
    if frame.empty:
        return None
    # `wall_s` is that of cold attempts, not of all as in the summary
    timed = solver_summary(results.attempts).drop(columns="wall_s").merge(frame, on="solver")
    caption = (
        "Quartiles and medians of the times of cold attempts at questions that have a path, "
        "failures included."
    )
    table = Table("times", caption, frame, TIMES)
    blocks: tuple[Picture | Table, ...] = (
        _quartiles(drawn_methods(timed), Palette.of_page(results)),
        table,
    )
    threads = _distinct(results.rows["threads"])
    jobs = _distinct(results.rows["jobs"])
    text = (
        "Questions that have a path. Times are measured in the process that solves, after a "
        f"warm-up; threads: {threads}; jobs side by side: {jobs}. The check is not timed. "
        "Compiled templates are reused between questions, so building only sets the data."
    )
    lead = "See how long an attempt takes, right or wrong, and how much that varies."
    return Section("time", "Time", text, blocks, lead)


def _quartiles(table: pd.DataFrame, palette: Palette) -> Picture:
    """The picture of whole attempts' times, by formulation."""
    caption = f"Time of one cold attempt: median (mark) and quartiles (bar). {DRAWN_TEXT}"
    alt = "Median times and quartiles, one line per method"
    label = "time of one attempt"
    return panels_picture("times", caption, quartile_lines, alt, table, "wall_s", palette, label)


def _distinct(numbers: pd.Series) -> str:
    """Distinct whole numbers in order, as text."""
    return ", ".join(map(str, sorted(numbers.dropna().astype(int).unique())))


TOPIC = Topic("time", time_section, General.COMPARED)

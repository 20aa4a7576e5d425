"""The paper's tables next to ours, and its figures drawn again."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, Column, columns, marks
from dubins_study.report.elements.content import Picture, Place, Section, Table
from dubins_study.report.elements.formats import count, digits, seconds
from dubins_study.report.elements.looks import Palette
from dubins_study.report.elements.topic import General, Topic
from dubins_study.report.paper.printed import QUANTITIES, compare
from dubins_study.report.statistics.methods import best_solvers
from dubins_study.report.topics.paper.numbers import (
    printed_times,
    problem_paths,
    scores,
    side_by_side,
    time_ends,
    word_paths,
)
from dubins_study.report.topics.paper.pictures import (
    feasible_picture,
    problem_picture,
    times_picture,
)

_TITLES = {
    "6.1": "Test problem 1: start (0, 0, 2π/3), target (10, 5), R = 1.",
    "6.2": "Test problem 2: start (0, 0, 2π/3), target (−6, 3), R = 1.",
    "6.3": "Test problem 3: start (0, 0, π/3), target (−1, 5), R = 1.",
    "6.4": "Test problem 4: start (0, 0, π/3), target (−2, −5), R = 1.",
    "6.5": "Test problem 5: start (0, 0, 2π/3), target (−80, 20), three radii.",
}


def paper_section(results: Results) -> Section | None:
    """Tables 6.1-6.5 cell by cell, Figures 6.1-6.5, and every solver's score."""
    paths = word_paths(results, EXACT)
    if not paths:
        return None
    cells = compare(paths)
    blocks: list[Table | Picture] = [_side_by_side(cells, number) for number in _TITLES]
    blocks.append(_scores(scores(results)))
    times = printed_times(results)
    if len(times):
        words = results.rows[results.rows["branch"].isin(["LS", "RS"])]
        blocks += [times_picture(times, best_solvers(words), Palette.of_page(results))]
        blocks += [_times(time_ends(times))]
    right = int((cells["verdict"] == "correct").sum())
    text = (
        f"{right} of the {len(cells)} printed lengths are correct roundings of the exact ones. The "
        "paper's optimal path is the shorter of LS and RS, its feasible path the longer. The audit "
        "below says what became of the others. The paper's solve times are 1, 2 and 3 ticks of a "
        "clock that moves 64 times a second (15.6, 31.2 and 46.9 ms), printed with three decimals: "
        "each tells that a solve ended within a tick of it, and nothing of which path or solver is "
        "the faster."
    )
    lead = (
        "Read a table's lines in pairs, the printed numbers above the exact ones: what is crossed "
        "is printed wrong."
    )
    return Section("paper", "The paper's tables", text, tuple(blocks), lead)


def _side_by_side(cells: pd.DataFrame, number: str) -> Table:
    frame = side_by_side(cells[cells["table"] == number])
    rows = frame.to_dict("records")
    wrong = frame[list(QUANTITIES)].map(lambda text: "✗" in str(text))
    frame["row"] = [_row_name(row) if row["source"] == "paper" else "" for row in rows]
    shown = (
        *columns(kind="text", row="row", source="from"),
        *columns(z1="left turn ζ₁", z2="right turn ζ₂", z3="straight ζ₃", f="total f"),
    )
    caption = f"Table {number}. {_TITLES[number]} Lengths; ✗ marks what is not a correct rounding."
    return Table(
        f"paper-{number.replace('.', '-')}", caption, frame, shown, marks(wrong, *QUANTITIES)
    )


def _row_name(row: Mapping[Hashable, Any]) -> str:
    """Row label: the radius in problem 5, the path name in the other problems."""
    _, radius, value = str(row["label"]).removeprefix("problem 5, ").partition("R=")
    return f"R = {value}" if radius else f"{str(row['path']).capitalize()} path"


def _scores(frame: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(count, answered=f"cells of {frame['cells'].iloc[0]}", printed="as printed"),
        *columns(digits(3), length_off="largest error of f", segment_off="largest error of ζ"),
    )
    caption = (
        "The same cells from each solver's LS and RS paths. A length may be right while its "
        "parts are not: compare both. Turns at less than the full rate count in proportion. Errors "
        "in the scenario's length unit."
    )
    return Table("paper-scores", caption, frame, shown)


def _times(frame: pd.DataFrame) -> Table:
    shown = (
        *columns(kind="text", label="scenario", path="path", word="word"),
        *columns(lambda s: f"{s:.3f} s", printed_s="printed"),
        *columns(count, ticks="ticks of 1/64 s"),
        *columns(seconds, exact_s="closed form"),
        Column("fastest", "fastest solver", kind="solver"),
        *columns(seconds, fastest_s="its median"),
        Column("slowest", "slowest solver", kind="solver"),
        *columns(seconds, slowest_s="its median"),
    )
    caption = (
        "The solve times that the paper's text prints, and the median times of our solvers for "
        "the same word, right answers only. Other machines and other clocks: only the orders of "
        "magnitude compare."
    )
    return Table("paper-times", caption, frame, shown)


def figures_section(results: Results) -> Section | None:
    """Figures 3.1 and 6.1-6.5, redrawn from the paths in the rows."""
    frames = {problem: problem_paths(results, problem) for problem in range(1, 6)}
    pictures = [problem_picture(problem, frame) for problem, frame in frames.items() if len(frame)]
    if not pictures:
        return None
    text = (
        "The paper's Figures 3.1 and 6.1–6.5, drawn from the controls in the rows, with as many "
        "panels as there. The arrow is the start heading, the ring the target; faint are the "
        "turning circles. The paper's text gives each length with two decimals; the tables above "
        "say which of these are right."
    )
    lead = (
        "In every problem one of two paths is the shortest, LS or RS; see how far the other is "
        "round."
    )
    return Section("paths", "The paper's figures", text, (feasible_picture(), *pictures), lead)


TOPIC = Topic(
    "the paper's tables",
    paper_section,
    "paper",
    (General.POOLED, General.COMPARED),
    place=Place.PAPER,
)

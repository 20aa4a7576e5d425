"""The audit of the paper: its wrong cells, its paths, its algorithm, what it leaves out."""

from __future__ import annotations

from typing import Any

import pandas as pd

from dubins_study.report.data.results import Results
from dubins_study.report.elements.content import Column, Section, Table, count, digits, share
from dubins_study.report.paper.audit_file import committed, misprints
from dubins_study.report.topics.audit.numbers import (
    Record,
    circle_crossings,
    distinct_times,
    excused_sums,
    printed_paths,
    wrong_verdicts,
)

_SYMBOLS = {"z1": "ζ₁", "z2": "ζ₂", "z3": "ζ₃", "f": "f"}


def audit_section(results: Results) -> Section | None:
    """What the committed audit finds; beside the paper's own experiment only."""
    if results.rows.empty:
        return None
    audit = committed()
    summary = audit["summary"]
    others = [f"{n} {verdict}" for verdict, n in wrong_verdicts(summary).items()]
    ticks = distinct_times(audit["times"])
    text = (
        "Every printed number recomputed from the exact headings in interval arithmetic; "
        "dubins-study audit does it again and shows 40 digits of each. Of the cells that are not "
        f"correct roundings, by a rule that looks for the accident behind them: "
        f"{', '.join(others)}. The bias is no more than a guess: it would print "
        f"{summary['correct_cells_that_the_bias_would_spoil']} of the correct cells otherwise. "
        f"{summary['times_that_are_ticks']} of the {len(audit['times'])} "
        f"printed solve times ({', '.join(ticks)} s) are whole ticks of a clock of 64 a second: "
        "they tell the clock, not the solver."
    )
    blocks = (
        _cells(),
        _paths(audit["paths"]),
        _algorithm(audit["algorithm"]),
        _omitted(audit["omitted"]),
        _statements(audit["statements"]),
    )
    return Section("audit", "The audit of the paper", text, blocks)


def _signed(value: float) -> str:
    return f"{value:+.6f}".replace("-", "−")


def _cross(wrong: bool) -> str:
    return "✗" if wrong else ""


def _judgement(holds: bool) -> str:
    return "right" if holds else "wrong or incomplete"


def _six(value: Any) -> str:
    return f"{float(value):.6f}"


def _cells() -> Table:
    frame = pd.DataFrame(misprints()).replace({"quantity": _SYMBOLS})
    columns = (
        Column("table", "table", kind="text"),
        Column("label", "scenario", kind="text"),
        Column("path", "path", kind="text"),
        Column("quantity", "cell", kind="text"),
        Column("printed", "printed"),
        Column("exact", "exact", lambda value: f"{float(value):.9f}"),
        Column("difference", "printed − exact", _signed),
        Column("verdict", "verdict", kind="text"),
        Column("reason", "the exact value …", kind="prose"),
    )
    caption = (
        "The cells that are not correct roundings. Double rounding: to more decimals first. "
        "Solver bias: model (4.12) at the last barrier parameter of Ipopt's default options, where "
        "the missing turn is not quite zero. Wrong: neither of them, nor cut off. The verdict says "
        "what gives the cell; what that would give in the rest of the row is said behind. Lengths."
    )
    return Table("audit-cells", caption, frame, columns)


def _paths(paths: list[Record]) -> Table:
    frame = printed_paths(paths)
    wrong = frame.to_dict("records")
    marks = {(i, "beyond"): "bad" for i, row in enumerate(wrong) if row["beyond"]}
    marks |= {(i, "wrong_sum"): "bad" for i, row in enumerate(wrong) if row["wrong_sum"]}
    columns = (
        Column("table", "table", kind="text"),
        Column("label", "scenario", kind="text"),
        Column("path", "path", kind="text"),
        Column("word", "word", kind="text"),
        Column("miss", "miss", digits(3)),
        Column("rounding_allows", "rounding allows", digits(3)),
        Column("beyond", "", _cross, kind="text"),
        Column("sum_of_parts", "sum of parts"),
        Column("total", "total"),
        Column("wrong_sum", "", _cross, kind="text"),
    )
    caption = (
        "The printed segments driven from the start: how far from the target they end, and how far "
        "correct roundings may. ✗ marks a miss beyond that, and parts that do not add up to the "
        f"total; in {excused_sums(paths)} of the {int(frame['wrong_sum'].sum())} rows that do not, "
        "correct roundings would not either. Lengths."
    )
    return Table("audit-paths", caption, frame, columns, marks)


def _algorithm(crossings: list[Record]) -> Table:
    frame = circle_crossings(crossings)
    columns = (
        Column("label", "scenario", kind="text"),
        Column("where", "circle, half", kind="text"),
        Column("radius", "R*", _six),
        Column("length_there", "on it", digits(6)),
        Column("word_beyond", "beyond", kind="text"),
        Column("length_beyond", "length", digits(6)),
        Column("algorithm_word", "algorithm", kind="text"),
        Column("algorithm_length", "length", digits(6)),
        Column("algorithm_excess", "too long", share),
        Column("model_excess", "model (4.12)", share),
        Column("example_radius", "at R =", count),
        Column("example_excess", "too long", share),
    )
    caption = (
        "Algorithm 1 where the turning circle, of radius R*, has reached the target. On it the "
        "optimum is one arc; just beyond, it turns away first (RL or LR), and the algorithm, which "
        "knows LS and RS, is too long by the share given; the model unsplit holds LR and is right "
        "in the right disc only. Last, a round radius beyond. Lengths."
    )
    return Table("audit-algorithm", caption, frame, columns)


def _omitted(paths: list[Record]) -> Table:
    columns = (
        Column("label", "scenario", kind="text"),
        Column("path", "path", kind="text"),
        Column("word", "word", kind="text"),
        Column("z2", "right turn ζ₂", _six),
        Column("z3", "straight ζ₃", _six),
        Column("f", "total f", _six),
    )
    caption = "Paths that the tables have no row for, though the text speaks of them. Lengths."
    return Table("audit-omitted", caption, pd.DataFrame(paths), columns)


def _statements(statements: list[Record]) -> Table:
    frame = pd.DataFrame(statements)
    columns = (
        Column("where", "where", kind="text"),
        Column("says", "says", kind="prose"),
        Column("holds", "is", _judgement, kind="text"),
        Column("finding", "found", kind="prose"),
    )
    caption = "Statements of the paper that its own scenarios decide."
    return Table("audit-statements", caption, frame, columns)

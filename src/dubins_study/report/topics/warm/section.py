"""Cold against warm starts along the radius sweeps: figure, table and what they say."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.content import (
    Column,
    Picture,
    Table,
    count,
    digits,
    seconds,
    share,
)
from dubins_study.report.elements.looks import name_of
from dubins_study.report.elements.style import HALF, new_figure
from dubins_study.report.topics.warm.figures import plot_warm

_SAME = 0.02  # ratios this near to 1 are called equal


def warm_blocks(table: pd.DataFrame) -> tuple[Picture, Table]:
    """Figure and table; `table` is of `warm.numbers.warm_starts`, with rows."""
    lines = max(name_of(solver).count("\n") + 1 for solver in table["solver"])
    figure = new_figure(HALF, 1.2 + max(0.42, 0.16 * lines) * len(table))
    plot_warm(figure.add_subplot(), table)
    figure.legend(loc="outside lower left", ncols=2)
    caption = (
        "Started from the answer at the neighbouring radius against cold: time and the solver's "
        "own iterations, question by question, median (mark) and quartiles (bar). Left of 1 the "
        "warm start saves."
    )
    alt = "Ratios of warm to cold time and iterations, one line a solver"
    return Picture("warm-starts", caption, figure, alt, True), _table(table)


def _table(table: pd.DataFrame) -> Table:
    columns = (
        Column("solver", "solver", kind="code"),
        Column("questions", "questions", count),
        Column("cold_s", "cold, median", seconds),
        Column("warm_s", "warm, median", seconds),
        Column("ratio", "warm / cold", digits(3)),
        Column("work", "iterations, warm / cold", digits(3)),
        Column("cold_success", "success cold", share),
        Column("warm_success", "success warm", share),
    )
    caption = (
        "The same questions cold, and started from the answer at the neighbouring radius. The "
        "ratios are medians over questions of warm over cold."
    )
    return Table("warm-starts", caption, table, columns)


def warm_sentences(table: pd.DataFrame) -> str:
    """What warm starts do; `table` is of `warm.numbers.warm_starts`, with rows."""
    return " ".join(
        sentence for sentence in (_time(table), _work(table), _success(table)) if sentence
    )


def _named(rows: pd.DataFrame, key: str) -> str:
    ranked = rows.sort_values(key).to_dict("records")
    return ", ".join(f"{row['solver']} ({digits(3)(row[key])})" for row in ranked)


def _changes(table: pd.DataFrame, key: str) -> str:
    known = table[table[key].notna()]
    groups = (
        ("less than a cold one for", known[known[key] < 1 - _SAME]),
        ("as much for", known[(known[key] - 1).abs() <= _SAME]),
        ("more for", known[known[key] > 1 + _SAME]),
    )
    return "; ".join(f"{verb} {_named(rows, key)}" for verb, rows in groups if len(rows))


def _time(table: pd.DataFrame) -> str:
    changes = _changes(table, "ratio")
    sentence = (
        f"In time a start from the neighbouring radius costs, as a median multiple: {changes}."
    )
    return sentence if changes else ""


def _work(table: pd.DataFrame) -> str:
    changes = _changes(table, "work")
    return f"In iterations it costs: {changes}." if changes else ""


def _success(table: pd.DataFrame) -> str:
    change = table["warm_success"] - table["cold_success"]
    worse, better = table[change < 0], table[change > 0]
    parts = [
        f"{row['solver']} is right {verb} often ({share(row['cold_success'])} cold, "
        f"{share(row['warm_success'])} warm)"
        for rows, verb in ((better, "more"), (worse, "less"))
        for row in rows.to_dict("records")
    ]
    if not parts:
        return "No solver is right more or less often for it."
    return f"With it {', '.join(parts)}."

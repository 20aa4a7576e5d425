"""Cold against warm starts along the radius sweeps: figure, table and sentences."""

from __future__ import annotations

import pandas as pd

from dubins_study.report.elements.columns import SOLVER, columns
from dubins_study.report.elements.content import Picture, Table, picture
from dubins_study.report.elements.formats import count, digits, seconds, sentences, share
from dubins_study.report.elements.looks import Palette
from dubins_study.report.topics.warm.figures import plot_warm

_SAME = 0.02  # ratios this near to 1 are called equal


def warm_blocks(table: pd.DataFrame, palette: Palette) -> tuple[Picture, Table]:
    """Figure and table for the result of `warm.numbers.warm_starts`, which must have rows."""
    ratios = picture(
        "warm-starts",
        plot_warm,
        *(table, list(palette.names(table["solver"]).values())),
        caption="Started from the answer at the neighbouring radius against cold: time and the "
        "solver's own iterations, question by question, median (mark) and quartiles (bar). Left "
        "of 1 the warm start saves.",
        alt="Ratios of warm to cold time and iterations, one line per solver",
        height=min(1.1 + 0.32 * len(table), 7.0),
    )
    return ratios, _table(table)


def _table(table: pd.DataFrame) -> Table:
    shown = (
        SOLVER,
        *columns(count, questions="questions"),
        *columns(seconds, cold_s="cold, median", warm_s="warm, median"),
        *columns(digits(3), ratio="warm / cold", work="iterations, warm / cold"),
        *columns(share, cold_success="success cold", warm_success="success warm"),
    )
    caption = (
        "The same questions cold, and started from the answer at the neighbouring radius. The "
        "ratios are medians over questions of warm over cold."
    )
    return Table("warm-starts", caption, table, shown)


def warm_sentences(table: pd.DataFrame) -> str:
    """Sentences about the result of `warm.numbers.warm_starts`, which must have rows."""
    return sentences(_time(table), _work(table), _success(table))


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

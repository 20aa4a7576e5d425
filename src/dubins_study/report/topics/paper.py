"""The paper's tables next to ours, and every solver's score."""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from decimal import Decimal
from typing import Any

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import SOLVER, columns, marks
from dubins_study.report.elements.content import (
    General,
    Place,
    Section,
    Table,
    Topic,
)
from dubins_study.report.elements.formats import count, digits
from dubins_study.report.paper.printed import QUANTITIES, compare
from dubins_study.report.statistics.metrics import solver_order
from dubins_study.study.path import Path

_MISPRINTED = ("misprint", "differs")
# Decimals of exact lengths; a double below 100 has no more than the latter.
_PLACES, _MOST_PLACES = 6, 17
_HALF = Decimal("0.005")  # of the last decimal that the paper prints


def word_paths(results: Results, solver: str) -> dict[tuple[str, str], Path]:
    """(label, LS or RS) -> a solver's path, from its first attempt at each of the paper's words."""
    rows = results.rows
    arrived = (rows["solver"] == solver) & rows["branch"].isin(["LS", "RS"]) & rows["gap"].notna()
    first = rows[arrived].drop_duplicates(["label", "branch"])
    paths = {
        (label, branch): results.path(index)
        for index, label, branch in zip(first.index, first["label"], first["branch"], strict=True)
    }
    return {key: path for key, path in paths.items() if path is not None}


def side_by_side(cells: pd.DataFrame) -> pd.DataFrame:
    """Two rows for each printed row of one table of `compare`: what is printed, and the exact.

    Columns label, path, source (`paper` or `exact`), and the text of each of `QUANTITIES`, empty
    if the path does not have it.
    """
    records: list[dict[str, object]] = []
    for (label, path), group in cells.groupby(["label", "path"], sort=False):
        printed: dict[str, object] = {"label": label, "path": path, "source": "paper"}
        exact: dict[str, object] = {"label": label, "path": path, "source": "exact"}
        for cell in group.to_dict("records"):
            quantity, mark = str(cell["quantity"]), " ✗" if cell["verdict"] in _MISPRINTED else ""
            printed[quantity] = f"{cell['printed']:.2f}{mark}"
            exact[quantity] = None if pd.isna(cell["ours"]) else _exact_text(cell, bool(mark))
        records += [printed, exact]
    columns = ["label", "path", "source", *QUANTITIES]
    return pd.DataFrame.from_records(records, columns=columns).astype(object)


def _exact_text(cell: Mapping[Hashable, Any], wrong: bool) -> str:
    """The exact length with six decimals; with more if these would round to what is printed wrong.

    Of 1.73499986, six decimals are 1.735000, which looks as if 1.74 were right.
    """
    printed = Decimal(f"{cell['printed']:.2f}")
    texts = (f"{cell['ours']:.{places}f}" for places in range(_PLACES, _MOST_PLACES))
    far = (text for text in texts if abs(Decimal(text) - printed) > _HALF)
    return next(far) if wrong else f"{cell['ours']:.{_PLACES}f}"


def scores(results: Results) -> pd.DataFrame:
    """One row per solver: how many of the printed cells it answers, and as they are printed.

    Columns solver, cells, answered, printed, length_off and segment_off (largest errors of f and of
    z1, z2, z3 against the closed form, length unit).
    """
    rows = results.rows[results.rows["branch"].isin(["LS", "RS"])]
    exact = compare(word_paths(results, EXACT))
    turns = exact["quantity"] != "f"
    records = []
    for solver in solver_order(rows["solver"].tolist()):
        cells = compare(word_paths(results, solver))
        error = (cells["ours"] - exact["ours"]).abs()
        answered, printed = cells["ours"].notna().sum(), (cells["verdict"] == "correct").sum()
        off = error[~turns].max(), error[turns].max()
        records.append((solver, len(exact), answered, printed, *off))
    columns = ["solver", "cells", "answered", "printed", "length_off", "segment_off"]
    return pd.DataFrame.from_records(records, columns=columns)


_TITLES = {
    "6.1": "Test problem 1: start (0, 0, 2π/3), target (10, 5), R = 1.",
    "6.2": "Test problem 2: start (0, 0, 2π/3), target (−6, 3), R = 1.",
    "6.3": "Test problem 3: start (0, 0, π/3), target (−1, 5), R = 1.",
    "6.4": "Test problem 4: start (0, 0, π/3), target (−2, −5), R = 1.",
    "6.5": "Test problem 5: start (0, 0, 2π/3), target (−80, 20), three radii.",
}


def paper_section(results: Results) -> Section | None:
    """Tables 6.1-6.5 cell by cell, and every solver's score."""
    paths = word_paths(results, EXACT)
    if not paths:
        return None
    cells = compare(paths)
    blocks = [_side_by_side(cells, number) for number in _TITLES]
    blocks.append(_scores(scores(results)))
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


_ENTERS = (General.POOLED, General.COMPARED)
TOPIC = Topic("the paper's tables", paper_section, "paper", _ENTERS, place=Place.PAPER)

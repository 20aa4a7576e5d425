"""The paper's tables beside the exact numbers.

`word_paths` also finds the closed form's paths for the paper's words.
"""

from __future__ import annotations

import pandas as pd

from dubins_study.report.data.attempts import EXACT
from dubins_study.report.data.results import Results
from dubins_study.report.elements.columns import columns, marks
from dubins_study.report.elements.content import (
    General,
    Place,
    Section,
    Table,
    Topic,
)
from dubins_study.report.paper.printed import (
    CORRECT,
    QUANTITIES,
    committed,
)
from dubins_study.study.path import Path


def word_paths(results: Results) -> dict[tuple[str, str], Path]:
    """Map (label, word) to the closed form's path.

    The word is LS or RS. The path is that of the first attempt that arrives.
    """
    rows = results.rows
    arrived = (rows["solver"] == EXACT) & rows["branch"].isin(["LS", "RS"]) & rows["gap"].notna()
    first = rows[arrived].drop_duplicates(["label", "branch"])
    paths = {
        (label, branch): results.path(index)
        for index, label, branch in first[["label", "branch"]].itertuples()
    }
    return {key: path for key, path in paths.items() if path is not None}


def side_by_side(cells: pd.DataFrame) -> pd.DataFrame:
    """Printed and exact numbers, one row above the other.

    `cells` are those of the audit. A printed row gives two rows: `paper` and `exact` in the column
    source. Other columns: label, path, and a text for each of `QUANTITIES`, missing if the path
    does not have it. A printed number that is no correct rounding is followed by ✗.
    """
    rows = []
    for (label, path), row in cells.groupby(["label", "path"], sort=False):
        marked = row["printed"] + row["verdict"].eq(CORRECT).map({True: "", False: " ✗"})
        exact = row["exact"].map(_exact_text)
        for source, texts in (("paper", marked), ("exact", exact)):
            named = {"label": label, "path": path, "source": source}
            rows.append(named | dict(zip(row["quantity"], texts, strict=True)))
    return pd.DataFrame(rows, columns=["label", "path", "source", *QUANTITIES])


def _exact_text(exact: str) -> str:
    """A length with seven decimals.

    With six, 1.73499986 would be 1.735000, which looks as if 1.74 were right.
    """
    return f"{float(exact):.7f}"


_TITLES = {
    "6.1": "Test problem 1: start (0, 0, 2π/3), target (10, 5), R = 1.",
    "6.2": "Test problem 2: start (0, 0, 2π/3), target (−6, 3), R = 1.",
    "6.3": "Test problem 3: start (0, 0, π/3), target (−1, 5), R = 1.",
    "6.4": "Test problem 4: start (0, 0, π/3), target (−2, −5), R = 1.",
    "6.5": "Test problem 5: start (0, 0, 2π/3), target (−80, 20), three radii.",
}


def paper_section(results: Results) -> Section | None:
    """The section with Tables 6.1-6.5, cell by cell."""
    if not word_paths(results):
        return None
    cells = pd.DataFrame(committed()["cells"])
    blocks = tuple(_side_by_side(cells, number) for number in _TITLES)
    right = int((cells["verdict"] == CORRECT).sum())
    text = (
        f"{right} of the {len(cells)} printed lengths are correct roundings of the exact ones. The "
        "paper's optimal path is the shorter of LS and RS, its feasible path the longer. The audit "
        "below explains the other lengths."
    )
    lead = (
        "Read a table's lines in pairs: the printed numbers above the exact ones. A cross marks a "
        "wrong number."
    )
    return Section("paper", "The paper's tables", text, blocks, lead)


def _side_by_side(cells: pd.DataFrame, number: str) -> Table:
    """The table for the paper's table of this number."""
    frame = side_by_side(cells[cells["table"] == number])
    wrong = frame[list(QUANTITIES)].map(lambda text: "✗" in str(text))
    shown = (
        *columns(kind="text", label="scenario", path="path", source="from"),
        *columns(z1="left turn ζ₁", z2="right turn ζ₂", z3="straight ζ₃", f="total f"),
    )
    caption = f"Table {number}. {_TITLES[number]} Lengths; ✗ marks a wrong rounding."
    name = f"paper-{number.replace('.', '-')}"
    return Table(name, caption, frame, shown, marks(wrong, *QUANTITIES))


_ENTERS = (General.POOLED, General.COMPARED)
TOPIC = Topic("the paper's tables", paper_section, "paper", _ENTERS, place=Place.PAPER)

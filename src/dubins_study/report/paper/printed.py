"""The paper: its citation, its printed numbers, and the committed audit of them.

After an intended change, write the audit again with this command:

    dubins-study audit --json > src/dubins_study/report/paper/audit.json
"""

from __future__ import annotations

import json
from fractions import Fraction
from functools import lru_cache
from importlib.resources import files
from typing import Any, NamedTuple

import pandas as pd

from dubins_study.study.path import Path

QUANTITIES = ("z1", "z2", "z3", "f")


class Problem(NamedTuple):
    """A scenario of the paper, exactly as stated; it starts at (0, 0)."""

    label: str  # in the experiment `paper`
    heading: Fraction  # at the start, in units of pi
    target: tuple[int, int]  # x and y
    radius: int  # same unit

    @property
    def position(self) -> str:
        """The test problem without its radius: `problem 1` to `problem 5`."""
        return self.label.partition(",")[0]


_60, _120 = Fraction(1, 3), Fraction(2, 3)
PROBLEMS = {
    problem.label: problem
    for problem in (
        Problem("problem 1", _120, (10, 5), 1),
        Problem("problem 2", _120, (-6, 3), 1),
        Problem("problem 3", _60, (-1, 5), 1),
        Problem("problem 4", _60, (-2, -5), 1),
        Problem("problem 5, R=25", _120, (-80, 20), 25),
        Problem("problem 5, R=10", _120, (-80, 20), 10),
        Problem("problem 5, R=5", _120, (-80, 20), 5),
    )
}


class PrintedRow(NamedTuple):
    """One printed row; lengths in the scenario's unit.

    `cells` are left turn z1, right turn z2, straight z3 and total f, as printed; `0` for the turn
    that a path does not have.
    """

    table: str  # the paper's number of it
    label: str  # of the problem
    path: str  # `optimal` or `feasible`
    cells: tuple[str, str, str, str]

    @property
    def word(self) -> str:
        """`LS` or `RS`, depending on which turn is printed as 0."""
        return "RS" if self.cells[0] == "0" else "LS"

    def record(self) -> dict[str, Any]:
        """The fields that identify the row in a record."""
        return {"table": self.table, "label": self.label, "path": self.path, "word": self.word}


PRINTED = (
    PrintedRow("6.1", "problem 1", "optimal", ("0", "1.74", "10.13", "11.87")),
    PrintedRow("6.1", "problem 1", "feasible", ("4.74", "0", "12.14", "16.88")),
    PrintedRow("6.2", "problem 2", "optimal", ("0.61", "0", "6.13", "6.74")),
    PrintedRow("6.2", "problem 2", "feasible", ("0", "5.72", "7.24", "12.96")),
    PrintedRow("6.3", "problem 3", "optimal", ("0.79", "0", "4.39", "5.17")),
    PrintedRow("6.3", "problem 3", "feasible", ("0", "5.61", "5.72", "11.33")),
    PrintedRow("6.4", "problem 4", "optimal", ("0", "3.38", "5.24", "8.61")),
    PrintedRow("6.4", "problem 4", "feasible", ("3.64", "0", "5.53", "9.17")),
    PrintedRow("6.5", "problem 5, R=25", "optimal", ("23.01", "0", "61.91", "84.92")),
    PrintedRow("6.5", "problem 5, R=10", "optimal", ("8.43", "0", "74.92", "83.36")),
    PrintedRow("6.5", "problem 5, R=5", "optimal", ("4.11", "0", "78.79", "82.89")),
)


class PrintedTime(NamedTuple):
    """A solve time that the text states, in seconds, as printed."""

    label: str
    path: str
    seconds: str


TIMES = (
    PrintedTime("problem 1", "optimal", "0.031"),
    PrintedTime("problem 1", "feasible", "0.047"),
    PrintedTime("problem 2", "optimal", "0.047"),
    PrintedTime("problem 2", "feasible", "0.016"),
    PrintedTime("problem 3", "optimal", "0.016"),
    PrintedTime("problem 3", "feasible", "0.031"),
    PrintedTime("problem 4", "optimal", "0.031"),
    PrintedTime("problem 4", "feasible", "0.047"),
    PrintedTime("problem 5, R=10", "optimal", "0.047"),
)

# A printed number has two decimals, so its error may be half a unit of the last decimal. The small
# rest allows for binary fractions instead of decimal ones.
HALF_UNIT = 0.005 + 1e-9


def segments(path: Path, radius: float) -> tuple[float, float, float, float]:
    """Total left turn, right turn and straight of a path, and its length: z1, z2, z3, f.

    A turn counts with the length that it would have at the full rate, the rest of its length as
    straight; for an arc at the full rate, the paper's only kind, that is the arc's own length.
    """
    turn = path.curvatures * path.lengths * radius
    left, right = float(turn[turn > 0].sum()), float(-turn[turn < 0].sum())
    return left, right, path.length - left - right, path.length


def compare(paths: dict[tuple[str, str], Path]) -> pd.DataFrame:
    """One row per printed cell, with our value; printed zeros of missing turns are left out.

    Of the `paths` by (scenario label, LS or RS) the shorter is held against the paper's `optimal`
    row, the longer against its `feasible` row. Columns table, label, path, word, quantity, printed,
    ours (NaN where there is no answer), difference and verdict: `correct` if ours rounds to what is
    printed, `misprint` if the audit knows why it does not, otherwise `differs`; or `no answer`.
    """
    known = {(c["label"], c["path"], c["quantity"]) for c in misprints(committed())}
    records = []
    for row in PRINTED:
        word, ours = _ranked(paths, row)
        for position, (quantity, text) in enumerate(zip(QUANTITIES, row.cells, strict=True)):
            if text == "0":
                continue
            printed = float(text)
            value = None if ours is None else ours[position]
            misprint = (row.label, row.path, quantity) in known
            record = row.record() | {"word": word, "quantity": quantity, "printed": printed}
            record |= {"ours": value, "difference": None if value is None else printed - value}
            records.append(record | {"verdict": _verdict(printed, value, misprint)})
    frame = pd.DataFrame.from_records(records)
    return frame.astype({"ours": float, "difference": float})


def _ranked(
    paths: dict[tuple[str, str], Path], row: PrintedRow
) -> tuple[str | None, tuple[float, float, float, float] | None]:
    both = [(b, paths[row.label, b]) for b in ("LS", "RS") if (row.label, b) in paths]
    if len(both) < 2:
        return None, None
    both.sort(key=lambda item: item[1].length)
    word, path = both[0 if row.path == "optimal" else 1]
    return word, segments(path, PROBLEMS[row.label].radius)


def _verdict(printed: float, ours: float | None, misprint: bool) -> str:
    if ours is None:
        return "no answer"
    if abs(printed - ours) <= HALF_UNIT:
        return "correct"
    return "misprint" if misprint else "differs"


# The copy that the tables were read from names neither authors nor year, so none are given.
TITLE = "Mathematical Model for Optimal Dubins Path to Intercept a Stationary Target"
CITATION = f"“{TITLE}” (authors and year unknown to this study)"

CORRECT = "correct rounding"


@lru_cache(maxsize=1)
def committed() -> dict[str, Any]:
    """The committed audit, a stored result of `report.paper.audit.audit`."""
    file = files("dubins_study.report.paper") / "audit.json"
    record: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return record


def misprints(audit: dict[str, Any]) -> list[dict[str, Any]]:
    """The printed cells of an audit that are not correct roundings."""
    return [cell for cell in audit["cells"] if cell["verdict"] != CORRECT]

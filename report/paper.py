"""The printed cells of the paper's Tables 6.1-6.5, and what is known of those that are wrong."""

from __future__ import annotations

from typing import NamedTuple

import pandas as pd

from study.path import Path

QUANTITIES = ("z1", "z2", "z3", "f")


class PrintedRow(NamedTuple):
    """One printed row; lengths in the scenario's unit, None for the turn that a path has not.

    Args:
        table: the paper's number of the table.
        label: the scenario's label in the experiment `paper`.
        path: `optimal` or `feasible`.
        radius: turning radius.
        cells: left turn z1, right turn z2, straight z3, total f.
    """

    table: str
    label: str
    path: str
    radius: float
    cells: tuple[float | None, float | None, float, float]


PRINTED = (
    PrintedRow("6.1", "problem 1", "optimal", 1.0, (None, 1.74, 10.13, 11.87)),
    PrintedRow("6.1", "problem 1", "feasible", 1.0, (4.74, None, 12.14, 16.88)),
    PrintedRow("6.2", "problem 2", "optimal", 1.0, (0.61, None, 6.13, 6.74)),
    PrintedRow("6.2", "problem 2", "feasible", 1.0, (None, 5.72, 7.24, 12.96)),
    PrintedRow("6.3", "problem 3", "optimal", 1.0, (0.79, None, 4.39, 5.17)),
    PrintedRow("6.3", "problem 3", "feasible", 1.0, (None, 5.61, 5.72, 11.33)),
    PrintedRow("6.4", "problem 4", "optimal", 1.0, (None, 3.38, 5.24, 8.61)),
    PrintedRow("6.4", "problem 4", "feasible", 1.0, (3.64, None, 5.53, 9.17)),
    PrintedRow("6.5", "problem 5, R=25", "optimal", 25.0, (23.01, None, 61.91, 84.92)),
    PrintedRow("6.5", "problem 5, R=10", "optimal", 10.0, (8.43, None, 74.92, 83.36)),
    PrintedRow("6.5", "problem 5, R=5", "optimal", 5.0, (4.11, None, 78.79, 82.89)),
)

_R25 = "wrong: the printed path is shorter than the true optimum and misses the target by 0.161"
MISPRINTS = {
    ("problem 1", "optimal", "z2"): "1.734999847 rounds to 1.73",
    ("problem 3", "optimal", "z1"): "wrong: no rounding of 0.777354 gives it",
    ("problem 4", "optimal", "z2"): "3.373651 rounds to 3.37",
    ("problem 5, R=25", "optimal", "z1"): _R25,
    ("problem 5, R=25", "optimal", "z3"): _R25,
    ("problem 5, R=25", "optimal", "f"): _R25,
    ("problem 5, R=10", "optimal", "z3"): (
        "74.929029 rounds to 74.93; 74.9164 is what an interior-point solver's bias gives"
    ),
}

# A printed number has two decimals, so it may be off by half of the last; the rest is for the
# binary fractions that stand in for decimal ones.
HALF_UNIT = 0.005 + 1e-9


def segments(path: Path, radius: float) -> tuple[float, float, float, float]:
    """Total left turn, right turn and straight of a path, and its length: z1, z2, z3, f.

    A turn counts with the length that it would have at the full rate, the rest of its length as
    straight; for an arc at the full rate, the paper's only kind, that is the arc's own length.
    """
    turn = path.curvature * path.length * radius
    left, right = float(turn[turn > 0].sum()), float(-turn[turn < 0].sum())
    return left, right, path.total_length - left - right, path.total_length


def compare(paths: dict[tuple[str, str], Path]) -> pd.DataFrame:
    """Every printed cell beside ours, one row each; structural zeros are left out.

    Args:
        paths: (scenario label, branch) -> path, branch LS or RS. The paper's `optimal` row is the
            shorter of the two and its `feasible` row the longer.

    Returns:
        Columns table, label, path, word, quantity, printed, ours (NaN where there is no answer),
        difference, verdict (`correct`, `misprint`, `differs`, `no answer`) and reason.
    """
    records = []
    for row in PRINTED:
        word, ours = _ranked(paths, row)
        for position, (quantity, printed) in enumerate(zip(QUANTITIES, row.cells, strict=True)):
            if printed is None:
                continue
            value = None if ours is None else ours[position]
            reason = MISPRINTS.get((row.label, row.path, quantity), "")
            records.append(
                {
                    "table": row.table,
                    "label": row.label,
                    "path": row.path,
                    "word": word,
                    "quantity": quantity,
                    "printed": printed,
                    "ours": value,
                    "difference": None if value is None else printed - value,
                    "verdict": _verdict(printed, value, reason),
                    "reason": reason,
                }
            )
    frame = pd.DataFrame.from_records(records)
    return frame.astype({"ours": float, "difference": float})


def _ranked(
    paths: dict[tuple[str, str], Path], row: PrintedRow
) -> tuple[str | None, tuple[float, float, float, float] | None]:
    found = [(b, paths[row.label, b]) for b in ("LS", "RS") if (row.label, b) in paths]
    if len(found) < 2:
        return None, None
    found.sort(key=lambda item: item[1].total_length)
    word, path = found[0 if row.path == "optimal" else 1]
    return word, segments(path, row.radius)


def _verdict(printed: float, ours: float | None, reason: str) -> str:
    if ours is None:
        return "no answer"
    if abs(printed - ours) <= HALF_UNIT:
        return "correct"
    return "misprint" if reason else "differs"

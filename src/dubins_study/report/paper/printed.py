"""The paper: its citation, its printed numbers, and the committed audit of them.

After an intended change, write the audit again with this command:

    dubins-study audit --json > src/dubins_study/report/paper/audit.json
"""

from __future__ import annotations

import json
import math
import tomllib
from fractions import Fraction
from functools import lru_cache
from importlib.resources import files
from typing import Any, NamedTuple, TypeAlias

from dubins_study.study.scenario import Scenario

# The copy that the tables were read from names neither authors nor year, so none are given.
TITLE = "Mathematical Model for Optimal Dubins Path to Intercept a Stationary Target"
CITATION = f"“{TITLE}” (authors and year unknown to this study)"

Record: TypeAlias = dict[str, Any]
QUANTITIES = ("z1", "z2", "z3", "f")
WORDS = ("LS", "RS")
CORRECT = "correct rounding"
_FOLDER = files("dubins_study.report.paper")
NUMBERS = tomllib.loads((_FOLDER / "printed.toml").read_text(encoding="utf-8"))


class Problem(NamedTuple):
    """A scenario of the paper, from (0, 0)."""

    label: str  # in the experiment `paper`
    heading: Fraction  # at the start, in units of pi
    target: tuple[int, int]  # x and y
    radius: int  # same unit

    @property
    def position(self) -> str:
        """The test problem: `problem 1` to `problem 5`."""
        return self.label.partition(",")[0]

    @property
    def scenario(self) -> Scenario:
        """The scenario with its heading as a double."""
        return Scenario(0, 0, float(self.heading) * math.pi, *self.target, self.radius)


PROBLEMS = {
    entry["label"]: Problem(
        entry["label"], Fraction(entry["heading"]), tuple(entry["target"]), entry["radius"]
    )
    for entry in NUMBERS["scenarios"]
}


class PrintedRow(NamedTuple):
    """One printed row; lengths in the scenario's unit."""

    table: str  # the paper's number of it
    label: str  # of the problem
    path: str  # `optimal` or `feasible`
    cells: list[str]  # of `QUANTITIES`

    @property
    def word(self) -> str:
        """`LS` or `RS`: one turn is printed as 0."""
        if self.cells[0] == "0":
            return "RS"
        return "LS"

    def record(self) -> Record:
        """The fields that identify the row in a record."""
        return {"table": self.table, "label": self.label, "path": self.path, "word": self.word}


PRINTED = [
    PrintedRow(entry["table"], entry["label"], path, cells)
    for entry in NUMBERS["scenarios"]
    for path, cells in entry["lengths"].items()
]


@lru_cache(maxsize=1)
def committed() -> Record:
    """The committed audit, a stored result of `report.paper.audit.audit`."""
    record: Record = json.loads((_FOLDER / "audit.json").read_text(encoding="utf-8"))
    return record


def misprints(audit: Record) -> list[Record]:
    """The printed cells that are not correct roundings."""
    return [cell for cell in audit["cells"] if cell["verdict"] != CORRECT]

"""Counts, worst deviation and first counterexample of each check."""

from dataclasses import dataclass, field
from typing import NamedTuple, Self

import pandas as pd

from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario


class Check(NamedTuple):
    """A check: allowed deviation, unit and promise."""

    allowed: float
    unit: str
    promise: str


# a length's ulp is 2^-52 of max(length, radius)
CHECKS = {
    "delta": Check(64, "eps", "the documented half width of the set"),
    "closed form length": Check(4, "ulp", "lies in the truth"),
    "closed form end": Check(1, "delta", "the path ends at a target of the set"),
    "closed form existence": Check(0, "wrong", "no path is said to be none only where it may be"),
    "kernel length": Check(4, "ulp", "frame equals scalar"),
    "kernel existence": Check(0, "wrong", "frame equals scalar"),
    "parts hold truth": Check(0, "ulp", "of the exact and of every sampled target"),
    "absent": Check(0, "wrong", "is true where a target of the set has no path, and only there"),
    "enclosure decided": Check(0, "wrong", "the interval is finite where a path exists"),
    "enclosure width": Check(8, "spread", "away from edges, beside that of sampled targets"),
    "bounds": Check(0, "wrong", "false above the truth, never below"),
    "frame judgement": Check(0, "wrong", "verdict, region, word, proof and flags equal scalar's"),
    "frame numbers": Check(1, "1e-14", "lengths, miss, margin, excess equal scalar's"),
    "frame gap": Check(8, "ulp", "of lengths: frame equals scalar"),
    "analytic claim": Check(0, "wrong", "optimal or none exists, no false claim or bound"),
    "broken path": Check(0, "wrong", "misses, and has no certificate"),
    "arrival": Check(0, "wrong", "misses if and only if the driven path does"),
    "verdict": Check(0, "wrong", "optimal if and only if the gap to the truth allows it"),
    "proved": Check(0, "wrong", "only what arrives and is as short as the truth"),
    "certificate": Check(1, "gap", "clear of its cut: shortest to its own end"),
    "route claim": Check(0, "wrong", "optimal or undecided, no false claim or bound"),
    "route arrival": Check(0, "wrong", "misses if and only if a dense sample does, in order"),
    "route verdict": Check(0, "wrong", "optimal, longer: never against a path that is known"),
    "route bound": Check(1e-11, "relative", "no path that arrives is below it"),
    "route false bound": Check(0, "wrong", "false above the interval, never at its lower end"),
    "route beaten": Check(1, "tolerated", "no route that is found is shorter than its bound"),
    "leg length": Check(1, "1e-9", "with a final heading: by circles and tangents"),
    "oracle by steps": Check(0, "wrong", "no first step leads to a shorter way"),
    "oracle by scan": Check(1, "1e-9", "no first arc leads to a shorter path of the word"),
}


@dataclass
class Cell:
    """One generator's cases of one check."""

    cases: int = 0
    worst: float = 0.0
    wrong: int = 0

    def add(self, cases: int, worst: float, wrong: int) -> None:
        self.cases += cases
        self.worst = max(self.worst, worst)
        self.wrong += wrong


@dataclass
class Table:
    """Counts by check and generator.

    `first` holds each check's first counterexample.
    """

    generator: str = ""
    cells: dict[tuple[str, str], Cell] = field(default_factory=dict)
    first: dict[str, str] = field(default_factory=dict)

    def note(self, check: str, deviation: float, line: str) -> None:
        """Count one case.

        A deviation that is not within the allowed one is a counterexample.
        """
        wrong = not deviation <= CHECKS[check].allowed
        cell = self.cells.setdefault((check, self.generator), Cell())
        cell.add(1, float(deviation), wrong)
        if wrong:
            self.first.setdefault(check, line)

    def add(self, other: Self) -> None:
        for key, cell in other.cells.items():
            self.cells.setdefault(key, Cell()).add(cell.cases, cell.worst, cell.wrong)
        self.first = other.first | self.first

    @property
    def wrong(self) -> int:
        return sum(cell.wrong for cell in self.cells.values())

    def __str__(self) -> str:
        """Rows by check and generator, by check, and failures."""
        rows = [(*key, cell.cases, cell.worst, cell.wrong) for key, cell in self.cells.items()]
        each = pd.DataFrame(rows, columns=["check", "generator", "cases", "worst", "wrong"])
        checks = each.groupby("check", sort=False).agg(
            {"cases": "sum", "worst": "max", "wrong": "sum"}
        )
        promises = pd.DataFrame(CHECKS.values(), CHECKS, columns=Check._fields)
        failed = [
            f"first counterexample of '{name}' ({CHECKS[name].promise}):\n    {line}"
            for name, line in self.first.items()
        ]
        whole = checks.join(promises).to_string()
        return "\n\n".join([each.to_string(index=False), whole, *failed])


def paste(scenario: Scenario, branch: str = "") -> str:
    """Arguments of a call: the scenario and the branch.

    The text needs `S = Scenario`.
    """
    s = scenario
    numbers = [*map(repr, (s.x, s.y, s.heading, s.target_x, s.target_y, s.radius))]
    if s.via or s.final_heading is not None:
        numbers.append(f"via={s.via!r}, final_heading={s.final_heading!r}")
    text = f"S({', '.join(numbers)})"
    return f"{text}, branch={branch!r}" if branch else text


def paste_path(scenario: Scenario, branch: str, path: Path) -> str:
    """A call of `judge` with this path."""
    k, s = path.curvatures.tolist(), path.lengths.tolist()
    start = tuple(path.start)
    asked = f"{paste(scenario)}, Path({start}, {k}, {s}), branch={branch!r}"
    return f"judge({asked})".replace("nan", "math.nan").replace("inf", "math.inf")

"""What was tried, the worst that was seen, and the first counterexample of each check."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario


class Check(NamedTuple):
    """A check's unit and the largest deviation that is allowed, in that unit."""

    unit: str
    allowed: float
    promise: str


# a length's ulp is 2^-52 of max(length, radius)
CHECKS = {
    "delta": Check("eps", 64, "the documented half width of the set"),
    "closed form length": Check("ulp", 4, "lies in the truth"),
    "closed form end": Check("delta", 1, "the path ends at a target of the set"),
    "closed form existence": Check("wrong", 0, "no path is said to be none only where it may be"),
    "kernel length": Check("ulp", 4, "frame equals scalar"),
    "kernel existence": Check("wrong", 0, "frame equals scalar"),
    "enclosure holds truth": Check("ulp", 0, "of the exact and of every sampled target"),
    "parts hold truth": Check("ulp", 0, "of the exact and of every sampled target"),
    "parts hold many": Check("ulp", 0, "of some hundred targets more"),
    "absent": Check("wrong", 0, "is true where a target of the set has no path, and only there"),
    "enclosure decided": Check("wrong", 0, "the interval is finite where a path exists"),
    "enclosure width": Check("spread", 8, "away from edges, beside that of sampled targets"),
    "bounds": Check("wrong", 0, "false above the truth, never below"),
    "frame judgement": Check("wrong", 0, "verdict, region, word, proof and flags equal scalar's"),
    "frame gap": Check("ulp", 8, "of lengths: frame equals scalar"),
    "frame interval": Check("wrong", 0, "there is one where balls give one"),
    "frame interval holds truth": Check("ulp", 0, "of all sampled targets"),
    "frame interval width": Check("1e-12", 1, "relative, beyond 64 times that in balls"),
    "analytic claim": Check("wrong", 0, "optimal or none exists, no false claim or bound"),
    "broken path": Check("wrong", 0, "misses, and has no certificate"),
    "arrival": Check("wrong", 0, "misses if and only if the driven path does"),
    "verdict": Check("wrong", 0, "optimal if and only if the gap to the truth allows it"),
    "proved": Check("wrong", 0, "only what arrives and is as short as the truth"),
    "certificate": Check("gap", 1, "clear of its cut: shortest to its own end"),
    "oracle by steps": Check("wrong", 0, "no first step leads to a shorter way"),
    "oracle by scan": Check("1e-9", 1, "no first arc leads to a shorter path of the word"),
    "oracle by mpmath": Check("1e-60", 1, "sine and cosine of the heading"),
}


@dataclass
class Cell:
    """One generator's cases of one check."""

    cases: int = 0
    worst: float = 0.0
    wrong: int = 0


@dataclass
class Table:
    """Counts by generator and check; `first` holds each check's first counterexample."""

    generator: str = ""
    cells: dict[tuple[str, str], Cell] = field(default_factory=dict)
    first: dict[str, str] = field(default_factory=dict)
    unproved: int = 0

    def note(self, check: str, deviation: float, line: str) -> None:
        """Count one case; a deviation that is not within the allowed one is a counterexample."""
        cell = self.cells.setdefault((self.generator, check), Cell())
        cell.cases += 1
        cell.worst = max(cell.worst, float(deviation))
        if not deviation <= CHECKS[check].allowed:
            cell.wrong += 1
            self.first.setdefault(check, line)

    def add(self, other: Table) -> None:
        for key, theirs in other.cells.items():
            cell = self.cells.setdefault(key, Cell())
            cell.cases += theirs.cases
            cell.worst = max(cell.worst, theirs.worst)
            cell.wrong += theirs.wrong
        for check, line in other.first.items():
            self.first.setdefault(check, line)
        self.unproved += other.unproved

    @property
    def wrong(self) -> int:
        return sum(cell.wrong for cell in self.cells.values())

    def count(self, check: str) -> int:
        """Counterexamples of one check."""
        return sum(cell.wrong for (_, name), cell in self.cells.items() if name == check)

    def lines(self) -> Iterator[str]:
        """The table as text: each generator and check, then each check alone, then what failed."""
        head = f"{'cases':>12}{'worst':>10} {'allowed':12}{'wrong':>8}"
        yield f"{'check':28}{'generator':20}{head}"
        kinds = sorted({kind for kind, _ in self.cells})
        for name in CHECKS:
            for kind in kinds:
                if cell := self.cells.get((kind, name)):
                    yield f"{name:28}{kind:20}{_numbers(name, [cell])}"
        yield f"\n{'check':28}{head}  promise"
        for name, check in CHECKS.items():
            some = [cell for (_, other), cell in self.cells.items() if other == name]
            yield f"{name:28}{_numbers(name, some)}  {check.promise}"
        yield f"answers of `analytic` that are right and not proved: {self.unproved:,}"
        for name, line in self.first.items():
            yield f"first counterexample of '{name}' ({CHECKS[name].promise}):\n    {line}"


def _numbers(check: str, cells: list[Cell]) -> str:
    cases, wrong = sum(cell.cases for cell in cells), sum(cell.wrong for cell in cells)
    worst = max((cell.worst for cell in cells), default=0.0)
    allowed = f"{CHECKS[check].allowed:g} {CHECKS[check].unit}"
    return f"{cases:12,}{worst:10.3g} {allowed:12}{wrong:8,}"


def paste(scenario: Scenario, branch: str = "") -> str:
    """The scenario and the branch as arguments of a call, with `S = Scenario`."""
    s = scenario
    numbers = (s.x, s.y, s.heading, s.target_x, s.target_y, s.radius)
    text = f"S({', '.join(map(repr, numbers))})"
    return f"{text}, branch={branch!r}" if branch else text


def paste_path(scenario: Scenario, branch: str, path: Path) -> str:
    """A call of `judge` with this path."""
    k, s = path.curvature.tolist(), path.length.tolist()
    start = tuple(path.start)
    asked = f"{paste(scenario)}, Path({start}, {k}, {s}), branch={branch!r}"
    return f"judge({asked})".replace("nan", "math.nan").replace("inf", "math.inf")

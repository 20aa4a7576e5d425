"""The attempts of one solver in one experiment, counted: any number of them, part by part."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from dubins_study.report.data.spread import Spread
from dubins_study.study.check.certificate import PMP_TOLERANCE
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import COLUMNS, Scenario

SUCCESSES = ("optimal", "none exists")
PROOFS = ("proved", "bounded", "extremal", "none")
# what is counted: a kind, and what it is told apart by
Count = tuple[str | None, ...]
TIMES = ("build_s", "solve_s", "wall_s")


@dataclass(frozen=True, eq=False)
class Tally:
    """Attempts of one solver in one experiment, or of several.

    Args:
        counts: `("attempts",)`, `("verdict", v)`, `("outcome", o)`, `("proof", p)`,
            `("failure", outcome, claim, verdict, said)`, `("answerable", region)`, `("jobs", n)`
            and the like -> attempts.
        spreads: `wall_s`, `cold build_s`, `gap outside` and the like -> values.
    """

    counts: Mapping[Count, int]
    spreads: Mapping[str, Spread]

    def count(self, *kind: str) -> int:
        """How many attempts are of a kind."""
        return self.counts.get(kind, 0)

    def kinds(self, kind: str) -> dict[Count, int]:
        """The counts of a kind by what they are told apart by."""
        return {key[1:]: number for key, number in self.counts.items() if key[0] == kind}

    def spread(self, *names: str) -> Spread:
        """The values under some names, together; none if there are none."""
        return Spread.merged([self.spreads[n] for n in names if n in self.spreads] or [_NOTHING])

    @property
    def attempts(self) -> int:
        return self.count("attempts")

    @property
    def success(self) -> int:
        return sum(self.count("verdict", verdict) for verdict in SUCCESSES)


_NOTHING = Spread.of([])


def united(tallies: Iterable[Tally]) -> Tally:
    """All of them counted together."""
    counts: Counter[Count] = Counter()
    spreads: dict[str, list[Spread]] = {}
    for tally in tallies:
        counts.update(tally.counts)
        for name, spread in tally.spreads.items():
            spreads.setdefault(name, []).append(spread)
    return Tally(dict(counts), {name: Spread.merged(own) for name, own in spreads.items()})


def success(rows: pd.DataFrame) -> pd.Series[bool]:
    """Whether the check found the attempt's answer right."""
    return rows["verdict"].isin(SUCCESSES)


def tally(rows: pd.DataFrame) -> Tally:
    """Count rows: the columns of `report.data.reduction.NEEDED`, index 0, 1, ..."""
    counts: Counter[Count] = Counter({("attempts",): len(rows)})
    for column in ("verdict", "outcome"):
        counts.update(_counted(rows[column], column))
    for column in ("false_claim", "wrong_basin"):
        counts[column,] = int(rows[column].sum())
    _count_failures(counts, rows[~success(rows)])
    spreads = {"wall_s": Spread.of(rows["wall_s"])}
    cold = rows[rows["initial_guess"] == "cold"]
    spreads |= {f"cold {name}": Spread.of(cold[name]) for name in TIMES}
    for column in ("jobs", "threads"):
        counts.update(_counted(rows[column].dropna().astype(int), column))
    asked = rows[_answerable(rows)]
    counts.update(_counted(asked["region"], "answerable"))
    gaps = asked["gap"].fillna(np.inf).clip(lower=0)
    for region in {key[1] for key in counts if key[0] == "answerable"}:
        there = asked["region"].isna() if region is None else asked["region"] == region
        spreads[f"gap {region}"] = Spread.of(gaps[there])
    _certified(rows, counts, spreads)
    return Tally({kind: n for kind, n in counts.items() if n}, spreads)


def _counted(column: pd.Series, kind: str) -> dict[Count, int]:
    found: dict[Any, int] = column.value_counts(dropna=False).to_dict()
    return {(kind, _text(value)): int(n) for value, n in found.items()}


def _text(value: Any) -> str | None:
    return None if pd.isna(value) else str(value)


def gist(message: str) -> str:
    """A message without its numbers and repetitions, so that like messages count as one."""
    parts = [re.sub(r"\d[\d.]*(?:[eE][+-]?\d+)?", "#", part) for part in message.split("; ")]
    return "; ".join(dict.fromkeys(parts))[:160]


def _count_failures(counts: Counter[Count], bad: pd.DataFrame) -> None:
    """Attempts without success by outcome, claim, verdict and the gist of what was said."""
    keys = ["outcome", "claim", "verdict", "message", "native_status"]
    found: dict[Any, int] = bad[keys].astype(object).groupby(keys, dropna=False).size().to_dict()
    for values, number in found.items():
        *kind, message, status = map(_text, values)
        counts["failure", *kind, gist(message or status or "")] += int(number)


def _answerable(rows: pd.DataFrame) -> pd.Series[bool]:
    """Whether an attempt's question has an answer, so that its gap can be measured.

    A row names the shortest word unless there is none; of one that was never judged, the closed
    form tells.
    """
    known = rows["reference_word"].notna()
    for index in rows.index[~known & rows["region"].isna()]:
        row = rows.loc[index]
        scenario = Scenario(**{str(name): row[name] for name in COLUMNS})
        known[index] = shortest(scenario, row["branch"]) is not None
    return known


def proof(rows: pd.DataFrame) -> pd.Series:
    """How far each attempt's proof goes; `none` of a process that did not come back."""
    said = rows["proof"].astype(object)
    return said.where(said.isin(PROOFS), "none")


def compared(rows: pd.DataFrame) -> pd.Series[bool]:
    """Whether an answer's multipliers can be compared with the costates of its own path.

    Only an extremal that arrives has costates to compare with: what a solver reports of a path
    that does not is a proof of infeasibility at best. A single arc has a whole family of them,
    which nothing but nu3 = 0 at its end and H = 0 ties.
    """
    arrived = rows["gap"].notna() & rows["costate_error"].notna()
    tied = ~rows["word"].isin(["L", "R"]) & (rows["pmp_residual"] <= PMP_TOLERANCE)
    return arrived & tied


def widths(rows: pd.DataFrame) -> pd.Series:
    """Width of the proven interval around each attempt's reference length, relative to its end.

    Lengths of zero are left out: they have no width to speak of.
    """
    high, low = rows["reference_high"], rows["reference_low"]
    known = high.notna() & low.notna() & (high > 0)
    width: pd.Series = ((high - low) / high)[known].astype(np.float64)
    return width


def _certified(rows: pd.DataFrame, counts: Counter[Count], spreads: dict[str, Spread]) -> None:
    counts["certified",] = int(rows["proof"].notna().sum())
    counts.update(_counted(proof(rows), "proof"))
    counts["bounds",] = int(rows["lower_bound"].notna().sum())
    counts["false_bounds",] = int(rows["false_bound"].eq(True).sum())
    right = rows[success(rows)]
    spreads["pmp_residual"] = Spread.of(right["pmp_residual"])
    spreads["cut_margin"] = Spread.of(right.loc[right["branch"] == "best", "cut_margin"])
    spreads["costate_error"] = Spread.of(rows.loc[compared(rows), "costate_error"])
    spreads["width"] = Spread.of(widths(rows))

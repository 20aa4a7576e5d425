"""Explain a printed cell: the ways to print a row, and the rule that selects a verdict.

A cell is a *correct rounding* if it is within half a unit of its last digit of the exact value.
Otherwise the cell is compared with the row that each of these accidents would print:

* *double rounding*: the exact value rounded (half up) to more places, then to the printed ones;
* *truncated*: the exact value cut off at the printed places;
* *solver bias reproduced*: the value that model (4.12) gives with Ipopt's last barrier parameter
  (`report.paper.exact.biased`), rounded or cut off.

If several accidents give the cell, the verdict is the one that gives most of the row's four cells
(the printed 0 of the missing turn is one of the four), and among equals the first in the list. If
no accident gives the cell, it is *wrong*. The reason names the cells of the row that the accident
does not give.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from typing import NamedTuple

from flint import arb

from dubins_study.report.paper.exact import (
    decide,
    places_of,
    rounded,
    rounded_twice,
    truncated,
)
from dubins_study.report.paper.printed import CORRECT, QUANTITIES

DOUBLE, CUT, BIAS, WRONG = "double rounding", "truncated", "solver bias reproduced", "wrong"
VERDICTS = (CORRECT, DOUBLE, CUT, BIAS, WRONG)
_MOST_PLACES = 15  # decimals; a double has no more digits
Row = Sequence[Decimal]


class Finding(NamedTuple):
    """A verdict and its reason."""

    verdict: str
    reason: str


class Accident(NamedTuple):
    """One way to print a row: its verdict, its description, and the printed row."""

    verdict: str
    how: str
    row: Row


def judge(printed: Sequence[str], exact: Sequence[arb], biased: Sequence[arb]) -> list[Finding]:
    """A verdict for each of a row's four cells, in the order of `QUANTITIES`."""
    accidents = _accidents(places_of(printed[-1]), exact, biased)
    return [_finding(i, printed, exact, accidents) for i in range(len(printed))]


def rounded_row(values: Sequence[arb], places: int) -> list[Decimal]:
    """A row correctly rounded."""
    return [decide(value, lambda v: rounded(v, places)) for value in values]


def _twice(values: Sequence[arb], first: int, places: int) -> Row:
    return [decide(value, lambda v: rounded_twice(v, first, places)) for value in values]


def _accidents(places: int, exact: Sequence[arb], biased: Sequence[arb]) -> list[Accident]:
    twice = [
        Accident(DOUBLE, str(first), _twice(exact, first, places))
        for first in range(places + 1, _MOST_PLACES + 1)
    ]
    cut = [[decide(x, lambda v: truncated(v, places)) for x in row] for row in (exact, biased)]
    return [
        *twice,
        Accident(CUT, "cut off", cut[0]),
        Accident(BIAS, "rounded", rounded_row(biased, places)),
        Accident(BIAS, "cut off", cut[1]),
    ]


def _finding(
    i: int, printed: Sequence[str], exact: Sequence[arb], accidents: Sequence[Accident]
) -> Finding:
    cell, places = Decimal(printed[i]), places_of(printed[-1])
    right = decide(exact[i], lambda v: rounded(v, places))
    if cell == right:
        return Finding(CORRECT, "")
    fitting = [accident for accident in accidents if accident.row[i] == cell]
    if not fitting:
        units = abs(cell - right).scaleb(places)
        return Finding(WRONG, f"rounds to {right}: {units:.0f} off in the last digit")
    best = max(fitting, key=lambda accident: _score(accident.row, printed))
    others = [a for a in fitting if a.verdict != best.verdict and a.verdict != DOUBLE]
    ways = [a.how for a in fitting if (a.verdict, a.row) == (best.verdict, best.row)]
    clauses = [
        f"rounds to {right}; {_description(best, ways)} it gives {cell}{_mismatches(best, printed)}"
    ]
    clauses += [
        f"{_description(other, [other.how])} too{_mismatches(other, printed)}" for other in others
    ]
    return Finding(best.verdict, "; ".join(clauses))


def _description(accident: Accident, ways: Sequence[str]) -> str:
    """An accident in words; `ways` are the roundings that give the same row."""
    how = " or ".join((", ".join(ways[:-1]), ways[-1])) if len(ways) > 1 else ways[0]
    how = f"rounded first to {how} decimals" if accident.verdict == DOUBLE else how
    return f"with an interior-point solver's bias, {how}," if accident.verdict == BIAS else how


def _score(row: Row, printed: Sequence[str]) -> int:
    return sum(value == Decimal(text) for value, text in zip(row, printed, strict=True))


def _mismatches(accident: Accident, printed: Sequence[str]) -> str:
    """The row's cells that an accident does not give."""
    off = [
        f"{quantity} = {value} (printed {text})"
        for quantity, value, text in zip(QUANTITIES, accident.row, printed, strict=True)
        if value != Decimal(text)
    ]
    return f", but in the same row {', '.join(off)}" if off else ", and all of its row"

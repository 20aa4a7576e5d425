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

from collections.abc import Callable, Sequence
from decimal import Decimal
from functools import partial
from typing import NamedTuple

from flint import arb

from dubins_study.report.paper.exact import decide, places_of, rounded, truncated
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


def printed_row(values: Sequence[arb], rule: Callable[[Decimal], Decimal]) -> list[Decimal]:
    """A row as a rule prints its exact values."""
    return [decide(value, rule) for value in values]


def _twice(first: int, places: int, value: Decimal) -> Decimal:
    return rounded(rounded(value, first), places)


def _accidents(places: int, exact: Sequence[arb], biased: Sequence[arb]) -> list[Accident]:
    nearest, cut = partial(rounded, places=places), partial(truncated, places=places)
    twice = [
        Accident(DOUBLE, str(first), printed_row(exact, partial(_twice, first, places)))
        for first in range(places + 1, _MOST_PLACES + 1)
    ]
    return [
        *twice,
        Accident(CUT, "cut off", printed_row(exact, cut)),
        Accident(BIAS, "rounded", printed_row(biased, nearest)),
        Accident(BIAS, "cut off", printed_row(biased, cut)),
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
    best = min(fitting, key=lambda accident: len(_mismatches(accident, printed)))
    others = [a for a in fitting if a.verdict != best.verdict and a.verdict != DOUBLE]
    ways = [a.how for a in fitting if (a.verdict, a.row) == (best.verdict, best.row)]
    first = f"rounds to {right}; {_description(best, ways)} it gives {cell}{_rest(best, printed)}"
    more = [f"{_description(a, [a.how])} too{_rest(a, printed)}" for a in others]
    return Finding(best.verdict, "; ".join([first, *more]))


def _description(accident: Accident, ways: Sequence[str]) -> str:
    """An accident in words; `ways` are the roundings that give the same row."""
    how = " or ".join((", ".join(ways[:-1]), ways[-1])) if len(ways) > 1 else ways[0]
    how = f"rounded first to {how} decimals" if accident.verdict == DOUBLE else how
    return f"with an interior-point solver's bias, {how}," if accident.verdict == BIAS else how


def _mismatches(accident: Accident, printed: Sequence[str]) -> list[str]:
    """The row's cells that an accident does not give."""
    return [
        f"{quantity} = {value} (printed {text})"
        for quantity, value, text in zip(QUANTITIES, accident.row, printed, strict=True)
        if value != Decimal(text)
    ]


def _rest(accident: Accident, printed: Sequence[str]) -> str:
    off = _mismatches(accident, printed)
    return f", but in the same row {', '.join(off)}" if off else ", and all of its row"

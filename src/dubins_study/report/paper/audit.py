"""The audit of the paper: recompute every printed length.

`audit` returns one record of plain values. It is the same on every machine, since every number is
proven to its last digit before it is rounded. `contradictions` compares it with the committed one.

A cell is a *correct rounding* if it is within half a unit of its last digit of the exact value.
Otherwise it is compared with what each of these accidents would print:

* *double rounding*: the exact value rounded (half up) to more places, then to the printed ones;
* *truncated*: the exact value cut off at the printed places;
* *solver bias reproduced*: the value that model (4.12) gives with Ipopt's last barrier parameter
  (`report.paper.exact.biased`), rounded or cut off.

If several accidents give the cell, the verdict is the one that gives most of the row's four cells
(the printed 0 of the missing turn is one of the four), and among equals the first in the list. If
no accident gives the cell, it is *wrong*.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from decimal import Decimal
from difflib import unified_diff
from fractions import Fraction
from itertools import chain, product
from typing import NamedTuple

from flint import arb, ctx

from dubins_study.report.paper.exact import (
    WORKING,
    Pieces,
    ball,
    biased,
    half_unit,
    heading,
    left_straight,
    miss,
    pieces,
    positive,
    rounded,
    rounded_twice,
    target,
    text,
    truncated,
)
from dubins_study.report.paper.printed import (
    CORRECT,
    NUMBERS,
    PRINTED,
    PROBLEMS,
    QUANTITIES,
    WORDS,
    PrintedRow,
    Problem,
    Record,
)
from dubins_study.study.check.enclosure import right_left_solutions

DOUBLE = "double rounding"
CUT = "truncated"
BIAS = "solver bias reproduced"
WRONG = "wrong"
_PLACES = 2  # decimals of a printed length
_MOST_PLACES = 15  # decimals; a double has no more digits


def audit() -> Record:
    """The whole audit as a record of four lists.

    Returns:
        Lengths are in the scenario's unit.

        cells: a record per printed length: table, label, path, word, quantity, printed, exact (to
            40 digits), difference (printed - exact), verdict.
        paths: a record per printed row: the miss when driven, and the miss that correct rounding
            allows.
        algorithm: a record per test problem: the radius at which the target enters a turning
            circle, and the path that Algorithm 1 returns for larger radii.
        statements: a record per statement of the paper: where, says, holds, finding.
    """
    with ctx.workdps(WORKING):
        return {
            "cells": list(chain.from_iterable(map(_cells, PRINTED))),
            "paths": [_path(row) for row in PRINTED],
            "algorithm": _algorithm(),
            "statements": _statements(),
        }


def _cells(row: PrintedRow) -> Iterator[Record]:
    """Yield a record for each length of a row.

    The printed 0 of the missing turn has no record.
    """
    problem = PROBLEMS[row.label]
    exact = _with_total(pieces(problem, row.word))
    accidents = _accidents(exact, _with_total(biased(problem, row.word)))
    for place, printed in enumerate(row.cells):
        if printed == "0":
            continue
        verdict = CORRECT
        if rounded(exact[place], _PLACES) != Decimal(printed):
            verdict = _accident_of(place, row, accidents)
        yield row.record() | {
            "quantity": QUANTITIES[place],
            "printed": printed,
            "exact": text(exact[place]),
            "difference": float(ball(Decimal(printed)) - exact[place]),
            "verdict": verdict,
        }


def _with_total(z: Pieces) -> list[arb]:
    """The values z1, z2, z3, and f, their sum."""
    return [*z, z[0] + z[1] + z[2]]


class Accident(NamedTuple):
    """One way to print a row: verdict and cells."""

    verdict: str
    row: list[Decimal]


def _accidents(exact: Sequence[arb], bias: Sequence[arb]) -> list[Accident]:
    """The accidents that are tried, the preferred ones first."""
    twice = [
        Accident(DOUBLE, [rounded_twice(value, first, _PLACES) for value in exact])
        for first in range(_PLACES + 1, _MOST_PLACES + 1)
    ]
    return [
        *twice,
        Accident(CUT, [truncated(value, _PLACES) for value in exact]),
        Accident(BIAS, [rounded(value, _PLACES) for value in bias]),
        Accident(BIAS, [truncated(value, _PLACES) for value in bias]),
    ]


def _accident_of(place: int, row: PrintedRow, accidents: Sequence[Accident]) -> str:
    """The verdict on a cell that is wrongly rounded.

    `place` is the cell's number in the row.
    """
    printed = [Decimal(cell) for cell in row.cells]

    def cells_given(accident: Accident) -> int:
        return sum(map(Decimal.__eq__, accident.row, printed))

    fitting = [accident for accident in accidents if accident.row[place] == printed[place]]
    if not fitting:
        return WRONG
    return max(fitting, key=cells_given).verdict


def _path(row: PrintedRow) -> Record:
    """A record of the printed path, driven exactly.

    `rounding_allows` is the largest miss of the exact path with each of its parts rounded by up to
    half a unit. For a fixed turn the miss is convex in the straight. Along the turn it grows with
    the distance from the best angle. So it is largest at a corner of the box.
    """
    problem = PROBLEMS[row.label]
    printed = [ball(Decimal(cell)) for cell in row.cells[:3]]
    half = half_unit(_PLACES)
    ends = []
    for part in pieces(problem, row.word):
        if part == 0:
            ends.append([part])
        else:
            ends.append([part - half, part + half])
    return row.record() | {
        "miss": float(miss(problem, printed)),
        "rounding_allows": max(float(miss(problem, corner)) for corner in product(*ends)),
    }


def _algorithm() -> list[Record]:
    """A record of Algorithm 1 for each test problem.

    A turning circle passes through the target at the radius R* = r^2 / (2 |Y|). Here r is the
    target's distance and Y its offset from the start's heading line. For larger radii the optimum
    begins with a turn away from the target (RL in the left disc, LR in the right disc). Of the
    algorithm's two words, only the one that begins with this turn then exists. The unsplit model
    (4.12) contains LR too, so it is right in the right disc, but it does not contain RL.
    """
    positions = {problem.position: problem for problem in PROBLEMS.values()}
    return [_crossing(position, problem) for position, problem in positions.items()]


def _crossing(position: str, problem: Problem) -> Record:
    """A record of lengths just beyond the radius R*.

    The right circle is computed as the left one of the mirror image.
    """
    at = target(problem, arb(1))
    left = positive(at.imag)
    circle = abs(at) ** 2 / (2 * abs(at.imag))
    near = target(problem, circle)
    circle_side = "left"
    word_beyond = "RL"
    algorithm_word = "RS"
    if not left:
        near = near.conjugate()
        circle_side = "right"
        word_beyond = "LR"
        algorithm_word = "LS"
    ((optimum,), _) = right_left_solutions(near.real, near.imag, inside=True)
    turn, straight = left_straight(near.conjugate())
    returned = turn + straight
    return {
        "label": position,
        "circle": circle_side,
        "radius": text(circle),
        "word_beyond": word_beyond,
        "length_beyond": float(optimum * circle),
        "algorithm_word": algorithm_word,
        "algorithm_length": float(returned * circle),
        "algorithm_excess": float(returned / optimum - 1),
    }


def _statements() -> list[Record]:
    """A record for each statement of the paper.

    The statements are checked on the paper's scenarios. A record has the keys where, says, holds,
    finding. That the exact LS and RS meet (4.10) and (4.11) is asserted for each of them in
    `pieces`.
    """
    turns: list[arb] = []  # left turn minus right turn of each LS and RS, rad
    ends: list[arb] = []  # final headings, not wrapped
    ratios: list[float] = []  # the longer of LS and RS by the shorter
    for problem in PROBLEMS.values():
        solutions = [pieces(problem, word) for word in WORDS]
        lengths = [z[0] + z[1] + z[2] for z in solutions]
        ratios.append(float(max(lengths) / min(lengths)))
        turned = [(z[0] - z[1]) / problem.radius for z in solutions]
        turns += turned
        ends += [heading(problem) + turn for turn in turned]
    # With nu0 = 1, (nu1, nu2) = -(cos, sin) of the end, nu3 from (2.10) and zero on the straight, H
    # (2.9) is zero at the start of each LS and RS; the control law (2.14) asks for nu3 and the turn
    # rate of opposite sign.
    qualify = [turn for turn in turns if positive(1 - turn.cos())]
    # phi = end + pi, and an arctangent lies where the cosine is positive
    wrong_quadrant = [end for end in ends if positive(end.cos())]
    inside = [end for end in ends if positive(end) and positive(2 * arb.pi() - end)]
    crossings = _algorithm()
    left = [crossing for crossing in crossings if crossing["circle"] == "left"]
    times: list[str] = []
    for scenario in NUMBERS["scenarios"]:
        times += scenario.get("times", {}).values()
    numbers = {
        "scenarios": len(PROBLEMS),
        "paths": len(ends),
        "algorithm_excess": _range(crossings),
        "right": len(crossings) - len(left),
        "left": len(left),
        "model_excess": _range(left),
        "qualify": len(qualify),
        "longest": max(ratios),
        "off": len(wrong_quadrant),
        "outside": len(ends) - len(inside),
        "times": len(times),
        "ticks": sum(_is_ticks(time) for time in times),
    }
    return [
        statement | {"finding": statement["finding"].format(**numbers)}
        for statement in NUMBERS["statements"]
    ]


def _range(crossings: list[Record]) -> str:
    percent = [100 * crossing["algorithm_excess"] for crossing in crossings]
    return f"{min(percent):.1f} % to {max(percent):.1f} %"


def _is_ticks(printed: str) -> bool:
    """Whether a printed time is whole clock ticks.

    The clock has 64 ticks a second; the time is rounded to 3 decimals.
    """
    ticks = round(Decimal(printed) * 64)
    return rounded(ball(Fraction(ticks, 64)), 3) == Decimal(printed)


def contradictions(computed: Record, committed: Record) -> list[str]:
    """Lines of a unified diff between two audits.

    There are none if the computed audit equals the committed one.
    """
    ours = json.dumps(computed, indent=1, ensure_ascii=False).splitlines()
    theirs = json.dumps(committed, indent=1, ensure_ascii=False).splitlines()
    return [*unified_diff(theirs, ours, "committed", "computed", n=7, lineterm="")]

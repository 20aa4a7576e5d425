"""The audit of the paper: every printed number is recomputed and judged.

`audit` returns one object of plain values. It is the same on every machine, since every number is
proven to its last digit before it is rounded. `contradictions` compares it with the committed one.

A cell is a *correct rounding* if it is within half a unit of its last digit of the exact value.
Otherwise it is compared with the row that each of these accidents would print:

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

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from decimal import Decimal
from difflib import unified_diff
from fractions import Fraction
from itertools import product
from typing import Any, NamedTuple

from flint import arb, ctx

from dubins_study.report.paper.audit_claims import algorithm, statements
from dubins_study.report.paper.exact import (
    NIL,
    WORKING,
    Pieces,
    ball,
    biased,
    half_unit,
    ipopt_barrier,
    miss,
    pieces,
    places_of,
    rounded,
    rounded_twice,
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
)

Record = dict[str, Any]
DOUBLE, CUT, BIAS, WRONG = "double rounding", "truncated", "solver bias reproduced", "wrong"
VERDICTS = (CORRECT, DOUBLE, CUT, BIAS, WRONG)
_MOST_PLACES = 15  # decimals; a double has no more digits


def audit() -> Record:
    """The whole audit; lengths in the scenario's unit.

    `cells` (one record per printed length: table, label, path, word, quantity, printed, exact to
    40 digits, difference = printed - exact, biased, bias_prints, verdict, reason), `paths` (one per
    printed row: the miss when driven, the miss that correct rounding allows, whether its parts add
    up), `algorithm` (one per test problem: the radius at which the target enters a turning circle,
    and the path that Algorithm 1 returns for larger radii), `omitted` (paths that the tables leave
    out), `times`, `statements` and `summary`.
    """
    with ctx.workdps(WORKING):
        parts = {
            "cells": [cell for row in PRINTED for cell in _cells(row)],
            "paths": [_path(row) for row in PRINTED],
            "algorithm": algorithm(),
            "omitted": _omitted(),
            "times": [*_times()],
            "statements": statements(),
        }
    return parts | {"summary": _summary(parts)}


def _with_total(z: Pieces) -> list[arb]:
    return [*z, z[0] + z[1] + z[2]]


def _exact(problem: Problem, word: str) -> list[arb]:
    """z1, z2, z3 and f of a word; asserts that it arrives."""
    z = pieces(problem, word)
    assert miss(problem, z) < ball(NIL), f"{problem.label}, {word} does not arrive"
    return _with_total(z)


def _cells(row: PrintedRow) -> Iterator[Record]:
    """The printed lengths of a row; the zero of its missing turn is none."""
    problem = PROBLEMS[row.label]
    places = places_of(row.cells[-1])
    exact = _exact(problem, row.word)
    bias = _with_total(biased(problem, row.word, ipopt_barrier()))
    right = [rounded(value, places) for value in exact]
    accidents = _accidents(places, exact, bias)
    longest_printed = ball(Decimal(row.cells[-1])) + half_unit(places)
    too_short = row.path == "optimal" and longest_printed < exact[-1]
    for i, cell in enumerate(row.cells):
        if cell == "0":
            continue
        verdict, reason = _judged(i, row.cells, right[i], accidents)
        if QUANTITIES[i] == "f" and too_short:
            reason += "; no path is that short"
        yield row.record() | {
            "quantity": QUANTITIES[i],
            "printed": cell,
            "exact": text(exact[i]),
            "difference": float(ball(Decimal(cell)) - exact[i]),
            "biased": text(bias[i], 10),
            "bias_prints": str(rounded(bias[i], places)),
            "verdict": verdict,
            "reason": reason,
        }


class Accident(NamedTuple):
    """One way to print a row: its verdict, its description, and the printed row."""

    verdict: str
    how: str
    row: tuple[Decimal, ...]


def _accidents(places: int, exact: Sequence[arb], bias: Sequence[arb]) -> list[Accident]:
    first_places: dict[tuple[Decimal, ...], list[str]] = {}  # of each row that they give
    for first in range(places + 1, _MOST_PLACES + 1):
        row = tuple(rounded_twice(value, first, places) for value in exact)
        first_places.setdefault(row, []).append(str(first))
    twice = [
        Accident(DOUBLE, f"rounded first to {_listed(each)} decimals", row)
        for row, each in first_places.items()
    ]
    cut = tuple(truncated(value, places) for value in exact)
    bias_rounded = tuple(rounded(value, places) for value in bias)
    bias_cut = tuple(truncated(value, places) for value in bias)
    solver = "with an interior-point solver's bias"
    return [
        *twice,
        Accident(CUT, "cut off", cut),
        Accident(BIAS, f"{solver}, rounded,", bias_rounded),
        Accident(BIAS, f"{solver}, cut off,", bias_cut),
    ]


def _listed(numbers: Sequence[str]) -> str:
    """Numbers in words: `3, 4 or 5`."""
    *first, last = numbers
    return f"{', '.join(first)} or {last}" if first else last


def _judged(
    i: int, printed: Sequence[str], right: Decimal, accidents: Sequence[Accident]
) -> tuple[str, str]:
    """The verdict on a cell of a row, and its reason."""
    cell = Decimal(printed[i])
    if cell == right:
        return CORRECT, ""
    fitting = [accident for accident in accidents if accident.row[i] == cell]
    if not fitting:
        units = abs(cell - right).scaleb(places_of(printed[i]))
        return WRONG, f"rounds to {right}: {units:.0f} off in the last digit"
    best = min(fitting, key=lambda accident: len(_mismatches(accident, printed)))
    parts = [f"rounds to {right}", f"{best.how} it gives {cell}{_rest(best, printed)}"]
    others = [each for each in fitting if each.verdict not in (best.verdict, DOUBLE)]
    parts += [f"{other.how} too{_rest(other, printed)}" for other in others]
    return best.verdict, "; ".join(parts)


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


def _path(row: PrintedRow) -> Record:
    """Drive the printed path from the exact start, and add its parts up."""
    problem = PROBLEMS[row.label]
    places = places_of(row.cells[-1])
    exact = _exact(problem, row.word)
    z1, z2, z3, total = map(Decimal, row.cells)
    right = [rounded(value, places) for value in exact]
    return row.record() | {
        "miss": float(miss(problem, (ball(z1), ball(z2), ball(z3)))),
        "rounding_allows": _allowed(problem, exact[:3], places),
        "sum_of_parts": str(z1 + z2 + z3),
        "total": row.cells[-1],
        "adds_up": z1 + z2 + z3 == total,
        "correct_parts_add_up": sum(right[:3]) == right[3],
        "rank_is_right": _rank(problem, row.word) == row.path,
    }


def _allowed(problem: Problem, z: Sequence[arb], places: int) -> float:
    """The largest miss of a path if each of its parts is rounded by up to half a unit.

    For a fixed turn the miss is convex in the straight, and along the turn it grows with the
    distance from the best angle, so it is largest at a corner of the box.
    """
    half = half_unit(places)
    ends = [(part,) if part == 0 else (part - half, part + half) for part in z]
    return max(float(miss(problem, (a, b, c))) for a, b, c in product(*ends))


def _omitted() -> list[Record]:
    """Paths of the paper's scenarios that have no row in its tables."""
    printed = {(row.label, row.word) for row in PRINTED}
    records = []
    for problem, word in product(PROBLEMS.values(), WORDS):
        if (problem.label, word) not in printed:
            named = {"label": problem.label, "path": _rank(problem, word), "word": word}
            values = map(text, _exact(problem, word))
            records.append(named | dict(zip(QUANTITIES, values, strict=True)))
    return records


def _rank(problem: Problem, word: str) -> str:
    """`optimal` for the shorter of LS and RS, `feasible` for the longer."""
    lengths = {each: _exact(problem, each)[-1] for each in WORDS}
    other = "LS" if word == "RS" else "RS"
    return "optimal" if lengths[word] < lengths[other] else "feasible"


def _times() -> Iterator[Record]:
    """Each printed solve time, in ticks of a clock with 64 ticks per second."""
    for scenario in NUMBERS["scenarios"]:
        for path, printed in scenario.get("times", {}).items():
            ticks = round(Decimal(printed) * 64)
            told = rounded(ball(Fraction(ticks, 64)), places_of(printed))
            yield {
                "label": scenario["label"],
                "path": path,
                "printed": printed,
                "ticks": ticks,
                "is_ticks": told == Decimal(printed),
            }


def _summary(parts: Record) -> Record:
    cells = parts["cells"]
    paths = parts["paths"]
    verdicts = Counter(cell["verdict"] for cell in cells)
    spoilt = [c for c in cells if c["verdict"] == CORRECT and c["bias_prints"] != c["printed"]]
    return {
        "cells": len(cells),
        "verdicts": {verdict: verdicts[verdict] for verdict in VERDICTS},
        "correct_cells_that_the_bias_would_spoil": len(spoilt),
        "totals_that_do_not_add_up": sum(not path["adds_up"] for path in paths),
        "paths_beyond_rounding": sum(path["miss"] > path["rounding_allows"] for path in paths),
        "omitted_paths": len(parts["omitted"]),
        "times_that_are_ticks": sum(time["is_ticks"] for time in parts["times"]),
    }


def contradictions(computed: Record, committed: Record) -> list[str]:
    """What the code and the committed audit differ in, as lines of a unified diff."""
    ours = json.dumps(computed, indent=1, ensure_ascii=False).splitlines()
    theirs = json.dumps(committed, indent=1, ensure_ascii=False).splitlines()
    return [*unified_diff(theirs, ours, "committed", "computed", n=7, lineterm="")]

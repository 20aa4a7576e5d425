"""The audit of the paper: every printed number is recomputed and judged.

`audit` returns one object of plain values. It is the same on every machine, since every number is
proven to its last digit before it is rounded. `contradictions` compares it with the committed one.
"""

from __future__ import annotations

from collections import Counter
from decimal import Decimal
from itertools import product
from typing import Any

from flint import arb, ctx

from dubins_study.report.paper import audit_rules as rules
from dubins_study.report.paper.audit_claims import algorithm, statements
from dubins_study.report.paper.exact import (
    NIL,
    WORKING,
    ball,
    biased,
    decide,
    distance,
    half_unit,
    ipopt_barrier,
    offset,
    pieces,
    places_of,
    rounded,
    text,
)
from dubins_study.report.paper.printed import (
    CORRECT,
    PRINTED,
    PROBLEMS,
    QUANTITIES,
    TIMES,
    PrintedRow,
    Problem,
    segments,
)
from dubins_study.study.angle import parse_angle
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.scenario import Scenario

Record = dict[str, Any]
_WORDS = ("LS", "RS")
_AGREES = 1e-13  # relative to max(length, radius); about a hundred roundings of a double


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
        mu = ipopt_barrier()
        cells = [cell for row in PRINTED for cell in _cells(row, mu)]
        paths = [_path(row) for row in PRINTED]
        parts = {
            "cells": cells,
            "paths": paths,
            "algorithm": algorithm(),
            "omitted": _omitted(),
            "times": _times(),
            "statements": statements(),
        }
    return parts | {"summary": _summary(parts)}


def _exact(problem: Problem, word: str) -> list[arb]:
    """z1, z2, z3 and f of a word; asserts that it arrives."""
    z = pieces(problem, word)
    for side in offset(problem, z):
        assert abs(side) < ball(NIL), f"{problem.label}, {word} does not arrive"
    return [*z, z[0] + z[1] + z[2]]


def _cells(row: PrintedRow, mu: arb) -> list[Record]:
    problem = PROBLEMS[row.label]
    exact = _exact(problem, row.word)
    z = biased(problem, row.word, mu)
    with_bias = [*z, z[0] + z[1] + z[2]]
    records = []
    places = places_of(row.cells[-1])
    findings = rules.judge(row.cells, exact, with_bias)
    total = ball(Decimal(row.cells[3])) + ball(half_unit(places))
    too_short = row.path == "optimal" and total < exact[3]
    for quantity, cell, value, biased_value, finding in zip(
        QUANTITIES, row.cells, exact, with_bias, findings, strict=True
    ):
        if cell == "0":
            continue
        derived = {
            "quantity": quantity,
            "printed": cell,
            "exact": text(value),
            "difference": float(ball(Decimal(cell)) - value),
            "biased": text(biased_value, 10),
            "bias_prints": str(decide(biased_value, lambda v: rounded(v, places))),
            "verdict": finding.verdict,
            "reason": finding.reason
            + ("; no path is that short" if quantity == "f" and too_short else ""),
        }
        records.append(row.record() | derived)
    return records


def _path(row: PrintedRow) -> Record:
    """Drive the printed path from the exact start, and add its parts up."""
    problem = PROBLEMS[row.label]
    exact = _exact(problem, row.word)
    places = places_of(row.cells[-1])
    printed = [Decimal(cell) for cell in row.cells]
    z1, z2, z3 = map(ball, printed[:3])
    miss = distance(offset(problem, (z1, z2, z3)))
    correct = rules.printed_row(exact, lambda value: rounded(value, places))
    return row.record() | {
        "miss": float(miss),
        "rounding_allows": _allowed(problem, exact[:3], places),
        "sum_of_parts": str(sum(printed[:3])),
        "total": row.cells[-1],
        "adds_up": sum(printed[:3]) == printed[3],
        "correct_parts_add_up": sum(correct[:3]) == correct[3],
        "rank_is_right": _rank(problem, row.word) == row.path,
    }


def _allowed(problem: Problem, z: list[arb], places: int) -> float:
    """The largest miss of a path if each of its parts is rounded by up to half a unit.

    For a fixed turn the miss is convex in the straight, and along the turn it grows with the
    distance from the best angle, so it is largest at a corner of the box.
    """
    half = ball(half_unit(places))
    corners = product(*((v,) if v == 0 else (v - half, v + half) for v in z))
    return max(float(distance(offset(problem, (a, b, c)))) for a, b, c in corners)


def _omitted() -> list[Record]:
    """Paths of the paper's scenarios that have no row in its tables."""
    printed = {(row.label, row.word) for row in PRINTED}
    records = []
    for problem, word in product(PROBLEMS.values(), _WORDS):
        if (problem.label, word) in printed:
            continue
        exact = _exact(problem, word)
        values = {q: text(value) for q, value in zip(QUANTITIES, exact, strict=True)}
        path = _rank(problem, word)
        records.append({"label": problem.label, "path": path, "word": word, **values})
    return records


def _rank(problem: Problem, word: str) -> str:
    """`optimal` for the shorter of LS and RS, `feasible` for the longer."""
    words = (word, "LS" if word == "RS" else "RS")
    length, other = (_exact(problem, each)[3] for each in words)
    return "optimal" if length < other else "feasible"


def _times() -> list[Record]:
    """Each printed solve time, in ticks of a clock with 64 ticks per second."""
    records = []
    for label, path, printed in TIMES:
        ticks = round(Decimal(printed) * 64)
        is_ticks = rounded(Decimal(ticks) / 64, places_of(printed)) == Decimal(printed)
        record = {"label": label, "path": path, "printed": printed}
        records.append(record | {"ticks": ticks, "is_ticks": is_ticks})
    return records


def _summary(parts: Record) -> Record:
    verdicts = Counter(cell["verdict"] for cell in parts["cells"])
    return {
        "cells": len(parts["cells"]),
        "verdicts": {verdict: verdicts[verdict] for verdict in rules.VERDICTS},
        "correct_cells_that_the_bias_would_spoil": sum(
            cell["verdict"] == CORRECT and cell["bias_prints"] != cell["printed"]
            for cell in parts["cells"]
        ),
        "totals_that_do_not_add_up": sum(not path["adds_up"] for path in parts["paths"]),
        "paths_beyond_rounding": sum(p["miss"] > p["rounding_allows"] for p in parts["paths"]),
        "omitted_paths": len(parts["omitted"]),
        "times_that_are_ticks": sum(time["is_ticks"] for time in parts["times"]),
    }


def contradictions(computed: Record, committed: Record) -> list[str]:
    """The numbers on which the code and the committed audit differ, one line each."""
    return [*_differences(computed, committed), *closed_form_differences(committed)]


def _differences(computed: Any, committed: Any, where: str = "") -> list[str]:
    if isinstance(computed, dict) and isinstance(committed, dict):
        pairs = [
            (computed.get(key), committed.get(key), f"{where}{'.' if where else ''}{key}")
            for key in dict.fromkeys((*computed, *committed))
        ]
    elif isinstance(computed, list) and isinstance(committed, list):
        if len(computed) != len(committed):
            return [f"{where}: {len(computed)} computed, {len(committed)} committed"]
        pairs = [
            (ours, theirs, f"{where}[{_name(ours, i)}]")
            for i, (ours, theirs) in enumerate(zip(computed, committed, strict=True))
        ]
    else:
        same = computed == committed
        return [] if same else [f"{where}: computed {computed!r}, committed {committed!r}"]
    return [line for pair in pairs for line in _differences(*pair)]


def _name(record: Any, place: int) -> str:
    """A readable name for an entry of a list."""
    keys = ("table", "label", "path", "quantity", "where")
    named = [str(record[key]) for key in keys if key in record] if isinstance(record, dict) else []
    return ", ".join(named) or str(place)


def closed_form_differences(committed: Record) -> list[str]:
    """Cells whose committed value differs from that of `study.closed_form`."""
    lines = []
    for cell in committed.get("cells", ()):
        problem = PROBLEMS[cell["label"]]
        heading = parse_angle(f"{problem.heading.numerator}pi/{problem.heading.denominator}")
        scenario = Scenario(0, 0, heading, *problem.target, problem.radius)
        path = shortest_path(scenario, cell["word"])
        lengths = (None,) * 4 if path is None else segments(path, problem.radius)
        ours = lengths[QUANTITIES.index(cell["quantity"])]
        exact = float(cell["exact"])
        if ours is None or abs(ours - exact) > _AGREES * max(exact, problem.radius):
            where = f"cells[{_name(cell, 0)}]"
            lines.append(f"{where}: the closed form has {ours!r}, committed {cell['exact']}")
    return lines

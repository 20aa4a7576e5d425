"""Published lengths of routes beside proven intervals.

A proven interval holds the shortest length. The routes are the four examples of C. Y. Kaya,
Markov-Dubins interpolating curves, Computational Optimization and Applications 73 (2019) 647-677,
which the packaged experiment `kaya` holds. The lengths (in `printed.toml`) stand in the test
programs of icosac/MPDP, a solver by dynamic programming. Kaya's are `KayaLengths` in
`test/dubinsTest.cc`, and its own have thirty digits.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

from dubins_study.report.paper.printed import NUMBERS, Record
from dubins_study.study.check.verdict import words_of
from dubins_study.study.kinds.table import reference_of
from dubins_study.study.scenario import Scenario

SHORTEST = "shortest"
LONGER = "longer"
TOO_SHORT = "too short"


class PrintedRoute(NamedTuple):
    """A published length of a route, as printed.

    `expected` is the verdict that the audit should come to.
    """

    source: str
    label: str  # in the experiment `kaya`
    printed: str
    expected: str = SHORTEST


PRINTED_ROUTES = [PrintedRoute(**each) for each in NUMBERS["routes"]]


def audit_routes(scenarios: Iterable[Scenario]) -> list[Record]:
    """A record for each published length.

    It has the printed length, our length, the proven interval and the verdict.
    """
    routes = {scenario.label: scenario for scenario in scenarios}
    records = []
    for source, label, printed, expected in PRINTED_ROUTES:
        scenario = routes[label]
        enclosure, path, at = reference_of(scenario)
        assert path is not None
        assert enclosure.low is not None
        assert enclosure.high is not None
        finding = compared(printed, path.length, enclosure.low, enclosure.high)
        record = {
            "source": source,
            "label": label,
            "legs": scenario.legs,
            "printed": printed,
            "length": path.length,
            "low": float(enclosure.low),
            "high": float(enclosure.high),
            **finding,
            "expected": expected,
            "word": words_of(path, at, scenario.radius),
        }
        records.append(record)
    return records


def compared(printed: str, length: float, low: float | Fraction, high: float | Fraction) -> Record:
    """Compare a printed length with ours.

    The result has `difference` (printed - ours) and `verdict`. The numbers that round to the
    printed one form an interval. The verdict is `longer` if this interval lies above `high`, the
    length of a path that was found. It is `too short` if it lies below `low`, where no path is.
    Else it is `shortest`, up to the width of the proven interval.
    """
    value = Fraction(printed)
    half_unit = Fraction(1, 2 * 10 ** len(printed.partition(".")[2]))
    verdict = SHORTEST
    if value - half_unit > high:
        verdict = LONGER
    elif value + half_unit < low:
        verdict = TOO_SHORT
    return {"difference": float(value - Fraction(length)), "verdict": verdict}

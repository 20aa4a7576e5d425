"""Published lengths of routes beside proven intervals.

An interval is around the shortest length. The routes are the four examples of C. Y. Kaya,
Markov-Dubins interpolating curves, Computational Optimization and Applications 73 (2019) 647-677,
which the packaged experiment `kaya` holds. The lengths (in `printed.toml`) stand in the test
programs of icosac/MPDP, a solver by dynamic programming: Kaya's as `KayaLengths` in
`test/dubinsTest.cc`, and its own to thirty digits.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import Any, NamedTuple

from dubins_study.report.paper.printed import NUMBERS
from dubins_study.study.check.verdict import words_of
from dubins_study.study.kinds.table import reference_of
from dubins_study.study.scenario import Scenario

SHORTEST = "shortest"
LONGER = "longer"
TOO_SHORT = "too short"


class PrintedRoute(NamedTuple):
    """A published length of a route.

    It is as printed, with the verdict that the audit expects.
    """

    source: str
    label: str  # in the experiment `kaya`
    printed: str
    expected: str = SHORTEST


PRINTED_ROUTES = [PrintedRoute(**each) for each in NUMBERS["routes"]]


def audit_routes(scenarios: Iterable[Scenario]) -> list[dict[str, Any]]:
    """A record for each published length.

    Ours, the proven interval and the verdict.
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


def compared(
    printed: str, length: float, low: float | Fraction, high: float | Fraction
) -> dict[str, Any]:
    """Compare a printed length with ours.

    `difference` is how much longer it is; also its `verdict`. It is `longer` than the shortest if
    what could round to it lies above the interval from `low` to `high`, which ends at the length of
    a path that was found; `too short` if it lies below, where no path is; else `shortest`, up to
    the interval's width.
    """
    value = Fraction(printed)
    half_unit = Fraction(1, 2 * 10 ** len(printed.partition(".")[2]))
    verdict = SHORTEST
    if value - half_unit > high:
        verdict = LONGER
    elif value + half_unit < low:
        verdict = TOO_SHORT
    return {"difference": float(value - Fraction(length)), "verdict": verdict}

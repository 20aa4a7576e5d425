"""What a certificate costs: of a path, of a reference length, and of a frame's answers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from time import perf_counter

import pandas as pd

from benchmarks.harness import Measurement, Timing, side_by_side
from benchmarks.peers import random_frame
from dubins_study.solvers.analytic import Analytic
from dubins_study.study.check.certificate import certify
from dubins_study.study.check.certificate_frame import certify_frame
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.verdict import judge
from dubins_study.study.check.verdict_frame import judge_frame
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario, check_frame, scenarios

N = 1_000_000
SOME = 200  # scenarios that are certified one by one


def measure() -> Iterable[Measurement]:
    frame = check_frame(random_frame(N))
    some = list(scenarios(frame[:SOME]))
    paths = [shortest_path(scenario) for scenario in some]
    pairs = [(s, p) for s, p in zip(some, paths, strict=True) if p is not None]
    judged = [judge(scenario, path) for scenario, path in pairs]

    def certificates() -> object:
        # every enclosure is in its cache after the first round
        return [certify(*pair, found) for pair, found in zip(pairs, judged, strict=True)]

    times = side_by_side(
        {
            "certificate": certificates,
            "judging": _each(judge, pairs),
            "enclosure": _each(_enclosed, pairs),
        },
        repeats=9,
    )
    certificate, judging, enclosure = (times[key].least / len(pairs) * 1e6 for key in times)
    yield Measurement(
        "a certificate, beside the interval enclosure",
        ours=certificate,
        peer=enclosure,
        unit="µs/path",
        ratio=certificate,
        target=200.0,
        note=f"µs, the enclosure left out; judging takes {judging:.0f} µs more",
    )
    timing, rows = _frame(frame)
    yield Measurement(
        f"certificates of 10^{len(str(N)) - 1} closed-form answers in batch",
        ours=timing.least / N * 1e9,
        unit="ns/row",
        ratio=timing.least,
        target=5.0,
        note=f"seconds in all, enclosures left out; {rows} rows are extremals",
    )


def _enclosed(scenario: Scenario, path: Path) -> object:
    return enclose.__wrapped__(scenario, "best")  # what the cache holds would cost nothing


def _each(
    function: Callable[[Scenario, Path], object], pairs: list[tuple[Scenario, Path]]
) -> Callable[[], object]:
    return lambda: [function(scenario, path) for scenario, path in pairs]


def _frame(frame: pd.DataFrame) -> tuple[Timing, int]:
    solution = Analytic().solve_frame(frame, "best")
    judged = judge_frame(frame, solution.paths, solution.claim)
    seconds, rows = [], 0
    for _ in range(4):
        began = perf_counter()
        found = certify_frame(frame, solution.paths, judged, enclosures=False)
        seconds.append(perf_counter() - began)
        rows = int((found.proof == 2).sum())
    return Timing(sorted(seconds)[1], min(seconds)), rows

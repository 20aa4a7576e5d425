"""What a certificate costs: of a path, of a reference length, and of a frame's answers."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from time import perf_counter

import pandas as pd

from benchmarks.harness import Measurement, Timing, side_by_side, sized
from benchmarks.peers import random_frame
from dubins_study.solvers.analytic import Analytic
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.enclosure_kernel import bound_rows
from dubins_study.study.closed_form.kernel import ScenarioArrays
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.judging.certificate_frame import PROOFS, certify_frame
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.judging.verdict_frame import judge_frame
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import check_frame, scenarios
from dubins_study.study.words import Proof

N = sized(1_000_000, 1_000)
SOME = sized(200, 5)  # scenarios that are certified one by one


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
        note=f"seconds in all, enclosures included; {rows} rows are proved",
    )
    yield from _enclosures(frame)


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
        found = certify_frame(frame, solution.paths, judged)
        seconds.append(perf_counter() - began)
        rows = int((found.proof == PROOFS.index(Proof.PROVED)).sum())
    return Timing(sorted(seconds)[1], min(seconds)), rows


def _enclosures(frame: pd.DataFrame) -> Iterable[Measurement]:
    """A frame's reference lengths by the compiled loops, beside some of them ball by ball."""
    arrays = ScenarioArrays(*(frame[name].to_numpy() for name in ScenarioArrays._fields))
    some = list(scenarios(frame[:SOME]))

    def balls() -> object:
        return [enclose.__wrapped__(scenario, "best") for scenario in some]

    times = side_by_side({"loops": lambda: bound_rows(arrays), "balls": balls}, repeats=9)
    ours, peer = times["loops"].least / N * 1e6, times["balls"].least / SOME * 1e6
    left = int(bound_rows(arrays).left.sum())
    what = f"enclosing 10^{len(str(N)) - 1} reference lengths, against ball by ball"
    yield Measurement(
        what,
        ours=ours,
        peer=peer,
        unit="µs/row",
        ratio=peer / ours,
        target=50.0,
        at_most=False,
        note=f"peer / ours; {left} rows are left to the balls",
    )
    yield Measurement(
        "the same, in time",
        ours=ours,
        unit="µs/row",
        ratio=ours,
        target=0.3,
        note="µs a row",
    )

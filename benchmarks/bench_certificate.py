"""Cost of a certificate.

It is measured for a path, for a reference length, and for a frame's answers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

import pandas as pd

from benchmarks.harness import Measurement, side_by_side, sized
from benchmarks.peers import random_frame
from dubins_study.asking.frame import solve_frame
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import check_frame, scenarios

SOME = sized(200, 5)  # scenarios that are certified one by one
FRAME = sized(100_000, 100)  # rows of a frame that are certified


def measure() -> Iterable[Measurement]:
    frame = check_frame(random_frame(FRAME))
    some = list(scenarios(frame[:SOME]))
    paths = [shortest_path(scenario) for scenario in some]
    pairs = [(s, p) for s, p in zip(some, paths, strict=True) if p is not None]
    judgements = [judge(scenario, path) for scenario, path in pairs]

    def certificates() -> object:
        # every enclosure is in its cache after the first round
        return [
            certify(*pair, judgement) for pair, judgement in zip(pairs, judgements, strict=True)
        ]

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
    yield _frame(frame)


def _enclosed(scenario: Scenario, path: Path) -> object:
    return enclose.__wrapped__(scenario, "best")  # what the cache holds would cost nothing


def _each(
    function: Callable[[Scenario, Path], object], pairs: list[tuple[Scenario, Path]]
) -> Callable[[], object]:
    return lambda: [function(scenario, path) for scenario, path in pairs]


def _frame(frame: pd.DataFrame) -> Measurement:
    """Cost of certificates of a frame.

    The same frame is judged alone beside it.
    """
    some = frame[:FRAME]
    times = side_by_side(
        {
            "certified": lambda: solve_frame(some, certified=True),
            "judged": lambda: solve_frame(some),
        }
    )
    ours, judging = (times[key].least / len(some) * 1e6 for key in times)
    return Measurement(
        f"solve_frame of {len(some)} rows, certified, beside judged alone",
        ours=ours,
        peer=judging,
        unit="µs/row",
        ratio=ours,
        target=100.0,
        note="µs a row, each row's interval enclosed in balls",
    )

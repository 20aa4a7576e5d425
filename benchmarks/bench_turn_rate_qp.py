"""turn-rate-qp at n = 50: time beside its engine.

It also compares the time and the gap of every engine.

Times are ms and medians over repeats, gaps are relative lengths above the closed form.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from dataclasses import dataclass
from statistics import fmean, median
from typing import Any

from benchmarks.harness import Measurement, sized
from dubins_study.solvers.engines import names
from dubins_study.solvers.optimal_control.turn_rate_qp import TurnRateQp
from dubins_study.solvers.optimal_control.turn_rate_template import template
from dubins_study.solvers.protocol import Question
from dubins_study.study.judging.judge import judge
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import QP, Claim

N = 50
TARGET_MS = 0.3  # most that handing a QP to its engine may add to the engine's time


@dataclass(frozen=True)
class EngineFigures:
    """One engine over all scenarios, branch `best`."""

    engine: str
    qps: int  # in one pass over the scenarios
    asked_ms: float  # a QP: its numbers written, cvxpy's interface, the engine, the answer read
    step_ms: float  # whole time over QPs: building, rollouts and corrections included
    engine_ms: float  # of it, what the engine itself reports
    median_ms: float  # per scenario
    outside_gap: float  # median
    disc_gap: float  # median
    failures: int  # scenarios without a local optimum

    @property
    def overhead_ms(self) -> float:
        """What is added around the engine, per QP."""
        return self.asked_ms - self.engine_ms


def scenarios() -> dict[str, list[Scenario]]:
    """Targets on spirals around the start.

    12 are outside the discs, 6 inside.
    """
    outside = [
        Scenario(1, -2, 0.3, 1 + d * math.cos(a), -2 + d * math.sin(a), 1)
        for k in range(sized(12, 1))
        for d, a in [(2.2 * 1.2**k, 2.4 * k)]
    ]
    inside = [
        Scenario(0, 0, 0, d * math.cos(a), side * (1 + d * math.sin(a)), 1)
        for k in range(sized(6, 1))
        for d, a, side in [(0.15 * (k + 1), 2.4 * k, (-1) ** k)]
    ]
    return {"outside": outside, "disc": inside}


def measure_engine(engine: str, repeats: int = 5) -> EngineFigures:
    """Solve all scenarios `repeats` times.

    The pass with the median time per QP counts.
    """
    solver = TurnRateQp(n=N, engine=engine)
    qp = template(N, 1, False, engine)
    groups = scenarios()
    inner = qp.solve
    reported: list[float] = []
    asked: list[float] = []

    def counted(*given: Any) -> object:
        began = time.perf_counter()
        try:
            return inner(*given)
        finally:
            asked.append(time.perf_counter() - began)
            reported.append(qp.solution.attr.get("solve_time") or 0.0)

    qp.solve = counted  # type: ignore[assignment, method-assign]
    passes: list[tuple[float, float, float, int]] = []
    seconds: list[float] = []
    gaps: dict[str, list[float]] = {name: [] for name in groups}
    failures = 0
    try:
        for turn in range(repeats + 1):  # the first is a warm-up
            reported.clear()
            asked.clear()
            spent = []
            for name, group in groups.items():
                for scenario in group:
                    began = time.perf_counter()
                    solution = solver.solve(solver.build(Question(scenario)), 30.0)
                    spent.append(time.perf_counter() - began)
                    if turn == 0:
                        judgement = judge(scenario, solution.path, solution.claim)
                        failures += solution.claim is not Claim.LOCAL
                        gap = math.inf if judgement.gap is None else judgement.gap
                        gaps[name].append(gap)
            if turn:
                step = sum(spent) / len(reported)
                passes.append((step, fmean(asked), fmean(reported), len(reported)))
                seconds += spent
    finally:
        del qp.solve  # the class's own method shows again
    step, one, own, count = sorted(passes)[len(passes) // 2]
    return EngineFigures(
        engine,
        count,
        one * 1e3,
        step * 1e3,
        own * 1e3,
        median(seconds) * 1e3,
        median(gaps["outside"]),
        median(gaps["disc"]),
        failures,
    )


def measure() -> Iterable[Measurement]:
    """Measure every engine.

    OSQP and HiGHS, which take tens of times longer, are measured in one pass.
    """
    for engine in names(QP):
        quick = engine in ("piqp", "clarabel")
        repeats = sized(5, 1) if quick else 1
        target = TARGET_MS if quick else None
        figures = measure_engine(engine, repeats)
        gaps = f"gap {figures.outside_gap:.1e} outside, {figures.disc_gap:.1e} in discs"
        # cvxpy's interfaces to the other two set the engine up anew for every QP
        yield Measurement(
            f"turn-rate-qp, n={N}, {engine}: a QP asked, beside the engine's own time",
            ours=figures.asked_ms,
            peer=figures.engine_ms,
            unit="ms/QP",
            ratio=figures.overhead_ms,
            target=target,
            note=f"ours - peer, ms; {figures.step_ms:.2f} ms a step of the sequence, with rollouts "
            f"and corrections; {figures.median_ms:.0f} ms a scenario; {gaps}; "
            f"{figures.failures} not local",
        )

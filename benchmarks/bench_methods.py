"""Times of the global and the discretised methods.

Measured are a proof, and a path beside another's.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from statistics import median
from time import perf_counter

from benchmarks.harness import Measurement, sized
from dubins_study.solvers.protocol import Question, Solution, Solver
from dubins_study.solvers.registry import load, settings
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim

THIRD = math.pi / 3
# the paper's five test problems
PAPER = (
    Scenario(0, 0, 2 * THIRD, 10, 5, 1),
    Scenario(0, 0, 2 * THIRD, -6, 3, 1),
    Scenario(0, 0, THIRD, -1, 5, 1),
    Scenario(0, 0, THIRD, -2, -5, 1),
    Scenario(0, 0, 2 * THIRD, -80, 20, 25),
    Scenario(0, 0, 2 * THIRD, -80, 20, 10),
    Scenario(0, 0, 2 * THIRD, -80, 20, 5),
)[: sized(7, 1)]
DISCS = tuple(
    Scenario(0, 0, 0, d * math.cos(a), side * (1 + d * math.sin(a)), 1)
    for k in range(6)
    for d, a, side in [(0.15 * (k + 1), 2.4 * k, (-1) ** k)]
)[: sized(6, 1)]
PROOF = 1e-6


def measure() -> Iterable[Measurement]:
    yield _proofs("the paper's problems", PAPER, 0.5)
    yield _proofs("six targets inside the discs", DISCS, None)
    milp, qp = load("heading-milp"), load("turn-rate-qp")
    both = _alternating({"milp": milp, "qp": qp}, (*PAPER, *DISCS), sized(5, 1))
    yield Measurement(
        f"heading-milp, {settings(milp)['headings']} headings, beside turn-rate-qp, n=50",
        ours=both["milp"] * 1e3,
        peer=both["qp"] * 1e3,
        unit="ms",
        ratio=both["milp"] / both["qp"],
        target=3.0,
        note="ours / peer, medians over scenarios of the least of 5",
    )


def _proofs(what: str, scenarios: Iterable[Scenario], target: float | None) -> Measurement:
    solver = load("disjunctive")
    seconds = []
    proven = 0
    for scenario in scenarios:
        least, solution = _least(solver, scenario, sized(3, 1))
        seconds.append(least)
        length = math.inf if solution.path is None else solution.path.length
        bound = -math.inf if solution.lower_bound is None else solution.lower_bound
        closed = length - bound <= PROOF * max(length, 1e-300) and math.isfinite(length)
        proven += solution.claim is Claim.OPTIMAL and closed
    return Measurement(
        f"disjunctive: proof to {PROOF:g} of {what}",
        ours=median(seconds) * 1e3,
        unit="ms",
        ratio=median(seconds),
        target=target,
        note=f"median s; largest {max(seconds):.2f} s; {proven} of {len(seconds)} proven",
    )


def _alternating(
    solvers: dict[str, Solver], scenarios: Iterable[Scenario], repeats: int
) -> dict[str, float]:
    """Median over scenarios of each solver's least time.

    In s; the solvers take turns.
    """
    times: dict[str, list[float]] = {name: [] for name in solvers}
    for scenario in scenarios:
        spent: dict[str, list[float]] = {name: [] for name in solvers}
        for _ in range(repeats):
            for name, solver in solvers.items():
                began = perf_counter()
                _ask(solver, scenario)
                spent[name].append(perf_counter() - began)
        for name, values in spent.items():
            times[name].append(min(values))
    return {name: median(values) for name, values in times.items()}


def _ask(solver: Solver, scenario: Scenario) -> Solution:
    return solver.solve(solver.build(Question(scenario)), 60.0)


def _least(solver: Solver, scenario: Scenario, repeats: int) -> tuple[float, Solution]:
    """The least time (s) of several solves.

    The answer comes with it; it is the same every time.
    """
    seconds = []
    for _ in range(repeats):
        began = perf_counter()
        answer = _ask(solver, scenario)
        seconds.append(perf_counter() - began)
    return min(seconds), answer

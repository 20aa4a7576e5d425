"""The solver that all harnesses run.

It knows the answer, so that only what the harnesses add is seen.
"""

from __future__ import annotations

from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution, Solver
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import BRANCHES, Claim

HEADING = 0.3
TARGET_Y = 3.0
FIRST = 2.0
LAST = 10.0


def question(target_x: float) -> Scenario:
    """One scenario of those asked.

    They differ in where the target lies.
    """
    return Scenario(0.0, 0.0, HEADING, target_x, TARGET_Y, 1.0)


def targets(cells: int) -> list[float]:
    """Positions of so many targets, evenly spaced."""
    return [FIRST + (LAST - FIRST) * i / (cells - 1) for i in range(cells)]


def solved(scenario: Scenario) -> Path:
    """All that the solver does, under every harness."""
    path = shortest_path(scenario)
    assert path is not None  # `best` always has one
    return path


class Trivial(Solver):
    """The closed form as a plug-in."""

    name = "trivial"
    method = Method("closed form", "closed form")
    guarantee = Guarantee.EXACT
    branches = BRANCHES[:1]
    summary = "the closed form, for measuring what a harness costs"

    def build(self, question: Question) -> Scenario:
        return question.scenario

    def solve(self, model: Scenario, limit: float) -> Solution:
        return Solution(Claim.OPTIMAL, path=solved(model))

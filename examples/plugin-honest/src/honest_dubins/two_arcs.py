"""Paths of two pieces by root finding.

Each is the root of two equations in two unknowns.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np
from scipy.optimize import root

from dubins_study import Claim, Guarantee, Path, Question, Scenario, Solution, Solver

WORDS = ("LS", "RS", "LR", "RL")
TURN = {"L": 1.0, "S": 0.0, "R": -1.0}  # curvature times radius
# radii: a path that ends this near to the target arrives; the check allows 1e-6
ARRIVES = 1e-9


@dataclass(frozen=True)
class TwoArcs(Solver):
    """Both lengths of a word by root finding.

    MINPACK's `hybr` solves for the end point, from a grid of guesses.

    Args:
        guesses: of the first arc's angle, and of the second's.
    """

    name = "two-arcs"
    summary = "Both lengths of a word as a root, from a grid of guesses"
    method = ("one NLP a word", "MINPACK hybr", "bearing")
    guarantee = Guarantee.LOCAL
    branches = ("best", *WORDS)
    packages = ("scipy",)

    guesses: int = 6

    def __post_init__(self) -> None:
        if self.guesses < 1:
            raise ValueError(f"guesses is {self.guesses}; expected 1 or more")

    def solve(self, question: Question, limit: float) -> Solution:
        """The shortest of all roots.

        LIMIT if not all guesses were tried in time.
        """
        end = perf_counter() + limit
        words = WORDS if question.branch == "best" else (question.branch,)
        best = None
        claim = Claim.LOCAL
        trials = 0
        for path in (path for word in words for path in self.paths(question.scenario, word)):
            trials += 1
            if path is not None and (best is None or path.length < best.length):
                best = path
            if perf_counter() > end:
                claim = Claim.LIMIT
                break
        if best is None:
            claim = Claim.LIMIT if claim is Claim.LIMIT else Claim.FAILED
            return Solution(claim, message=f"no root from {trials} guesses", evaluations=trials)
        return Solution(claim, best, claimed_length=best.length, evaluations=trials)

    def paths(self, scenario: Scenario, word: str) -> Iterator[Path | None]:
        """Path of a word from each guess.

        It is None where the path does not arrive.
        """
        radius = scenario.radius
        start = scenario.start
        curvature = np.array([TURN[letter] for letter in word]) / radius
        target = np.array([scenario.target_x, scenario.target_y])
        distance = math.hypot(*(target - start[:2])) / radius

        def path(radii: np.ndarray) -> Path:
            return Path(start, curvature, radii * radius)

        def miss(radii: np.ndarray) -> np.ndarray:
            return (np.array(path(radii).end[:2]) - target) / radius

        angles = np.linspace(0.1, 6.2, self.guesses)
        for first in angles:
            for second in [distance] if word.endswith("S") else angles:
                radii = root(miss, [first, second], options={"xtol": 1e-14}).x
                turning = [letter != "S" for letter in word]
                radii[turning] %= 2 * math.pi  # a full turn more or less ends at the same point
                arrives = np.all(radii >= 0) and math.hypot(*miss(radii)) < ARRIVES
                yield path(radii) if arrives else None

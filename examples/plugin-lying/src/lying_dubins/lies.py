"""A right solver with one lie each.

Its answers are changed before they are returned. No solver is wrong on purpose, but many are wrong
like one of these. `lie` chooses; the conformance kit has to find it and say what to do.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from honest_dubins import TwoArcs

from dubins_study import Claim, Path, Question, Scenario, Solution, Solver, solve

_HONEST = TwoArcs(guesses=3)
_LIMIT = 60.0  # s; the lies about time are told elsewhere


def honest(scenario: Scenario, branch: str = "best") -> Solution:
    """The right answer.

    For a route or a final heading it is that of the search.
    """
    if scenario.via or scenario.final_heading is not None:
        return Solution(Claim.OPTIMAL, solve(scenario, branch=branch).path)
    return _HONEST.solve(Question(scenario, branch), _LIMIT)


def _path(change: Callable[[Scenario, Path], Path]) -> Callable[[Question], Solution]:
    """A lie that changes the right path."""

    def tell(question: Question) -> Solution:
        right = honest(question.scenario, question.branch)
        if right.path is None:
            return right
        return replace(right, path=change(question.scenario, right.path))

    return tell


def _controls(
    curvature: Callable[[Scenario, Path], np.ndarray] = lambda s, p: p.curvatures,
    length: Callable[[Scenario, Path], np.ndarray] = lambda s, p: p.lengths,
) -> Callable[[Question], Solution]:
    """A lie that changes the right controls."""
    return _path(lambda s, p: Path(p.start, curvature(s, p), length(s, p)))


def _asked(change: Callable[[Scenario], Scenario]) -> Callable[[Question], Solution]:
    """A lie that answers another question.

    The start is right.
    """

    def tell(question: Question) -> Solution:
        answer = honest(change(question.scenario), question.branch)
        path = answer.path
        if path is None:
            return answer
        return replace(answer, path=Path(question.scenario.start, path.curvatures, path.lengths))

    return tell


def _answer(change: Callable[[Question, Solution], Solution]) -> Callable[[Question], Solution]:
    """A lie that changes the claim.

    What is said of the right path is changed.
    """

    def tell(question: Question) -> Solution:
        right = honest(question.scenario, question.branch)
        return right if right.path is None else change(question, right)

    return tell


def _optimal(tell: Callable[[Question], Solution]) -> Callable[[Question], Solution]:
    """A lie that claims to be the best."""

    def claim(question: Question) -> Solution:
        return replace(tell(question), claim=Claim.OPTIMAL)

    return claim


def _with_radius(path: Path) -> np.ndarray:
    turning = path.curvatures != 0
    return np.where(turning, 1 / np.where(turning, path.curvatures, 1.0), 0.0)


def _turns(path: Path, factor: float) -> np.ndarray:
    return np.where(path.curvatures != 0, path.lengths * factor, path.lengths)


def _flip_last(path: Path) -> np.ndarray:
    """Curvatures with the last of two turns reversed."""
    flipped = path.curvatures.copy()
    if flipped.size == 2 and flipped.all():
        flipped[-1] = -flipped[-1]
    return flipped


def _two_words(question: Question, _: Solution) -> Solution:
    """LS or RS, whichever is shorter.

    The paper claims that one of them is always the shortest.
    """
    s = question.scenario
    paths = [answer.path for word in ("LS", "RS") if (answer := honest(s, word)).path is not None]
    return Solution(Claim.OPTIMAL, min(paths, key=lambda path: path.length))


def _only_two_words(question: Question, right: Solution) -> Solution:
    path = right.path
    if path is not None and path.lengths[-1] > 0 and path.curvatures[-1] != 0:
        return Solution(Claim.INFEASIBLE)
    return right


# lies about what a path is made of
PATHS = {
    "radius as curvature": _controls(lambda s, p: _with_radius(p)),
    "lengths in radii": _controls(length=lambda s, p: p.lengths / s.radius),
    "path of radius 1": _controls(
        lambda s, p: p.curvatures * s.radius, lambda s, p: p.lengths / s.radius
    ),
    "angles": _controls(length=lambda s, p: _turns(p, 1 / s.radius)),
    "turn rates": _controls(lambda s, p: p.curvatures * s.speed),
    "positions": _path(lambda s, p: Path(p.start, p.sample(20)[:, 0], p.sample(20)[:, 1])),
    "left is right": _controls(lambda s, p: -p.curvatures),
    "one turn to the wrong side": _controls(lambda s, p: _flip_last(p)),
    "from the target": _path(lambda s, p: Path(p.end, p.curvatures[::-1], p.lengths[::-1])),
    "swapped arrays": _controls(lambda s, p: p.lengths, lambda s, p: p.curvatures),
    "negative length": _controls(length=lambda s, p: -p.lengths),
    "not a number": _controls(length=lambda s, p: p.lengths * math.nan),
    "nearly there": _controls(length=lambda s, p: p.lengths * (1 + 1e-4)),
    "start in degrees": _path(
        lambda s, p: Path((s.x, s.y, math.degrees(s.heading)), p.curvatures, p.lengths)
    ),
}
# lies about the question
QUESTIONS = {
    "heading in degrees": _asked(lambda s: replace(s, heading=math.radians(s.heading))),
    "diameter": _asked(lambda s: replace(s, radius=s.radius / 2)),
    "wide turns": _optimal(_asked(lambda s: replace(s, radius=2 * s.radius))),
    "radius times speed": _optimal(_asked(lambda s: replace(s, radius=s.radius * s.speed))),
    "no start": _asked(lambda s: replace(s, x=0.0, y=0.0, heading=0.0)),
    "any word": lambda question: honest(question.scenario),
}
# lies about what a path has to meet on its way, and at its end
VISITS = {
    "skips the last via point": _optimal(_asked(lambda s: replace(s, via=s.via[:-1]))),
    "sorts the via points": _optimal(_asked(lambda s: replace(s, via=sorted(s.via)))),
    "any final heading": _optimal(_asked(lambda s: replace(s, final_heading=None))),
    "denies routes": lambda q: (
        Solution(Claim.INFEASIBLE) if q.scenario.via else honest(q.scenario, q.branch)
    ),
}
# lies about the answer
CLAIMS = {
    "always optimal": _answer(_two_words),
    "needless turns": _optimal(
        _controls(
            length=lambda s, p: np.where(
                p.curvatures != 0, p.lengths + 2 * math.pi * s.radius, p.lengths
            )
        )
    ),
    "infeasible": _answer(_only_two_words),
    "no path": _answer(lambda q, right: Solution(Claim.LOCAL)),
    "high bound": _answer(lambda q, right: replace(right, lower_bound=1.01 * right.path.length)),
    "claimed time": _answer(
        lambda q, right: replace(right, claimed_length=right.path.length / q.scenario.speed)
    ),
}


def _raise(question: Question) -> Solution:
    raise KeyError("the target is behind")


def _raise_sometimes(question: Question) -> Solution:
    if question.scenario.local()[0] < 0:
        np.linalg.cholesky(-np.eye(2))
    return honest(question.scenario, question.branch)


def _crash(question: Question) -> Solution:
    os.abort()


def _hang(question: Question) -> Solution:
    while True:
        pass


# lies that are no answers
FAILURES = {
    "raises": _raise,
    "raises behind": _raise_sometimes,
    "returns a dict": lambda question: {"length": 1.0},
    "crashes": _crash,
    "hangs": _hang,
}
LIES = PATHS | QUESTIONS | VISITS | CLAIMS | FAILURES


@dataclass(frozen=True)
class Lying(Solver):
    """The honest plug-in's answers, and one lie.

    Args:
        lie: one of `LIES`.
    """

    name = "lying"
    summary = "Another solver's answers and one lie, to try the conformance kit on"
    method = ("one NLP a word", "MINPACK hybr", "bearing")
    branches = TwoArcs.branches
    takes = frozenset({"free final heading", "final heading", "via points"})

    lie: str = "left is right"

    def __post_init__(self) -> None:
        if self.lie not in LIES:
            raise ValueError(f"lie is {self.lie!r}; expected one of: {', '.join(LIES)}")

    def solve(self, question: Question, limit: float) -> Solution:
        return LIES[self.lie](question)

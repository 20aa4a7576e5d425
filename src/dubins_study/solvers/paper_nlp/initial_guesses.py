"""Starting points, shared by all local solvers: where one begins decides where one ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import Protocol, TypeVar

import numpy as np

from dubins_study.solvers.paper_nlp.model import FULL_TURN, Attempts, Point, Subproblem, target
from dubins_study.solvers.protocol import Question
from dubins_study.study.path import FloatArray, Path

STARTS = ("bearing", "zero", "random", "given")

# RL and LR have two isolated solutions each and only the one whose second arc exceeds pi can be
# optimal; its first arc is at most pi/3 (THEORY section 3), so these lie among them.
_LONG_SECOND_ARC = ((math.pi / 6, 3 * math.pi / 2), (0.1, 6.0), (0.8, 3.5))

# Asked for LR or RL itself, either solution may be the shorter, the second arc below pi or above.
# These turn the first arc by so much past the target's direction from the first circle's centre
# (from there the second centre is within pi/6 of the target); (0, 0.1) is for targets near the
# circle, where the short second arc vanishes.
_EITHER_SECOND_ARC = (
    (-math.pi / 6, math.pi / 2),
    (math.pi / 6, math.pi / 2),
    (0.0, 0.1),
    (-math.pi / 6, 3 * math.pi / 2),
    (math.pi / 6, 3 * math.pi / 2),
)

# rad: bearings below this are straight ahead, on whichever side rounding has put them
_STRAIGHT = 1e-9

# at z = 0 the two equations' derivatives are linearly dependent (THEORY section 5)
_SHORTEST = 1e-3

# Near a turning circle a Newton-like step from the first guess may leave the solution's basin. The
# bearing itself and these turns of the first guess (rad) are tried until a start succeeds.
_SWINGS = (0.7, -0.7, 1.4, -1.4)


def starting_points(
    question: Question, subproblem: Subproblem, kind: str, seed: int, count: int
) -> Iterator[FloatArray]:
    """Points z, each of shape (3,), from which to solve a subproblem; fixed lengths are zero.

    Args:
        question: its `start`, if it is a path of the subproblem's word, goes first.
        subproblem: which lengths are free, and in which order the turns come.
        kind: `bearing` (turn towards the target and by half the radius' apparent size more, then
            go straight; some turns to either side follow), `zero` (as AMPL does by default),
            `random`, or `given`: only from the question's own start, if it has one.
        seed, count: of the random points: arcs uniform in [0, 2 pi], straights up to twice the
            target's distance plus a turning circle's diameter.

    See `every_start` for which of them must all be solved from.
    """
    X, Y = target(question.scenario, subproblem.mirrored)
    if question.initial_guess is not None:
        warm = _from_path(question.initial_guess, question.scenario.radius, subproblem)
        if not np.delete(warm, subproblem.free).any():  # a path of another word is no help
            yield warm
        if kind == "given":
            return
    if kind == "zero":
        yield np.zeros(3)
    elif kind == "random":
        largest = np.array((FULL_TURN, FULL_TURN, 2 * math.hypot(X, Y) + 2))
        yield from np.random.default_rng(seed).uniform(size=(count, 3)) * largest * subproblem.mask
    else:
        asked = question.branch == subproblem.name
        for point in _bearing(X, Y, subproblem, asked):
            yield np.array(point) * subproblem.mask


def every_start(subproblem: Subproblem, kind: str) -> bool:
    """Whether all starting points must be solved from, or the first that succeeds will do.

    LS and RS have one solution below a full turn; the others have more.
    """
    return kind == "random" or subproblem.free == (0, 1)


class Posed(Protocol):
    """A subproblem as a backend takes it."""

    @property
    def subproblem(self) -> Subproblem: ...


Case = TypeVar("Case", bound=Posed)


def attempts(
    question: Question,
    cases: Iterable[Case],
    solve: Callable[[Case, FloatArray], Point],
    start: str,
    seed: int,
    count: int,
) -> list[Attempts]:
    """Every case of a question with its starting points; for start, seed, count see above."""
    return [
        Attempts(
            partial(solve, case),
            starting_points(question, case.subproblem, start, seed, count),
            every_start(case.subproblem, start),
        )
        for case in cases
    ]


def _bearing(
    X: float, Y: float, subproblem: Subproblem, asked: bool
) -> Iterator[tuple[float, float, float]]:
    bearing, distance = math.atan2(Y, X), max(math.hypot(X, Y), _SHORTEST)
    if subproblem.free == (0, 1) and asked:
        facing = math.atan2(Y - 1, X) + math.pi / 2
        for aside, second in _EITHER_SECOND_ARC:
            yield (facing + aside) % FULL_TURN, second, 0.0
        return
    if subproblem.free == (0, 1):
        yield from ((*arcs, 0.0) for arcs in _LONG_SECOND_ARC)
        return
    if subproblem.free == (0, 1, 2):
        yield max(bearing, 0.0), max(-bearing, 0.0), distance
        return
    facing = (bearing if subproblem.free[0] == 0 else -bearing) % FULL_TURN
    if min(facing, FULL_TURN - facing) < _STRAIGHT:
        yield 0.0, 0.0, distance
        return
    aim = facing + math.atan(1 / distance)
    for arc in (aim, facing, *(aim + swing for swing in _SWINGS)):
        yield arc % FULL_TURN, arc % FULL_TURN, distance + 0.5


def _from_path(path: Path, radius: float, subproblem: Subproblem) -> FloatArray:
    """How far a path turns the first way, turns the other way, and goes straight."""
    turn = path.curvature * path.length * subproblem.turns[0]
    straight = path.length[path.curvature == 0].sum() / radius
    return np.array((turn[turn > 0].sum(), -turn[turn < 0].sum(), straight))

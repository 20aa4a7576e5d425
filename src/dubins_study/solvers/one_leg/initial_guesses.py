"""Initial guesses of all local solvers.

The guess decides which local minimum is reached.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from dubins_study.solvers.one_leg.model import Case, Subproblem, case_of
from dubins_study.solvers.presolve import WORDS
from dubins_study.solvers.protocol import Question
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import Local
from dubins_study.study.path import Path

INITIAL_GUESSES = ("bearing", "one", "words", "straight", "zero", "random", "given")

# RL and LR have two isolated solutions each, and only the one whose second arc exceeds pi can be
# optimal (docs/derivation.md, section 4). Seen from the first circle's centre, the second centre is
# from 0 to pi/6 past the target there: the first guess lies in the middle, two at the ends.
_LONG_SECOND_ARC = (math.pi / 12, 0.0, math.pi / 6)

# rad; the long second arc falls from a full turn to half of one where the target's distance from
# the first centre grows from 1 to 3 radii. Its guess falls with the distance as a line does, but
# not below three quarters of a turn: from further down engines may reach the short second arc.
_LONGEST_SECOND = 6.0
_LEAST_SECOND = 3 * math.pi / 2

# If the branch is LR or RL itself, either solution may be the shorter: the second arc may be below
# pi or above. The first number of a pair is how far the first arc turns past the target's direction
# from the first circle's centre, the second number is the second arc (rad). (0, 0.1) is for targets
# near the circle, where the short second arc vanishes.
_EITHER_SECOND_ARC = (
    (-math.pi / 6, math.pi / 2),
    (math.pi / 6, math.pi / 2),
    (0.0, 0.1),
    (-math.pi / 6, 3 * math.pi / 2),
    (math.pi / 6, 3 * math.pi / 2),
)

# rad: bearings below this are straight ahead, on whichever side rounding has put them
_STRAIGHT = 1e-9

# radii; at z = 0 the gradients of the two equations are linearly dependent (docs/derivation.md,
# section 7)
_SHORTEST = 1e-3

# rad; near a turning circle a Newton-like step from the first guess may leave the solution's
# basin. Then the bearing itself and the first guess turned by these angles are tried.
_SWINGS = (0.7, -0.7, 1.4, -1.4)


def initial_guesses(
    question: Question, case: Case, kind: str, seed: int, count: int, *, both: bool = False
) -> Iterator[FloatArray]:
    """Points z from which to solve a case.

    Each point has shape (3,); fixed lengths are zero. The question's own guess goes first, if that
    is a path of the subproblem's word.

    The kinds:
    `bearing`: turn towards the target and by half the radius' apparent size more, then go straight;
        some turns to either side follow. The joint model begins as for `one`.
    `words`: the first guess of `bearing` for each word of the subproblem; if `both` orders are
        solved, each word is begun in one of them.
    `one`: the shorter turn towards the target, then straight, whatever the word.
    `straight`: no turn, the target's distance.
    `zero`: all lengths zero, AMPL's default.
    `random`: `count` points, arcs up to a full turn, straights up to twice the target's distance
        plus 2.
    `given`: only the question's own guess.
    """
    subproblem = case.subproblem
    target = case.target
    if question.initial_guess is not None:
        path = question.guess_in_radii
        if path is not None:
            warm = _from_path(path, subproblem)
            if not np.delete(warm, subproblem.free).any():  # a path of another word is no help
                yield warm
        if kind == "given":
            return
    if kind == "zero":
        yield np.zeros(3)
    elif kind == "straight":
        yield np.array((0.0, 0.0, math.hypot(target.X, target.Y))) * subproblem.mask
    elif kind == "one":
        yield np.array(_toward(target)) * subproblem.mask
    elif kind == "words":
        for word in _words_of(subproblem, both):
            yield _first(case, word, question.branch == word)
    elif kind == "random":
        largest = np.array((TWO_PI, TWO_PI, 2 * math.hypot(target.X, target.Y) + 2))
        random = np.random.default_rng(seed)
        for _ in range(count):  # one by one: time may be up long before the last
            yield random.uniform(size=3) * largest * subproblem.mask
    else:
        prescribed = question.branch == subproblem.name
        for point in bearing_guesses(case, prescribed):
            yield np.array(point) * subproblem.mask


def _words_of(subproblem: Subproblem, both: bool) -> list[str]:
    """The words that a subproblem holds.

    `LRS` holds LS, RS and LR. With `both` orders a subproblem leaves out the words that begin as
    the other order does: `LRS` then has LS and LR.
    """
    name = subproblem.name
    # a word's two letters stand in this order in the subproblem's name
    words = [word for word in WORDS if -1 < name.find(word[0]) < name.find(word[1])]
    if not both:
        return words
    return [word for word in words if word[0] == name[0]]


def suffices(question: Question, subproblem: Subproblem, kind: str, z: FloatArray) -> bool:
    """Whether a solution z needs no further guess.

    z, shape (3,), solves the subproblem. LS and RS have one solution below a full turn. LR and RL
    have two, of which only the one with the long second arc can be optimal. Where the branch asks
    for LR or RL itself, either may be the shorter.
    """
    if kind in ("random", "words"):
        return False
    if subproblem.free != (0, 1):
        return True
    return question.branch != subproblem.name and bool(z[1] >= math.pi)


def bearing_guesses(case: Case, prescribed: bool) -> Iterator[tuple[float, float, float]]:
    """The guesses `bearing` of a case.

    Yields points z: the case's first turn, its second turn and its straight. Lengths that the case
    fixes at zero are not zero here; the caller masks them. `prescribed` says that the branch asks
    for the case's word.
    """
    X, Y, _ = case.target
    free = case.subproblem.free
    distance = max(math.hypot(X, Y), _SHORTEST)
    if free == (0, 1):
        facing = math.atan2(Y - 1, X) + math.pi / 2
        beyond = min(max(math.hypot(X, Y - 1) - 1, 0.0), 2.0)
        long = min(max(TWO_PI - beyond * math.pi / 2, _LEAST_SECOND), _LONGEST_SECOND)
        arcs = tuple((aside, long) for aside in _LONG_SECOND_ARC)
        if prescribed:
            arcs = _EITHER_SECOND_ARC
        for aside, second in arcs:
            yield (facing + aside) % TWO_PI, second, 0.0
        return
    if free == (0, 1, 2):
        yield _toward(case.target)
        return
    bearing = math.atan2(Y, X)
    # one turn: the case's first (to the left) or its second (to the right)
    if free[0] != 0:
        bearing = -bearing
    facing = bearing % TWO_PI
    if min(facing, TWO_PI - facing) < _STRAIGHT:
        yield 0.0, 0.0, distance
        return
    aim = facing + math.atan(1 / distance)
    for arc in (aim, facing, *(aim + swing for swing in _SWINGS)):
        yield arc % TWO_PI, arc % TWO_PI, distance + 0.5


def _toward(target: Local) -> tuple[float, float, float]:
    """The shorter turn towards the target, then straight.

    The straight is as long as the target is away. Returns z: the first turn, the second turn, the
    straight.
    """
    bearing = math.atan2(target.Y, target.X)
    return max(bearing, 0.0), max(-bearing, 0.0), max(math.hypot(target.X, target.Y), _SHORTEST)


def _first(case: Case, word: str, prescribed: bool) -> FloatArray:
    """The first guess of a case's word.

    Shape (3,), in the case's order of turns. The word's own case may have the other order.
    """
    mirrored = case.subproblem.mirrored
    target = case.target
    if mirrored:
        target = target.mirrored
    word_case = case_of(word, target)
    point = np.array(next(bearing_guesses(word_case, prescribed))) * word_case.subproblem.mask
    if mirrored == word_case.subproblem.mirrored:
        return point
    return point[[1, 0, 2]]


def _from_path(path: Path, subproblem: Subproblem) -> FloatArray:
    """The lengths z of a path, shape (3,).

    They are its turns the first way, its turns the other way, and its straights.
    """
    turn = path.curvatures * path.lengths * subproblem.turns[0]
    straight = path.lengths[path.curvatures == 0].sum()
    return np.array((turn[turn > 0].sum(), -turn[turn < 0].sum(), straight))

"""Initial guesses of a transcription: one shaped like each word, at zero, or at random."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.optimal_control.arcs import HERE, LEAST, Elements, Rates, cut
from dubins_study.solvers.paper_nlp.model import FULL_TURN
from dubins_study.solvers.protocol import Question
from dubins_study.study.body_coordinates import Local
from dubins_study.study.path import FloatArray, Path, drivable

# arcs (rad) of RL and LR: the second exceeds pi where it can be shortest, the first is at most
# pi/3 (docs/derivation.md, section 4)
_TWO_ARCS = ((0.5, 4.5), (0.1, 6.0), (0.9, 3.5))
# rad, added to the turn towards the target where the first guess fails
_SWINGS = (0.7, -0.7)
# rad, to which the rounding of the bearing is added: a bearing so near to a full turn is straight
# ahead
_STRAIGHT = 1e-9


class Guess(NamedTuple):
    """An initial guess, and the word whose shape it has, or `warm`, `zero` or `random`."""

    subproblem: str
    elements: Elements


class Trial(NamedTuple):
    """Initial guesses to be tried in turn: all of them if `every`, else up to the first success."""

    guesses: Iterator[Guess]
    every: bool = False


class Kind(NamedTuple):
    """Where a search begins: the settings `initial_guess`, `seed` and `count`."""

    name: str = "bearing"
    seed: int = 0
    draws: int = 10


def trials(
    question: Question,
    target: Local,
    shapes: Sequence[str],
    n: int,
    shares: FloatArray | None,
    rates: Rates,
    kind: Kind = Kind(),  # noqa: B008  (frozen)
) -> Iterator[Trial]:
    """Initial guesses for a question.

    The question's own path goes first if it can be driven: among the guesses of the word that is
    asked for, or alone if the branch is `best`. The others are shaped like each word (kind
    `bearing`), or elements of no turn and no length (`zero`, AMPL's default), or drawn at random:
    turn rates uniform within their bounds, lengths up to twice the target's distance, a turning
    circle's length and its diameter. Kind `given` has the question's own path only, if there is
    one.

    `shapes` are the words of the kind `bearing`; the n elements have `shares` (n,) of the whole
    length, or are free; `rates` bound random turn rates.
    """
    warm = [Guess("warm", cut(path, n, shares)) for path in _given(question)]
    if kind.name == "given" and warm:
        yield Trial(iter(warm))
        return
    searches = {
        "zero": lambda: [Trial(iter([Guess("zero", Elements(np.zeros(n), np.zeros(n)))]))],
        "random": lambda: [Trial(_random(question, target, n, shares, rates, kind), every=True)],
    }
    cold = searches.get(kind.name, lambda: _words(question, target, shapes, n, shares))()
    if question.branch == "best":
        if warm:
            yield Trial(iter(warm))
        yield from cold
        return
    (only,) = cold
    yield Trial(chain(warm, only.guesses), only.every)


def _words(
    question: Question, target: Local, shapes: Sequence[str], n: int, shares: FloatArray | None
) -> list[Trial]:
    def shaped(word: str) -> Iterator[Guess]:
        return (Guess(word, cut(path, n, shares)) for path in _shaped(word, target))

    if question.branch != "best":
        return [Trial(shaped(question.branch))]
    # the nearer side first
    words = ("LS", "RS", "RL", "LR") if target.Y >= 0 else ("RS", "LS", "LR", "RL")
    return [Trial(shaped(word)) for word in words if word in shapes]


def _random(
    question: Question,
    target: Local,
    n: int,
    shares: FloatArray | None,
    rates: Rates,
    kind: Kind,
) -> Iterator[Guess]:
    random = np.random.default_rng((kind.seed, question.repeat))
    longest = 2 * math.hypot(target.X, target.Y) + 2 + FULL_TURN
    for _ in range(kind.draws):  # one by one: time may be up long before the last
        if shares is None:
            length = random.uniform(0.0, 2 * longest / n, n)
        else:
            length = shares * random.uniform(0.0, longest)
        yield Guess(
            "random", Elements(random.uniform(rates.lower, rates.upper, n) * length, length)
        )


def _given(question: Question) -> Iterator[Path]:
    """The question's path in body coordinates at unit radius, if it can be driven."""
    path, radius = question.initial_guess, question.scenario.radius
    if path is not None and drivable(path) and path.total_length > 0:
        yield Path(HERE, path.curvature * radius, path.length / radius)


def _shaped(word: str, target: Local) -> Iterator[Path]:
    """Paths shaped like a word: two arcs, or a turn towards the target and a straight.

    The first turn faces the target. The second one is larger by half the apparent size of a
    turning circle at the target, which is much where the target is near. Other turns follow.
    """
    sign = 1.0 if word[0] == "L" else -1.0
    if word[1] != "S":
        yield from (Path(HERE, (sign, -sign), arcs) for arcs in _TWO_ARCS)
        return
    distance = math.hypot(target.X, target.Y)
    facing = (sign * math.atan2(target.Y, target.X)) % FULL_TURN
    if facing > FULL_TURN - _STRAIGHT - 2 * target.delta / distance:
        facing = 0.0
    distance = max(distance, LEAST)
    aim = facing + math.atan(1 / distance)
    for turn in (facing, aim, *(aim + swing for swing in _SWINGS)):
        arc = turn % FULL_TURN
        lengths = (max(arc, LEAST), distance)
        yield Path(HERE, (sign * arc / lengths[0], 0.0), lengths)

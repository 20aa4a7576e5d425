"""Initial guesses of the transcription: one shaped like each word."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import chain

import numpy as np

from dubins_study.solvers.optimal_control.collocation_model import Elements
from dubins_study.solvers.paper_nlp.model import FULL_TURN
from dubins_study.solvers.protocol import Question
from dubins_study.study.path import Path, drivable
from dubins_study.study.scenario import Pose
from dubins_study.study.vehicle_frame import Local

# arcs (rad) of RL and LR: the second exceeds pi where it can be shortest, the first is at most
# pi/3 (docs/derivation.md, section 4)
_TWO_ARCS = ((0.5, 4.5), (0.1, 6.0), (0.9, 3.5))
# rad, added to the turn towards the target where the first guess fails
_SWINGS = (0.7, -0.7)
# rad, to which the rounding of the bearing is added: a bearing so near to a full turn is straight
# ahead
_STRAIGHT = 1e-9
_LEAST = 1e-3  # radii; elements of no length would be a poor guess
_HERE = Pose(0.0, 0.0, 0.0)


def guesses(
    question: Question, target: Local, shapes: Sequence[str], n: int, equal: bool
) -> Iterator[Iterator[Elements]]:
    """Initial guesses for a question: for each word, the guesses to try until one succeeds.

    The question's own path goes first if it can be driven: among the guesses of the word that is
    asked for, or alone if the branch is `best`.

    Args:
        question: its branch is `best` or a word.
        target: in the vehicle's frame.
        shapes: the words.
        n: number of elements.
        equal: whether they must be equally long.
    """
    warm = [cut(path, n, equal) for path in _given(question)]
    if question.branch != "best":
        yield chain(warm, (cut(path, n, equal) for path in _shaped(question.branch, target)))
        return
    if warm:
        yield iter(warm)
    # the nearer side first
    for word in ("LS", "RS", "RL", "LR") if target.Y >= 0 else ("RS", "LS", "LR", "RL"):
        if word not in shapes:
            continue
        yield (cut(path, n, equal) for path in _shaped(word, target))


def _given(question: Question) -> Iterator[Path]:
    """The question's path in the vehicle's frame at unit radius, if it can be driven."""
    path, radius = question.initial_guess, question.scenario.radius
    if path is not None and drivable(path) and path.total_length > 0:
        yield Path(_HERE, path.curvature * radius, path.length / radius)


def _shaped(word: str, target: Local) -> Iterator[Path]:
    """Paths shaped like a word: two arcs, or a turn towards the target and a straight.

    The first turn faces the target. The second one is larger by half the apparent size of a
    turning circle at the target, which is much where the target is near. Other turns follow.
    """
    sign = 1.0 if word[0] == "L" else -1.0
    if word[1] != "S":
        yield from (Path(_HERE, (sign, -sign), arcs) for arcs in _TWO_ARCS)
        return
    distance = math.hypot(target.X, target.Y)
    facing = (sign * math.atan2(target.Y, target.X)) % FULL_TURN
    if facing > FULL_TURN - _STRAIGHT - 2 * target.delta / distance:
        facing = 0.0
    distance = max(distance, _LEAST)
    aim = facing + math.atan(1 / distance)
    for turn in (facing, aim, *(aim + swing for swing in _SWINGS)):
        arc = turn % FULL_TURN
        lengths = (max(arc, _LEAST), distance)
        yield Path(_HERE, (sign * arc / lengths[0], 0.0), lengths)


def cut(path: Path, n: int, equal: bool) -> Elements:
    """A path in the vehicle's frame at unit radius as n elements, not all of them of length 0.

    Equally long elements turn as the path does over their length. Otherwise every arc is cut into
    equal parts, so many that the parts of all arcs turn by similar angles; a path of more than n
    arcs becomes equally long elements.
    """
    some = path.length > 0
    curvature, length = path.curvature[some], path.length[some]
    if equal or length.size > n:
        heading = path.at(np.linspace(0.0, path.total_length, n + 1))[:, 2]
        return Elements(np.diff(heading), np.full(n, path.total_length / n))
    turn = curvature * length
    parts = np.ones(turn.size, dtype=int)
    for _ in range(n - turn.size):
        parts[np.argmax((np.abs(turn) + _LEAST) / parts)] += 1
    return Elements(np.repeat(turn / parts, parts), np.repeat(length / parts, parts))

"""Where the transcription's solves begin: one guess shaped like each word."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from solvers.collocation_model import Elements
from solvers.protocol import Question
from solvers.reach import unreachable
from study.path import FloatArray, Path
from study.scenario import Pose
from study.verify import drivable

# arcs (rad) of RL and LR: the second exceeds pi where it can be shortest, the first is at most
# pi/3 (THEORY section 3)
_TWO_ARCS = (0.5, 4.5)
_STRAIGHT = 1e-9  # rad; a bearing so near to a full turn is straight ahead, up to rounding
_LEAST = 1e-3  # radii; an arc of no length gives the elements upon it nothing to begin with
_HERE = Pose(0.0, 0.0, 0.0)


def guesses(question: Question, target: FloatArray, n: int, equal: bool) -> Iterator[Elements]:
    """Elements to begin from: the path given, if it can be driven, then one of each word.

    Args:
        question: its branch says which words.
        target: shape (2,), in the vehicle's frame, radii.
        n: number of elements.
        equal: whether they must be equally long.
    """
    warm, radius = question.start, question.scenario.radius
    if warm is not None and drivable(warm) and warm.total_length > 0:
        yield cut(Path(_HERE, warm.curvature * radius, warm.length / radius), n, equal)
    X, Y = map(float, target)
    words = (question.branch,) if question.branch != "best" else _words(X, Y)
    for word in words:
        yield cut(_shaped(word, X, Y), n, equal)


def _words(X: float, Y: float) -> Iterator[str]:
    """The words that can end at the target, the nearer side first."""
    near, far = ("L", "R") if Y >= 0 else ("R", "L")
    for side in (near, far):
        if unreachable(X, Y, side + "S") is None:
            yield side + "S"
    for last, first in ((near, far), (far, near)):
        # the second arc's circle is 2 from the first one's: farther than 3 it cannot reach
        if math.hypot(X, Y + (1 if last == "L" else -1)) <= 3:
            yield first + last


def _shaped(word: str, X: float, Y: float) -> Path:
    """Two pieces: a turn to the target's bearing and as far as it is away, or two arcs."""
    sign = 1.0 if word[0] == "L" else -1.0
    if word[1] != "S":
        return Path(_HERE, (sign, -sign), _TWO_ARCS)
    bearing = (sign * math.atan2(Y, X)) % (2 * math.pi)
    if bearing > 2 * math.pi - _STRAIGHT:
        bearing = 0.0
    lengths = np.maximum((bearing, math.hypot(X, Y)), _LEAST)
    return Path(_HERE, (sign * bearing / lengths[0], 0.0), lengths)


def cut(path: Path, n: int, equal: bool) -> Elements:
    """A path in the vehicle's frame at unit radius as n elements, not all of them of length 0.

    Equally long elements turn as the path does over their length. Others keep its arcs: each
    is cut into equal parts, so many that the parts turn alike; a path of more than n arcs is
    taken as equally long elements.
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

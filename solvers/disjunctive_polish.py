"""A point that meets the target to a solver's tolerance, moved until it meets it exactly."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from solvers.model import FULL_TURN, SUBPROBLEMS, equations, jacobian
from study.path import FloatArray

# Where a word's two solutions meet (on a turning circle) a Newton step only halves the distance
# to them, so from a tolerance of 1e-6 some 25 steps lead to the last digit that there is.
_STEPS = 40
_HALVINGS = 8


class Polished(NamedTuple):
    """A word's lengths, shape (3,), as in `solvers.model`, and by how much they miss (radii)."""

    z: FloatArray
    miss: float


def polish(word: str, z: FloatArray, X: float, Y: float) -> Polished:
    """The point of a word near z whose end is nearest to the target.

    Newton's step on the two equations of the word, or the shortest least squares step where
    their derivative is singular, cut to the lengths that the word allows and halved until it
    gains.

    Args:
        word: `LS`, `RS`, `LR` or `RL`.
        z: shape (3,), in the word's own order of turns; lengths that it lacks are set to zero.
        X, Y: target in the word's frame (mirrored for `RL`), in radii.
    """
    subproblem = SUBPROBLEMS[word]
    free = list(subproblem.free)
    upper = np.array((FULL_TURN, FULL_TURN, math.inf))[free]
    at = np.clip(np.where(subproblem.mask, z, 0.0), 0.0, (FULL_TURN, FULL_TURN, math.inf))
    residual = equations(at, X, Y)
    for _ in range(_STEPS):
        step = np.linalg.lstsq(jacobian(at)[:, free], -residual, rcond=None)[0]
        for halving in range(_HALVINGS):
            ahead = at.copy()
            ahead[free] = np.clip(at[free] + step * 0.5**halving, 0.0, upper)
            left = equations(ahead, X, Y)
            if np.hypot(*left) < np.hypot(*residual):
                at, residual = ahead, left
                break
        else:
            break
    return Polished(at, float(np.hypot(*residual)))

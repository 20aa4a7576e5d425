"""Polishing: points moved until they meet the target.

A solver's point meets the target to a tolerance. A polished one meets it to rounding.
"""

from __future__ import annotations

import math
from itertools import product
from typing import NamedTuple

import numpy as np

from dubins_study.solvers.one_leg.model import Case, case_of, equations, jacobian
from dubins_study.solvers.protocol import Question
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import EPS, Local
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario

# Where a word's two solutions meet (on a turning circle) a Newton step only halves the distance
# to them, so from a tolerance of 1e-6 some 25 steps lead to the last digit that there is.
_STEPS = 40
_HALVINGS = 8
# radii; a straight to begin with, towards a target next to the circle
_OUTSIDE = 0.05


# Relative. A polished path counts as the solver's own if the two lengths differ by no more. A
# tolerance of 1e-6 on the squared length of the straight leaves such a difference.
_NEAR = 1e-3


class Polished(NamedTuple):
    """A word's lengths z and their miss.

    z has shape (3,). `miss` is in radii; `meets` says that it is only rounding.
    """

    z: FloatArray
    miss: float
    meets: bool


def meet_target(
    scenario: Scenario, target: Local, words: tuple[str, ...], word: str, z: FloatArray
) -> tuple[str, Polished]:
    """Move a solver's point until it meets the target.

    Returns two values: the word of the moved point, and the moved point.

    Where one arc leads to the target, several words share it, all within the solver's tolerance.
    Not each of them can be made to meet the target: if the solver's `word` cannot, the others are
    tried. z, shape (3,), holds the turns to the left and to the right (rad) of the solver's point,
    then its straight.
    """
    distance = math.hypot(target.X, target.Y)
    rounding = 8 * EPS * (1 + distance + scenario.extent / scenario.radius)
    first = None
    for name in (word, *(other for other in words if other != word)):
        case = case_of(name, target)
        turns = z
        if case.subproblem.mirrored:
            turns = z[[1, 0, 2]]
        point, miss = polish(case, turns)
        polished = Polished(point, miss, miss <= rounding)
        if polished.meets and abs(point.sum() - z.sum()) <= _NEAR * (1 + z.sum()):
            return name, polished
        first = first or polished
    assert first is not None  # `word` itself is always tried
    return word, first


def one_sided_only(question: Question, target: Local, path: Path) -> str | None:
    """The reason to reject a path, or None.

    The path turns one way and arrives, and the branch is `LS` or `RS`. The path may go straight
    first, and so enter the turning circle, which no path of the word does. So the word is driven
    with the path's own turn and straight, moved until they meet the target.
    """
    scenario = question.scenario
    word = question.branch
    if word not in ("LS", "RS"):
        return None
    case = case_of(word, target)
    turn = abs(path.turn)
    free = list(case.subproblem.free)
    straight = path.length / scenario.radius - turn
    assert scenario.target is not None
    missed = math.dist(path.end[:2], scenario.target) / scenario.radius
    arcs = turn % TWO_PI, min(turn, TWO_PI)  # either side of a full turn
    # within delta of the target the word may exist; EPS is the rounding of the word's own end
    allowed = max(missed + EPS, target.delta)
    least = math.inf
    # On the circle, without a straight, the equations are singular: begin a little outside as well.
    for arc, outside in product(arcs, (0.0, _OUTSIDE)):
        moved = min(outside, arc / 2)
        z = np.zeros(3)
        z[free] = arc - moved, straight + moved
        least = min(least, polish(case, z)[1])
        if least <= allowed:
            return None
    return f"turning to one side arrives, but {word} itself misses by {least:.1e} radii"


def polish(case: Case, z: FloatArray) -> tuple[FloatArray, float]:
    """Move a case's z nearest to the target.

    Returns two values: the moved point, and its miss (radii). Each step solves the two
    linearised equations: with two free lengths it is Newton's step, with three the shortest such
    step. The step is cut to the lengths that the case allows and halved until it gains. z, shape
    (3,), is in the case's own order of turns.
    """
    X, Y, _ = case.target
    free = list(case.subproblem.free)
    upper = case.upper[free]
    current = np.clip(z, 0.0, case.upper)
    residual = equations(current, X, Y)
    for _ in range(_STEPS):
        step = np.linalg.lstsq(jacobian(current)[:, free], -residual, rcond=None)[0]
        for halving in range(_HALVINGS):
            trial = current.copy()
            trial[free] = np.clip(current[free] + step * 0.5**halving, 0.0, upper)
            trial_residual = equations(trial, X, Y)
            if np.hypot(*trial_residual) < np.hypot(*residual):
                current = trial
                residual = trial_residual
                break
        else:  # no part of the step gains
            break
    return current, float(np.hypot(*residual))

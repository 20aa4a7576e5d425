"""Shortest paths by search, ends by an ODE integrator.

No formula is shared with the package. A word is a family of paths with one free angle; the zeros
of what is left over at its end are searched on a grid of that angle and bisected.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from dubins_study.study.path import Path

Array = NDArray[np.float64]
_GRID = np.linspace(0.0, 2 * math.pi, 4001)


def words_by_search(X: float, Y: float) -> dict[str, float]:
    """Least length of every word.

    Infinite where a word has no path to the target.
    """
    words = {"LS": _ending_straight(X, Y), "RS": _ending_straight(X, -Y)}
    return words | {"LR": _two_arcs(X, Y), "RL": _two_arcs(X, -Y)}


def _ending_straight(X: float, Y: float) -> float:
    """Least length of LS.

    The search is over the arcs after which the target lies straight ahead.
    """

    def off(a: Array) -> Array:
        x, y = np.sin(a), 1 - np.cos(a)
        return np.cos(a) * (Y - y) - np.sin(a) * (X - x)

    best = math.inf
    for a in _zeros(off):
        ahead = math.cos(a) * (X - math.sin(a)) + math.sin(a) * (Y - 1 + math.cos(a))
        if ahead >= 0:
            best = min(best, a + ahead)
    return best


def _two_arcs(X: float, Y: float) -> float:
    """Least length of LR.

    The search is over the first arcs after which the target lies on the second circle.
    """

    def off(a: Array) -> Array:
        return np.hypot(X - 2 * np.sin(a), Y - 1 + 2 * np.cos(a)) - 1

    best = math.inf
    for a in _zeros(off):
        x, y = 2 * math.sin(a), 1 - 2 * math.cos(a)  # centre of the second circle
        begin = math.atan2(math.cos(a), -math.sin(a))
        end = math.atan2(Y - y, X - x)
        best = min(best, a + (begin - end) % (2 * math.pi))
    return best


def pose_words_by_search(X: float, Y: float, heading: float) -> dict[str, float]:
    """Least length of each word to a pose.

    Infinite where it has no path. The middle arc of RLR and LRL is pi or more.
    """
    left = {word: _to_pose(word, X, Y, heading) for word in ("LSL", "LSR", "LRL")}
    mirrored = str.maketrans("LR", "RL")
    right = {word.translate(mirrored): _to_pose(word, X, -Y, -heading) for word in left}
    return left | right


def _to_pose(word: str, X: float, Y: float, heading: float) -> float:
    """Least length of a word that begins with L.

    The search is over the first arcs after which the rest fits.
    """
    last = 1 if word[2] == "L" else -1
    x, y = X - last * math.sin(heading), Y + last * math.cos(heading)  # the last circle's centre

    def off(t: Array) -> Array:
        if word[1] == "S":  # how far the line is from touching the last circle
            across = np.cos(t) * (y - 1 + np.cos(t)) - np.sin(t) * (x - np.sin(t))
            return across - last
        return np.hypot(x - 2 * np.sin(t), y - 1 + 2 * np.cos(t)) - 2

    best = math.inf
    for t in _zeros(off):
        if word[1] == "S":
            middle = math.cos(t) * (x - math.sin(t)) + math.sin(t) * (y - 1 + math.cos(t))
            if middle < 0:
                continue
            rest = last * (heading - t) % (2 * math.pi)
        else:
            # of the middle circle
            x2 = 2 * math.sin(t)
            y2 = 1 - 2 * math.cos(t)
            begin = math.atan2(1 - y2, -x2)
            end = math.atan2(y - y2, x - x2)
            middle = (begin - end) % (2 * math.pi)
            if middle < math.pi:
                continue
            rest = (heading - t + middle) % (2 * math.pi)
        best = min(best, t + middle + rest)
    return best


def _zeros(function: Callable[[Array], Array]) -> list[float]:
    """Zeros of a function of an angle, bisected.

    They are changes of sign in [0, 2 pi].
    """
    values = function(_GRID)
    at = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    low, high = _GRID[at].copy(), _GRID[at + 1].copy()
    below = np.sign(values[at])
    for _ in range(60):
        middle = (low + high) / 2
        same = np.sign(function(middle)) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return ((low + high) / 2).tolist()


def integrated(path: Path, radius: float = 1.0) -> Array:
    """End pose of a path by integration at 1e-12.

    The equations are x' = cos, y' = sin, heading' = curvature.

    In units of the radius, so that the integrator's tolerances mean the same everywhere.
    """
    pose: Array = np.array(path.start, dtype=float)
    for k, length in zip(path.curvatures * radius, path.lengths / radius, strict=True):
        if length > 0:
            arc = solve_ivp(
                lambda _, q, k=k: (math.cos(q[2]), math.sin(q[2]), k),
                (0, length),
                [0, 0, pose[2]],
                method="DOP853",
                rtol=1e-12,
                atol=1e-12,
            )
            moved = arc.y[:, -1]
            pose = np.array([*(pose[:2] + radius * moved[:2]), moved[2]])
    return pose

"""The pieces of a path that matter, in units of its radius: what its certificate is read from."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from dubins_study.study.check.two_arcs import FULL_RATE, NO_LENGTH, NO_TURN
from dubins_study.study.path import FEW, FloatArray, Path, corners
from dubins_study.study.scenario import Pose
from dubins_study.study.tolerances import ARRIVES, DRIVEN

_ORIGIN = Pose(0.0, 0.0, 0.0)


class Pieces(NamedTuple):
    """A path in units of its radius: start heading (rad), rates u and lengths of shape (n,)."""

    heading: float
    u: FloatArray
    length: FloatArray


def pieces(path: Path, radius: float) -> Pieces:
    """The pieces of a path that matter, or all of them where leaving some out would show.

    Rates within `FULL_RATE` of +1, 0 or -1 are these, neighbours of one rate are joined, what turns
    by less than `NO_TURN` is straight, and a straight shorter than `NO_LENGTH` is left out: solvers
    return such arcs where they mean none. Small things add up, and far away a small turn is a long
    way: if that merged path ends elsewhere or is shorter than the driven one by more than the check
    allows, it is another path, and the driven one's own pieces stand.
    """
    rate, scaled = path.curvature * radius, path.length / radius
    if rate.size <= FEW and _apart(rate.tolist(), scaled.tolist()):
        return Pieces(path.start.heading, rate, scaled)
    if not scaled.all():
        rate, scaled = rate[scaled != 0], scaled[scaled != 0]
    merged = _merged(rate, scaled)
    u, length = merged if _is_same(merged, (rate, scaled)) else (rate, scaled)
    return Pieces(path.start.heading, u, length)


def _merged(rate: FloatArray, scaled: FloatArray) -> tuple[FloatArray, FloatArray]:
    whole = np.clip(np.round(rate), -1, 1)
    u, length = _joined(np.where(np.abs(rate - whole) <= FULL_RATE, whole, rate), scaled)
    turns = np.abs(u) * length > NO_TURN
    if turns.all():
        return u, length
    kept = turns | (length > NO_LENGTH * min(1.0, float(length.sum())))
    return _joined(np.where(turns, u, 0.0)[kept], length[kept])


def _is_same(merged: tuple[FloatArray, FloatArray], driven: tuple[FloatArray, FloatArray]) -> bool:
    """Whether a merged path is the driven one, its end and its length compared."""
    before = float(driven[1].sum())
    allowed = ARRIVES + DRIVEN * before
    if not abs(before - float(merged[1].sum())) <= allowed:
        return False
    end, other = (corners(_ORIGIN, *path)[-1] for path in (merged, driven))
    return math.hypot(end[0] - other[0], end[1] - other[1]) <= allowed


def _apart(u: list[float], length: list[float]) -> bool:
    """Whether every piece turns or is a straight that matters, and no neighbours are of one rate.

    True of most paths of few pieces, which then need no further work. One or two pieces are so
    only if their rates need no rounding either, since they may have a cut margin.
    """
    least = NO_LENGTH * min(1.0, sum(length))
    return (
        all(
            abs(k) * s > NO_TURN if abs(k) > FULL_RATE else k == 0 and s > least
            for k, s in zip(u, length, strict=True)
        )
        and all(abs(a - b) > FULL_RATE for a, b in pairwise(u))
        and (len(u) > 2 or all(k == 0 or not 0 < abs(abs(k) - 1) <= FULL_RATE for k in u))
    )


def _joined(u: FloatArray, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Neighbours of one rate made one."""
    if u.size < 2:
        return u, length
    begins = np.abs(u[1:] - u[:-1]) > FULL_RATE
    if begins.all():
        return u, length
    first = np.concatenate(([0], 1 + np.flatnonzero(begins)))
    joined: FloatArray = np.add.reduceat(length, first)
    return u[first], joined

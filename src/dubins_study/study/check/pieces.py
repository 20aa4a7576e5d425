"""The pieces of a path that matter, in units of its radius: what its certificate is read from."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from dubins_study.study.check.two_arcs import FULL_RATE, WORD
from dubins_study.study.path import FEW, FloatArray, Path

_LOST = 1e-4  # share of a path's length; leaving out more would describe another path


class Pieces(NamedTuple):
    """A path in units of its radius: start heading (rad), rates u and lengths of shape (n,)."""

    heading: float
    u: FloatArray
    length: FloatArray


def pieces(path: Path, radius: float) -> Pieces:
    """The pieces of a path that matter, neighbours of one rate joined.

    As in `Path.word`, what turns by less than 1e-6 rad is straight, and a straight shorter than
    1e-6 of the path is left out: solvers return such arcs where they mean none.
    """
    rate, scaled = path.curvature * radius, path.length / radius
    if rate.size <= FEW and _apart(rate.tolist(), scaled.tolist()):
        return Pieces(path.start.heading, rate, scaled)
    rate[np.abs(rate) <= FULL_RATE] = 0.0
    u, length = _joined(rate, scaled)
    total = float(length.sum())
    turns = np.abs(u) * length > WORD
    kept = turns | (length > WORD * total)
    if not turns.all() and length[kept].sum() >= (1 - _LOST) * total:
        u, length = _joined(np.where(turns, u, 0.0)[kept], length[kept])
    return Pieces(path.start.heading, u, length)


def _apart(u: list[float], length: list[float]) -> bool:
    """Whether every piece turns or is a straight that matters, and no neighbours are of one rate.

    True of the closed form's pieces and most solvers', which then need no further work.
    """
    least = WORD * sum(length)
    return all(
        abs(k) * s > WORD if abs(k) > FULL_RATE else k == 0 and s > least
        for k, s in zip(u, length, strict=True)
    ) and all(abs(a - b) > FULL_RATE for a, b in pairwise(u))


def _joined(u: FloatArray, length: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Neighbours of one rate made one; what has no length is left out."""
    if not length.all():
        u, length = u[length != 0], length[length != 0]
    if u.size < 2:
        return u, length
    begins = np.abs(u[1:] - u[:-1]) > FULL_RATE
    if begins.all():
        return u, length
    first = np.concatenate(([0], 1 + np.flatnonzero(begins)))
    joined: FloatArray = np.add.reduceat(length, first)
    return u[first], joined

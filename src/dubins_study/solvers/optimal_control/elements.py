"""A path as a transcription sees it: n elements, each of one turn rate."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from dubins_study.study.path import FloatArray, Path
from dubins_study.study.scenario import Pose

HERE = Pose(0.0, 0.0, 0.0)
# Bounds on turns (rad). A shortest path turns by less than a full turn and, if it has two arcs, by
# pi/3 at most the other way (docs/derivation.md, section 4): elements of free length share
# MOST_TURN. No equally long element needs more than half a turn. Without these bounds a few
# elements take all the turning: full turns that lead nowhere, which in a collocated element even
# make the path shorter, by the error of the quadrature.
MOST_TURN = 3 * math.pi
MOST_TURN_EACH = math.pi
LEAST = 1e-3  # radii; elements of no length would be a poor guess


class Elements(NamedTuple):
    """Turns (n,) in rad, positive to the left, and lengths (n,) in radii of the elements."""

    turn: FloatArray
    length: FloatArray

    @property
    def rate(self) -> FloatArray:
        """Turn rates (n,) in units of 1 / radius; 0 for an element of no length."""
        some = self.length > 0
        return np.divide(self.turn, self.length, out=np.zeros_like(self.turn), where=some)

    @property
    def total(self) -> float:
        return float(self.length.sum())

    @property
    def path(self) -> Path:
        """The path in the vehicle's frame at unit radius."""
        return Path(HERE, self.rate, self.length)


def cut(path: Path, n: int, shares: FloatArray | None) -> Elements:
    """A path in the vehicle's frame at unit radius as n elements, not all of them of length 0.

    Elements with given shares (n,) of the whole length turn as the path does over their length.
    Otherwise every arc is cut into equal parts, so many that the parts of all arcs turn by similar
    angles; a path of more than n arcs becomes equally long elements.
    """
    some = path.length > 0
    curvature, length = path.curvature[some], path.length[some]
    if shares is None and length.size > n:
        shares = np.full(n, 1 / n)
    if shares is not None:
        ends = np.concatenate(([0.0], np.cumsum(shares)))
        ends[-1] = 1.0
        heading = path.at(ends * path.total_length)[:, 2]
        return Elements(np.diff(heading), shares * path.total_length)
    turn = curvature * length
    parts = np.ones(turn.size, dtype=int)
    for _ in range(n - turn.size):
        parts[np.argmax((np.abs(turn) + LEAST) / parts)] += 1
    return Elements(np.repeat(turn / parts, parts), np.repeat(length / parts, parts))

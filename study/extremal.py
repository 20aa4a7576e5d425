"""Pontryagin's conditions and the cut, checked from a path's controls alone.

In the paper's convention (2.3)-(2.15): H = nu0 + nu1 cos theta + nu2 sin theta + nu3 u is
minimised and zero, with u the curvature in units of 1 / radius and positions in radii. The paper
leaves out nu0 >= 0, (nu0, nu) not all zero, and nu3 = 0 at the free final heading (THEORY
section 6). On an extremal all of

    H = 0 on every piece,    nu3 = 0 on every straight,    nu3 = 0 at the end

are linear in (nu0, nu1, nu2, nu3 at the end): nu3 = nu1 (y - y_end) - nu2 (x - x_end) + constant.
So the costates are the null vector of a small matrix, and how far a path is from being an
extremal is how far that matrix is from having one (docs/derivation.md, section 9).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from study.path import FloatArray, Path, rollout
from study.scenario import Pose
from study.verify import WORD

_ORIGIN = Pose(0.0, 0.0, 0.0)

# columns of `study.schema` that hold what is measured here
MEASURED = (
    "costate_x",
    "costate_y",
    "hamiltonian",
    "sign_margin",
    "transversality",
    "pmp_residual",
    "cut_margin",
)
# a costate nu0 below this share of (nu1, nu2) is none: the extremal is abnormal
ABNORMAL = 1e-9
_LOST = 1e-4  # of a path's length; what passes over more describes another path
_TURN = 2 * math.pi
FULL_RATE = 1e-9  # how far from +1, -1 or 0 a rate may be and still name a letter


class Extremal(NamedTuple):
    """What Pontryagin's conditions say of a path.

    Residuals are for costates scaled to max(nu0, |(nu1, nu2)|) = 1, and nu3 is divided by the
    path's length in radii where that exceeds 1, so that they are errors of angles.

    Args:
        nu: (nu1, nu2) in the world frame with nu0 = 1, or of norm 1 if abnormal.
        abnormal: whether nu0 = 0.
        hamiltonian: max |H| over the path.
        sign_margin: least -u nu3 over the turning pieces; below 0 a turn goes the wrong way.
        transversality: |nu3| at the end.
        residual: the worst of all violations, those of nu3 = 0 on straights included.
    """

    nu: tuple[float, float]
    abnormal: bool
    hamiltonian: float
    sign_margin: float
    transversality: float
    residual: float


class Pieces(NamedTuple):
    """A path in units of its radius: start heading (rad), rates u and lengths of shape (n,)."""

    heading: float
    u: FloatArray
    length: FloatArray


def pieces(path: Path, radius: float) -> Pieces:
    """The pieces of a path that matter, neighbours of one rate joined.

    As in `Path.word`, what turns by less than 1e-6 rad is straight, and a straight shorter than
    1e-6 of the path is passed over: a solver leaves such where it means none.
    """
    rate = path.curvature * radius
    rate[np.abs(rate) <= FULL_RATE] = 0.0
    u, length = _joined(rate, path.length / radius)
    total = float(length.sum())
    turns = np.abs(u) * length > WORD
    kept = turns | (length > WORD * total)
    if not turns.all() and length[kept].sum() >= (1 - _LOST) * total:
        u, length = _joined(np.where(turns, u, 0.0)[kept], length[kept])
    return Pieces(path.start.heading, u, length)


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


def extremal(driven: Pieces) -> Extremal | None:
    """The costates that fit a path best, and how well; None for a path of no length."""
    start, u, length = driven
    n = u.size
    if not n:
        return None
    # in the frame of the start, where angles are small; the costates are turned back at the end
    poses = rollout(_ORIGIN, u, length)
    stretch = max(1.0, float(length.sum()))
    # columns: nu0, nu1, nu2, nu3 at the end
    nu3 = np.empty((n + 1, 4))
    nu3[:, 0], nu3[:, 3] = 0.0, 1.0
    nu3[:, 1], nu3[:, 2] = poses[:, 1] - poses[-1, 1], poses[-1, 0] - poses[:, 0]
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    # H is constant along a piece: one row for each
    hamiltonian = u[:, None] * nu3[:-1]
    hamiltonian[:, 0] += 1.0
    hamiltonian[:, 1] += cos[:-1]
    hamiltonian[:, 2] += sin[:-1]
    straight = np.abs(u) < 1 - FULL_RATE
    ends = np.zeros(n + 1, np.bool_)
    ends[:-1] = straight
    ends[1:] |= straight
    still = nu3[ends] / stretch
    # the row of zeros keeps the matrix as high as it is wide
    rows = [hamiltonian, still, nu3[-1:], np.zeros((1, 4))]
    if n == 1 and not straight[0]:
        # a single arc has a family of costates; the one of a straight of no length after it
        rows.append(np.array([[0.0, -sin[-1], cos[-1], 0.0]]))
    costates = np.linalg.svd(np.concatenate(rows), full_matrices=False)[2][-1]
    costates = costates / max(abs(costates[0]), math.hypot(costates[1], costates[2]))
    abnormal = bool(abs(costates[0]) < ABNORMAL)
    signs = (1.0, -1.0) if abnormal else (math.copysign(1.0, costates[0]),)
    arcs = poses[:-1, 2][u != 0], poses[1:, 2][u != 0]
    margin, sign = max((_sign_margin(sign * costates, *arcs), sign) for sign in signs)
    found = sign * costates
    H = float(np.abs(hamiltonian @ found).max())
    transversality = abs(float(found[3])) / stretch
    off_straight = float(np.abs(still @ found).max()) if still.size else 0.0
    nu1, nu2 = (found[1:3] if abnormal else found[1:3] / found[0]).tolist()
    c, s = math.cos(start), math.sin(start)
    return Extremal(
        nu=(nu1 * c - nu2 * s, nu1 * s + nu2 * c),
        abnormal=abnormal,
        hamiltonian=H,
        sign_margin=margin,
        transversality=transversality,
        residual=max(H, transversality, off_straight, -margin),
    )


def _sign_margin(costates: FloatArray, before: FloatArray, after: FloatArray) -> float:
    """Least nu0 + nu1 cos + nu2 sin over the turning pieces, which is -u nu3 where H = 0.

    `before` and `after` are the headings (rad) at the arcs' ends.
    """
    if not before.size:
        return 0.0
    nu0, nu1, nu2, _ = costates.tolist()
    # least at the heading opposite to (nu1, nu2) if an arc passes through it, or at an end
    a, b = before - math.atan2(-nu2, -nu1), after - math.atan2(-nu2, -nu1)
    passed = np.floor(np.maximum(a, b) / _TURN) > np.floor(np.minimum(a, b) / _TURN)
    nearest = np.where(passed, 1.0, np.maximum(np.cos(a), np.cos(b)))
    return float(nu0 - math.hypot(nu1, nu2) * nearest.max())


def cut_margin(driven: Pieces) -> float | None:
    """By how much (rad) a path stays clear of where another one becomes shorter.

    A path with a margin above zero is shortest to its own end point, and only such a path is
    (THEORY section 3; docs/derivation.md, section 10). None if it is not of a word S, C, CS or CC
    at full rate, which no shortest path can be.
    """
    if driven.u.size > 2:
        return None
    rates = [round(u) if abs(u - round(u)) <= FULL_RATE else None for u in driven.u.tolist()]
    length = driven.length.tolist()
    match rates:
        case [] | [0]:
            return math.pi
        case [1 | -1]:
            return cut_margin_cs(length[0], 0.0)
        case [1 | -1, 0]:
            return cut_margin_cs(length[0], length[1])
        case [1, -1] | [-1, 1]:
            return cut_margin_cc(length[0], length[1])
    return None


def cut_margin_cs(arc: float, straight: float) -> float:
    """Margin (rad) of an arc (rad) and a straight (radii): arc <= 2 (pi - atan(straight))."""
    return 2 * (math.pi - math.atan(straight)) - arc


def cut_margin_cc(first: float, second: float) -> float:
    """Margin (rad) of two arcs (rad): the second in (pi, 2 pi), the first short enough."""
    longest = 2 * math.atan2(-math.sin(second), 2 - math.cos(second))
    return min(second - math.pi, 2 * math.pi - second, longest - first)

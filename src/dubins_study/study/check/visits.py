"""Find where a path visits points.

The points have a given order or any. Only the path's arcs and straights are used.

A point (x, y) is seen from the start of a piece of curvature k >= 0, mirrored if the piece turns to
the right. It lies g = (k (x^2 + y^2) - 2 y) / (1 + D) from the piece's circle or line, where D =
hypot(k x, 1 - k y) is the distance from the centre times k. The piece passes it after atan2(k x, 1
- k y) / k, and d farther along their distance is the root of g^2 + D (2 sin(k d / 2) / k)^2. None
of these formulas cancels as k goes to 0, where the piece is a straight (docs/derivation.md, section
17).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Stop
from dubins_study.study.tolerances import DRIVEN, HEADED

_STRAIGHT = 1e-100  # a curvature times radius that no coordinate can tell from 0
# radii, or share of a leg shorter than a radius. A shorter piece at the end of a leg belongs to its
# neighbour and was cut off beside the point.
CUT = 1e-5
_PIECES_AT_ONCE = 32  # a visit is nearly always in the next few pieces; otherwise all are searched


class Visits(NamedTuple):
    """Visits of a path to points.

    Args:
        at: arc lengths (length unit) at which the path is nearest to each point, not decreasing.
        poses: the position of each visit, and the heading there (rad, not wrapped).
        order: the places of the points in the scenario, in the order of their visits.
        miss: the largest distance by which the path misses a point (length unit), 0 without points.
            Of a point that is not visited, it is the least distance on the rest of the path.
        turned: the largest angle between the path and a heading that is given at a point (rad).
    """

    at: tuple[float, ...]
    poses: tuple[Pose, ...]
    order: tuple[int, ...]
    miss: float
    turned: float


def visits(
    path: Path, via: Sequence[Stop], radius: float, allowed: float, any_order: bool = False
) -> Visits:
    """Follow a path from point to point.

    The earliest visit of each point counts, after the one before.

    Args:
        path: one that can be driven.
        via: the points, in order, with the headings that are given there.
        radius: the unit in which a piece's geometry is computed.
        allowed: how near a path has to come to visit a point (length unit).
        any_order: whether the visit of each point is its earliest on the whole path.
    """
    if not via:
        return Visits(at=(), poses=(), order=(), miss=0.0, turned=0.0)
    pieces = _Pieces(path, radius)
    at = 0.0
    nearest = 0.0
    miss = 0.0
    arc_lengths: list[float] = []
    for stop in via:
        # at: where the path comes within `allowed`; reached: where it then is nearest
        if any_order:
            at = 0.0
        at, reached, distance = pieces.visit(stop, at=at, allowed=allowed / radius)
        if not any_order:
            reached = max(nearest, reached)
        nearest = reached
        miss = max(miss, distance * radius)
        arc_lengths.append(min(nearest * radius, path.length))
    order = np.argsort(arc_lengths, kind="stable").tolist()
    along = [arc_lengths[i] for i in order]
    poses = tuple(Pose(*pose) for pose in path.at(np.array(along)).tolist())
    turned = 0.0
    for i, pose in zip(order, poses, strict=True):
        driven = arc_lengths[i] / radius
        turned = max(turned, off_heading(via[i].heading, pose.heading, driven))
    return Visits(at=tuple(along), poses=poses, order=tuple(order), miss=miss, turned=turned)


def off_heading(given: float | None, heading: float, driven: float) -> float:
    """Error of a heading (rad), less its rounding.

    It is 0 where the heading is free.

    Args:
        driven: length of the path up to there (radii), over which headings are rounded.
    """
    if given is None:
        return 0.0
    blur = DRIVEN * (abs(heading) + abs(given) + driven)
    return max(abs(math.remainder(heading - given, TWO_PI)) - blur, 0.0)


class _Pieces:
    """Pieces of a path, in units of the radius."""

    def __init__(self, path: Path, radius: float) -> None:
        self.radius = radius
        self.length = path.lengths / radius
        self.ends = np.concatenate(([0.0], np.cumsum(self.length)))
        rate = path.curvatures * radius
        self.k = np.maximum(np.abs(rate), _STRAIGHT)
        self.side = np.where(rate < 0, -1.0, 1.0)
        poses = path.poses
        self.x, self.y, self.heading = poses[:-1].T
        self.cos = np.cos(self.heading)
        self.sin = np.sin(self.heading)
        self.last = Pose(*poses[-1])

    def visit(self, stop: Stop, at: float, allowed: float) -> tuple[float, float, float]:
        """First visit of a point after an arc length.

        The arc length is `at`. If the point has a heading, the visit has it too.

        Returns:
            Where the path first is within the allowed distance, where it then is nearest, and how
            near. If it never is within, the last two are of its least distance after `at`, and the
            first equals the second.
        """
        x, y, heading = stop
        if not self.length.size:
            return 0.0, 0.0, math.hypot(x - self.last.x, y - self.last.y) / self.radius
        n = self.length.size
        begin = min(int(np.searchsorted(self.ends, at, "right")) - 1, n - 1)
        for end in (min(begin + _PIECES_AT_ONCE, n), n):
            within, nearest, distance = self._passing(
                slice(begin, end), x, y, at=at, allowed=allowed
            )
            # pieces in which the path comes within the distance, and in which it then is nearest
            chosen = None
            for first in np.flatnonzero(~np.isnan(within)).tolist():
                last = self._nearest_piece(first, begin, nearest, distance)
                if heading is None or self._fits(heading, piece=begin + last, along=nearest[last]):
                    chosen = first, last
                    break
                if chosen is None and end == n:  # the first one counts if none has the heading
                    chosen = first, last
            # beyond the pieces that were searched the path may still come nearer
            if chosen is not None and (begin + chosen[1] + 1 < end or end == n):
                first, last = chosen
                visited = max(at, float(self.ends[begin + first] + within[first]))
                reached = max(at, float(self.ends[begin + last] + nearest[last]))
                return visited, reached, float(distance[last])
        i = int(np.argmin(distance))
        reached = float(self.ends[begin + i] + nearest[i])
        return reached, reached, float(distance[i])

    def _nearest_piece(
        self, first: int, begin: int, nearest: FloatArray, distance: FloatArray
    ) -> int:
        """Piece that is nearest, from `first` on.

        It goes on as long as the path still comes nearer at the end of a piece. `begin` is the
        number of the piece that the arrays begin with.
        """
        last = first
        while last + 1 < nearest.size and nearest[last] >= self.length[begin + last]:
            if distance[last + 1] > distance[last]:
                break
            last += 1
        return last

    def _fits(self, given: float, piece: int, along: float) -> bool:
        """Whether a piece has a heading at a place.

        The place is given by its distance along the piece.
        """
        heading = self.heading[piece] + self.side[piece] * self.k[piece] * along
        return off_heading(given, float(heading), float(self.ends[-1])) <= HEADED

    @np.errstate(all="ignore")  # an overflow is no visit
    def _passing(
        self, part: slice, x: float, y: float, at: float, allowed: float
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Where each piece passes a point.

        Places from the arc length `at` on count, measured from the piece's start. Returns where it
        first is within the allowed distance, NaN if nowhere; where it then is nearest; and how
        near. If it never is within, the last two are of its least distance.
        """
        k = self.k[part]
        length = self.length[part]
        dx = (x - self.x[part]) / self.radius
        dy = (y - self.y[part]) / self.radius
        X = dx * self.cos[part] + dy * self.sin[part]
        Y = (dy * self.cos[part] - dx * self.sin[part]) * self.side[part]
        D = np.hypot(k * X, 1.0 - k * Y)
        g = (k * (X * X + Y * Y) - 2.0 * Y) / (1.0 + D)
        middle = np.arctan2(k * X, 1.0 - k * Y) / k
        turn = 2.0 * math.pi / k
        begin = np.clip(at - self.ends[:-1][part], 0.0, length)
        chord = np.sqrt((allowed - np.abs(g)) * (allowed + np.abs(g)) / D)  # NaN: never within
        width = 2.0 * np.arcsin(np.minimum(1.0, 0.5 * k * chord)) / k
        passed = middle + np.ceil((begin - width - middle) / turn) * turn
        first = np.maximum(passed - width, begin)
        within = first <= length  # False for NaN
        later = middle + np.ceil((begin - middle) / turn) * turn

        def distance(along: FloatArray) -> FloatArray:
            away: FloatArray = 2.0 * np.sin(0.5 * k * (along - middle)) / k
            together: FloatArray = np.hypot(g, np.sqrt(D) * away)
            return together

        end = np.where(distance(begin) <= distance(length), begin, length)
        # Within the distance: the nearest place of that visit. Else the circle's nearest place, if
        # it is still ahead on the piece, or else the nearer end of the piece.
        least = np.where(
            within, np.clip(passed, begin, length), np.where(later <= length, later, end)
        )
        near = distance(least)
        near[np.isnan(near)] = math.inf
        return np.where(within, first, math.nan), least, near


def cut_out(ends: FloatArray, begin: float, end: float) -> tuple[slice, FloatArray]:
    """Pieces of a path between two arc lengths.

    Returns the slice of these pieces, and how much of each lies between the two arc lengths.

    Args:
        ends: of n pieces, shape (n + 1,); the first is 0.
    """
    first = max(int(np.searchsorted(ends, begin, "right")) - 1, 0)
    part = slice(first, int(np.searchsorted(ends, end, "left")))
    return part, np.minimum(ends[1:][part], end) - np.maximum(ends[:-1][part], begin)


def legs(path: Path, at: Sequence[float], radius: float) -> Iterator[Path]:
    """Legs of a path cut at arc lengths.

    Pieces of almost no length are left out.
    """
    starts = path.at(np.array([0.0, *at])).tolist()
    ends = np.concatenate(([0.0], np.cumsum(path.lengths)))
    cuts = [0.0, *at, float(ends[-1])]
    for start, begin, end in zip(starts, cuts, cuts[1:], strict=False):
        part, lengths = cut_out(ends, begin, end)
        mask = lengths > CUT * min(radius, lengths.sum())
        yield Path(Pose(*start), path.curvatures[part][mask], lengths[mask])

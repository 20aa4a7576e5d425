"""Paths of many arcs as a few points on a coarse grid, precise enough for a drawing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Steps along the larger side of a polyline's box. A drawing is at most about 1000 pixels wide.
GRID = 4000
# A chord of an arc of this angle (rad) is off by R angle^2 / 8: 0.3 % of the radius.
_ANGLE = 0.15
_FEWEST, _MOST = 2, 160  # points of a polyline
_TINY = float(np.finfo(np.float64).tiny)


class Polylines(NamedTuple):
    """Points on grids, one grid a path.

    Args:
        counts: shape (m,), number of points of each path; 0 of one that cannot be drawn.
        boxes: shape (m, 3): x and y of the grid's corner, and the distance of neighbours on it
            (length).
        places: shape (counts.sum(), 2): columns and rows of the grids, 0 to `GRID`.
    """

    counts: NDArray[np.int64]
    boxes: FloatArray
    places: NDArray[np.int16]


def polylines(starts: FloatArray, curvatures: FloatArray, lengths: FloatArray) -> Polylines:
    """Points of paths of equally many arcs, closest where they turn; both ends are among them.

    A path has no points if a number in it is not finite, a length is negative, or its points are
    too far away for numbers of 64 bits.

    Args:
        starts: shape (m, 3): x, y (length), heading (rad).
        curvatures: shape (m, n), 1/length; n is at least 1.
        lengths: shape (m, n), length.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        drawn = np.isfinite([_extent(starts), _extent(curvatures), _extent(lengths)]).all(axis=0)
        drawn &= (lengths >= 0).all(axis=1) & np.isfinite(_extent(curvatures * lengths))
        driven = _driven(starts[drawn], curvatures[drawn], lengths[drawn])
    counts = np.zeros(len(starts), dtype=np.int64)
    counts[drawn] = driven.counts
    boxes = np.zeros((len(starts), 3))
    boxes[drawn] = driven.boxes
    return Polylines(counts, boxes, driven.places)


def _extent(numbers: FloatArray) -> FloatArray:
    extent: FloatArray = np.abs(numbers).sum(axis=1)
    return extent


def _driven(starts: FloatArray, curvatures: FloatArray, lengths: FloatArray) -> Polylines:
    counts, row, piece, part = _where(curvatures, lengths)
    poses = _poses(starts, curvatures, lengths)[row, piece]
    k, driven = curvatures[row, piece], part * lengths[row, piece]
    points = poses[:, :2] + _chord(poses[:, 2], k, driven)
    if not len(points):
        return Polylines(counts, np.zeros((0, 3)), np.zeros((0, 2), dtype=np.int16))
    first = np.append(0, np.cumsum(counts)[:-1])
    low = np.minimum.reduceat(points, first)
    step = (np.maximum.reduceat(points, first) - low).max(axis=1) / GRID
    finite = np.isfinite(step) & np.isfinite(low).all(axis=1)
    step = np.maximum(step, _TINY)
    places = np.rint((points - low[row]) / step[row, None])[finite[row]].astype(np.int16)
    boxes = np.where(finite[:, None], np.column_stack([low, step]), 0.0)
    return Polylines(np.where(finite, counts, 0), boxes, places)


def _where(
    curvatures: FloatArray, lengths: FloatArray
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64], FloatArray]:
    """Where the points lie: how many a path, then for each its path, its arc, and the arc's part.

    The points are evenly spaced in a measure: turned angle, and a little of the length.
    """
    m, n = lengths.shape
    total = np.maximum(lengths.sum(axis=1, keepdims=True), _TINY)
    measure = np.abs(curvatures * lengths) / _ANGLE + lengths / total
    measured = np.hstack([np.zeros((m, 1)), np.cumsum(measure, axis=1)])
    whole = np.maximum(measured[:, -1:], _TINY)
    counts = np.clip(np.ceil(whole[:, 0]) + 1, _FEWEST, _MOST).astype(np.int64)
    row = np.repeat(np.arange(m), counts)
    number = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    # One interpolation for all paths: that of path i lies between 2 i and 2 i + 1.
    known = (measured / whole + 2 * np.arange(m)[:, None]).ravel()
    wanted = number / (counts[row] - 1) + 2 * row
    place = np.interp(wanted, known, np.tile(np.arange(n + 1.0), m))
    piece = np.minimum(place.astype(np.int64), n - 1)
    return counts, row, piece, place - piece


def _poses(starts: FloatArray, curvatures: FloatArray, lengths: FloatArray) -> FloatArray:
    """Poses at the beginnings of the arcs, shape (m, n, 3)."""
    before = np.cumsum(curvatures * lengths, axis=1) - curvatures * lengths
    headings = starts[:, 2:] + before
    chords = _chord(headings, curvatures, lengths)
    places = starts[:, None, :2] + np.cumsum(chords, axis=1) - chords
    return np.dstack([places, headings])


def _chord(heading: FloatArray, curvature: FloatArray, length: FloatArray) -> FloatArray:
    """Chords of arcs that begin at some headings, in a last axis of two (derivation, eq. 2)."""
    half = curvature * length / 2
    chord = length * np.sinc(half / np.pi)  # numpy's sinc(x) is sin(pi x) / (pi x)
    return np.stack([chord * np.cos(heading + half), chord * np.sin(heading + half)], axis=-1)

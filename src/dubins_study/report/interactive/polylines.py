"""Paths of many arcs as a few points on a coarse grid, precise enough for a drawing."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dubins_study.study.path import Path, drivable

# Steps along the larger side of a polyline's box. A drawing is at most about 1000 pixels wide.
GRID = 4000
# A chord of an arc of this angle (rad) is off by R angle^2 / 8: 0.3 % of the radius.
_ANGLE = 0.15
_LEAST_POINTS, _MOST_POINTS = 2, 160


class Polyline(NamedTuple):
    """Points on a grid.

    Args:
        x, y: the place of the grid's point (0, 0), length.
        step: distance between neighbours on the grid, length.
        places: shape (n, 2): columns and rows of the grid, 0 to `GRID`.
    """

    x: float
    y: float
    step: float
    places: NDArray[np.int16]


def polyline(path: Path) -> Polyline | None:
    """Points of a path, closest where it turns; both ends are among them.

    None of a path that cannot be driven, or that is too large for numbers of 64 bits.
    """
    if not drivable(path) or not path.length.size:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        points = _points(path)
        low, size = points.min(axis=0), float(np.ptp(points, axis=0).max())
    if not np.isfinite([*low, size]).all():
        return None
    step = max(size / GRID, np.finfo(float).tiny)
    places = np.rint((points - low) / step).astype(np.int16)
    return Polyline(float(low[0]), float(low[1]), step, places)


def _points(path: Path) -> NDArray[np.float64]:
    total = max(path.total_length, np.finfo(float).tiny)
    # The points are evenly spaced in this measure: turned angle, and a little of the length.
    measure = np.abs(path.curvature * path.length) / _ANGLE + path.length / total
    measured, driven = (np.append(0.0, np.cumsum(each)) for each in (measure, path.length))
    number = int(np.clip(np.ceil(measured[-1]) + 1, _LEAST_POINTS, _MOST_POINTS))
    distances = np.interp(np.linspace(0.0, measured[-1], number), measured, driven)
    return path.at(distances)[:, :2]

"""Points as in practice: the laws of `field`.

The law `random` is in `plan.scenarios`.

A law takes a generator and a number n of steps. It returns n + 1 points, shape (n + 1, 2), in the
order in which they would be flown, the start first. Its unit is the distance that a block asks
for. The generator turns the whole field, so that none lies along an axis.
"""

from __future__ import annotations

import math

import numpy as np

from dubins_study.experiments.definition.scenario_block import FIELD_LAWS
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray

_BLOB = 0.3  # units; the standard deviation of a cluster
_NOISE = 0.1  # units; that of a GPS fix
_TURNING = 0.3  # rad; that of the change of a track's turn from one fix to the next
_TURN_SHARE = 0.8  # share of its turn that a track keeps until the next fix


def field_points(field: str, rng: np.random.Generator, steps: int, unit: float) -> FloatArray:
    """The points of a field, relative to its start.

    The start is left out. Shape (steps, 2), in the unit of `unit`.
    """
    points = _LAWS[field](rng, steps)
    turn = TWO_PI * float(rng.random())
    cos = math.cos(turn)
    sin = math.sin(turn)
    away = points[1:] - points[0]
    x = away[:, 0] * cos - away[:, 1] * sin
    y = away[:, 0] * sin + away[:, 1] * cos
    return unit * np.column_stack((x, y))


def _clusters(rng: np.random.Generator, steps: int) -> FloatArray:
    """Gaussian blobs in a square, one after another.

    There are about sqrt(n) centres; the square has a side of sqrt(n). Johnson and McGeoch 2007,
    clustered instances of the DIMACS challenge.
    """
    side = math.sqrt(steps + 1)
    centres = side * rng.random((max(round(side), 1), 2))
    owner = np.sort(rng.integers(len(centres), size=steps + 1))
    points: FloatArray = centres[owner] + _BLOB * rng.standard_normal((steps + 1, 2))
    return points


def _survey_rows(rng: np.random.Generator, steps: int) -> FloatArray:
    """Rows that are flown back and forth.

    Points of a row are one unit apart, rows half a unit to one unit. Choset and Pignon 1998,
    boustrophedon decomposition.
    """
    a_row = int(rng.integers(2, 2 + max(round(2 * math.sqrt(steps)), 1)))
    between = 0.5 + 0.5 * float(rng.random())
    # each point's row and its place in the row; every second row is flown backwards
    row, place = np.divmod(np.arange(steps + 1), a_row)
    along = np.where(row % 2 == 0, place, a_row - 1 - place)
    return np.column_stack((along.astype(np.float64), between * row))


def _roads(rng: np.random.Generator, steps: int) -> FloatArray:
    """Addresses along a drive, one on each block.

    The streets are one unit apart. At a crossing the drive goes straight on half of the time, else
    to the left or the right.
    """
    # 0 is straight on, 1 to the left, -1 to the right; their sum is a direction in quarter turns
    sides = np.cumsum(rng.choice([0, 0, 1, -1], size=steps + 1)) % 4
    directions = np.array([(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])[sides]
    # where each block begins
    crossings = np.cumsum(directions, axis=0) - directions
    points: FloatArray = crossings + directions * rng.random((steps + 1, 1))
    return points


def _gps(rng: np.random.Generator, steps: int) -> FloatArray:
    """Noisy fixes of a smooth track.

    The fixes are about one unit apart. From fix to fix the track's turn keeps a share of itself and
    changes at random.
    """
    turn = 0.0
    heading = 0.0
    x = y = 0.0
    track = [(x, y)]
    for change in rng.standard_normal(steps).tolist():
        turn = _TURN_SHARE * turn + _TURNING * change
        heading += turn
        x += math.cos(heading)
        y += math.sin(heading)
        track.append((x, y))
    points: FloatArray = np.array(track) + _NOISE * rng.standard_normal((steps + 1, 2))
    return points


_LAWS = dict(zip(FIELD_LAWS, (_clusters, _survey_rows, _roads, _gps), strict=True))

"""Frames of scenarios in every region.

The edges of each region are drawn on purpose.
"""

import math
from collections.abc import Iterable

import numpy as np
import pandas as pd

from dubins_study.study.scenario import Pose, Scenario
from tests.cases import driven, placed, scenario_frame


def hard_frame(n: int, seed: int = 0) -> pd.DataFrame:
    """n scenarios, a sixth of each kind.

    See `_target`. Radii are from 1e-6 to 1e6.
    """
    rng = np.random.default_rng(seed)
    return scenario_frame(_scenario(rng, row) for row in range(n))


def _scenario(rng: np.random.Generator, row: int) -> Scenario:
    R = 10 ** rng.uniform(-6, 6)
    heading = rng.uniform(-7, 7)
    if row % 17 == 0:
        heading = rng.choice([0, math.pi / 2, math.pi, -math.pi / 2, 2 * math.pi / 3])
    if row % 29 == 0:
        heading *= 10 ** rng.uniform(3, 15)
    X, Y = _target(rng, row % 6)
    x, y = rng.uniform(-5, 5, 2) * R if row % 2 else (0.0, 0.0)
    return placed(X, Y, x, y, heading, R, speed=rng.uniform(0.5, 3))


def _target(rng: np.random.Generator, kind: int) -> tuple[float, float]:
    """A target in radii, X forward, Y left."""
    sign = rng.choice([-1, 1], 2)
    if kind == 0:  # in and about the discs
        return tuple(rng.uniform(-3, 3, 2))
    angle = rng.uniform(-math.pi, math.pi)
    if kind == 1:  # at every distance
        r = 10 ** rng.uniform(-8, 3)
        return r * math.cos(angle), r * math.sin(angle)
    if kind == 2:  # on a circle and at every distance from it, front and rear
        r = 1 + rng.choice([-1, 0, 1]) * 10 ** rng.uniform(-16, -1)
        return r * math.sin(angle), sign[0] * (1 - r * math.cos(angle))
    if kind == 3:  # ahead, behind, and at the start, exactly or nearly
        X, Y = 10 ** rng.uniform(-16, 2, 2) * rng.choice([-1, 0, 1], 2)
        return X, Y
    if kind == 4:  # far
        X, Y = sign * 10 ** rng.uniform(0, 9, 2)
        return X, Y
    return tuple(rng.choice([0.0, 1, 2, -1, -2, 0.5], 2))  # round numbers


def hard_poses(n: int, seed: int = 0) -> pd.DataFrame:
    """n legs with a final heading, edges and random.

    They are the ends of driven paths whose segments are edges or random. Two thirds are then moved
    by 1e-16 to 1e-2 radii. Columns: those of `PoseArrays`.
    """
    rng = np.random.default_rng(seed)
    return pd.DataFrame([_hard_pose(rng, row) for row in range(n)])


_ARCS = (0.0, 0.0, math.pi / 2, math.pi, 2 * math.pi, 1e-9, 2 * math.pi - 1e-9)
_TURNS = ((1, 0, 1), (-1, 0, -1), (1, 0, -1), (-1, 0, 1), (-1, 1, -1), (1, -1, 1))


def _hard_pose(rng: np.random.Generator, row: int) -> dict[str, float]:
    pose = 0.0, 0.0, 0.0
    for turn in _TURNS[row % 6]:
        length = rng.choice(_ARCS) if rng.random() < 0.5 else rng.uniform(0, 2 * math.pi)
        if turn == 0:
            length = rng.choice((0.0, 1e-9, 1.0, 2.0, 4.0, 10 ** rng.uniform(-3, 3)))
        pose = driven(pose, turn, length)
    x, y, heading = pose
    if row % 7 == 0:  # round numbers
        x, y, heading = (*rng.choice([0.0, 1, 2, -1, -2, 4, 0.5], 2), rng.choice([0, 0.5, 1, -0.5]))
        heading *= math.pi
    if row % 3:
        x, y, heading = np.array([x, y, heading]) + rng.choice([-1, 0, 1], 3) * 10 ** rng.uniform(
            -16, -2, 3
        )
    R = 10 ** rng.uniform(-3, 3)
    start = rng.uniform(-math.pi, math.pi) * (row % 5 > 0)
    x0, y0 = rng.uniform(-5, 5, 2) * R * (row % 2)
    leg = placed(x, y, x0, y0, start, R)
    fields = ("x", "y", "heading", "target_x", "target_y", "radius")
    return {name: getattr(leg, name) for name in fields} | {"final_heading": start + heading}


def poses_of(row: Iterable[float]) -> tuple[Pose, Pose, float]:
    """Both poses and radius of a `hard_poses` row."""
    x, y, heading, target_x, target_y, radius, final = map(float, row)
    return Pose(x, y, heading), Pose(target_x, target_y, final), radius

"""Data and peers that more than one benchmark uses."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec

import numpy as np
import pandas as pd

from benchmarks.harness import sized

NAMES = ("x", "y", "heading", "target_x", "target_y", "radius")
# few enough that OMPL finds its states in the cache
PAIRS = 1_000
ROUNDS = sized(20, 1)
CALLS = PAIRS * ROUNDS  # of OMPL, in one timing
NO_OMPL = "ompl is not installed: pip install 'dubins-study[peers]'"


def random_frame(n: int, seed: int = 0) -> pd.DataFrame:
    """n scenarios in a square of ten length units.

    Radii are 0.5 to 2; a tenth lie in a disc.
    """
    rng = np.random.default_rng(seed)
    low, high = (-5, -5, -6, -5, -5, 0.5), (5, 5, 6, 5, 5, 2)
    return pd.DataFrame({k: rng.uniform(a, b, n) for k, a, b in zip(NAMES, low, high, strict=True)})


def ompl_distances() -> Callable[[], object] | None:
    """Time of OMPL's distances called from Python.

    `DubinsStateSpace.distance()` is called `CALLS` times, on poses made before. It answers an
    easier question, since the final heading is given. None without OMPL.
    """
    if find_spec("ompl") is None:
        return None
    from ompl import base

    space = base.DubinsStateSpace(1.0)

    def state(x: float, y: float, heading: float) -> object:
        pose = space.allocState()
        pose.setX(x)
        pose.setY(y)
        pose.setYaw(heading)
        return pose

    rows = random_frame(PAIRS)[["x", "y", "heading", "target_x", "target_y"]].to_numpy().tolist()
    pairs = [(state(x, y, (h + 7) % 6.28 - 3.14), state(u, v, 0.0)) for x, y, h, u, v in rows]
    distance = space.distance

    def every() -> None:
        for _ in range(ROUNDS):
            for start, end in pairs:
                distance(start, end)

    return every

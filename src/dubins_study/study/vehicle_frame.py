"""The target in the vehicle's frame, in units of the radius, and how exactly it is known."""

from __future__ import annotations

import math
from typing import NamedTuple

from dubins_study.study.scenario import Scenario

EPS = math.ulp(1.0)


class Local(NamedTuple):
    """A target in the vehicle's frame, in units of the radius.

    `rounding` bounds the error that the data's own rounding leaves in X and in Y.
    """

    X: float
    Y: float
    rounding: float

    @property
    def mirrored(self) -> Local:
        return Local(self.X, -self.Y, self.rounding)

    @property
    def w(self) -> float:
        """1 - |T - C_L|^2: positive inside the left turning circle, zero on it (snapped).

        Equals 2Y - r2, written so that it keeps its digits near the start and near (0, 2).
        The width of the snap is 4 times what `rounding` does to w.
        """
        return power(*self)


def power(X: float, Y: float, rounding: float) -> float:
    """`Local.w` of a target."""
    w = Y * (2.0 - Y) - X * X
    return 0.0 if abs(w) <= 8.0 * rounding * (1.0 + abs(X) + abs(Y)) else w


def local(scenario: Scenario) -> Local:
    """The target in the vehicle's frame, snapped to the axis or to the start within rounding.

    A coordinate read from the scenario is off by half an ulp, and so is the heading; the
    difference, the rotation and the division add a few more: 2 eps times the coordinates' size
    covers it (docs/derivation.md, section 5).
    """
    X, Y = scenario.local()
    rounding = 2.0 * EPS * scenario.extent / scenario.radius
    # next to the start w is snapped while |Y| is below 4 times the rounding
    if abs(X) <= rounding and abs(Y) <= 4.0 * rounding:
        return Local(0.0, 0.0, rounding)
    return Local(X, 0.0 if abs(Y) <= rounding else Y, rounding)

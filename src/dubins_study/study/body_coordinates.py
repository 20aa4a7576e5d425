"""The target in the vehicle's frame, and its uncertainty.

Coordinates are in units of the radius.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from dubins_study.study.scenario import Scenario

EPS = math.ulp(1.0)
# Errors of a target, in EPS, by the rounding of the data and of the transformation
# (docs/derivation.md, section 5). By extent: twice half an ulp of each coordinate. By distance: for
# every radius between start and target the heading's half ulp (up to pi), and the roundings of the
# transformation and of w.
PER_EXTENT = 2.0 * EPS
PER_DISTANCE = 12.0 * EPS


class Local(NamedTuple):
    """A target in the vehicle's frame and its uncertainty.

    X points forward, Y to the left, both in units of the radius. `delta` is the uncertainty of the
    data: every target whose X and Y are within delta of these stands for the same question.
    """

    X: float
    Y: float
    delta: float

    @property
    def mirrored(self) -> Local:
        return Local(self.X, -self.Y, self.delta)

    @property
    def w(self) -> float:
        """Power of the target: 1 - |T - C_L|^2.

        It is positive inside the left turning circle and zero on it (see `power`).
        """
        return power(*self)


def power(X: float, Y: float, delta: float) -> float:
    """Power of a target: 1 - |T - C_L|^2.

    It is zero within delta / 2 of the left turning circle.

    It equals 2Y - r2, written so that it keeps its digits near the start and near (0, 2). Near the
    circle it is twice the distance from it. Rounding moves it by less than delta. So a target that
    is not taken to be on the circle lies on the side that the sign says.
    """
    w = Y * (2.0 - Y) - X * X
    return 0.0 if abs(w) <= delta else w


def local(scenario: Scenario) -> Local:
    """Target of a scenario in the vehicle's frame.

    See docs/derivation.md, sections 1 and 5.
    """
    X, Y = scenario.local()
    spread = PER_EXTENT * scenario.extent / scenario.radius
    return Local(X, Y, spread + PER_DISTANCE * (abs(X) + abs(Y)))

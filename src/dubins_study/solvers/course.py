"""A scenario's points in units of the radius: what formulations of any number of legs begin with.

One leg with a free final heading is a course of one step.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import FloatArray
from dubins_study.study.body_coordinates import EPS, Local, local
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario


@dataclass(frozen=True, eq=False)
class Course:
    """n legs. The unknown headings are those at the points after the start, shape (k,).

    Methods take one set of headings, or several at once in a further dimension.
    """

    steps: FloatArray  # from each point to the next (radii), shape (n, 2)
    first: float  # heading at the start (rad)
    last: float | None  # heading at the target (rad); None if it is free
    # the target in body coordinates, of one leg with a free final heading
    target: Local | None = None

    @property
    def legs(self) -> int:
        """n."""
        return len(self.steps)

    @property
    def unknowns(self) -> int:
        """k: n, or n - 1 if the final heading is given."""
        return self.legs - (self.last is not None)

    @property
    def magnitude(self) -> float:
        """The size (radii) of what equations over the points add up."""
        return 1.0 + float(np.abs(np.cumsum(self.steps, axis=0)).sum(axis=1).max())

    @property
    def data(self) -> FloatArray:
        """The points after the start (radii), then a final heading (rad) if one is given."""
        points = np.cumsum(self.steps, axis=0).ravel()
        return points if self.last is None else np.append(points, self.last)

    def headings(self, unknown: FloatArray) -> FloatArray:
        """The headings at all points; shape (k, ...) -> (n + 1, ...)."""
        given = [self.first] if self.last is None else [self.first, self.last]
        first, *last = (np.full((1, *unknown.shape[1:]), heading) for heading in given)
        return np.concatenate((first, unknown, *last))

    def bearings(self) -> FloatArray:
        """The direction of each step (rad), shape (n,)."""
        directions: FloatArray = np.arctan2(self.steps[:, 1], self.steps[:, 0])
        return directions

    def toward_next(self) -> FloatArray:
        """The guess `bearing`: at each point toward the next one, at a free end as on the last leg.

        Shape (k,).
        """
        bearings = self.bearings()
        return np.append(bearings[1:], bearings[-1])[: self.unknowns]

    def turned(self) -> FloatArray:
        """At each point one turn toward the next, the shorter way round, and a straight line.

        A final heading is turned to at the end. Returns signed turns and straights: (rad, radii,
        rad) of each leg, shape (n, 3).
        """
        bearings = self.bearings()
        legs = np.zeros((self.legs, 3))
        legs[:, 0] = wrapped(np.diff(bearings, prepend=self.first))
        legs[:, 1] = np.hypot(*self.steps.T)
        if self.last is not None:
            legs[-1, 2] = wrapped(self.last - bearings[-1])
        return legs


def body_course(scenario: Scenario) -> Course:
    """The course with the start at heading 0, as `Scenario.local` turns a target."""
    dx, dy = np.diff(scenario.points, axis=0).T
    cos, sin = math.cos(scenario.start.heading), math.sin(scenario.start.heading)
    steps = np.column_stack((dx * cos + dy * sin, dy * cos - dx * sin)) / scenario.radius
    final = scenario.stops[-1].heading  # also where the path is closed
    last = None if final is None else final - scenario.start.heading
    target = local(scenario) if scenario.one_free_leg else None
    return Course(steps, 0.0, last, target)


def path_of(
    scenario: Scenario,
    turns: Iterable[float],
    lengths: Iterable[float],
    start: Pose | None = None,
) -> Path:
    """The path of pieces at unit radius; a length that is not above zero counts as zero.

    It begins with the scenario's start pose, or with `start` where the heading there is free.
    """
    pieces = [
        (turn / scenario.radius, length * scenario.radius)
        for turn, length in zip(turns, lengths, strict=True)
        if not length <= 0  # so that NaN stays and is seen by the check
    ]
    begin = scenario.start if start is None else start
    return Path(begin, [k for k, _ in pieces], [length for _, length in pieces])


def coordinate_rounding(scenario: Scenario) -> float:
    """The distance (radii) between start and target that the coordinates' rounding may fake."""
    return 2 * EPS * scenario.extent / scenario.radius


def in_world(scenario: Scenario, duals: FloatArray) -> tuple[float, float]:
    """The duals (2,) of the end point, turned from body coordinates."""
    along, left = float(duals[0]), float(duals[1])
    cos, sin = math.cos(scenario.start.heading), math.sin(scenario.start.heading)
    return along * cos - left * sin, along * sin + left * cos


def heading_gap(heading: Any, final: Any) -> Any:
    """Zero where a heading is the final one, or whole turns from it; there its slope is 1 or -1.

    A difference would fix the number of turns, sine and cosine as two equations have dependent
    gradients, and the sine alone is zero at the opposite heading too.
    """
    from casadi import sin

    return 2 * sin((heading - final) / 2)


def wrapped(angle: Any) -> Any:
    """An angle brought to [-pi, pi)."""
    return (angle + math.pi) % TWO_PI - math.pi

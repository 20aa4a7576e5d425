"""A scenario's points in units of the turning radius.

Formulations of any number of legs begin with them. One leg with a free final heading is a course of
one step.
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
    """The n legs of a scenario.

    The unknown headings (rad) are those at the points after the start, shape (k,). A final heading
    that is given is not among them. Methods take one set of headings, or several at once in a
    further dimension.
    """

    steps: FloatArray  # from each point to the next (radii), shape (n, 2)
    first: float  # heading at the start (rad)
    last: float | None  # heading at the target (rad); None if it is free
    # the target in body coordinates, of one leg with a free final heading
    target: Local | None = None

    @property
    def legs(self) -> int:
        """The number n of legs."""
        return len(self.steps)

    @property
    def unknowns(self) -> int:
        """The number k of unknown headings.

        It is n, or n - 1 if the final heading is given.
        """
        return self.legs - (self.last is not None)

    @property
    def magnitude(self) -> float:
        """The size (radii) of the terms in the equations.

        The equations compare sums of terms with the points' coordinates, so their rounding error is
        about `EPS` times this size: 1 plus the largest |x| + |y| of a point.
        """
        return 1.0 + float(np.abs(np.cumsum(self.steps, axis=0)).sum(axis=1).max())

    @property
    def data(self) -> FloatArray:
        """The points after the start (radii), as one vector.

        A final heading (rad) follows if one is given.
        """
        points = np.cumsum(self.steps, axis=0).ravel()
        if self.last is None:
            return points
        return np.append(points, self.last)

    @property
    def given_headings(self) -> list[float]:
        """The headings that are given (rad).

        The start's is first. A final heading follows if one is given.
        """
        headings = [self.first]
        if self.last is not None:
            headings.append(self.last)
        return headings

    def headings(self, unknown: FloatArray) -> FloatArray:
        """The headings at all points, the start included.

        Shape (k, ...) -> (n + 1, ...).
        """
        several = unknown.shape[1:]
        first, *last = (np.full((1, *several), heading) for heading in self.given_headings)
        return np.concatenate((first, unknown, *last))

    def bearings(self) -> FloatArray:
        """The direction of each step (rad), shape (n,)."""
        directions: FloatArray = np.arctan2(self.steps[:, 1], self.steps[:, 0])
        return directions

    def toward_next(self) -> FloatArray:
        """The headings of the guess `bearing`, shape (k,).

        Each heading points toward the next point. A free heading at the end is the last leg's
        bearing.
        """
        bearings = self.bearings()
        return np.append(bearings[1:], bearings[-1])[: self.unknowns]

    def turned(self) -> FloatArray:
        """One turn and one straight for each leg.

        Row i of the result, shape (n, 3), is leg i: its turn (rad, positive to the left), its
        straight (radii), and a turn at its end (rad). The first turn goes the shorter way round,
        toward the next point. The turn at the end is 0, but for a last leg with a final heading.
        """
        bearings = self.bearings()
        legs = np.zeros((self.legs, 3))
        legs[:, 0] = wrapped(np.diff(bearings, prepend=self.first))
        legs[:, 1] = np.hypot(*self.steps.T)
        if self.last is not None:
            legs[-1, 2] = wrapped(self.last - bearings[-1])
        return legs


def body_course(scenario: Scenario) -> Course:
    """The course with the start at heading 0.

    `Scenario.local` turns a target in the same way.
    """
    dx, dy = np.diff(scenario.points, axis=0).T
    cos = math.cos(scenario.start.heading)
    sin = math.sin(scenario.start.heading)
    steps = np.column_stack((dx * cos + dy * sin, dy * cos - dx * sin)) / scenario.radius
    last = scenario.stops[-1].heading  # also where the path is closed
    if last is not None:
        last -= scenario.start.heading
    return Course(steps, 0.0, last, free_target(scenario))


def free_target(scenario: Scenario) -> Local | None:
    """The target in body coordinates, or None.

    None unless the question is one leg with a free final heading.
    """
    if scenario.one_free_leg:
        return local(scenario)
    return None


def path_of(
    scenario: Scenario,
    turns: Iterable[float],
    lengths: Iterable[float],
    start: Pose | None = None,
) -> Path:
    """A scenario's path from pieces at unit radius.

    `turns` are the pieces' curvatures (1 / radius), `lengths` their lengths (radii). Pieces with a
    length of 0 or less are left out. The path begins with the scenario's start pose, or with
    `start` where the heading there is free.
    """
    pieces = [
        (turn / scenario.radius, length * scenario.radius)
        for turn, length in zip(turns, lengths, strict=True)
        if not length <= 0  # so that NaN stays and is seen by the check
    ]
    return Path(start or scenario.start, [k for k, _ in pieces], [length for _, length in pieces])


def coordinate_rounding(scenario: Scenario) -> float:
    """The distance (radii) that rounding alone may cause.

    A start and a target that are one point may be this far apart in rounded coordinates.
    """
    return 2 * EPS * scenario.extent / scenario.radius


def in_world(scenario: Scenario, duals: FloatArray) -> tuple[float, float]:
    """The end point's duals (2,) in the world frame.

    `duals` are in body coordinates.
    """
    along, left = duals.tolist()
    cos = math.cos(scenario.start.heading)
    sin = math.sin(scenario.start.heading)
    return along * cos - left * sin, along * sin + left * cos


def heading_gap(heading: Any, final: Any) -> Any:
    """An expression that is zero at the final heading.

    The expression is also zero whole turns away from that heading. Its slope at the zeros is 1 or
    -1. Both headings (rad) may be casadi expressions.

    A difference would fix the number of turns. Sine and cosine as two equations would have
    dependent gradients. The sine alone is zero at the opposite heading too.
    """
    from casadi import sin

    return 2 * sin((heading - final) / 2)


def wrapped(angle: Any) -> Any:
    """Bring an angle to [-pi, pi)."""
    return (angle + math.pi) % TWO_PI - math.pi

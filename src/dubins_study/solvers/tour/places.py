"""The places of a tour in turning radii.

A route in its given order is a tour with one way on from each place. One leg is a tour of two
places.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from dubins_study.solvers.course import coordinate_rounding, free_target, path_of
from dubins_study.solvers.legs import WORD_TURNS, legs
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.solvers.runs import at_start
from dubins_study.study.angle import TWO_PI
from dubins_study.study.arrays import BoolArray, FloatArray
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Order


@dataclass(frozen=True, eq=False)
class Places:
    """The places of a tour, the start first.

    The via points follow, then the target if it is another point.
    """

    points: FloatArray  # shape (m, 2), radii, seen from the start
    given: tuple[float | None, ...]  # headings at the places (rad); None where free
    with_target: bool  # whether the last place is the target, which is passed last
    closed: bool
    in_order: bool  # whether the via points are passed in their order

    @property
    def count(self) -> int:
        """The number m of places."""
        return len(self.points)

    @property
    def next_places(self) -> BoolArray:
        """Whether one place may follow another, shape (m, m).

        The entry [i, j] says whether j may follow i. A tour goes back to the start from its end.
        This is a leg only if the tour is closed.
        """
        m = self.count
        if self.in_order:
            return np.eye(m, k=1, dtype=np.bool_) | np.eye(m, k=1 - m, dtype=np.bool_)
        allowed = ~np.eye(m, dtype=np.bool_)
        if self.with_target:
            # only the target is followed by the start, and it follows a via point if there is one
            allowed[1:-1, 0] = False
            allowed[-1, 1:] = False
            allowed[0, -1] = m == 2
        return allowed

    def steps(self, order: list[int]) -> FloatArray:
        """The steps between the places of an order.

        Shape (legs, 2). The order begins with 0.
        """
        passed = order
        if self.closed:
            passed = [*order, 0]
        steps: FloatArray = np.diff(self.points[passed], axis=0)
        return steps

    def headings(self, count: int) -> list[FloatArray]:
        """The headings (rad) of a grid at each place.

        A place has `count` headings at equal distances, from the start's heading on. A place whose
        heading is given has that one only.
        """
        first = self.given[0] or 0.0
        grid: FloatArray = first + (TWO_PI / count) * np.arange(count, dtype=np.float64)
        headings = [grid] * self.count
        for place, heading in enumerate(self.given):
            if heading is not None:
                headings[place] = np.array([heading])
        return headings


def places_of(scenario: Scenario) -> Places:
    """The places of a scenario."""
    stops = scenario.stops
    if scenario.closed:
        stops = stops[:-1]
    points = [(scenario.x, scenario.y), *((stop.x, stop.y) for stop in stops)]
    return Places(
        points=(np.array(points) - points[0]) / scenario.radius,
        given=(scenario.heading, *(stop.heading for stop in stops)),
        with_target=scenario.target is not None and not scenario.closed,
        closed=scenario.closed,
        in_order=scenario.order is Order.GIVEN,
    )


def empty_path(question: Question) -> Solution | None:
    """A path of no length, or None.

    The answer exists if the question is one leg whose target is its start.
    """
    scenario = question.scenario
    return at_start(scenario, free_target(scenario), coordinate_rounding(scenario))


def tour_path(scenario: Scenario, places: Places, order: list[int], headings: FloatArray) -> Path:
    """The path through the places of an order.

    Its legs are the shortest ones between the headings, shape (legs + 1,).
    """
    x, y = places.steps(order).T
    segments, words = legs(x, y, headings[:-1], headings[1:])
    start = Pose(scenario.x, scenario.y, float(headings[0]))
    return path_of(scenario, WORD_TURNS[words].ravel(), segments.T.ravel(), start)

"""`tour-order`: first the order of the points by their distances, then the headings.

The baseline of tours: an order that knows nothing of the turning radius.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from dubins_study.solvers.protocol import Guarantee, Method, Question, Solution, Solver
from dubins_study.solvers.setting_checks import one_of, whole
from dubins_study.solvers.tour.euclidean import euclidean_order
from dubins_study.solvers.tour.order_headings import headings_on_grid, polished
from dubins_study.solvers.tour.places import Places, empty_path, places_of, tour_path
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import NEEDS, Claim

_EUCLIDEAN, _ALTERNATING = _ORDERS = ("euclidean", "alternating")


class OrderFirst(Solver):
    """An order of the points and a heading at each, exact legs between them."""

    guarantee = Guarantee.DISCRETISED

    def build(self, question: Question) -> tuple[Question, Places]:
        places = places_of(question.scenario)
        headings_on_grid(places, list(range(places.count)), 1)  # loads the compiled loops
        return question, places

    def solve(self, model: tuple[Question, Places], limit: float) -> Solution:
        question, places = model
        if there := empty_path(question):
            return there
        order, headings = self.choose(places, perf_counter() + limit)
        path = tour_path(question.scenario, places, order, headings)
        return Solution(Claim.FEASIBLE, path=path, claimed_length=path.length)

    @abstractmethod
    def choose(self, places: Places, until: float) -> tuple[list[int], FloatArray]:
        """The order of the places, and the headings there and at the end."""


@dataclass(frozen=True)
class TourOrder(OrderFirst):
    """The shortest order by straight lines, then headings.

    The order is exact up to 12 via points, beyond that the best that reversed parts and moved
    points find from nearest neighbours.

    Args:
        order: `euclidean`: with the best headings of a grid, improved off it; or `alternating`:
            every other leg is a straight line (Savla, Frazzoli and Bullo 2008).
        headings: headings of the grid at each point.
    """

    order: str = one_of(_EUCLIDEAN, _ORDERS)
    headings: int = whole(72, 4, 1000)

    name = "tour-order"
    takes = frozenset(NEEDS)
    summary = "tours: the order by straight lines, then the headings"
    variants = ("tour-order[order=alternating]",)

    @property
    def method(self) -> Method:
        return Method("order then headings", "dynamic programming")

    def choose(self, places: Places, until: float) -> tuple[list[int], FloatArray]:
        order = euclidean_order(places, until)
        if self.order == _ALTERNATING:
            return order, _alternating(places, order)
        headings = headings_on_grid(places, order, self.headings)
        return order, polished(places, order, headings, self.headings, until)


def _alternating(places: Places, order: list[int]) -> FloatArray:
    """Headings by which every other leg is a straight line; shape (legs + 1,).

    The first of these legs begins at the start if the heading there is free, else at the point
    after it. A heading that is given at one of its ends stays, and a point that is left over heads
    for the next one, or on as the last leg came.
    """
    steps = places.steps(order)
    bearings = np.arctan2(steps[:, 1], steps[:, 0])
    count = len(order)
    first = 0 if places.given[0] is None else 1
    headings = np.zeros(count)
    for k, place in enumerate(order):
        leg = k if (k - first) % 2 == 0 else k - 1
        given = places.given[place]
        headings[k] = bearings[min(max(leg, 0), len(bearings) - 1)] if given is None else given
    return np.append(headings, headings[0]) if places.closed else headings

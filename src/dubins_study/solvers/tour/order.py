"""`tour-order`: first the order, then the headings.

The order of the points follows from their distances. It is the baseline of tours: its order does
not depend on the turning radius.
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

_EUCLIDEAN = "euclidean"
_ALTERNATING = "alternating"
_ORDERS = (_EUCLIDEAN, _ALTERNATING)


class OrderFirst(Solver):
    """Base of solvers that choose headings directly.

    They choose an order of the points and a heading at each. The legs between the headings are
    exact.
    """

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
        """The order of the places, and the headings.

        Returns two values: the places in the order, the start first; and the headings (rad) at the
        beginning of each leg and at the end of the last, shape (legs + 1,).
        """


@dataclass(frozen=True)
class TourOrder(OrderFirst):
    """The shortest order by straight lines, then headings.

    The order is exact up to 12 via points. Beyond that it starts from nearest neighbours and is
    improved by reversed parts and moved points.

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
    """Headings that make every other leg straight.

    Shape (legs + 1,). The first of these legs begins at the start if the heading there is free,
    else at the point after it. A given heading at one of its ends stays. A point that is left over
    heads for the next point; the last point keeps the direction of the last leg.
    """
    steps = places.steps(order)
    bearings = np.arctan2(steps[:, 1], steps[:, 0])
    first = int(places.given[0] is not None)

    def straight_leg(k: int) -> int:
        """The straight leg at point k.

        It begins there, or ends there if k - `first` is odd. Beyond the first or the last leg that
        one counts.
        """
        leg = k - (k - first) % 2
        return min(max(leg, 0), len(bearings) - 1)

    headings = np.zeros(len(order))
    for k, place in enumerate(order):
        heading = places.given[place]
        if heading is None:
            heading = bearings[straight_leg(k)]
        headings[k] = heading
    if places.closed:
        return np.append(headings, headings[0])
    return headings

"""`heading-grid`: headings on a grid, by a dynamic program.

The program goes over layers of headings at the points. It is the simple baseline of routes. The
legs are the closed form's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from dubins_study.solvers.protocol import Method
from dubins_study.solvers.setting_checks import whole
from dubins_study.solvers.tour.order import OrderFirst
from dubins_study.solvers.tour.order_headings import headings_on_grid, polished
from dubins_study.solvers.tour.places import Places
from dubins_study.study.arrays import FloatArray
from dubins_study.study.words import IN_ORDER


@dataclass(frozen=True)
class HeadingGrid(OrderFirst):
    """Headings on a grid, exact legs between them.

    The path is the best of that grid; no bound is proved.

    Args:
        headings: number of headings at each point.
        refine: whether finer and finer grids about the best headings follow, down to 1e-9 rad
            (Frego, Bevilacqua, Saccon, Palopoli and Fontanelli 2020).
    """

    headings: int = whole(36, 4, 1000)
    refine: bool = False

    name = "heading-grid"
    takes = IN_ORDER
    summary = "headings on a grid, exact legs between them, by a dynamic program"
    keeps_limit = False  # only a grid that is refined looks at the clock
    variants = ("heading-grid[refine=true]",)
    profiles: ClassVar = {"fast": {"headings": 18}, "accurate": {"refine": True}}

    @property
    def method(self) -> Method:
        return Method("grid of headings", "dynamic programming")

    def choose(self, places: Places, until: float) -> tuple[list[int], FloatArray]:
        order = list(range(places.count))
        headings = headings_on_grid(places, order, self.headings)
        if self.refine:
            headings = polished(places, order, headings, self.headings, until)
        return order, headings

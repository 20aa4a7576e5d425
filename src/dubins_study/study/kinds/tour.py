"""Tours: via points in any order.

The target comes last, if there is one. The search over orders gives a proof.
"""

from __future__ import annotations

from dataclasses import replace

from dubins_study.study.kinds.route import ROUTE
from dubins_study.study.scenario import Scenario


def _prepare() -> None:
    from dubins_study.study.tour.search import compile_tour_loops

    compile_tour_loops()


TOUR = replace(
    ROUTE,
    prepare=_prepare,
    name="tour",
    title="a tour",
    task="via points, in whatever order is shortest",
    fields={"order": True},
    # 4 to 6 points in three spacings. The search proves each in less than a second. Without names:
    # x, y, heading, target_x, target_y.
    examples={
        "4 points far apart": Scenario(
            *(0, 0, 0.5, 12, 3), via=[(9, -6), (3, 7), (-5, 4), (4, -3)], order="free"
        ),
        "4 points, closed": Scenario(
            *(-2, 1, 2.0),
            radius=0.7,
            via=[(3, 2), (1, -4), (5, -1), (2, 6)],
            order="free",
            closed=True,
        ),
        "3 points near by, to a heading": Scenario(
            *(0, 0, -0.4, 3, 2),
            via=[(1.2, 2.1), (2.4, 0.3), (0.5, -1)],
            final_heading=2.0,
            order="free",
        ),
        "5 points, the end at any": Scenario(
            *(1, 2, 0.0), radius=1.3, via=[(4, 7), (-6, 3), (8, -2), (2, -9), (12, 5)], order="free"
        ),
        "4 points from any heading": Scenario(
            *(0, 1, None, 5, -4), via=[(6, 2), (3, 8), (-4, 5)], order="free"
        ),
        "2 lines to fly along": Scenario(
            *(0, 0, 0.7, 12, 1),
            via=[(3, 2, 1.5), (3, 9, 1.5), (7, 9, -1.5), (7, 2, -1.5)],
            order="free",
        ),
    },
)

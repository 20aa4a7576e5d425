"""Several legs through via points in their order.

They are answered by the search with a proof. The modules of the search are imported where they are
called. They load compiled code and SciPy's linear programs, which one leg does not need.
"""

from __future__ import annotations

from functools import partial
from time import perf_counter

from dubins_study.study.check.enclosure import Enclosure, Part
from dubins_study.study.check.verdict import words_of
from dubins_study.study.kinds import visiting
from dubins_study.study.kinds.kind import Costates, Exact, Kind, Reference
from dubins_study.study.kinds.leg import LEG
from dubins_study.study.kinds.pose import POSE
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances

_SEARCH_SHARE = 0.8  # of the time that a check has left: the steps after a search need some too


def _prepare() -> None:
    from dubins_study.study.route.search import compile_loops

    compile_loops()


def _exact(scenario: Scenario, branch: str, limit: float) -> Exact:
    from dubins_study.study.kinds.shortest import shortest_route

    route = shortest_route(scenario, limit)
    return Exact(route.path, route.low, route.high)


def _reference(scenario: Scenario, branch: str, tolerances: Tolerances) -> Reference:
    """Reference with a proven interval around the shortest length.

    A search that this process has already made for the same route is not repeated.
    """
    # a path that visits all its via points where it starts or ends is compared with one leg
    for kind in (LEG, POSE):
        if kind.matches(scenario):
            return kind.reference(scenario, branch, tolerances)
    from dubins_study.study.kinds.shortest import known_route

    seconds_left = min(tolerances.until - perf_counter(), tolerances.patience * tolerances.search_s)
    seconds = max(_SEARCH_SHARE * seconds_left, 0.0)
    route = known_route(scenario, search_s=tolerances.search_s, seconds=seconds)
    part = (route.low, route.high)
    enclosure = Enclosure(low=route.low, high=route.high, absent=False, parts=(part,))
    return Reference(enclosure, route.path, route.at)


def _interval(enclosure: Enclosure, length: float, tolerance: float) -> Part:
    """Both ends of the proven interval.

    The lower end is the reference, so that no gap is too small.
    """
    return enclosure.low, enclosure.high


def _costates(scenario: Scenario, path: Path, judgement: Judgement, until: float) -> Costates:
    """Costates of an arriving path, where known."""
    if judgement.gap is None:
        return Costates()
    from dubins_study.study.check.route_extremal import route_extremal

    if scenario.heading is None or scenario.via_heading is not None:
        # a free start and a given heading on the way have other conditions, which are not checked
        return Costates()
    free = scenario.final_heading is None and not scenario.closed
    ends = (judgement.visits or [])[: scenario.legs - 1]
    return Costates(route_extremal(path, ends, scenario.radius, free=free, until=until))


ROUTE = Kind(
    name="route",
    title="a route",
    task="via points, in the order in which they are given",
    fields={"searched": True, "order": False},
    branches=("best",),
    # 2 to 5 legs in three spacings. The search proves each in less than a second. Without names:
    # x, y, heading, target_x, target_y, radius, speed.
    examples={
        "2 legs of 9 R to 17 R": Scenario(-3, 4, 2.2, 9, -5, 0.8, 0.6, via=[(4, 7)]),
        "3 legs of 2 R to 4 R": Scenario(0, 0, 0.5, 4.8, 3.9, via=[(2.5, 1), (1, 3.2)]),
        "3 legs, the other order": Scenario(0, 0, 0.5, 4.8, 3.9, via=[(1, 3.2), (2.5, 1)]),
        "3 legs, the points in line": Scenario(0, 0, -0.9, 9, 3, 1.5, via=[(3, 1), (6, 2)]),
        "4 legs to a heading": Scenario(
            *(1, -2, -2.0, -8, -1, 1.3), via=[(-3, -6), (-9, -7), (-12, -3)], final_heading=0.4
        ),
        "5 legs of 1 R to 2 R": Scenario(
            *(2, 1, 1.0, 5.2, 3.6), via=[(2.9, 2.2), (4.1, 1.9), (4.6, 3.4), (6.1, 2.8)]
        ),
        "3 legs, closed": Scenario(1, 0, 0.3, via=[(6, 4), (2, 8)], closed=True),
        "3 legs, a heading on the way": Scenario(
            *(0, 0, -0.5, 9, 2, 1.2), via=[(4, 3, 1.2), (7, -2)]
        ),
        "2 legs from any heading": Scenario(2, -1, None, 9, 3, 1.4, via=[(5, 5)]),
    },
    exact=_exact,
    prepare=_prepare,
    reference=_reference,
    words_of=words_of,
    verdict=partial(visiting.verdict, reference_of=_reference, compared=_interval),
    costates=_costates,
    searched=True,
)

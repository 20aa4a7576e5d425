"""heading-milp against brute force over its grid, linear programming, and the closed form."""

from __future__ import annotations

import math
from itertools import pairwise, product

import numpy as np
import pytest
from cases import PAPER
from scipy.optimize import linprog

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.solvers.route.grid import HeadingMilp, flow_of, layers
from dubins_study.solvers.route.legs import route_of
from dubins_study.study.closed_form.pose import pose_path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Claim, Verdict

NEAR = Scenario(0, 0, 0, 1, 2, 1, via=[(1.5, 0.5), (0.5, 3)], final_heading=2.0)
FAR = Scenario(1, 2, "30deg", 22, 9, 2, via=[(12, 4), (14, -8)])


def of_all_choices(scenario: Scenario, count: int) -> float:
    """The shortest of all ways through the grid, each leg by the scalar closed form."""
    grid = scenario.heading + np.arange(count) * 2 * math.pi / count
    given = scenario.final_heading
    free = [grid] * (scenario.legs - (given is not None))
    ends = free if given is None else [*free, [given]]
    points, least = scenario.points, math.inf
    known: dict[tuple[int, float, float], float] = {}

    def length(leg: int, a: float, b: float) -> float:
        if (leg, a, b) not in known:
            (x, y), (u, v) = points[leg : leg + 2]
            ends = Pose(x, y, a), Pose(u, v, b)
            known[leg, a, b] = pose_path(*ends, scenario.radius).length
        return known[leg, a, b]

    for chosen in product(*ends):
        pairs = enumerate(pairwise((scenario.heading, *chosen)))
        least = min(least, sum(length(leg, float(a), float(b)) for leg, (a, b) in pairs))
    return least


@pytest.mark.parametrize("scenario", [NEAR, FAR], ids=["near", "far"])
def test_the_answer_is_the_shortest_way_through_the_grid(scenario):
    answer = attempt(HeadingMilp(headings=10), Question(scenario), 20.0)

    assert answer.length == pytest.approx(of_all_choices(scenario, 10), rel=1e-9)
    assert answer.claim is Claim.LOCAL
    assert not answer.false_claim


@pytest.mark.parametrize("scenario", [NEAR, FAR], ids=["near", "far"])
def test_its_relaxation_is_integral_and_the_dynamic_programs(scenario):
    """Why the integer program is only a check: a linear one has the same vertex."""
    route = route_of(scenario)
    found = layers(route, 12)
    flow = flow_of(found)

    relaxed = linprog(flow.cost, A_eq=flow.flow, b_eq=flow.begin, method="highs-ds")
    segments, _ = route.shortest(found.shortest())

    assert np.abs(relaxed.x - np.round(relaxed.x)).max() < 1e-9
    assert relaxed.fun == pytest.approx(segments.sum(), rel=1e-9)


def test_the_gap_falls_with_the_square_of_the_headings():
    """Eight times the headings; a grid that happens to hold the best headings is averaged out."""
    gaps = [
        [attempt(HeadingMilp(headings=k), Question(scenario), 20.0).gap for k in (n, n + 1, n + 3)]
        for scenario in (FAR, NEAR)
        for n in (16, 128)
    ]

    for coarse, fine in zip(gaps[::2], gaps[1::2], strict=True):
        assert 16 < np.mean(coarse) / np.mean(fine) < 256


@pytest.mark.parametrize("problem", PAPER)
def test_one_leg_with_a_free_final_heading_is_a_route_too(problem):
    answer = attempt(HeadingMilp(), Question(PAPER[problem]), 20.0)

    assert answer.verdict is Verdict.OPTIMAL
    assert answer.claim is Claim.LOCAL


def test_the_bound_is_of_the_grid_and_is_not_passed_off_as_the_scenarios():
    """The bound in the message is the path's length, which is above the shortest one."""
    answer = attempt(HeadingMilp(), Question(NEAR), 20.0)
    bound = float(answer.message.split("bound ")[1].split()[0])

    assert answer.lower_bound is None
    assert "not for the scenario" in answer.message
    assert bound == pytest.approx(answer.length, rel=1e-6)
    assert bound > answer.reference_high


OTHERS = [name for name in ("scip", "gurobi", "xpress") if HeadingMilp(name).unavailable() is None]


@pytest.mark.parametrize("engine", OTHERS)
def test_every_engine_finds_the_same_optimum(engine, capfd):
    """That of HiGHS, on a grid that fits into the licences of the wheels, and in silence."""
    answer, highs = (attempt(HeadingMilp(name, 16), Question(FAR)) for name in (engine, "highs"))

    assert answer.claim is highs.claim is Claim.LOCAL
    assert answer.length == pytest.approx(highs.length, rel=1e-6)  # their gap
    assert capfd.readouterr() == ("", "")


def test_it_declares_what_it_takes():
    solver = load("heading-milp[headings=12]")

    assert solver.takes == frozenset(("via points", "final heading", "free final heading"))
    assert solver.branches == ("best",)

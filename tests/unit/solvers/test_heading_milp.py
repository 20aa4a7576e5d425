"""heading-milp against the closed form, brute force over its grid, and its promises."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases import PAPER
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.heading_milp.grid import one_turn
from dubins_study.solvers.heading_milp.solver import HeadingMilp
from dubins_study.solvers.presolve import WORDS
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.check.verdict import judge
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Verdict

DEFAULT = HeadingMilp()
# in radii, from the origin facing +x
DISCS = {"centre": (0.0, 1.0), "left": (-0.2, 0.6), "right": (0.4, -1.2), "rear": (-0.5, -1.2)}


def ask(
    scenario: Scenario, branch: str = "best", solver: HeadingMilp = DEFAULT, limit: float = 20.0
) -> tuple[Solution, Judgement]:
    solution = solver.solve(solver.build(Question(scenario, branch)), limit)
    return solution, judge(scenario, solution.path, solution.claim, branch)


def coarseness(solver: HeadingMilp) -> float:
    """Largest relative gap outside the discs.

    Between two legs' headings that are b apart the way is longer by up to 1 / cos(b / 2) - 1, and
    the rest of a step of d that is turned in vain costs less than d^3 / 6 radii.
    """
    step = 2 * math.pi / solver.headings
    return 1 / math.cos(step / solver.legs / 2) - 1 + step**3 / 6


@pytest.mark.parametrize("problem", PAPER)
@pytest.mark.parametrize("solver", [DEFAULT, HeadingMilp(legs=1), HeadingMilp(headings=20)])
def test_paper_problems_cost_no_more_than_the_grid_is_coarse(problem, solver):
    """The gap is above nothing, and below what the coarseness of the grid explains."""
    solution, found = ask(PAPER[problem], "best", solver)

    assert solution.claim is Claim.LOCAL
    assert found.gap is not None
    assert -1e-12 <= found.gap <= coarseness(solver)


@pytest.mark.slow
def test_the_gap_falls_with_the_square_of_the_headings():
    """Ten times the headings, a hundredth of the gap; halved and doubled for where they happen."""
    gaps = [
        [
            ask(problem, "best", HeadingMilp(headings=k, legs=1))[1].gap
            for problem in list(PAPER.values())[:3]
        ]
        for k in (36, 360)
    ]

    assert 50 <= np.max(gaps[0]) / np.max(gaps[1]) <= 200


@pytest.mark.parametrize("place", DISCS)
def test_inside_a_disc_the_second_arc_is_the_long_one(place):
    """Inside the discs RL or LR is found; its gap falls with the square of the step, 1.1 d^2."""
    X, Y = DISCS[place]
    scenario = Scenario(0, 0, 0, X, Y, 1)
    solution, found = ask(scenario)

    assert solution.claim is Claim.LOCAL
    assert found.word == found.reference_word
    # for these targets; next to a circle's front it is larger
    assert 0 <= found.gap <= 0.15 * (2 * math.pi / DEFAULT.headings) ** 2


@pytest.mark.parametrize("exponent", [1, 5, 9, 14])
@pytest.mark.parametrize("angle", [0.3, 2.5, 6.0])
def test_a_target_just_outside_its_circle_is_reached_by_a_tangent(angle, exponent):
    """However near: an equal grid has no turn that ends between tangent point and target."""
    r = 1 + 10.0**-exponent
    scenario = Scenario(0, 0, 0, r * math.sin(angle), 1 - r * math.cos(angle), 1)
    solution, found = ask(scenario, "LS")

    assert solution.claim is Claim.LOCAL
    assert found.verdict is Verdict.OPTIMAL


@pytest.mark.parametrize("Y", [1e-1, 1e-4, 1e-8, 1e-13])
@pytest.mark.parametrize("X", [0.05, 700.0])
def test_a_target_nearly_ahead_is_reached_by_less_than_a_step(X, Y):
    """A full step would pass it: without shorter ones only a full turn would get there."""
    solution, found = ask(Scenario(0, 0, 0, X, -Y, 1))

    assert solution.claim is Claim.LOCAL
    assert found.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
    assert found.gap <= coarseness(DEFAULT) or found.region == "right disc"


@pytest.mark.slow
@settings(max_examples=25)
@given(st.floats(-4, 4), st.floats(-4, 4), st.sampled_from(["LS", "RS"]))
def test_highs_finds_the_best_choice_of_the_grid(X, Y, branch):
    """Brute force over all choices, the legs of each by linear programming, says the same."""
    solver = HeadingMilp(headings=16, legs=2)
    if math.hypot(X, Y) < 1e-3:
        return  # the linear programs' tolerances are 1e-7
    family = one_turn(1 if branch == "LS" else -1, 16, 2, X, Y)
    lengths = []
    for choice, heading in enumerate(family.heading):
        u = np.array([np.cos(heading), np.sin(heading)])
        gap = np.array([X, Y]) - family.shift[:, choice]
        legs = linprog(np.ones(heading.size), A_eq=u, b_eq=gap, method="highs-ipm")
        if legs.status == 0:
            lengths.append(family.length[choice] + legs.fun)
    solution, _ = ask(Scenario(0, 0, 0, X, Y, 1), branch, solver)

    if lengths and solution.claimed_length is not None:
        assert solution.claimed_length == pytest.approx(min(lengths), abs=2e-6)  # gap 1e-6
    else:
        # next to the turning circle, within the tolerances, the two may disagree
        side = 1 if branch == "LS" else -1
        assert bool(lengths) is (solution.claimed_length is not None) or math.isclose(
            math.hypot(X, Y - side), 1, abs_tol=1e-5
        )


def test_the_bound_is_of_the_grid_and_is_not_passed_off_as_the_scenarios():
    """The bound in the message is the path's length, which is above the shortest one."""
    scenario = PAPER["problem 4"]
    solution, found = ask(scenario)
    bound = float(solution.message.split("bound ")[1].split()[0])

    assert solution.lower_bound is None
    assert "not for the scenario" in solution.message
    assert bound == pytest.approx(found.length, rel=1e-6)
    assert bound > found.reference * (1 + 1e-6)


def test_a_grid_without_a_path_does_not_say_that_there_is_none(monkeypatch):
    """HiGHS's proof is about the grid: the claim is `failed`, and the message names its scope."""
    monkeypatch.setattr(
        "dubins_study.solvers.heading_milp.solver.least_legs", lambda heading, gap: None
    )
    solution, _ = ask(PAPER["problem 1"], "LS")
    assert solution.claim is Claim.FAILED
    assert "no path on the grid of 72 headings" in solution.message

    monkeypatch.undo()
    solution, found = ask(Scenario(0, 0, 0, 0.2, 1, 1), "LS")

    assert solution.claim is Claim.FAILED
    assert not found.false_claim
    assert "HiGHS proves that there is none, on this grid only" in solution.message


OTHERS = [name for name in ("scip", "gurobi", "xpress") if HeadingMilp(name).unavailable() is None]


@pytest.mark.parametrize("engine", OTHERS)
@pytest.mark.parametrize(("target", "branch"), [((3, 2), "LS"), ((0.3, 1.2), "best")])
def test_every_engine_finds_the_same_optimum(engine, target, branch, capfd):
    """That of HiGHS, on a grid that fits into the licences of the wheels, and in silence."""
    question = Question(Scenario(0, 0, 0, *target, 1), branch)
    answer, highs = (attempt(HeadingMilp(name, 24, 2), question) for name in (engine, "highs"))

    assert answer.claim is highs.claim is Claim.LOCAL
    assert answer.length == pytest.approx(highs.length, rel=1e-6)  # their gap
    assert answer.native_status.startswith(f"{answer.subproblems.split()[0]} ")
    assert set(answer.subproblems.split()) == ({"LS"} if branch == "LS" else set(WORDS))
    assert sum(answer.subproblem_evaluations) == answer.evaluations
    assert capfd.readouterr() == ("", "")

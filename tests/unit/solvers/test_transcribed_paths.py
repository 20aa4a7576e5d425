"""What every transcription finds: the closed form's length up to its tolerance or its steps."""

from __future__ import annotations

import math
from time import process_time

import numpy as np
import pytest
from cases import EDGES
from hard_cases import hard_frame

from dubins_study.experiments.solve import solve
from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.optimal_control.arcs import RATES
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import scenario_of
from dubins_study.study.words import Claim, Verdict

# The gap that the engine's tolerance of 1e-9 leaves of free lengths; of free elements a few 1e-11
# an element, and 3e-8 at most over 900 questions of the hard frame, on a circle, where convergence
# is slowest.
TINY = {"multiple-shooting": 1e-8, "collocation": 1e-7}
SLOW_COLLOCATION = ["multiple-shooting", pytest.param("collocation", marks=pytest.mark.slow)]
LEFT = Scenario(0, 0, 0, -0.2, 0.6, 1)


@pytest.mark.parametrize("spec", TINY)
@pytest.mark.parametrize("branch", RATES)
@pytest.mark.parametrize("edge", EDGES)
def test_every_branch_at_every_kind_of_target(edge, branch, spec):
    """The closed form's length, and turns to the branch's side only; else the search fails."""
    answer = solve(EDGES[edge], spec, branch)

    assert not answer.false_claim
    if shortest(EDGES[edge], branch) is None:
        assert answer.claim in (Claim.FAILED, Claim.INFEASIBLE)
        assert answer.iterations > 0
        return
    assert answer.verdict is Verdict.OPTIMAL
    assert abs(answer.gap) <= TINY[spec]
    rate = answer.path.curvatures * EDGES[edge].radius
    # dividing by the radius and multiplying again may cost a rounding
    assert rate.min(initial=0) >= RATES[branch].lower - 1e-15
    assert rate.max(initial=0) <= RATES[branch].upper + 1e-15


@pytest.mark.slow
@pytest.mark.parametrize("spec", TINY)
def test_hard_scenarios(spec):
    """Radii from 1e-6 to 1e6, targets on circles, next to them, at the start and 1e9 radii away."""
    for row in hard_frame(24, seed=3).itertuples():
        scenario = scenario_of(row._asdict())
        for branch in RATES:
            answer = attempt(load(spec), Question(scenario, branch), 60.0)
            assert not answer.false_claim, (scenario, branch)
            assert not answer.wrong_basin, (scenario, branch)
            exists = shortest(scenario, branch) is not None
            assert not exists or answer.verdict is Verdict.OPTIMAL, (scenario, branch)


@pytest.mark.parametrize("spec", SLOW_COLLOCATION)
def test_equal_elements_gain_with_their_number(spec):
    """A switch inside an element costs; 8 times more elements cost 20 times less, or better.

    64 would be the second order's; where in an element the switch falls decides the rest.
    """
    more = "points=3," if spec == "collocation" else ""
    coarse, fine = (solve(LEFT, f"{spec}[{more}mesh=equal,n={n}]").gap for n in (10, 80))

    assert TINY[spec] < fine < coarse / 20


@pytest.mark.parametrize("place", [(5, 1, 0.7), (-3, 0, 0), (-0.2, 0.6, 0)])
@pytest.mark.parametrize(
    ("spec", "steps", "factor"),
    [("turn-rates", (12, 24, 72, 144), 15), ("turn-rate-qp", (12, 24, 192, 384), 100)],
)
def test_the_gap_falls_with_the_square_of_the_step(spec, steps, factor, place):
    """6 or 16 times more steps: 15 or 100 times smaller where order two would give 36 or 256."""
    X, Y, heading = place
    gaps = [solve(Scenario(0, 0, heading, X, Y, 1), f"{spec}[n={n}]").gap for n in steps]

    coarse, fine = gaps[0] + gaps[1], gaps[2] + gaps[3]  # where a step ends matters: average
    assert 0 < fine < coarse / factor


@pytest.mark.parametrize("spec", ["turn-rates", "turn-rate-qp"])
@pytest.mark.parametrize("mesh", ["equal", "graded"])
def test_far_targets_need_a_graded_mesh(spec, mesh):
    """1000 R behind, equal steps are 20 R long: the turn is too wide, and the gap says so."""
    answer = solve(Scenario(0, 0, 0, -950, 300, 1), f"{spec}[mesh={mesh}]")

    assert answer.claim is Claim.LOCAL
    assert 1e-3 < answer.gap < 0.05 if mesh == "equal" else answer.gap < 1e-5


@pytest.mark.parametrize("spec", ["turn-rates[n=20]", "turn-rate-qp"])
@pytest.mark.parametrize(("branch", "Y"), [("LS", 0.7), ("RS", -0.7)])
def test_words_that_cannot_enter_their_disc_are_searched_in_vain(spec, branch, Y):
    """No LS into the left disc, no RS into the right; the other word gets there."""
    answer = solve(Scenario(0, 0, 0, 0.3, Y, 1), spec, branch)

    assert answer.claim in (Claim.FAILED, *[Claim.INFEASIBLE] * ("qp" not in spec))
    assert answer.iterations
    assert not answer.false_claim
    assert solve(Scenario(0, 0, 0, 0.3, -Y, 1), spec, branch).verdict is Verdict.OPTIMAL


@pytest.mark.parametrize(
    ("spec", "error"),
    [
        ("collocation", 1e-5),  # of the quadrature in the end point's derivatives: the raw miss
        ("multiple-shooting", 1e-6),  # Ipopt relaxes bounds by 1e-8, and stops as far off
        ("turn-rate-qp[n=320]", 0.05),  # steps of 0.018: the switch lies somewhere within one
        ("shooting", 1e-7),
    ],
)
def test_multipliers_of_two_arcs_point_along_the_chord(spec, error):
    """-(nu1, nu2) / nu0 of RL is the second arc's chord / cos(a2 / 2) (derivation, section 9)."""
    scenario = Scenario(1, -2, 0, 1.1, -1.2, 1)
    first, second = shortest(scenario).segments
    switch = Path(scenario.start, [-1.0], [first]).end
    chord = np.array((scenario.target_x - switch.x, scenario.target_y - switch.y))

    answer = solve(scenario, spec)

    expected = chord / np.hypot(*chord) / math.cos(second / 2)
    assert (answer.multiplier_x, answer.multiplier_y) == pytest.approx(expected, abs=error)


@pytest.mark.parametrize("spec", ["collocation", "turn-rate-qp"])
@pytest.mark.parametrize(
    ("curvature", "length"),
    [([1.0, 0.0] * 4, [0.5] * 8), ([math.nan], [1.0]), ([], []), ([1.0], [0.0]), ([5.0], [3.0])],
)
def test_a_useless_warm_start_does_no_harm(spec, curvature, length):
    """More arcs than elements, a broken path, one of no length, one that turns too hard."""
    behind = EDGES["behind"]

    answer = solve(behind, spec, initial_guess=Path(behind.start, curvature, length))

    assert answer.verdict is Verdict.OPTIMAL


@pytest.mark.parametrize(
    ("spec", "limit"),
    [
        ("collocation[n=160,mesh=equal]", 0.1),  # without the limit 4 s
        ("multiple-shooting[n=20,mesh=equal]", 1e-3),
        ("turn-rates[n=50]", 1e-3),
    ],
)
def test_time_runs_out(spec, limit):
    """The engine stops between two iterations."""
    solver = load(spec)
    model = solver.build(Question(LEFT))
    solver.solve(model, limit)  # compiled
    began = process_time()  # a busy machine takes the wall clock, not the processor

    solution = solver.solve(model, limit)

    assert process_time() - began < 1.0 + limit
    assert solution.claim is Claim.LIMIT
    if spec.startswith("collocation"):  # keeps the point that it has
        assert solution.path is not None

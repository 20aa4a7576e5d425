"""collocation against the closed form, and its parts against other integrators and derivatives."""

from __future__ import annotations

import math
from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from cases import EDGES, PAPER, scenarios
from hard_cases import hard_frame
from hypothesis import given, settings
from hypothesis import strategies as st
from pyomo.environ import Constraint
from pyomo.environ import value as value_of
from scipy.integrate import solve_ivp

from dubins_study.experiments.solve import solve
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.optimal_control.arcs import RATES, Elements, Rates, closed, cut
from dubins_study.solvers.optimal_control.collocation import Collocation, program, template
from dubins_study.solvers.optimal_control.word_guesses import trials
from dubins_study.solvers.protocol import Question
from dubins_study.study.body_coordinates import local
from dubins_study.study.check.verdict import judge
from dubins_study.study.closed_form.shortest import margin, shortest
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import SCENARIO, names
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Claim, Verdict

# The gap of free elements is what Ipopt's barrier leaves at tol = 1e-9: a few 1e-11 an element, and
# 3e-8 at most over 900 questions of the hard frame, on a circle, where its convergence is slowest.
TINY = 1e-7
IN_DISCS = {
    "left centre": Scenario(0, 0, 0.7, -math.sin(0.7), math.cos(0.7), 1),
    "left": Scenario(0, 0, 0, -0.2, 0.6, 1),
    "right": Scenario(0, 0, 0, 0.4, -1.2, 1),
    "problem 1, R=6": replace(PAPER["problem 1"], radius=6.0),
    "problem 5, R=60": Scenario(0, 0, 2 * math.pi / 3, -80, 20, 60),
}


@pytest.mark.parametrize("place", IN_DISCS)
def test_targets_in_both_discs_get_the_closed_forms_length(place):
    """RL and LR are found, switch and all, though no element knows where the switch is."""
    answer = solve(IN_DISCS[place], "collocation")

    assert answer.region in ("left disc", "right disc")
    assert answer.claim is Claim.LOCAL
    assert answer.verdict is Verdict.OPTIMAL
    assert abs(answer.gap) <= TINY


@pytest.mark.parametrize("branch", RATES)
@pytest.mark.parametrize("edge", EDGES)
def test_every_branch_at_every_kind_of_target(edge, branch):
    """The gap is Ipopt's tolerance everywhere; where a branch has no path, the search fails."""
    answer = solve(EDGES[edge], "collocation", branch)

    if shortest(EDGES[edge], branch) is None:
        assert answer.claim in (Claim.FAILED, Claim.INFEASIBLE)
        assert answer.iterations > 0
    else:
        assert answer.verdict is Verdict.OPTIMAL
        assert abs(answer.gap) <= TINY


@pytest.mark.slow
def test_hard_scenarios():
    """Radii from 1e-6 to 1e6, targets on circles, next to them, at the start and 1e9 radii away."""
    solver = Collocation()
    for row in hard_frame(150, seed=3).itertuples():
        scenario = Scenario(**{name: getattr(row, name) for name in names(SCENARIO)})
        for branch in RATES:
            solution = solver.solve(solver.build(Question(scenario, branch)), 60.0)
            found = judge(scenario, solution.path, solution.claim, branch)
            assert not found.false_claim, (scenario, branch)
            exists = shortest(scenario, branch) is not None
            assert not exists or found.verdict is Verdict.OPTIMAL, (scenario, branch)


@pytest.mark.slow
@given(scenarios())
@settings(max_examples=10, deadline=None)
def test_the_mirror_image_is_as_long(scenario):
    """Nothing prefers a side: starts, bounds and the order of the words are mirrored too."""
    flipped = Scenario(
        scenario.x, -scenario.y, -scenario.heading,
        scenario.target_x, -scenario.target_y, scenario.radius,
    )  # fmt: skip
    if margin(scenario) < 1e-6:  # the length jumps across the circles
        return

    found, other = solve(scenario, "collocation"), solve(flipped, "collocation")

    assert found.length == pytest.approx(other.length, rel=TINY, abs=TINY * scenario.radius)


def test_the_transcription_is_an_ode_solved_by_quadrature():
    """The end point that Ipopt meets is the ODE's, up to the miss that is reported before closing.

    An adaptive integrator drives the raw controls; with 3 points an arc cannot be hit by chance.
    """
    scenario = IN_DISCS["left"]
    answer = solve(scenario, "collocation[n=4,points=3,correct=false]")
    ends = np.cumsum(answer.path.length)
    pose = np.array(scenario.start)
    for k, length in zip(answer.path.curvature, answer.path.length, strict=True):
        pose = solve_ivp(
            lambda _, s, k=k: (math.cos(s[2]), math.sin(s[2]), k),
            (0.0, length), pose, rtol=1e-12, atol=1e-12,
        ).y[:, -1]  # fmt: skip

    off = math.hypot(pose[0] - scenario.target_x, pose[1] - scenario.target_y)

    assert ends[-1] == pytest.approx(answer.claimed_length, rel=1e-12)
    assert off == pytest.approx(answer.miss, rel=1e-6)
    assert f"missed by {off:.1e} radii" in answer.message
    assert answer.verdict is Verdict.MISSES


@pytest.mark.parametrize("points", [2, 3, 4])
def test_the_miss_falls_as_radaus_order_says(points):
    """Order 2 p - 1 in the elements (Hairer and Wanner 1996, sec. IV.5), switch or no switch."""
    misses = [
        solve(IN_DISCS["left"], f"collocation[n={n},points={points},correct=false]").miss
        for n in (4, 12)
    ]

    order = math.log(misses[0] / misses[1], 3)
    # each order is seen a few tenths off, since the elements at either arc's end differ in size
    assert order == pytest.approx(2 * points - 1, abs=1.5)


@pytest.mark.slow
def test_equal_elements_gain_with_their_number():
    """A switch inside an element costs; 8 times more elements cost 20 times less, or better.

    64 would be the second order's; where in an element the switch falls decides the rest.
    """
    spec = "collocation[mesh=equal,points=3,n={}]"
    coarse, fine = (solve(IN_DISCS["left"], spec.format(n)).gap for n in (10, 80))

    assert TINY < fine < coarse / 20


def test_multipliers_of_two_arcs_point_along_the_chord():
    """-(nu1, nu2) / nu0 of RL is the second arc's chord / cos(a2 / 2) (derivation, section 9)."""
    scenario = Scenario(1, -2, 0, 1.1, -1.2, 1)
    first, second = shortest(scenario).segments
    switch = Path(scenario.start, [-1.0], [first]).end
    chord = np.array((scenario.target_x - switch.x, scenario.target_y - switch.y))

    answer = solve(scenario, "collocation")

    expected = chord / np.hypot(*chord) / math.cos(second / 2)
    # the quadrature's error in the end point's derivatives, of the size of the raw miss
    assert (answer.multiplier_x, answer.multiplier_y) == pytest.approx(expected, abs=1e-5)


def test_multipliers_turn_with_the_vehicle():
    """In the world frame: straight at the end, they are the final heading."""
    scenario = Scenario(0, 0, 2.2, 3, -4, 1.5)
    answer = solve(scenario, "collocation")

    final = answer.path.end.heading
    expected = (math.cos(final), math.sin(final))
    # the last element, nearly straight, turns by what the barrier leaves
    assert (answer.multiplier_x, answer.multiplier_y) == pytest.approx(expected, abs=1e-4)


def test_a_warm_start_comes_first():
    """A path in the world, at its radius, becomes the first guess, and a word may need no other."""
    scenario = EDGES["huge radius"]
    start = solve(scenario, "analytic", "RS").path
    question = Question(scenario, "RS", start)

    (trial,) = trials(question, local(scenario), ("RS",), 5, None, RATES["RS"])

    label, first = next(trial.guesses)
    assert label == "warm"
    assert first.total * scenario.radius == pytest.approx(start.total_length)
    assert first.path.end[:2] == pytest.approx(scenario.local(), abs=1e-9)
    assert {guess.subproblem for guess in trial.guesses} == {"RS"}  # if it fails there are others


@pytest.mark.parametrize(
    ("curvature", "length"),
    [([1.0, 0.0] * 4, [0.5] * 8), ([math.nan], [1.0]), ([], []), ([1.0], [0.0]), ([5.0], [3.0])],
)
def test_a_useless_warm_start_does_no_harm(curvature, length):
    """More arcs than elements, a broken path, one of no length, one that turns too hard."""
    behind = EDGES["behind"]

    answer = solve(behind, "collocation", initial_guess=Path(behind.start, curvature, length))

    assert answer.verdict is Verdict.OPTIMAL


def test_time_runs_out():
    """Ipopt stops between two iterations, with the point it has and a claim that says so."""
    solver, scenario = Collocation(n=160, mesh="equal"), IN_DISCS["left"]
    model = solver.build(Question(scenario))
    began = process_time()  # a busy machine takes the wall clock, not the processor

    solution = solver.solve(model, 0.1)

    assert process_time() - began < 1.5  # without the limit: 4 s on this test's machine class
    assert solution.claim is Claim.LIMIT
    assert solution.path is not None
    assert solver.solve(model, 0.0).claim is Claim.LIMIT


def test_ipopt_giving_up_is_a_claim():
    """After three iterations nothing is a solution: at most a path that the correction closed."""
    answer = solve(IN_DISCS["left"], "collocation[max_iter=3]")

    assert answer.claim in (Claim.FEASIBLE, Claim.FAILED)
    assert answer.native_status == "Maximum_Iterations_Exceeded"
    assert answer.path is not None
    assert not answer.false_claim


@pytest.mark.parametrize(
    "wrong",
    [
        {"n": 2}, {"n": 4.5}, {"points": 0}, {"max_iter": True},
        {"mesh": "fine"}, {"via": "mail"}, {"tol": 0},
    ],
)  # fmt: skip
def test_wrong_settings_are_refused_by_name(wrong):
    """The message names the setting and the value."""
    ((name, value),) = wrong.items()

    with pytest.raises(ValueError, match=rf"{name} is '?{value}'?; expected"):
        Collocation(**wrong)


@given(st.integers(3, 12), st.integers(0, 10_000), st.sampled_from(sorted(RATES)), st.booleans())
@settings(max_examples=60, deadline=None)
def test_correction_keeps_what_it_must(n, seed, branch, equal):
    """It arrives from nearby, within the rates' bounds and the mesh, at about the same length."""
    random, rates = np.random.default_rng(seed), RATES[branch]
    length = np.full(n, 0.4) if equal else random.uniform(0.1, 0.8, n)
    elements = Elements(random.uniform(rates.lower, rates.upper, n) * length, length)
    target = np.array(elements.path.end[:2]) + random.normal(size=2) * 1e-4

    moved, miss, _ = closed(elements, rates, target, equal)

    assert miss <= 1e-10
    assert (moved.length > 0).all()
    assert moved.rate.min() >= rates.lower - 1e-12
    assert moved.rate.max() <= rates.upper + 1e-12
    assert abs(moved.total - elements.total) < 0.05  # a few hundred times the shift
    if equal:
        assert np.ptp(moved.length) <= 1e-14


def test_correction_leaves_bounds_alone():
    """Two arcs at full rate: only their lengths change, as the closed form's would."""
    full = Rates(-1.0, 1.0)
    arcs = Elements(np.array((-0.5, 2.0, 2.5)), np.array((0.5, 2.0, 2.5)))
    end = arcs.path.end
    target = np.array((end.x + 1e-3, end.y - 2e-3))

    moved, miss, _ = closed(arcs, full, target, equal=False)

    expected = shortest(Scenario(0, 0, 0, *target, 1), "RL")
    assert miss <= 1e-10
    assert np.abs(moved.rate) == pytest.approx(np.ones(3), abs=1e-14)
    assert moved.length[0] == pytest.approx(expected.segments.first, abs=1e-9)
    assert moved.length[1:].sum() == pytest.approx(expected.segments.second, abs=1e-9)


def test_correction_of_what_cannot_arrive_is_honest():
    """The miss that is left comes back, not an exception."""
    straight = Elements(np.zeros(3), np.ones(3))

    _, miss, _ = closed(straight, RATES["LS"], np.array((0.0, -0.1)), equal=False)
    _, nothing, _ = closed(Elements(np.zeros(3), np.zeros(3)), RATES["LS"], np.ones(2), equal=True)

    assert miss > 1e-3
    assert nothing == pytest.approx(math.sqrt(2))


@given(st.integers(1, 6), st.integers(0, 10_000), st.integers(3, 9), st.booleans())
@settings(max_examples=60, deadline=None)
def test_cutting_a_path_keeps_its_turn_and_length(arcs, seed, n, equal):
    """And where its arcs fit into the elements, the path itself."""
    random = np.random.default_rng(seed)
    path = Path(Pose(0, 0, 0), random.uniform(-1, 1, arcs), random.uniform(0, 2, arcs))

    elements = cut(path, n, np.full(n, 1 / n) if equal else None)

    assert elements.length.shape == (n,)
    assert elements.total == pytest.approx(path.total_length)
    assert elements.turn.sum() == pytest.approx(path.turn, abs=1e-12)
    if not equal and arcs <= n:
        assert elements.path.end == pytest.approx(path.end, abs=1e-12)


@pytest.mark.parametrize("equal", [False, True])
def test_a_guess_follows_its_controls(equal):
    """Arcs driven exactly satisfy every equation of the transcription, the target's included.

    Up to what polynomials of degree 6 leave of arcs of 0.7 rad: 3e-7 here. A state in another's
    place would be off by tenths.
    """
    asked = program(4, 6, equal)
    given = []

    def ask(start, lower, upper):
        given.append(start)
        return EngineResult(start, Claim.LOCAL, None, 0, 0, "", "")

    compiled = template(4, 6, equal, "ipopt", 1e-9, 100, by_executable=False)
    guess = cut(Path(Pose(0, 0, 0), [0.9, -0.5], [1.5, 1.5]), 4, compiled.shares)
    end = np.array(guess.path.end[:2])
    replace(compiled, ask=ask).solve(guess, RATES["best"], end, math.inf)
    for variable, value in zip(asked.variables, given[0], strict=True):
        variable.set_value(float(value), skip_validation=True)

    for row in asked.model.component_data_objects(Constraint):
        if row.equality:
            assert value_of(row.body) == pytest.approx(value_of(row.upper), abs=1e-6), row.name
        else:
            assert value_of(row.body) <= value_of(row.upper) + 1e-15, row.name

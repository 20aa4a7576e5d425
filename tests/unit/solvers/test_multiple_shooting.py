"""multiple-shooting against the closed form, its equations against an ODE integrator."""

from __future__ import annotations

import math
from dataclasses import replace
from time import perf_counter, process_time

import numpy as np
import pytest
from cases import EDGES, PAPER, mirrored, scaled, scenarios
from hard_cases import hard_frame
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dubins_study.experiments.solve import solve
from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.optimal_control.arcs import INTEGRATORS, RATES, cut, mean_cosine
from dubins_study.solvers.optimal_control.multiple_shooting import MultipleShooting, expressions
from dubins_study.solvers.protocol import Question
from dubins_study.study.closed_form.shortest import margin, shortest
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import SCENARIO, names
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Claim, Outcome, Verdict

# A free length's gap is what the engine's tolerance leaves, 1e-9 on equations and multipliers.
TINY = 1e-8
IN_DISCS = {
    "left": Scenario(0, 0, 0, -0.2, 0.6, 1),
    "right": Scenario(0, 0, 0.5, 0.4, -1.0, 1),
    "problem 1, R=6": replace(PAPER["problem 1"], radius=6.0),
}


@pytest.mark.parametrize("place", IN_DISCS)
def test_targets_in_both_discs_get_the_closed_forms_length(place):
    """RL and LR are found, switch and all."""
    answer = solve(IN_DISCS[place], "multiple-shooting")

    assert answer.region in ("left disc", "right disc")
    assert answer.claim is Claim.LOCAL
    assert answer.verdict is Verdict.OPTIMAL
    assert abs(answer.gap) <= TINY


@pytest.mark.parametrize("branch", RATES)
@pytest.mark.parametrize("edge", EDGES)
def test_every_branch_at_every_kind_of_target(edge, branch):
    """The closed form's length, and turns to the branch's side only; else the search fails."""
    answer = solve(EDGES[edge], "multiple-shooting", branch)

    assert not answer.false_claim
    if shortest(EDGES[edge], branch) is None:
        assert answer.claim in (Claim.FAILED, Claim.INFEASIBLE)
        return
    assert answer.verdict is Verdict.OPTIMAL
    assert abs(answer.gap) <= TINY
    rate = answer.path.curvature * EDGES[edge].radius
    # dividing by the radius and multiplying again may cost a rounding
    assert rate.min(initial=0) >= RATES[branch].lower - 1e-15
    assert rate.max(initial=0) <= RATES[branch].upper + 1e-15


@pytest.mark.slow
def test_hard_scenarios():
    """Radii from 1e-6 to 1e6, targets on circles, next to them, at the start and 1e9 radii away."""
    solver = MultipleShooting()
    for row in hard_frame(100, seed=3).itertuples():
        scenario = Scenario(**{name: getattr(row, name) for name in names(SCENARIO)})
        for branch in RATES:
            answer = attempt(solver, Question(scenario, branch))
            assert not answer.false_claim, (scenario, branch)
            exists = shortest(scenario, branch) is not None
            assert not exists or answer.verdict is Verdict.OPTIMAL, (scenario, branch)


@given(scenarios(), st.floats(-5, 5))
@settings(max_examples=10, deadline=None)
def test_mirror_image_and_scale(scenario, exponent):
    """Nothing prefers a side or a unit."""
    if margin(scenario) < 1e-6:  # the length jumps across the circles
        return
    factor = 10.0**exponent

    answer = solve(scenario, "multiple-shooting")
    other = solve(mirrored(scenario), "multiple-shooting")
    large = solve(scaled(scenario, factor), "multiple-shooting")

    tolerance = {"rel": TINY, "abs": TINY * scenario.radius}
    assert answer.length == pytest.approx(other.length, **tolerance)
    assert answer.length == pytest.approx(large.length / factor, **tolerance)


@given(st.floats(0, 1.5 * math.pi))
def test_the_mean_cosine_is_sinc(half):
    """To rounding for turns up to 3 pi; its derivative too, which the engines use."""
    points, weights = mean_cosine("exact")

    value = (weights * np.cos(half * points)).sum()
    slope = -(weights * points * np.sin(half * points)).sum()

    assert value == pytest.approx(math.sin(half) / half if half else 1.0, abs=1e-14)
    exact = (half * math.cos(half) - math.sin(half)) / half**2 if half > 1e-2 else -half / 3
    # below 1e-2 the series' next term, half^3 / 30, is left out: 4e-8
    assert slope == pytest.approx(exact, abs=1e-12 if half > 1e-2 else 4e-8)


@given(st.integers(1, 5), st.integers(0, 10_000), st.sampled_from(INTEGRATORS), st.booleans())
@settings(max_examples=30, deadline=None)
def test_equations_are_the_gaps_between_driven_segments(n, seed, integrator, equal):
    """An adaptive integrator, or the textbook's Runge-Kutta step, drives every segment."""
    random = np.random.default_rng(seed)
    left, right, straight = random.uniform(0, 1, (3, n))
    whole, poses = random.uniform(1, 5), random.normal(size=(n - 1, 3))
    target = random.normal(size=2)
    program = expressions(n, (1, -1), equal, integrator)
    x = np.concatenate((left, right, straight, [whole] if equal else [], poses.ravel()))

    gaps = program.functions(target).equations(x)

    length, turn = left + right + straight, left - right
    starts = np.vstack((np.zeros(3), poses))
    drive = driven if integrator == "exact" else runge_kutta
    ends = np.array([drive(*state) for state in zip(starts, turn, length, strict=True)])
    expected = np.concatenate(((starts[1:] - ends[:-1]).ravel(), target - ends[-1, :2]))
    if equal:
        expected = np.concatenate((length - whole / n, expected))
    assert gaps == pytest.approx(expected, abs=1e-10)
    objective = program.functions(target).objective(x)
    assert objective == pytest.approx(whole if equal else length.sum())


def driven(pose, turn, length):
    """The pose at the end of an arc, by an adaptive integrator."""

    def motion(_, state):
        return (length * math.cos(state[2]), length * math.sin(state[2]), turn)

    return solve_ivp(motion, (0, 1), pose, rtol=1e-12, atol=1e-12).y[:, -1]


def runge_kutta(pose, turn, length):
    """The pose after one classical Runge-Kutta step of order 4."""

    def slope(state):
        return np.array((length * math.cos(state[2]), length * math.sin(state[2]), turn))

    first = slope(pose)
    second = slope(pose + first / 2)
    third = slope(pose + second / 2)
    return pose + (first + 2 * second + 2 * third + slope(pose + third)) / 6


def test_runge_kuttas_miss_falls_with_the_fourth_power():
    """Three times more segments: 81 times less, up to where in a segment the switch falls."""
    spec = "multiple-shooting[integrator=rk4,mesh=equal,n={},correct=false]"
    misses = [solve(IN_DISCS["left"], spec.format(n)).miss for n in (6, 18)]

    assert math.log(misses[0] / misses[1], 3) == pytest.approx(4, abs=1)


def test_equal_segments_gain_with_their_number():
    """A switch inside a segment costs; 8 times more segments cost 20 times less, or better."""
    spec = "multiple-shooting[mesh=equal,n={}]"
    coarse, fine = (solve(IN_DISCS["left"], spec.format(n)).gap for n in (10, 80))

    assert TINY < fine < coarse / 20


@pytest.mark.parametrize("mesh", ["free", "equal"])
@pytest.mark.parametrize("branch", RATES)
def test_a_guess_follows_its_controls(branch, mesh):
    """Arcs driven exactly satisfy every equation, the target's included, and every bound."""
    given_programs = []

    def engine(program, guess, seconds):
        given_programs.append((program, guess))
        return EngineResult(guess, Claim.LOCAL, None, 1, 1, "", "")

    rates = RATES[branch]
    template = replace(MultipleShooting(n=6, mesh=mesh).template(1.0), engine=engine)
    path = Path(Pose(0, 0, 0), [rates.upper or rates.lower, 0.0], [2.0, 1.5])
    guess = cut(path, 6, template.shares)
    end = guess.path.end

    transcribed = template.solve(guess, rates, np.array(end[:2]), perf_counter() + 1)

    ((program, start),) = given_programs
    assert (start >= program.lower).all()
    assert (start <= program.upper).all()
    assert program.functions.equations(start) == pytest.approx(0, abs=1e-13)
    assert transcribed.elements.turn == pytest.approx(guess.turn, abs=1e-14)
    assert transcribed.elements.length == pytest.approx(guess.length, abs=1e-14)


def test_multipliers_of_two_arcs_point_along_the_chord():
    """-(nu1, nu2) / nu0 of RL is the second arc's chord / cos(a2 / 2) (derivation, section 9)."""
    scenario = Scenario(1, -2, 0, 1.1, -1.2, 1)
    first, second = shortest(scenario).segments
    switch = Path(scenario.start, [-1.0], [first]).end
    chord = np.array((scenario.target_x - switch.x, scenario.target_y - switch.y))

    answer = solve(scenario, "multiple-shooting")

    expected = chord / np.hypot(*chord) / math.cos(second / 2)
    # Ipopt relaxes bounds by 1e-8 and stops with multipliers as far off
    assert (answer.multiplier_x, answer.multiplier_y) == pytest.approx(expected, abs=1e-6)


def test_time_runs_out():
    """The engine stops between two iterations; without any time none begins."""
    solver, scenario = MultipleShooting(n=20, mesh="equal"), IN_DISCS["left"]
    solver.solve(solver.build(Question(scenario, "RS")), 60.0)  # compiled
    model = solver.build(Question(scenario))

    began = process_time()  # a busy machine takes the wall clock, not the processor
    solution = solver.solve(model, 1e-3)

    assert process_time() - began < 1.0
    assert solution.claim is Claim.LIMIT
    assert solver.solve(model, 0.0).path is None


# Engines that may end without a solution of three segments, and why: two build models from values
# alone and stop at the limit; L-BFGS within the augmented Lagrangian gives up at its rounding.
MAY_FAIL = {"cobyqa", "nlopt-cobyla", "nlopt-auglag"}
ENGINE_LIMIT_S = 3.0  # the others take a few hundredths


@pytest.mark.parametrize(
    "engine",
    [
        pytest.param(name, marks=pytest.mark.slow if name in MAY_FAIL else ())
        for name in NLP_ENGINES
        if name != "sleqp"
    ],
)
def test_every_engine_of_the_table(engine):
    """A solution of problem 1, or at least no false claim; a missing engine has a reason."""
    solver = MultipleShooting(n=3, engine=engine, max_iter=100)
    if (reason := solver.unavailable()) is not None:
        assert reason.strip()
        return

    answer = attempt(solver, Question(PAPER["problem 1"], "RS"), ENGINE_LIMIT_S)

    assert answer.outcome is Outcome.RETURNED, answer.message
    assert answer.engine == ENGINES[engine].label
    assert not answer.false_claim
    if answer.claim is Claim.LOCAL:
        assert answer.verdict is Verdict.OPTIMAL
    else:
        assert engine in MAY_FAIL, (answer.claim, answer.message)


@pytest.mark.parametrize(
    "wrong",
    [
        {"n": 2}, {"n": 4.5}, {"max_iter": True}, {"engine": "cplex"}, {"mesh": "graded"},
        {"integrator": "euler"}, {"tol": 0}, {"initial_guess": "warm"}, {"count": 0}, {"seed": -1},
    ],
)  # fmt: skip
def test_wrong_settings_are_refused_by_name(wrong):
    """The message names the setting and the value."""
    ((name, value),) = wrong.items()

    with pytest.raises(ValueError, match=rf"{name} is '?{value}'?; expected"):
        MultipleShooting(**wrong)

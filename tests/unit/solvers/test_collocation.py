"""collocation against the closed form, and its parts against other integrators and derivatives."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import EDGES
from hypothesis import given, settings
from hypothesis import strategies as st
from pyomo.environ import Constraint
from pyomo.environ import value as value_of
from scipy.integrate import solve_ivp

from dubins_study.experiments.solve import solve
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.optimal_control.arcs import RATES, Elements, Rates, closed, cut
from dubins_study.solvers.optimal_control.collocation import program, template
from dubins_study.solvers.optimal_control.word_guesses import trials
from dubins_study.solvers.protocol import Question
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Claim, Verdict

# The gap of free elements is what Ipopt's barrier leaves at tol = 1e-9: a few 1e-11 an element, and
# 3e-8 at most over 900 questions of the hard frame, on a circle, where its convergence is slowest.
LEFT = Scenario(0, 0, 0, -0.2, 0.6, 1)


def test_the_transcription_is_an_ode_solved_by_quadrature():
    """The end point that Ipopt meets is the ODE's, up to the miss that is reported before closing.

    An adaptive integrator drives the raw controls; with 3 points an arc cannot be hit by chance.
    """
    scenario = LEFT
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
        solve(LEFT, f"collocation[n={n},points={points},correct=false]").miss for n in (4, 12)
    ]

    order = math.log(misses[0] / misses[1], 3)
    # each order is seen a few tenths off, since the elements at either arc's end differ in size
    assert order == pytest.approx(2 * points - 1, abs=1.5)


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


def test_ipopt_giving_up_is_a_claim():
    """After three iterations nothing is a solution: at most a path that the correction closed."""
    answer = solve(LEFT, "collocation[max_iter=3]")

    assert answer.claim in (Claim.FEASIBLE, Claim.FAILED)
    assert answer.native_status == "Maximum_Iterations_Exceeded"
    assert answer.path is not None
    assert not answer.false_claim


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

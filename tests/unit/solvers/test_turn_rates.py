"""turn-rates against the closed form, its end point against an ODE integrator."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import PAPER, mirrored, scaled
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dubins_study.experiments.solve import solve
from dubins_study.solvers.optimal_control.arcs import RATES
from dubins_study.solvers.optimal_control.turn_rates import TurnRates, expressions
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Verdict

PLACES = {
    "left": Scenario(0, 0, 0.7, 5, 1, 1),
    "behind": Scenario(0, 0, 0, -3, 0, 1),
    "left disc": Scenario(0, 0, 0, -0.2, 0.6, 1),
}


@pytest.mark.parametrize("place", PLACES)
def test_the_sequence_of_qps_finds_the_same_path(place):
    """`turn-rate-qp` solves the same program by another method."""
    program = solve(PLACES[place], "turn-rates[n=24]")
    sequence = solve(PLACES[place], "turn-rate-qp[n=24]")

    # 1e-6: the sequence stops at a promised gain of 1e-7 of the length
    assert program.length == pytest.approx(sequence.length, rel=1e-6)
    assert program.formulation == sequence.formulation == "turn rates"


@given(st.integers(2, 12), st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_equations_are_the_gap_at_the_end(n, seed):
    """An adaptive integrator drives the steps one after another."""
    random = np.random.default_rng(seed)
    rate, whole = random.uniform(-1, 1, n), random.uniform(0.5, 8)
    share, target = random.dirichlet(np.ones(n)), random.normal(size=2)
    pose = np.zeros(3)
    for u, length in zip(rate, share * whole, strict=True):
        pose = solve_ivp(
            lambda _, s, u=u: (math.cos(s[2]), math.sin(s[2]), u),
            (0, length), pose, rtol=1e-11, atol=1e-11,
        ).y[:, -1]  # fmt: skip

    functions = expressions(n).functions(np.concatenate((target, share)))
    x = np.append(rate, whole)

    assert functions.equations(x) == pytest.approx(target - pose[:2], abs=1e-8)
    assert functions.objective(x) == pytest.approx(whole)


@pytest.mark.parametrize("branch", RATES)
def test_mirror_image_and_scale(branch):
    """Nothing prefers a side or a unit; a branch turns to its side only."""
    scenario = PLACES["left"]
    other = {"LS": "RS", "RS": "LS"}.get(branch, branch)

    answer = solve(scenario, "turn-rates[n=20]", branch)
    mirror = solve(mirrored(scenario), "turn-rates[n=20]", other)
    large = solve(scaled(scenario, 1e4), "turn-rates[n=20]", branch)

    # what Ipopt's tolerance leaves
    assert answer.length == pytest.approx(mirror.length, rel=1e-7)
    assert answer.length == pytest.approx(large.length / 1e4, rel=1e-7)
    assert RATES[branch].lower <= answer.path.curvature.min()
    assert answer.path.curvature.max() <= RATES[branch].upper


def test_no_step_turns_by_more_than_half_a_circle():
    """The bounds that the engine gets keep full turns out, and leave short steps alone."""
    far, near = TurnRates(n=10).template(1000.0), TurnRates(n=10).template(5.0)

    assert (far.most * far.shares * 1000.0 <= math.pi).all()
    assert near.most == pytest.approx(np.ones(10), abs=0)


@given(st.floats(-20, 20), st.floats(-20, 20), st.sampled_from(["best", "LS", "RS"]))
def test_a_shortest_path_makes_less_of_a_detour_than_the_bounds_allow(x, y, branch):
    """The closed form's length exceeds the distance by less than two full turns."""
    scenario = Scenario(0, 0, 0, x, y, 1)
    if shortest(scenario, branch) is not None:
        length = solve(scenario, "analytic", branch).length
        assert length < math.hypot(x, y) + 4 * math.pi


@pytest.mark.parametrize("engine", ["ipopt", "slsqp"])
def test_engines_agree(engine):
    """An interior-point and an active-set method end at the same path."""
    scenario = replace(PAPER["problem 1"], radius=2.0)

    answer = solve(scenario, f"turn-rates[n=20,mesh=graded,engine={engine}]")

    assert answer.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
    # 20 steps: the order is tested above
    assert 0 <= answer.gap < 3e-4

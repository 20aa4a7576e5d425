"""collocation against the closed form, and its parts against other integrators and derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dubins_study.experiments.solve import solve
from dubins_study.solvers.optimal_control.arcs import cut, rollout
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
    ends = np.cumsum(answer.path.lengths)
    pose = np.array(scenario.start)
    for k, length in zip(answer.path.curvatures, answer.path.lengths, strict=True):
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


def test_ipopt_giving_up_is_a_claim():
    """After three iterations nothing is a solution: at most a path that the correction closed."""
    answer = solve(LEFT, "collocation[max_iter=3]")

    assert answer.claim in (Claim.FEASIBLE, Claim.FAILED)
    assert answer.native_status == "Maximum_Iterations_Exceeded"
    assert answer.path is not None
    assert not answer.false_claim


@given(st.integers(1, 6), st.integers(0, 10_000), st.integers(3, 9), st.booleans())
@settings(max_examples=60, deadline=None)
def test_cutting_a_path_keeps_its_turn_and_length(arcs, seed, n, equal):
    """And where its arcs fit into the elements, the path itself."""
    random = np.random.default_rng(seed)
    path = Path(Pose(0, 0, 0), random.uniform(-1, 1, arcs), random.uniform(0, 2, arcs))

    elements = cut(path, n, np.full(n, 1 / n) if equal else None)

    assert elements.length.shape == (n,)
    assert elements.total == pytest.approx(path.length)
    assert elements.turn.sum() == pytest.approx(path.turn, abs=1e-12)
    if not equal and arcs <= n:
        chords = rollout(elements).chords
        assert chords.sum(axis=1) == pytest.approx(path.end[:2], abs=1e-12)

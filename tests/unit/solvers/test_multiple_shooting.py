"""multiple-shooting against the closed form, its equations against an ODE integrator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases import PAPER
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dubins_study.experiments.solve import solve
from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES
from dubins_study.solvers.optimal_control.arcs import INTEGRATORS
from dubins_study.solvers.optimal_control.multiple_shooting import MultipleShooting, expressions
from dubins_study.solvers.protocol import Question
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome, Verdict

# A free length's gap is what the engine's tolerance leaves, 1e-9 on equations and multipliers.
LEFT = Scenario(0, 0, 0, -0.2, 0.6, 1)


@given(st.integers(1, 5), st.integers(0, 10_000), st.sampled_from(INTEGRATORS), st.booleans())
@settings(max_examples=30, deadline=None)
def test_equations_are_the_gaps_between_driven_segments(n, seed, integrator, equal):
    """An adaptive integrator, or the textbook's Runge-Kutta step, drives every segment."""
    random = np.random.default_rng(seed)
    controls = random.uniform(0, 1, (n, 3))
    left, right, straight = controls.T
    whole, starts = random.uniform(1, 5), np.vstack((np.zeros(3), random.normal(size=(n - 1, 3))))
    target = random.normal(size=2)
    program = expressions(n, (1, -1), equal, integrator, 1, 0)
    x = np.append(np.hstack((starts, controls)).ravel()[3:], [whole] if equal else [])

    gaps = program.functions(target).equations(x)

    length, turn = left + right + straight, left - right
    drive = driven if integrator == "exact" else runge_kutta
    ends = np.array([drive(*state) for state in zip(starts, turn, length, strict=True)])
    each = (length - whole / n)[:, None] if equal else np.empty((n, 0))
    expected = np.hstack((np.vstack((starts[1:] - ends[:-1], np.zeros(3))), each)).ravel()
    expected = np.append(
        np.delete(expected, slice(-3 - equal, expected.size - equal)), target - ends[-1, :2]
    )
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
    misses = [solve(LEFT, spec.format(n)).miss for n in (6, 18)]

    assert math.log(misses[0] / misses[1], 3) == pytest.approx(4, abs=1)


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

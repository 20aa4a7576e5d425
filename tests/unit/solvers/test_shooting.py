"""shooting: equations, sign conditions and judged answers.

The equations are compared with an integrator, the sign conditions with theory.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dubins_study.experiments.solve import solve
from dubins_study.solvers.indirect.structure import Structure
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Verdict
from tests.cases import PAPER

TURNS = ((1.0, 0.0), (-1.0, 0.0), (1.0, -1.0), (-1.0, 1.0))

durations = st.tuples(st.floats(0, 7), st.floats(0, 7)).map(np.array)
costates = st.tuples(*[st.floats(-2, 2)] * 4).map(np.array)


def integrate(structure, durations, costates):
    """States and nu3 by (2.2) and (2.6).

    They are rows (x, y, theta, nu3) at the ends of both pieces.
    """
    nu1, nu2, nu3 = costates[1:]
    states = [np.array((0.0, 0.0, 0.0, nu3))]
    for turn, duration in zip(structure.turns, durations, strict=True):

        def rates(_, s, turn=turn):
            cos, sin = math.cos(s[2]), math.sin(s[2])
            return cos, sin, turn, nu1 * sin - nu2 * cos

        run = solve_ivp(rates, (0, duration), states[-1], method="DOP853", rtol=1e-12, atol=1e-12)
        states.append(run.y[:, -1])
    return np.array(states[1:])


@pytest.mark.parametrize("turns", TURNS)
@settings(max_examples=15)
@given(durations, costates)
def test_the_pieces_are_solutions_of_the_canonical_equations(turns, durations, costates):
    """The pieces solve the canonical equations.

    States, nu3 and its derivative are compared with an ODE integrator at 1e-12.
    """
    structure = Structure(turns, 3.0, -2.0)
    switch, end = integrate(structure, durations, costates)
    nu0, nu1, nu2, nu3 = costates
    stays = nu1 * math.sin(switch[2]) - nu2 * math.cos(switch[2])
    expected = (
        (end[0] - 3.0) / structure.scale,
        (end[1] + 2.0) / structure.scale,
        switch[3],
        stays if structure.singular else end[3],
        nu0 + nu1 + turns[0] * nu3,
        nu0**2 + nu1**2 + nu2**2 - 1,
    )

    residual = structure.residual(structure.unknowns(costates, durations))

    # the integrator's error over 14 radii
    np.testing.assert_allclose(residual, expected, atol=1e-9)
    assert structure.miss(durations) == pytest.approx(
        math.hypot(end[0] - 3.0, end[1] + 2.0), abs=1e-9
    )


@pytest.mark.parametrize("turns", TURNS)
@given(durations, costates)
def test_the_jacobian_is_the_derivative_of_the_residual(turns, durations, costates):
    """The Jacobian is the derivative of the residual.

    Central differences with step 1e-6 are right to about 1e-9 for numbers of this size.
    """
    structure = Structure(turns, 3.0, -2.0)
    h = 1e-6
    v = structure.unknowns(costates, durations)
    numeric = np.column_stack(
        [
            (structure.residual(v + h * e) - structure.residual(v - h * e)) / (2 * h)
            for e in np.eye(6)
        ]
    )

    np.testing.assert_allclose(structure.jacobian(v), numeric, atol=1e-7)


@pytest.mark.parametrize("front", [True, False])
@pytest.mark.parametrize("side", [1, -1])
def test_margins_down_to_rounding(front, side):
    """Margins down to rounding give no wrong answer.

    Where the equations become singular and the length jumps, no answer is wrong or claims more.

    From 1e-1 to 1e-13 of a radius outside and inside the left circle.
    """
    for exponent in range(1, 14):
        r = 1 + side * 10.0**-exponent
        for angle in (0.3, 1.5, 2.9):
            a = angle if front else 2 * math.pi - angle
            near = Scenario(0, 0, 0, r * math.sin(a), 1 - r * math.cos(a), 1)
            for branch in ("best", "LS", "RS"):
                answer = solve(near, "shooting", branch)
                exists = shortest(near, branch) is not None
                assert answer.verdict is Verdict.OPTIMAL or not exists, (near, branch)
                assert not answer.false_claim


def test_an_extremal_need_not_be_the_shortest():
    """An extremal need not be the shortest.

    LS where RS is best meets every condition: this is why the claim is local.
    """
    problem = PAPER["problem 1"]
    best = solve(problem, "shooting")
    other = solve(problem, "shooting", "LS")

    assert other.length > best.length + 1
    assert other.claim is Claim.LOCAL
    assert "LS: bang-singular, normal" in other.message


def test_a_branch_may_be_answered_by_a_path_that_is_no_extremal():
    """A branch may be answered by no extremal.

    A second arc below pi turns against nu3, but a branch that prescribes the turns has it.
    """
    short = solve(Scenario(0, 0, 0, 1.5, 0.5, 1), "shooting", "RL")
    long = solve(Scenario(0, 0, 0, 0.3, 1.2, 1), "shooting", "RL")

    assert short.path.lengths[1] < math.pi < long.path.lengths[1]
    assert short.verdict is long.verdict is Verdict.OPTIMAL
    assert "no extremal" in short.message
    assert "no extremal" not in long.message


def test_a_start_that_fails_says_so_and_keeps_its_point():
    """A start that fails keeps its point.

    From all zeros the dogleg gets nowhere: failed, with what is wrong and the nearest path.
    """
    answer = solve(PAPER["problem 1"], "shooting[initial_guess=zero]")

    assert answer.claim is Claim.FAILED
    assert answer.verdict is Verdict.MISSES
    assert "misses the target" in answer.message
    assert answer.native_status.startswith("hybr")
    assert answer.path is not None

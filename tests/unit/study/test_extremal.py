"""Pontryagin's conditions and the cut, against an ODE integrator, and the closed form.

The functions for two arcs against the general code for any number of arcs.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases import EDGES, PAPER
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dubins_study.study.check.extremal import extremal, measure, pieces
from dubins_study.study.check.two_arcs import FULL_RATE, PATH_WORDS, path_word
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose

ARCS = st.floats(0.01, 6.2)
# rounding of a path of up to a thousand radii, in angles
ROUNDING = 1e-9


def certified(path, radius=1.0):
    return extremal(pieces(path, radius))


def cut_margin(path, radius=1.0):
    return measure(path, radius)[1]


def driven(path: Path, nu, nu0: float, radius: float):
    """Pontryagin's system (2.3)-(2.9) integrated backwards from the end with nu3 = 0 there.

    Returns max |H|, and the least -u nu3 over turns, by an ODE integrator at 1e-12: no code is
    shared with `study.check.extremal`.
    """
    x, y, heading = path.end
    state = np.array([x, y, heading, 0.0]) / np.array([radius, radius, 1, 1])
    largest, least = 0.0, math.inf
    arcs = zip(path.curvatures[::-1] * radius, path.lengths[::-1] / radius, strict=True)
    for u, length in arcs:

        def field(s, z, u=u):
            # d/ds of x, y, theta and nu3; nu1 and nu2 are constant
            cos, sin = math.cos(z[2]), math.sin(z[2])
            return [cos, sin, u, nu[0] * sin - nu[1] * cos]

        flow = solve_ivp(
            field, (length, 0), state, rtol=1e-12, atol=1e-12, t_eval=np.linspace(length, 0, 50)
        )
        theta, nu3 = flow.y[2], flow.y[3]
        H = nu0 + nu[0] * np.cos(theta) + nu[1] * np.sin(theta) + nu3 * u
        largest = max(largest, float(np.abs(H).max()))
        if u != 0:
            least = min(least, float((-u * nu3).min()))
        state = flow.y[:, -1]
    return largest, least


@pytest.mark.parametrize("name", PAPER | EDGES)
def test_costates_against_an_ode_integrator(name):
    """With the costates found, the integrated Hamiltonian is zero and every turn has its sign."""
    scenario = (PAPER | EDGES)[name]
    path = shortest_path(scenario)
    if path is None or not path.lengths.size:
        pytest.skip("nothing to drive")
    found = certified(path, scenario.radius)
    H, margin = driven(path, found.nu, 0.0 if found.abnormal else 1.0, scenario.radius)

    # the integrator's 1e-12 grows with the length in radii, and with the costates' size
    allowed = 1e-9 * (1 + path.length / scenario.radius) * max(1, math.hypot(*found.nu))
    assert found.pmp_residual <= ROUNDING
    assert allowed >= H
    assert margin >= -allowed


@given(ARCS, ARCS, st.sampled_from([1, -1]), st.floats(-4, 4))
def test_two_arcs_are_extremal_iff_theory_says_so(first, second, side, heading):
    """docs/derivation.md, section 9, CC: extremal iff pi < a2 < 2 pi and a1 <= a2."""
    assume(min(abs(second - math.pi), abs(first - second)) > 1e-4)
    path = Path(Pose(0, 0, heading), [side, -side], [first, second])
    found = certified(path)

    is_extremal = math.pi < second and first <= second
    assert (found.pmp_residual <= ROUNDING) == is_extremal
    if is_extremal:
        rho = -1 / math.cos(second / 2)
        phi = heading + side * first - side * second / 2
        expected = (rho * math.cos(phi), rho * math.sin(phi))
        assert found.nu == pytest.approx(expected, rel=1e-6)


def test_a_second_arc_of_half_a_turn_is_abnormal():
    """a2 = pi: rho = -nu0 / cos(a2 / 2) has no bound, nu0 = 0."""
    found = certified(Path(Pose(0, 0, 0), [-1, 1], [0.3, math.pi]))

    assert found.abnormal
    assert math.hypot(*found.nu) == pytest.approx(1)
    assert found.hamiltonian <= ROUNDING


@pytest.mark.parametrize(
    ("curvature", "length", "least"),
    [
        # an interior-point solver's bias: H is off by its square
        ([1, -1, 0], [1.735, 1.36e-3, 10.0], 3e-7),
        ([0, 1], [2.0, 1.0], 1e-3),  # straight first
        ([0.5, 0], [1.0, 5.0], 1e-3),  # not at the full rate
        ([0.9, 0], [1.0, 1.0], 1e-3),
        ([1, -1, 0], [1.0, 1.0, 1.0], 1e-3),
        ([1, 0, 1, 0], [0.5, 2.0, 0.5, 2.0], 1e-3),
        ([1, 0, -1], [0.5, 2.0, 0.5], 1e-3),
    ],
)
def test_what_is_no_extremal(curvature, length, least):
    """Nor has it a cut."""
    path = Path(Pose(0, 0, 0.4), curvature, length)

    assert certified(path).pmp_residual > least
    assert cut_margin(path) is None


def test_what_is_too_small_to_matter_is_passed_over():
    """A solver's arcs of 1e-9 name no piece, and equal neighbours are one."""
    path = Path(Pose(0, 0, 0), [1, 1, -1, 0, 0], [0.5, 0.5, 1e-9, 3.0, 2.0])
    found = pieces(path, 1.0)

    assert found.u.tolist() == [1, 0]
    assert found.length == pytest.approx([1.0, 5.0])
    assert certified(path).pmp_residual <= ROUNDING


def test_a_path_of_no_length_has_no_costates():
    assert measure(Path(Pose(0, 0, 0), [], []), 1.0) == (None, math.pi)


def test_a_nearly_straight_leg_is_a_leg():
    """Found in review: 5 R at a rate of 5e-8 is no piece too small to matter."""
    bent = Path(Pose(0, 0, 0), [1, 5e-8], [4.5, 5])
    straight = Path(Pose(0, 0, 0), [1, 0], [4.5, 5])

    assert pieces(bent, 1.0).length.sum() == pytest.approx(9.5)
    assert cut_margin(bent) == pytest.approx(cut_margin(straight))
    assert cut_margin(bent) < 0


@pytest.mark.parametrize(
    ("curvature", "length", "radius"),
    [
        ([1e308], [1e-3], 1e4),
        ([1, 1e308], [0, 1], 1e4),
        ([0], [1e308], 1e-4),
        ([1e200, 0], [1, 1e200], 1),
    ],
)
def test_numbers_that_overflow_are_not_measured(curvature, length, radius):
    """Found by fuzzing: infinite conditions have no costates, and their factors raise."""
    found, _ = measure(Path(Pose(0, 0, 0), curvature, length), radius)

    assert found is None


SIZES = st.sampled_from([0.0, 1e-12, 1e-7, 9e-7, 2e-6, 1e-4, 0.3, 1.0, 5.0, 1e3])
LENGTHS = st.one_of(st.floats(1e-9, 10.0), SIZES)
RATES = st.one_of(
    st.sampled_from([-1.0, 0.0, 1.0, 1 + 1e-10, -1e-10, 0.5, 1e-3, -1e-3, 2e-3, 1e-7]),
    st.floats(-2, 2),
)


@given(RATES, LENGTHS, RATES, LENGTHS)
def test_the_word_of_two_arcs_is_the_word_of_the_path(k1, l1, k2, l2):
    """Ripples, turns of next to nothing and straights of next to no length included."""
    assume(l1 + l2 > 0)
    expected = Path(Pose(0, 0, 0), [k1, k2], [l1, l2]).word()

    assert PATH_WORDS[path_word(k1, l1, k2, l2)] == expected


@given(
    st.sampled_from([(1, 0), (-1, 0), (1, -1), (-1, 1), (1,), (-1,), (0,)]),
    st.floats(1e-3, 6.2),
    st.floats(1e-3, 6.2),
    st.floats(-1, 1).map(lambda z: z * 0.9 * FULL_RATE),
    st.floats(-4, 4),
    st.floats(0.1, 50),
)
def test_costates_in_closed_form_are_the_null_vector(turns, first, second, off, heading, radius):
    """Of S, C, CS and CC at full rate: the linear conditions, solved, have the same costates.

    Two arcs that turn by less than half a turn at the end violate the conditions. The null vector
    spreads the violation over all of them, the closed form puts it into the sign of nu3: only that
    there is one is the same.
    """
    assume(abs(second - math.pi) > 1e-3)  # costates have no bound there
    lengths = np.array([first, second][: len(turns)]) * radius
    curvature = np.array([t + off * (t != 0) for t in turns]) / radius
    path = Path(Pose(1, -2, heading), curvature, lengths)
    quick, _ = measure(path, radius)
    general = extremal(pieces(path, radius))

    assert quick.abnormal == general.abnormal
    assert (quick.pmp_residual <= 1e-7) == (general.pmp_residual <= 1e-7)
    if general.pmp_residual <= 1e-7:
        assert quick.nu == pytest.approx(general.nu, rel=1e-4, abs=1e-7)
        assert quick.sign_margin == pytest.approx(general.sign_margin, abs=1e-7)
        assert abs(quick.hamiltonian - general.hamiltonian) <= 1e-7

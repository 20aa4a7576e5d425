"""Pontryagin's conditions and the cut.

They are compared with an ODE integrator, and the closed form.

The functions for two arcs against the general code for any number of arcs; costates of routes and
of final headings against differences of the lengths of legs.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from dubins_study.study.check.extremal import extremal, measure, pieces
from dubins_study.study.check.route_extremal import route_costates, route_extremal, route_legs
from dubins_study.study.check.two_arcs import RATE_TOLERANCE
from dubins_study.study.closed_form.pose import pose_path, pose_shortest
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.kinds.shortest import shortest_route
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import POSE_BRANCHES, Proof, Verdict
from tests.cases import EDGES, PAPER, walked

ARCS = st.floats(0.01, 6.2)
# rounding of a path of up to a thousand radii, in angles
ROUNDING = 1e-9


def certified(path, radius=1.0, free=True):
    driven = pieces((path.curvatures * radius).tolist(), (path.lengths / radius).tolist())
    return extremal(path.start.heading, *driven, free)


def cut_margin(path, radius=1.0):
    return measure(path, radius)[1]


def driven(path: Path, nu, nu0: float, radius: float):
    """Pontryagin's system (2.3)-(2.9), integrated backwards.

    It begins at the end with nu3 = 0 there.

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
        theta = flow.y[2]
        nu3 = flow.y[3]
        H = nu0 + nu[0] * np.cos(theta) + nu[1] * np.sin(theta) + nu3 * u
        largest = max(largest, float(np.abs(H).max()))
        if u != 0:
            least = min(least, float((-u * nu3).min()))
        state = flow.y[:, -1]
    return largest, least


@pytest.mark.parametrize("name", PAPER | EDGES)
def test_costates_against_an_ode_integrator(name):
    """Costates agree with an ODE integrator.

    With the costates found, the integrated Hamiltonian is zero and every turn has its sign.
    """
    scenario = (PAPER | EDGES)[name]
    path = shortest_path(scenario)
    if path is None or not path.lengths.size:
        pytest.skip("nothing to drive")
    certificate = certified(path, scenario.radius)
    H, margin = driven(path, certificate.nu, 0.0 if certificate.abnormal else 1.0, scenario.radius)

    # the integrator's 1e-12 grows with the length in radii, and with the costates' size
    allowed = 1e-9 * (1 + path.length / scenario.radius) * max(1, math.hypot(*certificate.nu))
    assert certificate.pmp_residual <= ROUNDING
    assert allowed >= H
    assert margin >= -allowed


@given(ARCS, ARCS, st.sampled_from([1, -1]), st.floats(-4, 4))
def test_two_arcs_are_extremal_iff_theory_says_so(first, second, side, heading):
    """Two arcs are extremal iff theory says so.

    docs/derivation.md, section 9, CC: extremal iff pi < a2 < 2 pi and a1 <= a2.
    """
    assume(min(abs(second - math.pi), abs(first - second)) > 1e-4)
    path = Path(Pose(0, 0, heading), [side, -side], [first, second])
    certificate = certified(path)

    is_extremal = math.pi < second and first <= second
    assert (certificate.pmp_residual <= ROUNDING) == is_extremal
    if is_extremal:
        rho = -1 / math.cos(second / 2)
        phi = heading + side * first - side * second / 2
        expected = (rho * math.cos(phi), rho * math.sin(phi))
        assert certificate.nu == pytest.approx(expected, rel=1e-6)


def test_a_second_arc_of_half_a_turn_is_abnormal():
    """A second arc of half a turn is abnormal.

    a2 = pi: rho = -nu0 / cos(a2 / 2) has no bound, nu0 = 0.
    """
    certificate = certified(Path(Pose(0, 0, 0), [-1, 1], [0.3, math.pi]))

    assert certificate.abnormal
    assert math.hypot(*certificate.nu) == pytest.approx(1)
    assert certificate.hamiltonian <= ROUNDING


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
    """Other paths have a residual and no cut."""
    path = Path(Pose(0, 0, 0.4), curvature, length)

    assert certified(path).pmp_residual > least
    assert cut_margin(path) is None


def test_what_is_too_small_to_matter_is_passed_over():
    """Negligible pieces are passed over.

    A solver's arcs of 1e-9 name no piece, and equal neighbours are one.
    """
    path = Path(Pose(0, 0, 0), [1, 1, -1, 0, 0], [0.5, 0.5, 1e-9, 3.0, 2.0])
    rates, lengths = pieces(path.curvatures.tolist(), path.lengths.tolist())

    assert rates == [1, 0]
    assert lengths == pytest.approx([1.0, 5.0])
    assert certified(path).pmp_residual <= ROUNDING


def test_a_path_of_no_length_has_no_costates():
    assert measure(Path(Pose(0, 0, 0), [], []), 1.0) == (None, math.pi)


def test_a_nearly_straight_leg_is_a_leg():
    """A nearly straight leg is a leg.

    Found in review: 5 R at a rate of 5e-8 is no piece too small to matter.
    """
    bent = Path(Pose(0, 0, 0), [1, 5e-8], [4.5, 5])
    straight = Path(Pose(0, 0, 0), [1, 0], [4.5, 5])

    _, lengths = pieces(bent.curvatures.tolist(), bent.lengths.tolist())
    assert sum(lengths) == pytest.approx(9.5)
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
    """Numbers that overflow are not measured.

    Found by fuzzing: infinite conditions have no costates, and their factors raise.
    """
    found, _ = measure(Path(Pose(0, 0, 0), curvature, length), radius)

    assert found is None


@given(
    st.sampled_from([(1, 0), (-1, 0), (1, -1), (-1, 1), (1,), (-1,), (0,)]),
    st.floats(1e-3, 6.2),
    st.floats(1e-3, 6.2),
    st.floats(-1, 1).map(lambda z: z * 0.9 * RATE_TOLERANCE),
    st.floats(-4, 4),
    st.floats(0.1, 50),
)
def test_costates_in_closed_form_are_the_null_vector(turns, first, second, off, heading, radius):
    """Closed-form costates are the null vector.

    Of S, C, CS and CC at full rate the linear conditions, solved, have the same costates.

    Two arcs that turn by less than half a turn at the end violate the conditions. The null vector
    spreads the violation over all of them, the closed form puts it into the sign of nu3: only that
    there is one is the same.
    """
    assume(abs(second - math.pi) > 1e-3)  # costates have no bound there
    lengths = np.array([first, second][: len(turns)]) * radius
    curvature = np.array([t + off * (t != 0) for t in turns]) / radius
    path = Path(Pose(1, -2, heading), curvature, lengths)
    quick, _ = measure(path, radius)
    general = certified(path, radius)

    assert quick.abnormal == general.abnormal
    assert (quick.pmp_residual <= 1e-7) == (general.pmp_residual <= 1e-7)
    if general.pmp_residual <= 1e-7:
        assert quick.nu == pytest.approx(general.nu, rel=1e-4, abs=1e-7)
        assert quick.sign_margin == pytest.approx(general.sign_margin, abs=1e-7)
        assert abs(quick.hamiltonian - general.hamiltonian) <= 1e-7


STEP = 1e-5  # of central differences, whose error is its square


def route(seed: int, shortest: float, free: bool) -> Scenario:
    """A random route of two to six legs."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 7))
    lengths = rng.uniform(shortest, 4 * shortest, n)
    directions = rng.uniform(-4, 4, n)
    final = None if free else float(rng.uniform(-3, 3))
    start = (*rng.uniform(-5, 5, 2), rng.uniform(-3, 3))
    points = walked(lengths, directions)[1:] + start[:2]
    return Scenario(*start, *points[-1], via=points[:-1], final_heading=final)


def length(*leg: float) -> float:
    """Length of a leg.

    It is a function of x, y and both headings.
    """
    return pose_shortest(*leg, 1e-15)[0]


def slope(leg: tuple[float, ...], place: int) -> float:
    """Derivative of a leg's length.

    It is by one of the leg's four numbers.
    """
    more, less = list(leg), list(leg)
    more[place] += STEP
    less[place] -= STEP
    return (length(*more) - length(*less)) / (2 * STEP)


def legs_of(scenario: Scenario, headings) -> list[tuple[float, ...]]:
    steps = np.diff(scenario.points, axis=0)
    return [(*xy, a, b) for xy, a, b in zip(steps, headings, headings[1:], strict=False)]


@pytest.mark.parametrize("free", [True, False])
@pytest.mark.parametrize("seed", range(8))
def test_costates_are_derivatives_of_lengths(seed, free):
    """Costates are derivatives of lengths.

    nu3 is what a turned heading costs the leg before, or saves the leg after: by differences.
    """
    scenario = route(seed, 4.2, free)  # legs whose lengths are smooth
    found = shortest_route(scenario, 20.0)
    headings = found.path.at([0.0, *found.at, found.path.length])[:, 2]
    measured = route_extremal(found.path, found.at, 1.0, free)
    fitted = route_costates(list(route_legs(found.path, found.at, 1.0)), free)
    c, s = math.cos(scenario.heading), math.sin(scenario.heading)

    assert measured.pmp_residual < 1e-12
    assert (measured.transversality is None) is not free
    legs = legs_of(scenario, headings)
    for leg, (nu1, nu2, nu3) in zip(legs, fitted.tolist(), strict=True):
        expected = [-slope(leg, place) for place in (0, 1, 3)]
        np.testing.assert_allclose((nu1 * c - nu2 * s, nu1 * s + nu2 * c, nu3), expected, atol=1e-6)
    for leg, (_, _, nu3) in zip(legs[1:], fitted.tolist(), strict=False):
        assert slope(leg, 2) == pytest.approx(nu3, abs=1e-6)
    last = [-slope(legs[-1], place) for place in (0, 1)]
    np.testing.assert_allclose((measured.costate_x, measured.costate_y), last, atol=1e-6)


@pytest.mark.parametrize(
    "seed", [0, 1, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 10))]
)
def test_shortest_routes_of_short_legs_are_extremals(seed):
    """Shortest routes of short legs are extremals.

    Legs on a jump are among them, of two arcs or one: lengths tell their headings to a root.
    """
    scenario = route(seed, 0.7, seed % 2 == 0)
    found = shortest_route(scenario, 2.0)
    measured = route_extremal(found.path, found.at, 1.0, scenario.final_heading is None)

    assert measured.pmp_residual < 1e-7
    # cut into small pieces it is the same path
    parts = np.full(found.path.lengths.size, 7)
    cut = Path(
        found.path.start,
        np.repeat(found.path.curvatures, parts),
        np.repeat(found.path.lengths / parts, parts),
    )
    again = route_extremal(cut, found.at, 1.0, scenario.final_heading is None)
    assert again.pmp_residual < 1e-7


@pytest.mark.parametrize("off", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("seed", range(4))
def test_a_turned_heading_is_no_extremal(seed, off):
    """A turned heading is no extremal.

    The residual is as large as what turning one heading gains, but for a factor.
    """
    scenario = route(seed, 4.2, True)
    found = shortest_route(scenario, 20.0)
    headings = found.path.at([0.0, *found.at, found.path.length])[:, 2]
    headings[1] += off
    points = [Pose(x, y, a) for (x, y), a in zip(scenario.points, headings, strict=True)]
    legs = [pose_path(a, b, 1.0) for a, b in pairwise(points)]
    path = Path(
        scenario.start,
        np.concatenate([leg.curvatures for leg in legs]),
        np.concatenate([leg.lengths for leg in legs]),
    )
    before, after, *_ = legs_of(scenario, headings)
    jump = abs(slope(before, 3) + slope(after, 2))

    at = np.cumsum([leg.length for leg in legs])[:-1]
    measured = route_extremal(path, tuple(at), 1.0, True)

    assert 1e-3 * jump < measured.pmp_residual < jump
    judgement = judge(scenario, path)
    assert judgement.verdict is not Verdict.MISSES
    assert certify(scenario, path, judgement).proof is not Proof.EXTREMAL or off < 1e-5


def test_nu3_may_jump_at_a_point_on_the_turning_circle():
    """nu3 may jump at a point on the circle.

    It is the turning circle. An arc goes to the point, then right and straight: nu3 <= 0 before
    the point, and > 0 after it.

    The arc's end heading is forced, and what follows is the shortest path from there.
    """
    path = Path(Pose(0, 0, 0), [1, -1, 0], [math.pi / 2, 1.0, 3.0])
    scenario = Scenario(target_x=path.end.x, target_y=path.end.y, via=[(1, 1)])

    measured = route_extremal(path, (math.pi / 2,), 1.0, True)

    assert measured.pmp_residual < 1e-9
    judgement = judge(scenario, path, tolerances=Tolerances(search_s=1e-9))
    assert certify(scenario, path, judgement).proof in (Proof.EXTREMAL, Proof.PROVED)
    backwards = Path(Pose(0, 0, 0), [0, 1, -1], [3.0, 1.0, math.pi / 2])
    reversed_in_time = route_extremal(backwards, (4.0,), 1.0, False)
    assert reversed_in_time.pmp_residual < 1e-9
    free = route_extremal(backwards, (4.0,), 1.0, True)
    inside = route_extremal(path, (1.0,), 1.0, True)  # what follows the point is left, right, ahead
    for other in (free, inside):
        assert other.pmp_residual > 1e-2


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("word", POSE_BRANCHES[1:])
def test_costates_of_a_leg_with_a_final_heading(seed, word):
    """Costates of a leg with a final heading.

    (nu1, nu2) is what moving the end costs; the closed form is what the general code finds.
    """
    rng = np.random.default_rng(seed)
    end = Pose(*rng.uniform(-3, 3, 3))
    path = pose_path(Pose(0, 0, 1.0), end, 1.0, word)
    if path is None:
        pytest.skip("this word does not reach the end")
    measured, _ = measure(path, 1.0, free=False)
    general = certified(path, free=False)

    assert measured.transversality is None
    assert measured.hamiltonian < 1e-12
    assert general.nu == pytest.approx(measured.nu, rel=1e-8, abs=1e-8)
    assert general.sign_margin == pytest.approx(measured.sign_margin, abs=1e-9)
    moved = [
        pose_path(Pose(0, 0, 1.0), Pose(end.x + dx, end.y + dy, end.heading), 1.0, word)
        for dx, dy in ((STEP, 0), (-STEP, 0), (0, STEP), (0, -STEP))
    ]
    if all(moved):
        right, left, up, down = (other.length for other in moved)
        if max(right, left, up, down) - min(right, left, up, down) < 1:  # no jump between them
            expected = (left - right) / (2 * STEP), (down - up) / (2 * STEP)
            size = max(1.0, math.hypot(*expected))
            assert measured.nu == pytest.approx(expected, abs=1e-3 * size**3)


@pytest.mark.parametrize("radius", [1.0, 0.3])
def test_a_middle_arc_of_half_a_turn_is_abnormal(radius):
    """A middle arc of half a turn is abnormal.

    nu0 = 0, and the sign of (nu1, nu2) is that with which the arcs turn the right way.
    """
    lengths = radius * np.array([0.24, math.pi, math.pi / 2])
    path = Path(Pose(0, 0, 0), np.array([1, -1, 1]) / radius, lengths)
    found, _ = measure(path, radius, free=False)

    assert found.abnormal
    assert found.pmp_residual < 1e-12


def test_a_local_optimum_of_a_leg_is_an_extremal():
    """A leg's local optimum is an extremal.

    It is a word that is not the shortest, judged as an answer to the question for the best.
    """
    scenario = Scenario(heading="30deg", target_x=1, target_y=0.5, final_heading="90deg")
    end = Pose(1, 0.5, math.pi / 2)
    proofs = {}
    for word in POSE_BRANCHES[1:]:
        path = pose_path(scenario.start, end, 1.0, word)
        if path is not None:
            judgement = judge(scenario, path)
            proofs[word] = judgement.verdict, certify(scenario, path, judgement).proof

    assert (Verdict.OPTIMAL, Proof.PROVED) in proofs.values()
    assert proofs["LSL"] == (Verdict.LONGER, Proof.EXTREMAL)
    assert set(proofs.values()) <= {
        (Verdict.OPTIMAL, Proof.PROVED),
        (Verdict.LONGER, Proof.EXTREMAL),
        (Verdict.LONGER, Proof.NONE),
    }


@pytest.mark.parametrize(
    ("curvature", "length"),
    [([1, 0, 0.5], [1, 2, 1]), ([0, 1, 0], [1, 1, 1]), ([1, -1, 1, -1], [1, 4, 1, 1])],
)
def test_what_is_no_extremal_to_a_pose(curvature, length):
    found, _ = measure(Path(Pose(0, 0, 0), curvature, length), 1.0, free=False)

    assert found.pmp_residual > 1e-3

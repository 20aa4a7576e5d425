"""Costates of routes and of final headings, against differences of the lengths of legs."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from dubins_study.study.check.certificate import certify
from dubins_study.study.check.extremal import extremal, measure_pose, pieces
from dubins_study.study.check.route_extremal import route_costates, route_extremal, route_legs
from dubins_study.study.check.verdict import judge
from dubins_study.study.closed_form.pose import pose_path, pose_shortest
from dubins_study.study.path import Path
from dubins_study.study.route.shortest import shortest_route
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import POSE_BRANCHES, Proof, Verdict

STEP = 1e-5  # of central differences, whose error is its square


def route(seed: int, shortest: float, free: bool) -> Scenario:
    """A random route of two to six legs."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 7))
    lengths, directions = rng.uniform(shortest, 4 * shortest, n), rng.uniform(-4, 4, n)
    x, y = np.cumsum([lengths * np.cos(directions), lengths * np.sin(directions)], axis=1)
    final = None if free else float(rng.uniform(-3, 3))
    start = (*rng.uniform(-5, 5, 2), rng.uniform(-3, 3))
    via = np.column_stack([start[0] + x[:-1], start[1] + y[:-1]])
    return Scenario(*start, start[0] + x[-1], start[1] + y[-1], via=via, final_heading=final)


def length(*leg: float) -> float:
    """Of a leg in x, y and both headings."""
    return pose_shortest(*leg, 1e-15)[0]


def slope(leg: tuple[float, ...], place: int) -> float:
    """The derivative of a leg's length by one of its four numbers."""
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
    """nu3 is what a turned heading costs the leg before, or saves the leg after: by differences."""
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


@pytest.mark.parametrize("seed", range(10))
def test_shortest_routes_of_short_legs_are_extremals(seed):
    """Legs on a jump among them, of two arcs or one."""
    scenario = route(seed, 0.7, seed % 2 == 0)
    found = shortest_route(scenario, 2.0)
    measured = route_extremal(found.path, found.at, 1.0, scenario.final_heading is None)

    assert measured.pmp_residual < 1e-9
    # cut into small pieces it is the same path
    parts = np.full(found.path.lengths.size, 7)
    cut = Path(
        found.path.start,
        np.repeat(found.path.curvatures, parts),
        np.repeat(found.path.lengths / parts, parts),
    )
    again = route_extremal(cut, found.at, 1.0, scenario.final_heading is None)
    assert again.pmp_residual < 1e-9


@pytest.mark.parametrize("off", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("seed", range(4))
def test_a_turned_heading_is_no_extremal(seed, off):
    """The residual is as large as what turning one heading gains, but for a factor."""
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
    judged = judge(scenario, path)
    assert judged.verdict is not Verdict.MISSES
    assert certify(scenario, path, judged).proof is not Proof.EXTREMAL or off < 1e-5


def test_nu3_may_jump_at_a_point_on_the_turning_circle():
    """An arc to the point, then right and straight: nu3 <= 0 before the point, and > 0 after it.

    The arc's end heading is forced, and what follows is the shortest path from there.
    """
    path = Path(Pose(0, 0, 0), [1, -1, 0], [math.pi / 2, 1.0, 3.0])
    scenario = Scenario(target_x=path.end.x, target_y=path.end.y, via=[(1, 1)])

    measured = route_extremal(path, (math.pi / 2,), 1.0, True)

    assert measured.pmp_residual < 1e-9
    judged = judge(scenario, path, tolerances=Tolerances(search_s=1e-9))
    assert certify(scenario, path, judged).proof in (Proof.EXTREMAL, Proof.PROVED)
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
    """(nu1, nu2) is what moving the end costs; the closed form is what the general code finds."""
    rng = np.random.default_rng(seed)
    end = Pose(*rng.uniform(-3, 3, 3))
    path = pose_path(Pose(0, 0, 1.0), end, 1.0, word)
    if path is None:
        pytest.skip("this word does not reach the end")
    measured = measure_pose(path, 1.0)
    general = extremal(pieces(path, 1.0), free=False)

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
    """nu0 = 0, and the sign of (nu1, nu2) is that with which the arcs turn the right way."""
    lengths = radius * np.array([0.24, math.pi, math.pi / 2])
    found = measure_pose(Path(Pose(0, 0, 0), np.array([1, -1, 1]) / radius, lengths), radius)

    assert found.abnormal
    assert found.pmp_residual < 1e-12


def test_a_local_optimum_of_a_leg_is_an_extremal():
    """A word that is not the shortest, judged as an answer to the question for the best."""
    scenario = Scenario(heading="30deg", target_x=1, target_y=0.5, final_heading="90deg")
    end = Pose(1, 0.5, math.pi / 2)
    proofs = {}
    for word in POSE_BRANCHES[1:]:
        path = pose_path(scenario.start, end, 1.0, word)
        if path is not None:
            judged = judge(scenario, path)
            proofs[word] = judged.verdict, certify(scenario, path, judged).proof

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
    found = measure_pose(Path(Pose(0, 0, 0), curvature, length), 1.0)

    assert found.pmp_residual > 1e-3

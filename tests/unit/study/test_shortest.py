"""The closed form against four independent ways to find the same numbers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from brute_force import integrated
from cases import EDGES, PAPER, mirrored, rotated, scaled, scenarios
from flint import acb, ctx
from hard_cases import hard_frame
from hypothesis import assume, given
from hypothesis import strategies as st

from dubins_study.study import scenario as scenario_module
from dubins_study.study.body_coordinates import EPS, Local, local
from dubins_study.study.check.verdict import judge
from dubins_study.study.closed_form.shortest import (
    as_path,
    margin,
    shortest,
    shortest_local,
    shortest_path,
)
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import BRANCHES
from tests.adversary.oracle import bits, lengths


def unit(X: float, Y: float) -> Scenario:
    """Target (X, Y) in the vehicle's frame, R = 1."""
    return Scenario(0, 0, 0, X, Y, 1)


# ---- the oracle of 60 digits ----


@pytest.mark.parametrize("n", [600, pytest.param(20_000, marks=pytest.mark.slow)])
def test_every_branch_against_geometry_in_60_digits(n):
    """To 8 eps relative, a dozen roundings of which few add up, times the rate |grad V|.

    The rate is 1 / |cos(a2 / 2)| for words that end in an arc a2 (derivation.md, 9), else 1.
    Asked of the target as the closed form sees it, in the vehicle's frame. Targets within delta of
    a circle or of the axis are left to the tests below, since 60 digits see a side of it where the
    data do not.
    """
    for scenario in scenario_module.scenarios(hard_frame(n, seed=2)):
        target = local(scenario)
        if min(margin(scenario), abs(target.Y)) <= max(1e-12, target.delta):
            continue
        with ctx.workprec(bits(scenario)):
            expected = lengths(acb(target.X, target.Y))
            for branch in BRANCHES:
                found, exact = shortest_local(target, branch), expected[branch]
                assert (found is None) == (exact is None), (branch, target)
                if found is not None:
                    arcs = len(found.word) == 2 and "S" not in found.word
                    rate = 1 / abs(math.cos(found.segments.second / 2)) if arcs else 1.0
                    assert abs(found.total / exact - 1) < 8 * EPS * rate, (branch, target)


# ---- peer library: the fixed-heading problem, minimised over the heading ----


@pytest.mark.parametrize("target", [(3, 1), (-2, 0.5), (0.3, 1.2), (-0.5, -1.2), (0, 1), (-5, -4)])
def test_best_against_ompl_minimised_over_the_final_heading(target):
    """OMPL's shortest path to a pose, least over 100 001 headings: 1e-7 relative.

    The length is smooth about the best heading, so a grid of step h is off by about h^2 / 2 times
    the curvature of the length there: 2e-9 at h = 6e-5, times 10 to be safe, more where the best
    heading is next to a jump: never less than ours by more than OMPL's own 1e-6 of slack.
    """
    base = pytest.importorskip("ompl.base")
    space = base.DubinsStateSpace(1.0)
    start, end = space.allocState(), space.allocState()
    for state in (start, end):
        state.setX(0.0)
        state.setY(0.0)
        state.setYaw(0.0)
    end.setX(float(target[0]))
    end.setY(float(target[1]))

    def length(heading: float) -> float:
        end.setYaw(heading)
        return space.distance(start, end)

    headings = np.linspace(-math.pi, math.pi, 20_001)
    coarse = headings[np.argmin([length(float(h)) for h in headings])]
    fine = coarse + np.linspace(-1, 1, 20_001) * (headings[1] - headings[0])
    least = min(length(float(h)) for h in fine)

    assert least == pytest.approx(shortest(unit(*target)).total, rel=1e-7)


# ---- ODE integrator ----


@pytest.mark.parametrize("scenario", [*PAPER.values(), *EDGES.values()], ids=[*PAPER, *EDGES])
@pytest.mark.parametrize("branch", BRANCHES)
def test_paths_drive_to_the_target(scenario, branch):
    """x' = cos, y' = sin, heading' = u, integrated: meets the target to 1e-10.

    Errors of up to a hundred steps add up, in units of the size of the motion.
    """
    path = shortest_path(scenario, branch)
    if path is None:
        return
    end = integrated(path, scenario.radius)

    off = math.hypot(end[0] - scenario.target_x, end[1] - scenario.target_y)
    assert off < 1e-10 * (scenario.radius + path.total_length) + 1e-15 * scenario.extent


# ---- symmetries ----


@given(scenarios(), st.sampled_from(BRANCHES))
def test_the_mirror_image_has_the_mirrored_path(scenario, branch):
    """Exactly: no operation prefers a side, and y = |Y| is all that the closed form sees."""
    opposite = branch if branch == "best" else branch.translate(str.maketrans("LR", "RL"))
    found, image = shortest(scenario, branch), shortest(mirrored(scenario), opposite)

    assert (found is None) == (image is None)
    if found is not None:
        assert image.segments == found.segments
        tie = len(found.words) > 1
        assert tie or image.word == found.word.translate(str.maketrans("LR", "RL"))


@given(scenarios(), st.floats(-3, 3), st.floats(-4, 4))
def test_turning_and_scaling_the_plane_changes_nothing(scenario, angle, decades):
    """To 1e-13 plus what the rounding of turned coordinates leaves open (see test_kernel)."""
    assume(margin(scenario) > 1e-9)  # the length jumps across the circles
    factor = 10.0**decades
    moved = scaled(rotated(scenario, angle), factor)
    found, image = shortest(scenario), shortest(moved)
    assume(len(found.word) == 2)
    rate = 1 / abs(math.cos(found.segments.second / 2)) if found.word[1] != "S" else 1.0
    slack = 1e-13 * found.total + 4 * rate * (local(scenario).delta + local(moved).delta)

    assert image.word == found.word
    assert abs(image.total - found.total) <= slack


# ---- the discontinuity, and numbers known in advance ----


def test_the_length_jumps_across_the_front_of_a_circle():
    """At arc angle 0.3: 0.300 on the circle and just outside, 6.535 just inside."""
    x, y = math.sin(0.3), math.cos(0.3)
    on = shortest(unit(x, 1 - y))
    outside = shortest(unit(x * (1 + 1e-9), 1 - y * (1 + 1e-9)))
    inside = shortest(unit(x * (1 - 1e-9), 1 - y * (1 - 1e-9)))

    assert (on.word, outside.word, inside.word) == ("L", "LS", "RL")
    assert on.total == pytest.approx(0.3, abs=1e-15)
    assert outside.total == pytest.approx(0.300, abs=5e-4)
    assert inside.total == pytest.approx(6.535, abs=5e-4)  # printed to three digits


@given(st.floats(math.pi + 0.01, 2 * math.pi - 0.01))
def test_the_length_is_continuous_across_the_rear_of_a_circle(angle):
    """1e-9 either side: the gradient is at most 1 / |cos(a2 / 2)|, here below 100 for both."""
    lengths = [
        shortest(unit(r * math.sin(angle), 1 - r * math.cos(angle))).total
        for r in (1 - 1e-9, 1, 1 + 1e-9)
    ]

    assert max(lengths) - min(lengths) < 1e-4  # LS' arc itself goes like the root of the distance
    assert lengths[1] == pytest.approx(angle, abs=1e-14)


def test_centre_of_a_disc_and_straight_behind():
    """Lengths known to six digits; straight behind, the least is at D = 1 exactly."""
    centre = shortest(unit(0, 1))
    assert centre.total == pytest.approx(5.470430, abs=5e-7)
    assert centre.segments == pytest.approx((0.505361, 4.965069), abs=5e-7)
    behind = [shortest(unit(-D, 0)).total for D in (0.9, 1.0, 1.1)]
    assert behind[1] == pytest.approx(5.712389, abs=5e-7)
    assert behind[1] < min(behind[0], behind[2])
    assert shortest(unit(-1, 0)).words == ("LS", "RS")


@pytest.mark.parametrize(
    ("X", "Y"),
    [(0, 3e-16), (1e-16, -8e-16), (-1e-16, 2 + 4e-16), (-1e-16, 2 - 4e-16), (0, 2), (9e-16, 4e-16)],
)
def test_targets_that_rounding_hides_are_met(X, Y):
    """Beside a far origin these are the start or (0, 2); every branch's path still arrives."""
    for branch in BRANCHES:
        for target in (Local(X, Y, 4e-15), Local(X, -Y, 4e-15)):
            found = shortest_local(target, branch)
            if found is not None:
                path = as_path(unit(0, 0), found.word, found.segments)
                off = math.hypot(path.end.x - target.X, path.end.y - target.Y)
                # the root of a rounding of 4e-15 is 6e-8; the verdict allows 1e-6
                assert off < 2e-7, (branch, target)


def test_regions():
    names = [
        judge(unit(*t), None).region for t in ((5, 0), (0, 1), (0, -1), (1, 1), (0, 0), (0, -2))
    ]

    assert names == ["outside", "left disc", "right disc", "circle", "circle", "circle"]

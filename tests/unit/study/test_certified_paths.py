"""A certificate is of the path itself: no adversary that looks like a shortest path is proved."""

from __future__ import annotations

import math

import numpy as np
import pytest
from brute_force import shortest_by_search
from cases import scenario_frame
from hypothesis import assume, given
from hypothesis import strategies as st

from dubins_study.study.check.certificate import PMP_TOLERANCE, certify
from dubins_study.study.check.certificate_frame import certify_frame
from dubins_study.study.check.verdict import judge
from dubins_study.study.check.verdict_frame import judge_frame
from dubins_study.study.path import Path, Paths
from dubins_study.study.rows.schema import Certificate
from dubins_study.study.scenario import Pose, Scenario, check_frame
from dubins_study.study.tolerances import ARRIVES, Tolerances
from dubins_study.study.words import Claim, Proof, Verdict

START = Pose(0.0, 0.0, 0.0)


def at_its_end(curvature, length, branch="best") -> tuple[Certificate, Path]:
    """The certificate of a path of radius 1 for the question that its own end answers."""
    path = Path(START, curvature, length)
    scenario = Scenario(*START, path.end.x, path.end.y, 1)
    return certify(scenario, path, judge(scenario, path, Claim.OPTIMAL, branch), branch), path


def repeated(n, curvature, length, then):
    """Pieces driven n times over, and others after them."""
    return np.append(np.tile(curvature, n), then[0]), np.append(np.tile(length, n), then[1])


HALF_TURN = 3.14  # rad, just less than what a straight far away may follow
SMALL = 9e-7  # rad or radii: less than a merging passes over
ADVERSARIES = {
    "99 straights of a radius each": repeated(
        99, [1, 0], [HALF_TURN / 99, 0.99], ([0.0], [1e6])
    ),
    "straights too small to matter": repeated(
        3000, [1, 0], [HALF_TURN / 3000, SMALL], ([0.0], [1e5])
    ),
    "arcs too small to matter": repeated(20_000, [1, 0], [SMALL, 1.0], ([0.0], [1.0])),
    "arcs too small to matter, to both sides": repeated(
        20_000, [1, 0, -1, 0], [SMALL, 50.0, SMALL, 1.0], ([0.0], [1.0])
    ),
    "one arc too small to matter": ([0, 1, 0], [1e6, SMALL, 1e6]),
    "rates that are nearly straight": ([1, 9e-10], [1.0, 1e6]),
    "a slow ramp of rates": (np.arange(20_000) * 5e-10, np.full(20_000, 0.1)),
    "a long way at a rate that is nearly straight": ([9e-10], [1e6]),
    "a way there and back": (
        np.array([*[0, 1] * 270, 1, *[0, 1] * 270, 0]),
        np.array([*[SMALL, 1e-12] * 270, HALF_TURN, *[SMALL, 1e-12] * 270, 2]),
    ),
}  # fmt: skip


@pytest.mark.parametrize("branch", ["best", "LS"])
@pytest.mark.parametrize("name", ADVERSARIES)
def test_no_adversary_is_proved(name, branch):
    """Small things add up; what is driven counts, not what it looks like."""
    curvature, length = map(np.asarray, ADVERSARIES[name])
    if branch == "LS" and curvature.min() < 0:
        pytest.skip("turns to both sides")
    found, _ = at_its_end(curvature, length, branch)

    assert found.proof is Proof.NONE
    assert found.cut_margin is None
    assert found.pmp_residual > PMP_TOLERANCE


@pytest.mark.slow
@pytest.mark.parametrize(
    ("curvature", "length"),
    [
        repeated(50_000, [1, -1, 0], [SMALL, SMALL, 2e-6], ([0.0], [1e3])),
        ([1 - 9e-10, 0], [3.0, 1e6]),
    ],
)
def test_what_is_as_short_as_the_shortest_may_be_an_extremal(curvature, length):
    """But it has no cut margin: a ripple, and a rate that is not full over a long way."""
    found, path = at_its_end(curvature, length)

    assert found.proof is Proof.EXTREMAL
    assert found.cut_margin is None
    assert path.total_length == pytest.approx(found.reference_low, rel=1e-12)


def test_a_merged_path_may_be_off_by_the_miss_that_is_allowed():
    assert Tolerances().miss == ARRIVES


def test_a_straight_that_bends_is_no_straight():
    """nu3 vanishes at both its ends and not between, where an integrator sees it."""
    found, _ = at_its_end([1.0, 1e-5], [1.0, 6.0], "LS")

    # the costates point along the chord: a bulge of rate length^2 / 8, of a path of 7 radii
    assert found.pmp_residual == pytest.approx(1e-5 * 36 / 8 / 7, rel=0.3)
    assert found.proof is Proof.NONE


SIZES = st.floats(-9, -1).map(lambda exponent: 10.0**exponent)
DETOURS = st.tuples(st.sampled_from([-1.0, 0.0, 1.0, 0.5]), SIZES)


@given(
    st.sampled_from([1.0, -1.0]),
    st.floats(0.05, 6.2),
    st.one_of(st.floats(0.05, 20), st.sampled_from([1e3, 1e5])),
    st.booleans(),
    st.lists(DETOURS, max_size=4),
    st.integers(1, 60),
    st.floats(-13, -1).map(lambda exponent: 10.0**exponent),
)
def test_what_is_proved_is_shortest_by_brute_force(side, first, second, turns, detours, n, off):
    """A shortest path, or one that detours lengthen: proved only if no path found is shorter.

    The word is cut into n parts with the detours between them, its rates are off, and its end is
    the target. A proved path may be longer by what merging passes over, which the length's
    steepness (derivation.md, section 9) multiplies.
    """
    last = -side if turns else 0.0
    second = second % 6.2 + 0.05 if turns else second
    extra_rates, extra = [u for u, _ in detours], [length for _, length in detours]
    word = [side * (1 - off), *extra_rates], [first / n, *extra]
    curvature, length = repeated(n, *word, ([last], [second]))
    found, path = at_its_end(curvature, length)
    end = path.end
    if found.proof is Proof.PROVED:
        steep = 1 / abs(math.cos(second / 2)) if turns else 1.0
        assume(steep < 100)
        passed_over = 2 * (1 + steep) * (ARRIVES + 1e-14 * path.total_length)
        assert path.total_length <= shortest_by_search(end.x, end.y) + passed_over
    elif not detours and off < 1e-12:
        # an honest path is shortest only if it is proved
        assume(abs(second - math.pi) > 1e-3 or not turns)
        assert path.total_length > shortest_by_search(end.x, end.y) * (1 + 1e-12)


def test_a_path_that_cannot_be_driven_has_no_certificate():
    """Found by an adversary: a length of -4.59 had a cut margin of 5.4, a NaN piece a residual."""
    curvature = np.array([[1, 1, 1, np.nan, 1, np.inf, 1, 0], [0, 0, 0, 0, np.nan, 0, 0, 0.0]])
    length = np.array([[1, -4.59, np.nan, 1, 1, 1, np.inf, 1e308], [2, 2, 2, 2, 1e-9, 2, 2, 1e308]])
    frame = check_frame(scenario_frame([Scenario(*START, 3, 1, 1)] * 8))
    paths = Paths(curvature, length)
    found = certify_frame(frame, paths, judge_frame(frame, paths))

    assert np.isfinite(found.measured[:, 0]).all()
    assert np.isnan(found.measured[:, 1:]).all()


def test_a_path_that_nothing_but_its_size_makes_extremal_has_no_costates():
    """The condition on nu3, divided by a length of 1e299, is the least violated: no costate."""
    scenario = Scenario(0, 0, 0.3, 5, 1, 1000)
    path = Path(scenario.start, [0.001, -0.001, 2.73e-251], [2.8e-22, 1.6e70, 2.39e298])
    found = certify(scenario, path, judge(scenario, path))

    assert judge(scenario, path).verdict is Verdict.MISSES
    assert found.pmp_residual is None

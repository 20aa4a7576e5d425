"""Proofs of paths: proved, bounded, extremal, or lies.

A certificate is of the path itself: no adversary that looks like a shortest path is proved.
"""

import math

import numpy as np
import pytest

from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.judging.certify import PMP_TOLERANCE, certify
from dubins_study.study.judging.judge import judge
from dubins_study.study.path import Path, Paths
from dubins_study.study.rows.schema import Certificate
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import BRANCHES, Claim, Proof, Verdict
from tests.cases import EDGES, PAPER

ALL = PAPER | EDGES
PROBLEM = PAPER["problem 1"]


def certified(scenario, path, branch="best", claim=Claim.LOCAL, **said):
    return certify(scenario, path, judge(scenario, path, claim, branch), branch, **said)


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize("branch", BRANCHES)
def test_the_closed_form_is_proved_everywhere(name, branch):
    """The closed form is proved everywhere.

    It is also proved that there is no path, where there is none.
    """
    path = shortest_path(ALL[name], branch)
    certificate = certified(
        ALL[name], path, branch, Claim.INFEASIBLE if path is None else Claim.OPTIMAL
    )

    assert certificate.proof is Proof.PROVED
    assert (certificate.reference_high is None) == (path is None)


@pytest.mark.parametrize("problem", PAPER)
def test_the_papers_feasible_row_is_an_extremal_and_no_more(problem):
    """The paper's feasible row is only an extremal.

    LS where RS is best satisfies every condition, and the cut rejects it (derivation.md, 9).
    """
    scenario = PAPER[problem]
    both = [shortest_path(scenario, word) for word in ("LS", "RS")]
    longer = max(both, key=lambda path: path.length)
    certificate = certified(scenario, longer)

    assert certificate.proof is Proof.EXTREMAL
    assert certificate.pmp_residual < 1e-9
    assert certificate.cut_margin < 0
    assert certificate.reference_high < longer.length


def test_a_short_path_that_is_no_extremal_is_not_proved():
    """A short path that is no extremal is unproved.

    Forty steps average to the shortest path's turn: optimal to four digits, unproved.
    """
    path = shortest_path(PROBLEM)
    wobble = 1 + 1e-3 * np.sin(np.arange(40))
    arc, straight = path.lengths
    curvature = np.concatenate((np.full(40, path.curvatures[0]), [0.0]))
    lengths = np.concatenate((arc / 40 * wobble / wobble.mean(), [straight]))
    same = Path(PROBLEM.start, curvature * np.append(1 / wobble, 1), lengths * np.append(wobble, 1))
    judgement = judge(
        PROBLEM, same, Claim.LOCAL, tolerances=Tolerances(miss=1, curvature=1, gap=1e-2)
    )

    assert judgement.verdict is Verdict.OPTIMAL
    assert certify(PROBLEM, same, judgement, tolerances=Tolerances(gap=1e-2)).proof is Proof.NONE


def test_a_bound_proves_what_no_condition_does():
    """A bound proves what no condition does.

    It is a global solver's own bound, if it is within the tolerance; it names no extremal.
    """
    exact = shortest_path(PROBLEM)
    arc, straight = exact.lengths
    # an arc of 1e-5 the other way makes it no extremal, and no longer to speak of
    path = Path(PROBLEM.start, [*exact.curvatures[:1], 1.0, 0.0], [arc + 1e-5, 1e-5, straight])
    length = path.length
    judgement = judge(PROBLEM, path, Claim.OPTIMAL, tolerances=Tolerances(miss=1e-3))

    assert judgement.verdict is Verdict.OPTIMAL
    assert certify(PROBLEM, path, judgement).proof is not Proof.PROVED
    bounded = certify(PROBLEM, path, judgement, lower_bound=exact.length * (1 - 1e-7))
    assert bounded.proof is Proof.BOUNDED
    for bound in (length - 0.1, length + 0.1, math.inf):
        loose = certify(PROBLEM, path, judgement, lower_bound=bound)
        assert loose.proof is not Proof.BOUNDED


def test_an_answer_that_owes_its_length_to_its_miss_is_not_proved():
    """A length that a miss explains is not proved.

    Inside a circle's front by 1e-8 the arc beside it arrives and proves nothing.
    """
    r = 1 - 1e-8
    scenario = Scenario(0, 0, 0, r * math.sin(0.3), 1 - r * math.cos(0.3), 1)
    arc = Path(scenario.start, [1.0], [0.3])
    judgement = judge(scenario, arc, Claim.LOCAL)

    assert judgement.verdict is Verdict.OPTIMAL
    assert judgement.length < 0.31
    assert certify(scenario, arc, judgement).proof is Proof.EXTREMAL
    assert certify(scenario, arc, judgement).reference_low > 6
    assert not certify(scenario, arc, judgement, lower_bound=6.5).false_bound


@pytest.mark.parametrize("bound", [0.4, 1e9, math.inf])
def test_a_bound_above_the_answers_own_length_is_false(bound):
    """A bound above the answer's own length is false.

    On a circle, where the data leave open whether LS exists, the arc that arrives shows it.
    """
    scenario = Scenario(0, 0, 0, math.sin(0.3), 1 - math.cos(0.3), 1)
    arc = Path(scenario.start, [1.0], [0.3])

    assert certified(scenario, arc, "LS", lower_bound=bound).false_bound
    assert not certified(scenario, arc, "LS", lower_bound=0.3).false_bound
    assert not certified(scenario, None, "LS", lower_bound=math.inf).false_bound


@pytest.mark.parametrize("path", [None, Path(Pose(0, 0, 0), [math.nan], [1.0])])
def test_nothing_is_said_of_no_path(path):
    """Nothing is said of no path.

    Nor does it prove that there is none, where one exists.
    """
    certificate = certified(PROBLEM, path)

    assert certificate.proof is Proof.NONE
    assert certificate.pmp_residual is None
    assert certificate.reference_low == pytest.approx(certificate.reference_high)
    assert certified(PROBLEM, path, "LS", Claim.INFEASIBLE).proof is Proof.NONE


@pytest.mark.parametrize("branch", ["best", "LS", "RS"])
def test_multipliers_are_compared_with_the_costates(branch):
    """Multipliers are compared with the costates.

    Those of (4.12) are -(nu1, nu2)/nu0 (derivation.md, 9); a sign error is 2, a turn shows.
    """
    path = shortest_path(PROBLEM, branch)
    heading = path.end.heading
    right = (math.cos(heading), math.sin(heading))

    assert certified(PROBLEM, path, branch, multipliers=right).costate_error < 1e-9
    wrong = (-right[0], -right[1])
    assert certified(PROBLEM, path, branch, multipliers=wrong).costate_error == pytest.approx(2)
    assert certified(PROBLEM, path, branch, multipliers=(math.nan, 0.0)).costate_error is None


START = Pose(0.0, 0.0, 0.0)


def at_its_end(curvature, length, branch="best") -> tuple[Certificate, Path]:
    """Certificate of a path for its own end.

    The path has radius 1; its own end is the question.
    """
    path = Path(START, curvature, length)
    scenario = Scenario(*START, path.end.x, path.end.y, 1)
    return certified(scenario, path, branch, Claim.OPTIMAL), path


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


@pytest.mark.many(3)
@pytest.mark.parametrize("branch", ["best", "LS"])
@pytest.mark.parametrize("name", ADVERSARIES)
def test_no_adversary_is_proved(name, branch):
    """No adversary is proved.

    Small things add up; what is driven counts, not what it looks like.
    """
    curvature, length = map(np.asarray, ADVERSARIES[name])
    if branch == "LS" and curvature.min() < 0:
        pytest.skip("turns to both sides")
    found, _ = at_its_end(curvature, length, branch)

    assert found.proof is Proof.NONE
    assert found.cut_margin is None
    assert found.pmp_residual > PMP_TOLERANCE


def test_a_straight_that_bends_is_no_straight():
    """A straight that bends is no straight.

    nu3 vanishes at both its ends and not between, where an integrator sees it.
    """
    found, _ = at_its_end([1.0, 1e-5], [1.0, 6.0], "LS")

    # the costates point along the chord: a bulge of rate length^2 / 8, of a path of 7 radii
    assert found.pmp_residual == pytest.approx(1e-5 * 36 / 8 / 7, rel=0.3)
    assert found.proof is Proof.NONE


def test_a_path_that_cannot_be_driven_has_no_certificate():
    """An impossible path has no certificate.

    An adversary found it: a length of -4.59 had a cut margin of 5.4, a NaN piece a residual.
    """
    curvature = np.array([[1, 1, 1, np.nan, 1, np.inf, 1, 0], [0, 0, 0, 0, np.nan, 0, 0, 0.0]])
    length = np.array([[1, -4.59, np.nan, 1, 1, 1, np.inf, 1e308], [2, 2, 2, 2, 1e-9, 2, 2, 1e308]])
    scenario = Scenario(*START, 3, 1, 1)
    paths = Paths(curvature, length)
    certificates = [certified(scenario, paths.path(row, scenario)) for row in range(8)]

    assert certificates[0].pmp_residual is not None
    assert all(each.pmp_residual is None and each.cut_margin is None for each in certificates[1:])


def test_a_path_that_nothing_but_its_size_makes_extremal_has_no_costates():
    """A huge path that only looks extremal is none.

    It has no costates. The condition on nu3, divided by a length of 1e299, is the least violated:
    no costate.
    """
    scenario = Scenario(0, 0, 0.3, 5, 1, 1000)
    path = Path(scenario.start, [0.001, -0.001, 2.73e-251], [2.8e-22, 1.6e70, 2.39e298])
    certificate = certify(scenario, path, judge(scenario, path))

    assert judge(scenario, path).verdict is Verdict.MISSES
    assert certificate.pmp_residual is None

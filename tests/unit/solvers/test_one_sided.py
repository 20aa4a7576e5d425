"""What turning to one side proves of the words LS and RS: nothing."""

import math

import pytest

from dubins_study import Path, Scenario, solve
from dubins_study.study.words import Claim, Proof, Verdict

# inside the circle of the first turn, which no path of the word enters
INSIDE = [(0.0, 1.0), (0.3, 0.6), (-0.5, 1.2)]


def one_sided(X, Y):
    """Straight on, and then less than a full turn to the left: arrives at a target in the disc."""
    ahead = X + math.sqrt(1 - (Y - 1) ** 2)
    return Path((0.0, 0.0, 0.0), [0.0, 1.0], [ahead, math.atan2(X - ahead, 1 - Y) % (2 * math.pi)])


@pytest.mark.parametrize(("X", "Y"), INSIDE)
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("name", ["turn-rates", "collocation", "multiple-shooting", "turn-rate-qp"])
def test_no_claim_about_the_word(name, side, X, Y):
    """With rates on one side a path exists, so whoever calls that infeasible has failed.

    The word has none: `none exists` would be right by accident, and proved by nobody.
    """
    there = one_sided(X, Y)
    assert (there.end.x, there.end.y) == pytest.approx((X, Y), abs=1e-12)
    assert there.lengths[0] > 0
    answer = solve(Scenario(0, 0, 0, X, side * Y, 1), name, "LS" if side > 0 else "RS")

    assert answer.claim not in (Claim.INFEASIBLE, Claim.OPTIMAL, Claim.LOCAL)
    assert answer.verdict is not Verdict.NONE_EXISTS
    assert answer.proof is Proof.NONE
    assert not answer.false_claim


def test_the_word_itself_is_denied_by_who_poses_it():
    """One NLP a word has the word's own problem: its engine's claim is about the word."""
    answer = solve(Scenario(0, 0, 0, 0.3, 0.6, 1), "ipopt", "LS")
    assert (answer.claim, answer.verdict) == (Claim.INFEASIBLE, Verdict.NONE_EXISTS)

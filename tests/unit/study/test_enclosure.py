"""Proven intervals against high precision, brute force and the closed form."""

from __future__ import annotations

import math

import pytest
from brute_force import shortest_by_search
from cases import PAPER, placed
from flint import acb, ctx
from hard_cases import hard_frame
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.study.body_coordinates import local
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.verdict import judge
from dubins_study.study.closed_form.shortest import margin, shortest
from dubins_study.study.scenario import Scenario, scenarios
from dubins_study.study.words import BRANCHES
from tests.adversary import oracle


@pytest.mark.parametrize("branch", BRANCHES)
def test_every_interval_of_the_hard_frame_is_narrow_and_right(branch):
    """Circles, edges, discs, far and near: every part holds its lengths, and little else.

    The closed form is off by a few roundings of its own. Where a path ends straight its length
    follows the target at the rate 1, so that a part is about 2 sqrt(2) delta wide; of two arcs at
    the rate 1 / sqrt(q / 8) at most, which delta itself bounds: like the root of delta.
    """
    for scenario in scenarios(hard_frame(1500, seed=5)):
        interval, optimum = enclose(scenario, branch), shortest(scenario, branch)
        R, delta = scenario.radius, local(scenario).delta
        assert interval.parts or interval.absent
        if optimum is None:
            assert interval.absent, scenario
            continue
        length = optimum.total * R
        ulp = math.ulp(max(length, R))
        assert interval.holds(length, 8 * ulp), scenario
        outside = "S" in optimum.word and margin(scenario) > 10 * delta
        straight = branch in ("LS", "RS") or outside
        allowed = 10 * delta if straight else 20 * math.sqrt(delta)
        for low, high in interval.parts:
            assert high - low <= allowed * R + 8 * ulp, scenario


@pytest.mark.parametrize("branch", BRANCHES)
def test_one_part_away_from_the_edges(branch):
    """A second part, or a path that may be absent, needs an edge within a few delta."""
    for scenario in scenarios(hard_frame(1500, seed=6)):
        interval, (X, Y, delta) = enclose(scenario, branch), local(scenario)
        y = abs(Y)
        to_edges = [abs(math.hypot(X, y + c) - r) for c, r in ((-1, 1), (1, 1), (1, 3), (-1, 3))]
        if min(*to_edges, y) > 10 * delta:
            assert len(interval.parts) == (not interval.absent), scenario


_PLACES = [(0.3, 0.9), (-0.4, 1.2), (0.5, -0.7), (-0.2, -1.5)]
INSIDE = [placed(X, Y, 0.5, -0.25, 0.7, 2) for X, Y in _PLACES]


@pytest.mark.parametrize("scenario", [*PAPER.values(), *INSIDE])
def test_intervals_hold_sixty_digits(scenario):
    """The oracle's shortest length, which a search along all words finds too; a few delta wide."""
    found = enclose(scenario)
    with ctx.workprec(oracle.bits(scenario)):
        X, Y = oracle.local(scenario)
        exact = oracle.lengths(acb(X, Y), driven=True)["best"]
        assert found.low <= exact * scenario.radius <= found.high
        searched = shortest_by_search(float(X), float(Y))

    assert searched == pytest.approx(float(exact), rel=1e-12)
    width = 10 * local(scenario).delta * scenario.radius
    assert found.high - found.low <= width + 8 * math.ulp(found.high)


@given(
    st.floats(-6, 6),
    st.floats(-6, 6),
    st.floats(-7, 7),
    st.floats(0.01, 100),
    st.sampled_from("LR"),
)
def test_words_enclose_their_mirror_images(X, Y, heading, radius, first):
    """The mirrored scenario's mirrored word has the same interval."""
    scenario = Scenario(0, 0, heading, X * radius, Y * radius, radius)
    mirrored = Scenario(0, 0, -heading, X * radius, -Y * radius, radius)
    other = {"L": "R", "R": "L"}[first]

    assert enclose(scenario, first + "S") == enclose(mirrored, other + "S")
    assert enclose(scenario, first + other) == enclose(mirrored, other + first)


def test_the_jump_across_a_circle_is_not_blurred():
    """On the circle the arc, and a full turn more of the targets just inside; not what is between.

    A millionth inside the circle, the full turn alone.
    """
    on = Scenario(0, 0, 0, math.sin(0.3), 1 - math.cos(0.3), 1)
    inside = Scenario(0, 0, 0, (1 - 1e-6) * math.sin(0.3), 1 - (1 - 1e-6) * math.cos(0.3), 1)

    assert judge(on, None).region == "circle"
    assert [round(low, 3) for low, _ in enclose(on).parts] == [0.3, 6.535]
    assert all(high - low < 1e-13 for low, high in enclose(on).parts)
    assert enclose(inside).low > 6.5


def test_just_behind_the_start_a_turn_of_nothing_is_none():
    """Found in review: the arc there is a full turn less 2e-7, which no path of 6e-7 replaces."""
    scenario = Scenario(0, 0, 0, -2e-7, 2e-14, 1)
    for branch in ("best", "RL"):
        found = enclose(scenario, branch)
        assert found.low <= 2 * math.pi - 2e-7 <= found.high + 1e-13
        assert found.low > 6.28

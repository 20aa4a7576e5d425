"""Targets on and beside the edges: one meaning for the closed form, the frame and the check."""

from __future__ import annotations

import math

import numpy as np
import pytest
from cases import placed, scenario_frame
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.experiments.solve import solve
from dubins_study.solvers.frame import solve_frame
from dubins_study.study.body_coordinates import local
from dubins_study.study.check.certificate import certify
from dubins_study.study.check.enclosure import enclose
from dubins_study.study.check.verdict import judge
from dubins_study.study.closed_form.shortest import Segments, as_path, shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import BRANCHES, Claim

# found by an adversarial campaign; each was judged wrongly by one part of the check or another
FOUND = {
    "top, far from the origin": (
        Scenario(1e4, 2e4, 1.0, 9998.317058030385, 20001.080604611736, 1),
        "RL",
    ),
    "top, heading down": (
        Scenario(0, 0, -1.5707963267948966, 1.9999999999999996, 1.2246467991473532e-16, 1),
        "RL",
    ),
    "top, ahead by a hair": (
        Scenario(0, 0, 0, 2.877115121030117e-06, 45.60778211196118, 22.80389105598058),
        "RL",
    ),
    "inside by a hair": (
        Scenario(
            *(292933.162296969, -183188.23419347886, -3.2378215871170593),
            *(292932.8581381104, -183188.7936594308, 0.3459425262285938),
        ),
        "best",
    ),
    "tiny radius far away": (
        Scenario(
            *(-16935347.04161746, 32948693.033956386, 0),
            *(-16935347.0432896, 32948693.031933352, 0.0017030445404372149),
        ),
        "best",
    ),
    "beside (0, 4)": (Scenario(0, 0, 0, 5e-324, 4, 1), "LR"),
    "beside (0, -4)": (Scenario(0, 0, 0, 5e-324, -4, 1), "RL"),
    "next to the start": (Scenario(0, 0, 0, 1e-9, 1e-12, 1), "RL"),
    "just behind the start": (Scenario(0, 0, 0, -1e-12, 1e-25, 1), "LR"),
}


@pytest.mark.parametrize("name", FOUND)
@pytest.mark.parametrize("solver", ["analytic", "shooting", "slsqp"])
def test_right_answers_are_right(name, solver):
    """Whichever target within delta a solver answers for, its length is right.

    The closed form's is proved, too. Next to the start other solvers answer for a target farther
    off than delta, as their tolerances allow, which is right but proves nothing.
    """
    scenario, branch = FOUND[name]
    answer = solve(scenario, solver, branch)

    assert not answer.false_claim
    assert not answer.false_bound
    if answer.path is None:
        assert (answer.claim, answer.verdict) == ("infeasible", "none exists")
    else:
        assert answer.verdict == "optimal"
        assert answer.proof == "proved" or (solver != "analytic" and "start" in name)


@pytest.mark.parametrize("name", FOUND)
def test_the_frame_finds_what_the_scalar_finds(name):
    scenario, branch = FOUND[name]
    answer = solve(scenario, branch=branch)
    row = solve_frame(scenario_frame([scenario]), branch=branch, certified=True).iloc[0]

    for column in ("verdict", "claim", "proof", "region", "false_claim", "false_bound"):
        assert row[column] == getattr(answer, column), column
    length = np.nan if answer.length is None else answer.length
    np.testing.assert_allclose(row.length, length, rtol=1e-15)
    if answer.reference_low is None:
        assert np.isnan([row.reference_low, row.reference_high]).all()
        return
    assert row.reference_low <= answer.reference_low
    assert answer.reference_high <= row.reference_high


def test_the_exact_length_of_the_doubles_lies_in_the_interval():
    """Shortest lengths to fourteen digits, from arithmetic in sixty."""
    for name, exact in (("top, heading down", 3.1415927022568), ("inside by a hair", 1.5453843965)):
        answer = solve(*[FOUND[name][0]], branch=FOUND[name][1])
        assert answer.reference_low <= exact <= answer.reference_high


def test_a_full_turn_to_a_target_that_is_the_start_exactly_is_longer():
    scenario = Scenario(0, 0, 0.4, 0, 0, 1)
    for branch in ("best", "LS", "RL"):
        assert enclose(scenario, branch)[:3] == (0.0, math.ulp(0.0), False)
        turn = judge(scenario, as_path(scenario, "L", Segments(2 * math.pi, 0.0)), branch=branch)
        assert turn.verdict in ("longer", "misses")


def test_the_path_ends_within_delta_of_the_target_where_two_edges_meet():
    """Just behind the start, which is beside the axis and a circle."""
    scenario = Scenario(
        *(-631863061.6509018, -1270932786.5693164, -1.0650437884893282),
        *(-631863061.6682206, -1270932786.5380447, 565.3008639090407),
    )
    X, Y, delta = local(scenario)
    best = shortest(scenario)
    end = as_path(Scenario(0, 0, 0, 0, 0, 1), best.word, best.segments).end

    assert max(abs(end.x - X), abs(end.y - Y)) <= delta + 1e-15


@pytest.mark.parametrize("box", [1.0, 1e5])
@pytest.mark.parametrize("branch", BRANCHES)
@pytest.mark.parametrize("target", [(0, 2), (0, -2), (0, 4), (math.sin(0.3), 1 - math.cos(0.3))])
def test_targets_that_a_user_computed_to_lie_on_an_edge(box, branch, target):
    """No false claim and no false bound, whatever rounding made of them; circles are circles."""
    starts = np.random.default_rng(1).uniform(
        (-box, -box, -math.pi, 0.5), (box, box, math.pi, 2), (100, 4)
    )
    frame = scenario_frame(placed(*target, *start) for start in starts)
    rows = solve_frame(frame, branch=branch, certified=True)

    assert not rows.false_claim.any()
    assert not rows.false_bound.any()
    assert set(rows.verdict) <= {"optimal", "none exists"}
    if target != (0, 4):
        assert set(rows.region) == {"circle"}


@given(
    st.floats(0.3, 2.9),
    st.floats(-1e5, 1e5),
    st.floats(-math.pi, math.pi),
    st.floats(-1.0, 1.0),
)
def test_on_a_front_half_both_lengths_are_right_and_none_between(angle, offset, heading, off):
    """Beside the circle by up to delta / 2 the arc and the path from inside are both right."""

    def seen(r: float) -> Scenario:
        """A target seen from C_L under an arc angle, at a distance r."""
        return placed(r * math.sin(angle), 1 - r * math.cos(angle), offset, -offset, heading)

    scenario = seen(1 + off * 0.4 * local(seen(1.0)).delta)
    inside = shortest(seen(1 - 10 * local(scenario).delta))
    arc = as_path(scenario, "L", Segments(angle, 0.0))
    around = as_path(scenario, inside.word, inside.segments)

    for path in (arc, around):
        judged = judge(scenario, path, Claim.OPTIMAL)
        assert judged.verdict == "optimal", path
        assert certify(scenario, path, judged).proof == "proved"
    assert around.length - arc.length > 0.1
    longer = as_path(scenario, "L", Segments(angle + 2 * math.pi, 0.0))
    assert judge(scenario, longer, Claim.OPTIMAL).false_claim


def test_what_lies_between_two_parts_is_compared_with_the_lower():
    interval = enclose(Scenario(0, 0, 0, math.sin(0.3), 1 - math.cos(0.3), 1))
    (_, arc), (around, _) = interval.parts

    assert interval.nearest(1.0) == arc
    assert interval.nearest(around + 1e-16) >= around
    assert interval.nearest(0.1) == interval.low
    assert not interval.holds(1.0, 0.5)

"""The check of tours, beside dense samples.

It is tested with headings at stops, free starts and closed paths.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from dubins_study import solve
from dubins_study.study.check.visits import visits
from dubins_study.study.closed_form.pose import pose_path
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge, miss_reason
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario, Stop
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import Claim, Proof, Verdict
from tests.brute_force import integrated

SAMPLES = 40_001
SOON = Tolerances(search_s=0.1)


def random_path(rng):
    """A path of up to eight arcs and straights.

    Some arcs are of more than a turn.
    """
    n = int(rng.integers(1, 9))
    return Path(
        Pose(*rng.uniform(-2, 2, 2), rng.uniform(-4, 4)),
        rng.choice([-1.0, 0.0, 1.0, rng.uniform(-1, 1)], n),
        rng.uniform(0.0, 7.0, n),
    )


@pytest.mark.parametrize("seed", range(60))
def test_each_point_is_visited_first_in_any_order(seed):
    """Each point is visited first, in any order.

    The points lie on a path, half of them with the heading there; no sample before is a visit.
    """
    rng = np.random.default_rng((34, seed))
    path = random_path(rng)
    placed = rng.uniform(0.0, path.length, 6)
    stops = [
        Stop(x, y, heading if rng.random() < 0.5 else None)
        for x, y, heading in path.at(placed).tolist()
    ]

    seen = visits(path, stops, 1.0, 1e-6, any_order=True)

    assert seen.miss < 1e-12
    assert seen.turned < 1e-6
    assert sorted(seen.order) == list(range(6))
    assert list(seen.at) == sorted(seen.at)
    samples = path.sample(SAMPLES)
    step = path.length / (SAMPLES - 1)
    for place, at in zip(seen.order, seen.at, strict=True):
        stop = stops[place]
        assert at <= placed[place] + 1e-6
        before = samples[: max(0, int((at - 1e-3) / step))]
        near = np.hypot(before[:, 0] - stop.x, before[:, 1] - stop.y) < step
        if stop.heading is not None:
            turned = before[:, 2] - stop.heading
            near &= np.abs(np.remainder(turned + math.pi, 2 * math.pi) - math.pi) < 2 * step
        for k in np.flatnonzero(near):  # a sample that is near is no visit: look closer
            along = np.linspace((k - 1) * step, (k + 1) * step, 2001)
            closest = path.at(np.clip(along, 0.0, path.length))
            assert np.hypot(closest[:, 0] - stop.x, closest[:, 1] - stop.y).min() > 1e-6


# straight on for 8, round to the left, and back to x = 0 above: (4, 0) and (4, 2) are on it
U_TURN = Path(Pose(0, 0, 0), [0.0, 1.0, 0.0], [8.0, math.pi, 8.0])
THROUGH = Scenario(target_x=0, target_y=2, via=[(4, 2), (9, 1), (4, 0)], order="free")


def test_the_order_is_read_from_the_path():
    """The order is read from the path.

    The order of the points in the scenario does not matter; the route in their order is missed.
    """
    np.testing.assert_allclose(integrated(U_TURN)[:2], (0, 2), atol=1e-9)
    judgement = judge(THROUGH, U_TURN)

    assert judgement.verdict is Verdict.OPTIMAL
    assert judgement.visit_order == [2, 1, 0]
    assert judgement.visits == pytest.approx([4.0, 8.0 + math.pi / 2, 12.0 + math.pi], abs=1e-6)
    in_order = replace(THROUGH, order="given")
    assert judge(in_order, U_TURN).verdict is Verdict.MISSES
    assert "in their order" in miss_reason(in_order, U_TURN, "best")
    beside = replace(THROUGH, via=[*THROUGH.via, (4, 1)])
    assert judge(beside, U_TURN).verdict is Verdict.MISSES
    assert miss_reason(beside, U_TURN, "best") == "the path passes 1 R from a via point"


def test_a_point_that_is_passed_early_counts_there():
    """A point that is passed early counts there.

    A figure of eight passes its middle twice; a target that is passed early is no end.
    """
    eight = Path(Pose(-3, 0, 0), [0.0, 1.0, 0.0, -1.0], [6.0, 1.5 * math.pi, 4.0, 1.0])
    crossing = eight.at(6.0 + 1.5 * math.pi + 1.0)[0, :2]
    assert crossing == pytest.approx((2.0, 0.0), abs=1e-9)
    end = eight.end
    scenario = Scenario(
        *(-3, 0, 0, end.x, end.y), via=[tuple(eight.at(9.0)[0, :2]), (2, 0)], order="free"
    )

    assert judge(scenario, eight).visit_order == [1, 0]
    assert judge(scenario, eight).visits[0] == pytest.approx(5.0, abs=1e-6)
    early = replace(scenario, target_x=0, target_y=0)
    assert judge(early, eight).verdict is Verdict.MISSES
    assert "from the target" in miss_reason(early, eight, "best")


@pytest.mark.parametrize(
    ("off", "verdict"), [(0.0, "optimal"), (0.9e-6, "optimal"), (2e-6, "misses"), (1.0, "misses")]
)
@pytest.mark.parametrize("order", ["given", "free"])
def test_a_heading_at_a_stop_is_met(off, verdict, order):
    via = [(4, 0, off), (9, 1), (4, 2, off - math.pi)]
    scenario = replace(THROUGH, via=via, order=order)

    assert judge(scenario, U_TURN).verdict == verdict
    if verdict == "misses":
        reason = miss_reason(scenario, U_TURN, "best")
        assert reason.endswith("rad from the heading of a via point when it passes there")
        turned = replace(scenario, via=[(4, 0, 2 * math.pi), *via[1:]])  # a turn is nothing
        assert judge(turned, U_TURN).verdict == "misses"


@pytest.mark.parametrize("off", [0.7, 1e-3, 2.5e-6])
def test_the_second_passing_counts_where_it_has_the_heading(off):
    """The second passing counts for a heading.

    A path comes through a point with another heading, and returns there with the right one.
    """
    back = pose_path(Pose(2, 0, 0), Pose(2, 0, -off), 1.0)
    path = Path(Pose(0, 0, 0), [0.0, *back.curvatures, 0.0], [2.0, *back.lengths, 3.0])
    end = path.end
    scenario = Scenario(target_x=end.x, target_y=end.y, via=[(2, 0, -off)])

    for order in ("given", "free"):
        judgement = judge(replace(scenario, order=order), path)
        assert judgement.verdict is not Verdict.MISSES
        assert judgement.visits == pytest.approx([2.0 + back.length], abs=1e-5)


def test_a_closed_path_ends_with_the_heading_of_its_start():
    """A closed path ends with its start's heading.

    A turn more is the same heading; a path that comes back with another one misses.
    """
    circle = Path(Pose(0, 0, 1.0), [1.0], [2 * math.pi])
    x, y, _ = circle.at(2.0)[0]
    scenario = Scenario(heading=1.0, via=[(x, y)], closed=True)
    for one in (scenario, replace(scenario, order="free"), replace(scenario, heading=None)):
        if one.heading is not None:
            assert judge(one, circle).verdict is Verdict.OPTIMAL
        there = pose_path(Pose(0, 0, 1.0), Pose(x, y, 2.0), 1.0)
        for end, arrives in ((1.0, True), (1.0 + 3e-6, False), (1.0 + math.pi, False)):
            back = pose_path(there.end, Pose(0, 0, end), 1.0)
            path = Path(
                there.start,
                [*there.curvatures, *back.curvatures],
                [*there.lengths, *back.lengths],
            )
            judgement = judge(replace(one, heading=1.0), path)
            assert (judgement.verdict is not Verdict.MISSES) == arrives
            if not arrives:
                assert "final heading" in miss_reason(replace(one, heading=1.0), path, "best")


def test_a_free_start_begins_at_its_place():
    """A free start begins at its place.

    It may have any heading; the judgement says which.
    """
    scenario = Scenario(1, 2, "free", 7, -3)
    answer = solve(scenario)
    away = math.atan2(-5, 6)

    assert answer.length == pytest.approx(math.hypot(6, 5), rel=1e-8)
    straight = Path(Pose(1, 2, away), [0.0], [math.hypot(6, 5)])
    judgement = judge(scenario, straight)
    assert (judgement.verdict, judgement.start_heading) == (Verdict.OPTIMAL, away)
    beside = Path(Pose(1 + 1e-9, 2, away), [0.0], [math.hypot(6, 5)])
    assert judge(scenario, beside).verdict is Verdict.MISSES
    assert miss_reason(scenario, beside, "best") == "the path starts elsewhere"


def test_an_open_end_is_wherever_all_are_passed():
    """An open end is wherever all are passed.

    What is driven beyond the last point is driven for nothing.
    """
    scenario = Scenario(via=[(3, 0), (8, 0), (5, 0)], order="free")

    assert judge(scenario, Path(scenario.start, [0.0], [8.0])).verdict is Verdict.OPTIMAL
    assert judge(scenario, Path(scenario.start, [0.0], [8.1])).verdict is Verdict.LONGER
    assert judge(scenario, Path(scenario.start, [0.0], [7.9])).verdict is Verdict.MISSES


CHEATED = {
    "to a target": {"target_x": 2, "target_y": 1.5},
    "to a heading": {"target_x": 2, "target_y": 1.5, "final_heading": 2.0},
    "open": {},
    "closed": {"closed": True},
    "free start": {"heading": None},
}


@pytest.mark.many(3)
@pytest.mark.parametrize("name", CHEATED)
def test_who_misses_points_by_less_than_is_allowed_gains_nothing(name):
    """Missing points by little gains nothing.

    The best tours of points moved by up to 1e-6 R arrive, and by no more than that shorter.

    Those of points moved by more miss. Nobody's claim `optimal` is false for a millionth.
    """
    rng = np.random.default_rng(7)
    for _ in range(3):
        via = rng.uniform(-2, 2, (3, 2))
        asked = Scenario(**CHEATED[name], via=via, order="free")
        best = solve(asked)
        for size, arrives in ((0.9e-6, True), (5e-6, False)):
            angle = rng.uniform(-4, 4, 3)
            moved = via + size * np.stack([np.cos(angle), np.sin(angle)], axis=1)
            path = solve(replace(asked, via=moved)).path
            judgement = judge(asked, path, Claim.OPTIMAL)
            certificate = certify(asked, path, judgement, lower_bound=judgement.length)
            assert (judgement.verdict is Verdict.OPTIMAL) == arrives
            if arrives:
                assert not judgement.false_claim
                assert abs(judgement.length - best.length) < 1e-4 * best.length
                assert certificate.proof is Proof.PROVED


# just inside a turning circle of the start, and by 1e-6 R outside: most of a turn less
INSIDE, OUTSIDE = (0.0, 2.0 - 4e-7), (0.0, 2.0 + 4e-7)


@pytest.mark.parametrize("ends", [{}, {"target_x": -6, "target_y": 2}, {"closed": True}])
def test_a_shortcut_of_a_turn_is_judged_by_the_points_that_it_visits(ends):
    """Visited points judge a shortcut of a turn.

    The reference falls by a jump within what is allowed; the cheat is no crash and no proof.
    """
    asked = Scenario(**ends, via=[INSIDE], order="free")
    cheat = solve(replace(asked, via=[OUTSIDE])).path

    judgement = judge(asked, cheat, Claim.OPTIMAL)
    certificate = certify(asked, cheat, judgement, lower_bound=cheat.length)

    assert judgement.verdict in (Verdict.OPTIMAL, Verdict.UNDECIDED)
    assert judgement.gap > -1e-4
    assert not certificate.false_bound


@pytest.mark.parametrize(
    "ends", [{}, {"closed": True}, {"target_x": 0, "target_y": 9e-7}, {"heading": None}]
)
@pytest.mark.parametrize("via", [[(0, 5e-7)], [(0, 5e-7), (0, -5e-7)], [(0, 5e-7, 0.0)]])
def test_a_path_may_rest_where_all_points_are(via, ends):
    """A path may rest where all points are.

    It is no crash, and nothing is claimed for more than it is.
    """
    asked = Scenario(**ends, via=via, order="free")
    resting = Path(Pose(0, 0, 0), [], [])

    judgement = judge(asked, resting, Claim.OPTIMAL, tolerances=SOON)
    certify(asked, resting, judgement, tolerances=SOON)

    assert judgement.verdict is Verdict.OPTIMAL
    assert judgement.gap == pytest.approx(0.0, abs=1e-5)

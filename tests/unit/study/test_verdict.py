"""The closed form's known numbers, and the check.

The check is tested for what it accepts, what it does not, and what it compares.

The campaign compares both with an oracle of 60 digits.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.solvers.analytic import Analytic
from dubins_study.study.body_coordinates import Local, local
from dubins_study.study.check.verdict import curvature_excess
from dubins_study.study.closed_form.kernel_math import LARGEST_ANGLE
from dubins_study.study.closed_form.shortest import (
    as_path,
    right_left_pair,
    shortest,
    shortest_local,
    shortest_path,
)
from dubins_study.study.judging.judge import judge
from dubins_study.study.judging.verdict_frame import LEG_WORDS, NO_WORD, VERDICTS, judge_frame
from dubins_study.study.path import CLAIMS, Path, Paths
from dubins_study.study.scenario import Scenario
from dubins_study.study.scenario_frame import check_frame
from dubins_study.study.scenario_frame import scenarios as scenarios_of
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import BRANCHES, POSE_BRANCHES, Claim, Verdict
from tests.cases import EDGES, PAPER, scenario_frame, scenarios
from tests.hard_cases import hard_frame, hard_poses

PROBLEM = PAPER["problem 1"]
N = 1200
HARD = hard_frame(N, seed=11)


def on_left_circle(angle: float, inside: float = 0.0) -> Scenario:
    """A target seen from the left circle.

    It has an arc angle. R = 1; it lies `inside` radii towards the centre.
    """
    r = 1 - inside
    return Scenario(0, 0, 0, r * math.sin(angle), 1 - r * math.cos(angle), 1)


def test_a_wrong_basin_is_not_a_false_claim_unless_optimality_is_claimed():
    worse = shortest_path(PROBLEM, "LS")

    local = judge(PROBLEM, worse, Claim.LOCAL)
    assert (local.verdict, local.wrong_basin, local.false_claim) == (Verdict.LONGER, True, False)
    assert judge(PROBLEM, worse, Claim.OPTIMAL).false_claim
    assert judge(PROBLEM, worse, Claim.LOCAL, "LS").verdict is Verdict.OPTIMAL


def test_a_coarse_answer_is_not_a_wrong_basin():
    """A coarse answer is not a wrong basin.

    It is a path of the right shape, a little longer: a detour of the same net turn.
    """
    straight = Scenario(0, 0, 0, 10, 0, 1)
    wave = Path(straight.start, [0.5, -0.5, 0.5], [0.5, 1.0, 0.5])
    end = wave.end
    reached = replace(straight, target_x=end.x, target_y=end.y)
    # its heading at the end is the one it began with
    judgement = judge(reached, wave, Claim.LOCAL)

    assert judgement.verdict is Verdict.LONGER
    assert not judgement.wrong_basin


@pytest.mark.parametrize(
    ("path", "verdict"),
    [
        (None, Verdict.NONE),
        (Path(PROBLEM.start, [-2.0, 0.0], [0.8, 11.0]), Verdict.MISSES),
        (Path(PROBLEM.start, [math.nan], [1.0]), Verdict.MISSES),
        (Path(PROBLEM.start, [1.0], [math.inf]), Verdict.MISSES),
        (Path(PROBLEM.start, [1.0], [-1.0]), Verdict.MISSES),
        # so long that rounding hides where they end, and so long that lengths overflow
        (Path(PROBLEM.start, [1.0], [1e16]), Verdict.MISSES),
        (Path(PROBLEM.start, [1.0], [1e300]), Verdict.MISSES),
        (Path(PROBLEM.start, [0.0, 0.0], [1e308, 1e308]), Verdict.MISSES),
        (Path(PROBLEM.start, [], []), Verdict.MISSES),
        (Path(replace(PROBLEM, x=9.9, y=5).start, [0.0], [0.1]), Verdict.MISSES),
    ],
)
def test_what_does_not_arrive(path, verdict):
    """Paths that do not arrive.

    They are no path, too sharp a turn, broken numbers, backwards, nothing, and another start.
    """
    judgement = judge(PROBLEM, path, Claim.LOCAL)

    assert judgement.verdict is verdict
    assert judgement.gap is None
    assert judgement.false_claim


@pytest.mark.parametrize(
    ("branch", "curvature", "excess"),
    [
        *(("LS", [1, 0], 0), ("LS", [-0.25, 1], 0.25), ("RS", [0.25, -1], 0.25)),
        *(("LR", [1, -1], 0), ("LR", [-1, 1], 2), ("LR", [1, 0, -1], 1)),
        *(("RL", [-1, 1], 0), ("RL", [-1], 0), ("RL", [1], 0), ("best", [1.5], 0.5)),
        *(("LSR", [1, 0, -1], 0), ("LSR", [0, 1, -1], 1), ("LSR", [1, 0.25, -1], 0.25)),
        ("LSR", [1, -1], 0),  # its straight has no length
        *(("RLR", [-1, 1, -1], 0), ("RLR", [-1, 1, -1, 1], 2), ("LR", [0.9, 1, -0.75], 0.25)),
    ],
)
def test_curvature_that_a_branch_allows(branch, curvature, excess):
    assert curvature_excess(curvature, branch) == pytest.approx(excess)


def test_arcs_of_no_length_exceed_nothing():
    for lengths, excess in (([0, 1], 0), ([1, 1], 1)):
        path = Path(EDGES["ahead"].start, [-1, 1], lengths)
        judgement = judge(EDGES["ahead"], path, branch="LS")
        assert judgement.curvature_excess == pytest.approx(excess)


def test_the_reference_is_relaxed_over_the_miss_near_a_circle():
    """Near a circle the reference is relaxed.

    It is relaxed over the miss. Just inside a circle, the optimum is 6.535; a miss of 1e-7 makes
    0.300 honest.

    There LS does not exist, but the arc that misses answers it. Paths that arrive, a longer one
    too, are compared with the exact optimum.
    """
    inside = on_left_circle(0.3, inside=1e-7)
    arc = Path(inside.start, [1.0], [0.3])
    exact = judge(inside, shortest_path(inside))
    longer = judge(inside, shortest_path(inside, "RS"))
    short, as_ls = judge(inside, arc), judge(inside, arc, branch="LS")

    assert exact.length == pytest.approx(6.535, abs=1e-3)
    assert exact.verdict is short.verdict is as_ls.verdict is Verdict.OPTIMAL
    assert longer.reference == pytest.approx(6.535, abs=1e-3)
    assert short.miss == pytest.approx(1e-7, rel=1e-6)
    assert short.length == pytest.approx(0.3)
    assert abs(short.gap) < 1e-6
    assert short.reference < 0.31
    assert as_ls.reference_word is None


def test_an_exact_answer_that_lands_across_the_circle_is_not_punished():
    """An exact answer across the circle is right.

    The long path to a target 1e-9 inside ends 2e-9 off on the outer side.
    """
    inside = on_left_circle(0.3, inside=1e-9)
    path = shortest_path(inside)
    nudged = Path(path.start, path.curvatures, path.lengths - [0, 3e-9])

    judgement = judge(inside, nudged, Claim.LOCAL)

    assert judgement.miss > 1e-9
    assert judgement.verdict is Verdict.OPTIMAL
    assert judgement.reference > 6


def test_near_the_rear_a_miss_explains_more():
    """Near the rear a miss explains more.

    There the optimal length changes by 1 / cos(a / 2) = 48 times the target's shift.
    """
    scenario = on_left_circle(3.10, inside=4e-9)
    short = on_left_circle(3.10, inside=1e-9)  # its target is 3e-9 away, its optimum 1e-7 shorter
    path = shortest_path(short)
    assert path is not None

    judgement = judge(scenario, path)

    assert path.length < shortest_path(scenario).length
    assert judgement.verdict is Verdict.OPTIMAL


def test_going_straight_first_does_not_answer_ls_inside_the_left_disc():
    """Going straight first is not LS in the disc.

    It is the left disc. One-sided turning arrives at the centre (straight 1, left 3 pi / 2), but
    not as LS.
    """
    centre = EDGES["centre of the left disc"]
    path = Path(centre.start, [0.0, 1.0], [1.0, 1.5 * math.pi])

    judgement = judge(centre, path, Claim.LOCAL, "LS")

    assert judgement.miss < 1e-12
    assert judgement.verdict is Verdict.MISSES
    assert judge(centre, path, Claim.LOCAL).verdict is Verdict.LONGER


@given(scenarios(), st.lists(st.tuples(st.floats(0, 1), st.floats(0, 3)), min_size=1, max_size=6))
def test_one_sided_turning_is_never_shorter_than_ls(scenario, pieces):
    """One-sided turning is never shorter than LS.

    docs/derivation.md, section 8: any end that LS reaches at all, it reaches first.
    """
    radius = scenario.radius
    path = Path(
        scenario.start, [u / radius for u, _ in pieces], [length * radius for _, length in pieces]
    )
    moved = replace(scenario, target_x=path.end.x, target_y=path.end.y)
    best = shortest_path(moved, "LS")

    if best is not None:
        assert best.length <= path.length + 1e-9 * radius


def test_claims_of_infeasibility():
    inside = Scenario(0, 0, 0, 0, 1, 1)

    right = judge(inside, None, Claim.INFEASIBLE, "LS")
    wrong = judge(inside, None, Claim.INFEASIBLE, "RS")

    assert (right.verdict, right.false_claim) == (Verdict.NONE_EXISTS, False)
    assert (wrong.verdict, wrong.false_claim) == (Verdict.NONE, True)


def test_tolerances_decide():
    """Tolerances decide.

    The same path is optimal or longer by the gap that is allowed.
    """
    path = shortest_path(PROBLEM)
    stretched = Path(path.start, path.curvatures, path.lengths * [1, 1 + 5e-5])
    end = stretched.end
    moved = replace(PROBLEM, target_x=end.x, target_y=end.y)
    assert judge(moved, stretched).verdict is Verdict.OPTIMAL

    loose, tight = Tolerances(miss=1e-2), Tolerances(miss=1e-2, gap=1e-6)
    assert judge(PROBLEM, stretched, tolerances=loose).verdict is Verdict.OPTIMAL
    assert judge(PROBLEM, stretched, tolerances=tight).verdict is Verdict.LONGER
    assert judge(PROBLEM, stretched).verdict is Verdict.MISSES


@given(scenarios())
def test_margin_is_the_distance_to_the_nearer_circle(scenario):
    """Margin is the distance to the nearer circle.

    It is compared with the distance computed in the world frame.
    """
    judgement = judge(scenario, None)
    x = scenario.x
    y = scenario.y
    heading = scenario.heading
    radius = scenario.radius
    centres = [
        (x - side * radius * math.sin(heading), y + side * radius * math.cos(heading))
        for side in (1, -1)
    ]
    distances = [math.hypot(scenario.target_x - a, scenario.target_y - b) for a, b in centres]

    expected = min(abs(d / radius - 1) for d in distances)
    # coordinates up to 100 radii from the origin are rounded at 1e-14 radii
    np.testing.assert_allclose(judgement.margin, expected, rtol=1e-9, atol=1e-12)
    if expected > 1e-9:
        inside = [d < radius for d in distances]
        place = {(1, 0): "left disc", (0, 1): "right disc", (0, 0): "outside"}
        assert judgement.region == place[tuple(map(int, inside))]


def test_another_word_far_off_is_a_wrong_basin_though_it_turns_as_far():
    """Another word far off is a wrong basin.

    It turns as far. Found in review: RL beside the rear of a circle's front turns as LS does, a
    third longer.
    """
    scenario = on_left_circle(2.8, inside=-1e-5)
    target = local(scenario)
    first, second, _, _ = right_left_pair(*target)
    path = as_path(scenario.start, scenario.radius, "RL", (first, second))
    judgement = judge(scenario, path, Claim.LOCAL)

    assert judgement.gap > 0.3
    assert abs(path.turn - 2.8) < 1
    assert judgement.wrong_basin


def test_next_to_the_start_a_miss_reaches_the_circle_for_all_its_rounding():
    """Next to the start a miss reaches the circle.

    A path ends inside, 5e-12 R off a target 2e-14 R inside, where delta is 1e-16 R. The nearest
    point of the circle counts as a target that RS reaches, whatever its rounding.
    """
    scenario = Scenario(
        *(0, 0, -2.809937325251296, 1.9494799770390372e-07, 7.027045308769248e-08),
        7.2433132805187565e-06,
    )
    X, Y = scenario.local()
    turn = math.atan2(X, 1 + Y) % (2 * math.pi)
    lengths = scenario.radius * np.array([5e-12, turn])
    path = Path(scenario.start, [0.0, -1 / scenario.radius], lengths)

    judgement = judge(scenario, path, Claim.LOCAL, "RS")

    assert 1e-12 < judgement.miss / scenario.radius < 1e-11
    assert (judgement.verdict, judgement.false_claim) == (Verdict.OPTIMAL, False)


# frames against the scalar check; the adversary compares them row by row


def test_the_closed_form_is_judged_optimal_without_the_scalar_check(monkeypatch):
    """The closed form needs no scalar check.

    It is judged optimal. Ordinary rows take the quick way: the tolerance for what is not is one
    row in a hundred.
    """
    calls = []
    monkeypatch.setattr(
        "dubins_study.study.judging.verdict_frame.judge",
        lambda *args: calls.append(1) or judge(*args),
    )
    paths = Analytic().solve_frame(HARD, "best").paths
    judgements = judge_frame(HARD, paths, Claim.OPTIMAL)

    assert (judgements.verdict == VERDICTS.index(Verdict.OPTIMAL)).all()
    assert not judgements.false_claim.any()
    ordinary = (HARD["heading"].abs() < LARGEST_ANGLE).sum()
    assert len(calls) < N - ordinary + N / 100


def test_a_longer_path_of_a_tie_is_in_the_right_basin():
    """A tie's longer path is no wrong basin.

    Straight behind, LS and RS tie: either word, coarsely driven, turns the right way.
    """
    behind = Scenario(0, 0, 0, -1, 0, 1)
    paths = [shortest_path(replace(behind, radius=1.1), word) for word in ("LS", "RS")]
    controls = (np.array([getattr(p, name) for p in paths]).T for name in ("curvatures", "lengths"))
    judgements = judge_frame(scenario_frame([behind, behind]), Paths(*controls))

    assert [VERDICTS[code] for code in judgements.verdict] == [Verdict.LONGER] * 2
    assert not judgements.wrong_basin.any()
    assert not any(judge(behind, path).wrong_basin for path in paths)


def test_two_arcs_of_one_run_are_one_letter_in_a_frame_too():
    """Two arcs of one run are one letter.

    That holds in a frame too. The second turns by too little to be named alone, and is long enough
    to be a straight.
    """
    scenario = Scenario(
        -0.002090161445753378,
        -0.0498766661720182,
        -3.141592653589793,
        target_x=-0.002460789043721996,
        target_y=-0.04987374231113782,
        radius=0.02349177525175248,
    )
    rates = np.full((2, 1), -42.5680898647879)
    lengths = np.array([[0.00037064136279217597], [1.6124375849148113e-09]])
    rows = judge_frame(scenario_frame([scenario]), Paths(rates, lengths))
    path = Path(scenario.start, rates[:, 0], lengths[:, 0])

    assert LEG_WORDS[rows.word[0]] == judge(scenario, path).word == "R"


# what a path with the closed form's word is given more: nothing, next to nothing, and too much
DETOURS = (0.0, 1e-15, 1e-9, 1e-5, 2 * math.pi)


@pytest.mark.parametrize("branch", POSE_BRANCHES)
def test_a_frame_of_poses_says_of_each_row_what_the_check_says(branch):
    """A frame of poses agrees with the check.

    Of 600 legs at and next to the edges of words there are the shortest path, longer ones, and
    none.
    """
    n = 600
    frame = check_frame(hard_poses(n, seed=12))
    paths = Analytic().solve_frame(frame.copy(), branch).paths
    rng = np.random.default_rng(12)
    lengths = paths.lengths.copy()
    detours = rng.choice(DETOURS, n) * frame["radius"].to_numpy()
    lengths[rng.integers(0, 3, n), np.arange(n)] += detours
    returned = rng.random(n) < 0.8
    if paths.returned is not None:
        returned &= paths.returned
    claims = rng.integers(0, len(CLAIMS), n)
    answers = Paths(paths.curvatures, lengths, returned)
    rows = judge_frame(frame, answers, claims, branch)

    for row, scenario in enumerate(scenarios_of(frame)):
        path = answers.path(row, scenario)
        judgement = judge(scenario, path, CLAIMS[claims[row]], branch)
        assert VERDICTS[rows.verdict[row]] is judgement.verdict, (row, scenario)
        assert rows.false_claim[row] == judgement.false_claim, (row, scenario)
        assert rows.wrong_basin[row] == judgement.wrong_basin, (row, scenario)
        for name in ("word", "reference_word"):
            code = int(getattr(rows, name)[row])
            text = None if code == NO_WORD else LEG_WORDS[code]
            assert text == getattr(judgement, name), (row, scenario, name)
        size = scenario.extent + scenario.radius + (judgement.length or 0.0)
        # next to the edge of a word's reach lengths are known to a root of the rounding
        units = {
            "length": 1e-14 * size,
            "miss": 1e-14 * size,
            "gap": 1e-7,
            "reference": 1e-7 * size,
        }
        for name, allowed in units.items():
            expected = getattr(judgement, name)
            value = float(getattr(rows, name)[row])
            if expected is None:
                assert math.isnan(value), (row, scenario, name)
            else:
                assert abs(value - expected) <= allowed, (row, scenario, name)


def unit(X: float, Y: float) -> Scenario:
    """A target (X, Y) in the vehicle's frame.

    R = 1.
    """
    return Scenario(0, 0, 0, X, Y, 1)


def test_the_length_jumps_across_the_front_of_a_circle():
    """The length jumps across a circle's front.

    At arc angle 0.3: 0.300 on the circle and just outside, 6.535 just inside.
    """
    x, y = math.sin(0.3), math.cos(0.3)
    on = shortest(unit(x, 1 - y))
    outside = shortest(unit(x * (1 + 1e-9), 1 - y * (1 + 1e-9)))
    inside = shortest(unit(x * (1 - 1e-9), 1 - y * (1 - 1e-9)))

    assert (on.word, outside.word, inside.word) == ("L", "LS", "RL")
    assert on.total == pytest.approx(0.3, abs=1e-15)
    assert outside.total == pytest.approx(0.300, abs=5e-4)
    assert inside.total == pytest.approx(6.535, abs=5e-4)  # printed to three digits


def test_centre_of_a_disc_and_straight_behind():
    """A disc's centre and straight behind.

    Lengths are known to six digits; straight behind, the least is at D = 1 exactly.
    """
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
    """Targets that rounding hides are met.

    Beside a far origin these are the start or (0, 2); every branch's path still arrives.
    """
    for branch in BRANCHES:
        for target in (Local(X, Y, 4e-15), Local(X, -Y, 4e-15)):
            optimum = shortest_local(target, branch)
            if optimum is not None:
                path = as_path(unit(0, 0).start, 1.0, optimum.word, optimum.segments)
                off = math.hypot(path.end.x - target.X, path.end.y - target.Y)
                # the root of a rounding of 4e-15 is 6e-8; the verdict allows 1e-6
                assert off < 2e-7, (branch, target)

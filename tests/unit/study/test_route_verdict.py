"""The check of routes and of final headings.

Tested are what it accepts and what it compares with.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from dubins_study import solve
from dubins_study.asking.attempt import attempt, judged, shorter_answer
from dubins_study.asking.reply import Reply
from dubins_study.solvers.analytic import Analytic
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.study.judging.certify import certify
from dubins_study.study.judging.judge import judge, miss_reason
from dubins_study.study.kinds import shortest
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Times
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.tolerances import Tolerances
from dubins_study.study.words import POSE_BRANCHES, Claim, Outcome, Proof, Verdict

ROUTE = Scenario(
    heading="30deg", target_x=10, target_y=5, via=[(4, 1), (6, -2)], final_heading="90deg"
)
FREE = replace(ROUTE, final_heading=None)
POSE = Scenario(heading="30deg", target_x=1, target_y=0.5, final_heading="90deg")


NO_TIME = Tolerances(search_s=1e-9)


@pytest.mark.parametrize(
    ("scenario", "changed", "branch", "reason"),
    [
        (ROUTE, {"via": ROUTE.via[::-1]}, "best", "via point"),
        (ROUTE, {"via": [(4, 1 + 2.5e-6), (6, -2)]}, "best", "via point"),
        (ROUTE, {"via": [(4, 1 + 0.9e-6), (6, -2)]}, "best", None),
        (POSE, {"final_heading": math.pi / 2 + 2e-6}, "best", "final heading"),
        (POSE, {"final_heading": math.pi / 2 + 0.9e-6}, "best", None),
        (POSE, {"via": [(0.5, 0.5)]}, "best", "via point"),
        (POSE, {}, "LSL", "curvature"),
    ],
)
def test_what_misses_and_why(scenario, changed, branch, reason):
    """Misses and their reasons.

    A millionth of the radius is allowed. The campaign tries misses of every size.
    """
    path = solve(scenario).path
    asked = replace(scenario, **changed)
    expected = Verdict.OPTIMAL if reason is None else Verdict.MISSES

    assert judge(asked, path, branch=branch).verdict is expected
    assert reason is None or reason in miss_reason(asked, path, branch)


@pytest.mark.parametrize("scenario", [ROUTE, FREE, POSE])
def test_the_analytic_answer_is_proved(scenario):
    answer = solve(scenario)

    assert (answer.outcome, answer.claim) == (Outcome.RETURNED, Claim.OPTIMAL)
    assert (answer.verdict, answer.proof) == (Verdict.OPTIMAL, Proof.PROVED)
    assert answer.reference_low <= answer.length <= answer.reference_high * (1 + 1e-12)
    assert answer.reference_high - answer.reference_low <= 2e-9 * answer.length
    assert answer.word == answer.reference_word
    assert len(answer.word.split()) == scenario.legs
    assert not answer.false_claim
    assert not answer.false_bound


@pytest.mark.parametrize("branch", POSE_BRANCHES)
def test_each_word_is_a_branch_of_a_leg_with_a_final_heading(branch):
    answer = solve(POSE, branch=branch)

    none = branch == "RSL"
    assert answer.verdict is (Verdict.NONE_EXISTS if none else Verdict.OPTIMAL)
    assert answer.proof is Proof.PROVED
    assert none or answer.word == branch or branch == "best"


@pytest.mark.parametrize("scenario", [ROUTE, FREE, POSE])
def test_a_detour_is_longer(scenario):
    path = solve(scenario).path
    circle = Path(
        path.start, [1.0, *path.curvatures], [2 * math.pi / scenario.radius, *path.lengths]
    )

    judgement = judge(scenario, circle, Claim.OPTIMAL)

    assert judgement.verdict is Verdict.LONGER
    assert judgement.wrong_basin
    assert judgement.false_claim
    assert judgement.gap == pytest.approx(2 * math.pi / path.length)
    # an arc that is a turn longer satisfies Pontryagin's conditions as well, another arc does not
    same_side = path.curvatures[0] > 0
    proof = Proof.EXTREMAL if same_side else Proof.NONE
    assert certify(scenario, circle, judgement).proof is proof


@pytest.mark.parametrize("arc", [0.5, 1.0, math.pi, 4.0, 5.5])
@pytest.mark.parametrize("side", [1, -1])
def test_a_needless_turn_is_longer_from_half_a_turn_on(arc, side):
    """A needless turn is longer from half a turn.

    It is a leg of one arc. Below half a turn, rounding may put its end where a turn more is
    needed.
    """
    end = math.sin(arc), side * (1.0 - math.cos(arc))
    scenario = Scenario(target_x=end[0], target_y=end[1], final_heading=side * arc)
    path = Path(scenario.start, [side], [arc])
    turned = Path(scenario.start, [side], [arc + 2 * math.pi])

    assert judge(scenario, path).verdict is Verdict.OPTIMAL
    expected = Verdict.OPTIMAL if arc < math.pi else Verdict.LONGER
    assert judge(scenario, turned).verdict is expected


def test_an_answer_tells_where_it_visits_the_via_points():
    """An answer tells its visits of via points.

    They are in their order, each within what a path may miss by; nothing where there is none.
    """
    answer = solve(ROUTE)
    places = answer.path.at(answer.visits)

    assert np.hypot(*(places[:, :2] - ROUTE.via).T).max() <= 1e-6
    assert 0 < answer.visits[0] < answer.visits[1] < answer.length
    assert solve(POSE).visits is None
    assert certify(ROUTE, answer.path, _judgement(answer)).pmp_residual < 1e-9


def _judgement(answer):
    return judge(answer.scenario, answer.path, answer.claim)


def test_what_the_interval_leaves_open_is_undecided():
    """Answers within an open interval are undecided.

    They are neither right nor wrong, whatever is claimed; a path that is surely longer is longer.
    """
    path = solve(FREE).path
    shortest._known.clear()  # which closed the gap

    for claim in (Claim.OPTIMAL, Claim.LOCAL, Claim.FEASIBLE):
        judgement = judge(FREE, path, claim, tolerances=NO_TIME)
        assert (judgement.verdict, judgement.false_claim) == (Verdict.UNDECIDED, False)
    assert judge(FREE, path, Claim.INFEASIBLE, tolerances=NO_TIME).false_claim
    certificate = certify(FREE, path, judgement, tolerances=NO_TIME)
    assert certificate.proof is Proof.EXTREMAL
    assert certificate.reference_low < 0.999 * path.length
    bounded = certify(FREE, path, judgement, lower_bound=path.length, tolerances=NO_TIME)
    assert bounded.proof is Proof.BOUNDED

    circles = Path(path.start, [1.0, *path.curvatures], [20 * math.pi, *path.lengths])
    assert judge(FREE, circles, tolerances=NO_TIME).verdict is Verdict.LONGER


def test_the_check_repeats_no_search(monkeypatch):
    """The check repeats no search.

    A search is the solver's own each time; the check takes the last one if it suffices.
    """
    limits: list[float] = []

    def told(*given):
        """The limit that a solver is told.

        It is 95 % of the limit, less what building took.
        """
        return pytest.approx([0.95 * each for each in given], rel=0.02)

    def search(*question, limit, **options):
        limits.append(limit)
        return search_routes(*question, limit=limit, **options)

    search_routes = shortest.search
    monkeypatch.setattr(shortest, "search", search)
    shortest._known.clear()

    for _ in range(2):
        solve(FREE, limit=30)
    assert limits == told(30, 30)
    judge(FREE, solve(ROUTE).path)  # of another question
    assert limits[2:] == told(60)

    solve(FREE, limit=1e-9)
    assert limits[3] <= 1e-9
    judge(FREE, solve(FREE, limit=1e-9).path)  # in its own time
    assert limits[4] <= 1e-9
    assert limits[5:] == [4 * 20]  # a count of boxes ends it sooner


def _zigzag(points):
    """A route that no search closes in a second."""
    x, y = 0.4 * np.arange(1, points + 1), 0.3 * (-1.0) ** np.arange(points)
    *via, target = zip(x.tolist(), y.tolist(), strict=True)
    return Scenario(target_x=target[0], target_y=target[1], via=via)


@pytest.mark.parametrize("speed", [1e5, 1e12])
def test_what_the_solver_searched_is_the_reference_on_any_machine(speed, monkeypatch):
    """The solver's search is the reference on any machine.

    The search was ended by its limit; a check that may take as long does not search again.
    """
    searches = []
    search_routes = shortest.search
    monkeypatch.setattr(shortest, "BOXES_A_SECOND", speed)
    monkeypatch.setattr(
        shortest, "search", lambda *a, **o: searches.append(o) or search_routes(*a, **o)
    )

    answer = solve(_zigzag(60), limit=0.3)

    assert answer.claim is Claim.FEASIBLE
    assert len(searches) == 1
    assert answer.reference_low == answer.lower_bound


def test_a_check_out_of_time_certifies_less():
    """A check out of time certifies less.

    The conditions are not checked; the interval, which is known, still proves the path.
    """
    answer = solve(ROUTE)
    judged_before = judge(ROUTE, answer.path)
    late = replace(Tolerances(), until=-math.inf)

    certificate = certify(ROUTE, answer.path, judged_before, tolerances=late)

    assert answer.pmp_residual < 1e-7
    assert certificate.pmp_residual is None
    assert certificate.proof is Proof.PROVED


def test_a_longer_answer_comes_with_the_shorter_path():
    """A longer answer comes with the shorter path.

    The check's own path is an answer too, judged as all are.
    """
    best = solve(ROUTE).path
    circled = Path(best.start, [1.0, *best.curvatures], [2 * math.pi, *best.lengths])
    reply = Reply(Outcome.RETURNED, Solution(Claim.LOCAL, circled), Times())
    answer = judged("circles", Question(ROUTE), reply)

    shorter = shorter_answer(answer)

    assert answer.verdict is Verdict.LONGER
    assert shorter.verdict is Verdict.OPTIMAL
    assert shorter.length == pytest.approx(answer.length - 2 * math.pi, rel=1e-9)
    assert shorter_answer(shorter) is None


def test_a_search_that_is_cut_short_claims_no_optimum():
    answer = solve(FREE, limit=1e-9)

    assert answer.claim is Claim.FEASIBLE
    assert answer.lower_bound < answer.length


def test_no_path_is_judged_without_a_search(monkeypatch):
    monkeypatch.setattr(shortest, "search", None)
    nothing = Reply(Outcome.RETURNED, Solution(Claim.FAILED), Times())

    answer = judged("nobody", Question(FREE), nothing)

    assert (answer.verdict, answer.proof, answer.reference) == (Verdict.NONE, Proof.NONE, None)
    assert judge(FREE, None, Claim.INFEASIBLE).false_claim


@pytest.mark.parametrize("via", [(), [(-3, 2)]])
def test_missing_by_a_little_buys_no_turn(via):
    """Missing by a little buys no turn.

    Just inside the start's circle the shortest path is a whole turn longer than on it.

    A path to the circle, which misses by less than is allowed, is compared with the shortest one to
    where it ends: it is right, but only an extremal.
    """
    inside = 1 - 5e-7
    arc = 1.0
    last = Pose(inside * math.sin(arc), 1 - inside * math.cos(arc), arc)
    path = Path(Pose(0, 0, 0), [1.0], [arc])
    scenario = Scenario(target_x=last.x, target_y=last.y, final_heading=arc)
    if via:  # the same as the first leg of a route
        there = solve(Scenario(*path.end, target_x=-3, target_y=2, final_heading=1)).path
        scenario = Scenario(target_x=-3, target_y=2, via=[last[:2]], final_heading=1)
        path = Path(path.start, [1.0, *there.curvatures], [arc, *there.lengths])

    judgement = judge(scenario, path, Claim.OPTIMAL)
    proved = certify(scenario, path, judgement)

    assert proved.reference_low > path.length + 1
    assert judgement.verdict is not Verdict.MISSES
    assert judgement.gap > -1e-5
    assert judgement.miss == pytest.approx(5e-7, rel=1e-3)
    assert proved.proof is Proof.EXTREMAL
    assert solve(scenario).verdict is Verdict.OPTIMAL


@pytest.mark.parametrize("seed", range(8))
def test_rounding_beside_the_turning_circle_costs_no_turn(seed):
    """Rounding beside the turning circle costs no turn.

    A point is computed to lie on the start's circle, inside or outside by rounding.
    """
    rng = np.random.default_rng(seed)
    arc = Path(Pose(*rng.uniform(-5, 5, 3)), [1.0], [rng.uniform(0.3, 3)])
    x, y, heading = arc.end
    away = rng.uniform(3, 8, 2) * (math.cos(heading), math.sin(heading))
    there = solve(Scenario(*arc.end, x + away[0], y + away[1])).path
    path = Path(arc.start, [1.0, *there.curvatures], [*arc.lengths, *there.lengths])
    scenario = Scenario(*arc.start, x + away[0], y + away[1], via=[(x, y)])
    quick = Tolerances(search_s=0.5)

    judgement = judge(scenario, path, tolerances=quick)

    assert judgement.verdict in (Verdict.OPTIMAL, Verdict.UNDECIDED)
    certificate = certify(scenario, path, judgement, tolerances=quick)
    assert certificate.reference_low <= path.length * (1 + 1e-9)
    assert certificate.proof in (Proof.PROVED, Proof.EXTREMAL)


def test_the_check_knows_a_path_where_the_answer_has_none():
    """The check knows a path that the answer lacks.

    It also knows one of a leg; not of an answer that is the shortest.
    """
    nothing = judged("nobody", Question(FREE), Reply(Outcome.RETURNED, Solution(Claim.FAILED)))

    assert shorter_answer(nothing).verdict in (Verdict.OPTIMAL, Verdict.UNDECIDED)


def test_what_loads_is_no_part_of_a_limit(monkeypatch):
    """Loading is no part of a limit.

    The loops of the search are ready before a solver builds, and before its limit begins.
    """
    ready = []
    monkeypatch.setattr("dubins_study.study.route.search.compile_loops", lambda: ready.append(1))

    class Late(Analytic):
        def build(self, question):
            assert ready
            return question

    assert attempt(Late(), Question(FREE)).outcome is Outcome.RETURNED

"""disjunctive and global-nlp.

Tested are the models, the engines, and what is claimed of their answers.
"""

import math
import os
import subprocess
import sys
import time
from functools import partial
from itertools import permutations
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dubins_study.asking.attempt import attempt
from dubins_study.solvers.course import body_course
from dubins_study.solvers.engines import ENGINES, MINLP_ENGINES, Engine
from dubins_study.solvers.global_minlp.disjunctive import Disjunctive
from dubins_study.solvers.global_minlp.gdp_model import WORDS, gdp_model
from dubins_study.solvers.global_minlp.global_nlp import GlobalNlp
from dubins_study.solvers.minlp_engines import scip
from dubins_study.solvers.minlp_engines.mixed_program import (
    MixedProgram,
    ProvenResult,
    Row,
    Settings,
    Written,
)
from dubins_study.solvers.protocol import Question
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.route.search import search
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Proof, Verdict
from tests.cases import PAPER, margin, scenarios

INSTALLED = [name for name in MINLP_ENGINES if ENGINES[name].unavailable() is None]
FEASTOL = Disjunctive().feastol

# Targets where SCIP cut off the optimum or every path before angles were split into quadrants and
# its presolving and propagation left out: beside, next to the start, and far off nearly ahead.
CUT_OFF = [
    (0.0, -3.0),
    (0.0, 3.0),
    (1.011068997830838, -63.18905319850239),
    (0.05446073572801041, 0.005708768130479339),
    (-0.0203216164990006, 0.0017709727196027504),
    (-0.02793741840670497, 5.608788533307239e-09),
    (900.8394326368331, 0.8170759852533361),
    (301.8016023597201, -8.307724142603096e-05),
    (2.043299241646155e-08, -1.2117505825159536e-08),
]


def ask(X, Y, branch="best", kind=Disjunctive, **settings):
    return attempt(kind(**settings), Question(Scenario(0, 0, 0, X, Y, 1), branch), 20.0)


ask_nlp = partial(ask, kind=GlobalNlp)


def test_without_quadrants_the_arcs_have_the_sines():
    answer = ask(3, 2, quadrants=False)

    course = body_course(Scenario(0, 0, 0, 3, 2, 1))
    assert not hasattr(gdp_model(course, quadrants=False), "quadrant")
    assert (answer.claim, answer.verdict) == (Claim.OPTIMAL, Verdict.OPTIMAL)


IN_DISCS = [(-0.8, 0.5), (0.8, -1.5), (-0.4, -0.8), (0.4, 1.1)]


@pytest.mark.parametrize("target", CUT_OFF + IN_DISCS)
def test_no_optimum_is_cut_off(target):
    """No optimum is cut off.

    The bound does not exceed the shortest length, and a path is found.

    In discs to the gap that the setting promises.
    """
    answer = ask(*target)

    assert answer.verdict is Verdict.OPTIMAL
    assert not answer.false_claim
    if target in IN_DISCS:
        assert abs(answer.gap) < 1e-12  # polished to rounding
        assert answer.reference <= answer.lower_bound * (1 + 1e-6)
        # SCIP's own point is off by its tolerance, amplified at most tenfold away from the circles
        assert answer.claimed_length == pytest.approx(answer.reference, rel=10 * FEASTOL)
    # a target that is nearer to the start than SCIP's tolerance is one that it cannot tell apart
    assert answer.claim is (Claim.OPTIMAL if math.hypot(*target) > 1e-6 else Claim.FEASIBLE)
    assert answer.lower_bound <= answer.reference


@pytest.mark.parametrize("angle", [0.3, 2.0, 4.0])
@pytest.mark.parametrize("factor", [1.0, -1.0])
def test_on_a_circle_the_arc_is_proven(angle, factor):
    """On a circle the arc is proven.

    Every word shares the one arc there, and LS and RL have double solutions.
    """
    answer = ask(math.sin(angle), factor * (1 - math.cos(angle)))

    assert answer.claim is Claim.OPTIMAL, answer.message
    # where solutions meet, lengths are known to the square root of rounding, in their difference
    assert answer.length == pytest.approx(angle, abs=1e-7)
    assert answer.lower_bound <= angle * (1 + 1e-15)


@pytest.mark.parametrize("angle", [0.3, 2.0])
def test_inside_a_circle_by_less_than_the_tolerance_nothing_is_proven(angle):
    """Next to a circle, inside, nothing is proven.

    The target is inside by less than the tolerance. The shortest path is nearly a full turn longer
    than one that misses by 1e-10: no proof.
    """
    r = 1 - 1e-10
    answer = ask(r * math.sin(angle), 1 - r * math.cos(angle))

    assert answer.claim is Claim.FEASIBLE
    assert not answer.false_claim
    assert answer.miss <= 10 * FEASTOL
    optimum = shortest(answer.scenario).total
    assert answer.lower_bound <= angle < optimum - 3


@settings(max_examples=25)
@given(scenario=scenarios(far=1000.0), branch=st.sampled_from(WORDS))
def test_words_are_proven_to_be_there_or_not(scenario, branch):
    """Words are proven to exist or not.

    Away from where words begin and end, the claim is the closed form's and the bound holds.
    """
    X, Y = scenario.local()
    # a word's domain ends on circles of radius 1 or 3, LS and RS jump by a full turn on the axis
    reach = [abs(math.hypot(X, Y - side) - r) for side in (1, -1) for r in (1, 3)]
    assume(min(*reach, abs(Y)) > 1e-3)

    answer = attempt(Disjunctive(), Question(scenario, branch))

    if shortest(scenario, branch) is None:
        assert answer.claim is Claim.INFEASIBLE
        assert answer.path is None
    else:
        assert answer.claim is Claim.OPTIMAL, answer.message
        assert answer.verdict is Verdict.OPTIMAL
        assert answer.lower_bound <= answer.reference


POSED = [
    *((Disjunctive, {"transformation": name}, "all words") for name in ("bigm", "hull")),
    (GlobalNlp, {"model": "joint"}, "LRS RLS"),
    (GlobalNlp, {"model": "words"}, "LS RS LR RL"),
]


@pytest.mark.many(3)
@pytest.mark.parametrize("engine", INSTALLED)
@pytest.mark.parametrize(("kind", "settings_", "programs"), POSED)
@pytest.mark.parametrize(
    "target",
    [(3.0, 2.0), *(pytest.param(t, marks=pytest.mark.slow) for t in ((-1.0, 2.5), (0.4, -1.9)))],
)
def test_every_engine_proves_the_optimum(engine, kind, settings_, programs, target, capfd):
    """Every engine proves the optimum.

    Targets are outside, behind and inside a disc. In silence an engine has the shortest length,
    and a bound up to it.
    """
    # of disjunctions MAiNGO closes no gap near its tolerance
    feastol = 1e-8 if (engine, kind) == ("maingo", Disjunctive) else 1e-6
    answer = ask(*target, kind=kind, engine=engine, gap=1e-4, feastol=feastol, **settings_)

    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert answer.gap < 1e-12  # polished to rounding
    # above by the tolerance, times ten as an arc's end may move; below by the gap that was asked
    # for, and as much again: each engine has a formula of its own for it
    assert answer.reference * (1 - 2e-4) <= answer.lower_bound <= answer.reference + 1e-5
    assert answer.subproblems == programs
    assert answer.best_run_s in answer.subproblem_s
    assert capfd.readouterr() == ("", "")


def test_far_away_nothing_is_claimed_to_be_proven():
    """Far away nothing is claimed to be proven.

    Here SCIP's bound is 2e-6 above the shortest length (`solvers.global_minlp.disjunctive`).
    """
    answer = ask(25.422563016520616, -2538547.0079247607)

    assert answer.claim is Claim.FEASIBLE
    assert answer.lower_bound is None
    assert answer.verdict is Verdict.OPTIMAL


@pytest.mark.parametrize("branch", ["LS", "RS"])
def test_far_away_no_word_is_called_infeasible(branch):
    """Far away no word is called infeasible.

    Both reach a target 1.4e9 R away; SCIP's tolerances cannot tell.
    """
    answer = attempt(Disjunctive(), Question(Scenario(0, 0, 1, 1e9, -1e9, 1), branch))

    assert answer.claim is not Claim.INFEASIBLE
    assert not answer.false_claim


@pytest.mark.slow
def test_soplex_writes_87_000_bytes_that_nobody_sees(capfd):
    """More than a pipe holds."""
    ask(0.3382875641532451, -0.058957228594529676)

    assert capfd.readouterr() == ("", "")


def test_the_error_output_is_the_callers_again(capfd):
    """The error output is the caller's again.

    That holds after a solve, and where the caller has closed it.
    """
    ask(3, 2)
    os.write(2, b"still there")
    assert capfd.readouterr().err == "still there"

    saved = os.dup(2)
    os.close(2)
    try:
        answer = ask(3, 2)
        with pytest.raises(OSError, match="Bad file descriptor"):
            os.fstat(2)
    finally:
        os.dup2(saved, 2)
        os.close(saved)
    assert answer.claim is Claim.OPTIMAL


def test_errors_of_scip_are_a_failed_claim(monkeypatch):
    """Errors of SCIP are a failed claim.

    They come as bare exceptions; one that is not SCIP's is not swallowed.
    """
    model = Mock()
    monkeypatch.setattr(scip, "translated", lambda program: (model, None))
    model.optimize.side_effect = Exception("SCIP: error in LP solver!")
    assert ask(3, 2).claim is Claim.FAILED
    assert "LP solver" in ask(3, 2).native_status
    assert model.optimize.call_count == 4  # each time with a looser tolerance too
    assert ask(3, 2).subproblem_runs == [2]
    model.optimize.side_effect = Exception("something else")
    assert "something else" in ask(3, 2).message


def test_ctrl_c_goes_through(monkeypatch):
    """Ctrl-C goes through.

    SCIP catches the signal and stops, which is no time limit.
    """
    model = Mock(**{"getStatus.return_value": "userinterrupt"})
    monkeypatch.setattr(scip, "translated", lambda program: (model, None))

    with pytest.raises(KeyboardInterrupt):
        ask(3, 2)


def test_the_second_run_gets_the_time_that_is_left(monkeypatch):
    """The second run gets the time left.

    An infeasible word is asked again with a looser tolerance, within the one limit.
    """
    limits = []

    def engine(program, seconds):
        limits.append(seconds)
        time.sleep(0.1)
        return ProvenResult(None, Claim.INFEASIBLE, math.inf, 1, 0, "infeasible", "")

    monkeypatch.setattr(Engine, "load", lambda self: lambda settings: engine)
    solver = Disjunctive()
    solver.solve(solver.build(Question(Scenario(0, 0, 0, 0, 1, 1), "LS")), 5.0)

    assert limits[0] == 5.0
    assert limits[1] <= 4.9


@pytest.mark.slow
@settings(max_examples=80)
@given(scenario=scenarios(far=1000.0))
def test_no_claim_is_false(scenario):
    """No claim is false.

    Whatever the target: no claim is above what the check finds, no bound above the optimum.
    """
    answer = attempt(Disjunctive(), Question(scenario))

    assert not answer.false_claim
    assert answer.verdict is Verdict.OPTIMAL
    assert answer.lower_bound <= shortest(scenario).total * scenario.radius
    if margin(scenario) > 1e-6:
        assert answer.claim is Claim.OPTIMAL


@pytest.mark.many(3)
@pytest.mark.parametrize("final", [-2.0, 1.0, 3.0])
@pytest.mark.parametrize("target", [(5, 1), (1.5, -0.5), (0.2, 0.3)])
def test_a_final_heading_is_proven(target, final):
    """A final heading is proven.

    All six words take part, the ones of three arcs among them where the target is near.
    """
    answer = attempt(Disjunctive(), Question(Scenario(0, 0, 0.7, *target, 1, final_heading=final)))

    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert not answer.false_bound
    assert answer.lower_bound <= answer.reference_high


@pytest.mark.slow
@pytest.mark.parametrize("via", [(5, 0.5), (1.5, 0.5)])
def test_two_legs_are_proven(via):
    """Two legs are proven.

    It takes a hundred times as long as one leg.
    """
    scenario = Scenario(0, 0, 0, via[0] + 4, 3, 1, via=[via])
    answer = attempt(Disjunctive(gap=1e-4, feastol=1e-7), Question(scenario), 120.0)

    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert answer.lower_bound <= answer.reference_high


@pytest.mark.slow
def test_a_route_out_of_time_claims_nothing_and_its_bound_holds():
    via = [(1.5, 0.5), (0.5, 3), (2, 4)]
    answer = attempt(Disjunctive(), Question(Scenario(0, 0, 0, 1, 2, 1, via=via)), 2.0)

    assert answer.claim in (Claim.LIMIT, Claim.OPTIMAL)
    assert not answer.false_claim
    assert not answer.false_bound


TOURS = {
    "the end at any": {},
    "a target": {"target_x": 3.0, "target_y": -2.0},
    "a final heading": {"target_x": 3.0, "target_y": -2.0, "final_heading": 2.0},
    "closed": {"closed": True},
}


def tour(seed, count, **kind):
    """A tour of points in a square.

    Their order is free; the start has some heading.
    """
    random = np.random.default_rng(seed)
    via = random.uniform(0, 8 * math.sqrt(count), (count, 2))
    return Scenario(1, 0, random.uniform(0, 6), via=via, order="free", **kind)


def shortest_of_all_orders(scenario):
    """Proven length of the best order's shortest route."""
    target = [(stop.x, stop.y) for stop in scenario.stops[len(scenario.via) :]]
    last = scenario.heading if scenario.closed else scenario.final_heading
    orders = permutations(scenario.via)
    points = ([(scenario.x, scenario.y), *order, *target] for order in orders)
    return min(search(each, scenario.heading, last, tolerance=1e-9).low for each in points)


# points and kinds of tours that are proven in less than 15 s; others are not in a minute
CLOSING = {(2, "the end at any"), (2, "a target"), (2, "closed")}


@pytest.mark.many(2)
@pytest.mark.parametrize("kind", TOURS)
@pytest.mark.parametrize("count", [2, pytest.param(3, marks=pytest.mark.slow)])
def test_points_in_any_order_are_proven(kind, count):
    """Points in any order are proven.

    The search in every order is the comparison; out of time a bound is left, which holds.
    """
    scenario = tour(1, count, **TOURS[kind])
    solver = Disjunctive(gap=1e-3, feastol=1e-6, emphasis="default")
    limit = 30.0 if (count, kind) in CLOSING else 5.0
    answer = attempt(solver, Question(scenario), limit)
    least = shortest_of_all_orders(scenario)

    assert 0 < answer.lower_bound <= least
    assert answer.claim in (Claim.OPTIMAL, Claim.LIMIT), answer.message
    assert not answer.false_claim
    if answer.claim is Claim.OPTIMAL:
        assert least * (1 - 1e-9) <= answer.length <= least * (1 + 1e-3)
        assert answer.lower_bound >= least * (1 - 2e-3)


def test_two_points_in_any_order_are_proven_by_default():
    scenario = tour(1, 2)
    answer = attempt(Disjunctive(), Question(scenario), 60.0)

    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.length == pytest.approx(shortest_of_all_orders(scenario), rel=1e-6)


def test_too_many_points_in_any_order_are_told():
    answer = attempt(Disjunctive(), Question(tour(0, 9)), 5.0)

    assert answer.claim is Claim.FAILED
    assert answer.message == "more than 8 via points in any order"


@pytest.mark.parametrize("engine", [name for name in INSTALLED if name != "maingo"])
def test_a_limit_is_kept_and_claimed(engine):
    """A limit is kept and claimed.

    0.02 s is less than any engine takes for both orders of this question at a gap of 1e-12.
    """
    solver = GlobalNlp(engine=engine, gap=1e-12, feastol=1e-9)
    assert solver.keeps_limit
    solver.build(Question(PAPER["problem 2"]))
    began = time.process_time()  # a busy machine takes the wall clock, not the processor
    answer = attempt(solver, Question(PAPER["problem 2"]), 0.02)

    assert time.process_time() - began < 1.5  # the limit, a second, and the library's first import
    assert answer.claim is Claim.LIMIT, answer.message
    assert not answer.false_claim
    assert not answer.false_bound


def test_one_order_alone_proves_nothing():
    """One order alone proves nothing.

    (4.12) has no RL: inside the left disc its optimum is longer, and no bound is passed on.
    """
    answer = ask_nlp(0.3, 1.2, order="LRS", feastol=1e-6)

    assert answer.claim is Claim.LOCAL
    assert answer.verdict is Verdict.LONGER
    assert answer.lower_bound is None
    assert answer.proof is not Proof.BOUNDED
    assert answer.formulation == "joint NLP, LRS"
    at_start = ask_nlp(0.0, 0.0, order="LRS")
    assert (at_start.claim, at_start.lower_bound) == (Claim.LOCAL, None)
    both = ask_nlp(0.0, 0.0)
    assert (both.claim, both.lower_bound) == (Claim.OPTIMAL, 0.0)


def test_a_raw_point_is_the_engines():
    """A raw point is the engine's.

    Without polish the path misses by up to the tolerance, and has the engine's length.
    """
    raw = ask_nlp(3.0, 2.0, polish=False, gap=1e-4, feastol=1e-6, engine="scip")
    polished = ask_nlp(3.0, 2.0, gap=1e-4, feastol=1e-6, engine="scip")

    assert 0 < raw.miss <= 2e-6
    # a length that the engine leaves below zero by its tolerance is not driven
    assert raw.length == pytest.approx(raw.claimed_length, abs=2e-6)
    assert polished.miss < 1e-14


@pytest.mark.parametrize("heading", ["expression", "variable"])
def test_both_ways_of_posing_the_heading_are_one_model(heading):
    answer = ask_nlp(0.4, -1.9, heading=heading, gap=1e-4, feastol=1e-6)

    assert (answer.claim, answer.verdict) == (Claim.OPTIMAL, Verdict.OPTIMAL)
    assert answer.lower_bound <= answer.reference + 1e-5


FOUND = ProvenResult(np.array((1.0, 2.0)), Claim.OPTIMAL, 2.9, 5, 7, "done", "done")
NONE = ProvenResult(None, Claim.INFEASIBLE, math.inf, 1, 0, "none", "none")
STOPPED = ProvenResult(None, Claim.LIMIT, 1.0, 9, 9, "limit", "limit")
BROKEN = ProvenResult(None, Claim.FAILED, -math.inf, None, None, "error", "licence expired")


@pytest.mark.parametrize(
    ("results", "claim", "bound"),
    [
        ([FOUND, NONE, NONE, FOUND], Claim.OPTIMAL, 2.9),
        ([FOUND, NONE, STOPPED, NONE], Claim.LIMIT, 1.0),
        ([FOUND, NONE, BROKEN, NONE], Claim.FEASIBLE, None),
        ([BROKEN, BROKEN, BROKEN, BROKEN], Claim.FAILED, None),
        ([NONE, NONE, NONE, NONE], Claim.INFEASIBLE, None),
    ],
)
def test_claims_and_bounds_of_all_programs_together(monkeypatch, results, claim, bound):
    """Claims and bounds of all programs together.

    The bound is the least of the four words, if all have one; the claim is optimal only if all are
    solved.
    """
    left = iter(results)
    monkeypatch.setattr(Engine, "load", lambda engine: lambda settings: lambda *_: next(left))
    solver = GlobalNlp(model="words", polish=False)
    question = Question(Scenario(0, 0, 0, 3.0, 2.0, 10.0))
    solution = solver.solve(solver.build(question), 10.0)

    assert solution.claim is claim
    assert solution.lower_bound == (None if bound is None else 10.0 * bound)
    assert (solution.path is not None) == (results[0] is FOUND)
    assert ("licence expired" in solution.message) == any(one is BROKEN for one in results)


@pytest.mark.parametrize("name", INSTALLED)
@pytest.mark.parametrize("lean", [False, True])
def test_a_program_with_binaries_and_curves(name, lean):
    """A program with binaries and curves.

    min x - b with x >= sin(2) b, b binary, x^2 + cos(x) <= 2: the bound meets the optimum.

    For b = 1 the least x is sin(2) = 0.909, whose square and cosine add up to 1.44: the optimum
    is sin(2) - 1; for b = 0 it is 0.
    """

    def write(x, functions):
        curve = x[0] ** 2 + functions.cos(x[0]) - 2
        rows = [Row(x[0] - math.sin(2) * x[1], 0.0, 9.0), Row(curve, -math.inf, 0.0)]
        return Written(x[0] - x[1], rows)

    program = MixedProgram(np.zeros(2), np.array((3.0, 1.0)), np.array((False, True)), write)
    result = ENGINES[name].load()(Settings(1e-6, 1e-6, lean))(program, 20.0)

    assert result.claim is Claim.OPTIMAL
    assert result.x == pytest.approx([math.sin(2), 1], abs=1e-5)
    assert result.bound == pytest.approx(math.sin(2) - 1, abs=1e-5)
    assert result.nodes is None or result.nodes >= 0


@pytest.mark.parametrize("engine", INSTALLED)
@pytest.mark.parametrize("solver", [GlobalNlp, Disjunctive])
def test_a_word_without_a_path_is_called_infeasible(solver, engine):
    """A word without a path is called infeasible.

    No LS path ends inside the left disc: its own program says so.
    """
    question = Question(Scenario(0, 0, 0, 0.3, 1.2, 1), "LS")
    none = attempt(solver(engine=engine, feastol=1e-6), question, 20.0)

    assert none.claim is Claim.INFEASIBLE, none.message
    assert none.verdict is Verdict.NONE_EXISTS
    assert none.path is None


@pytest.mark.parametrize(("seconds", "told"), [(5.99, 5), (1.0, 1), (0.95, 1), (0.0, 0), (-0.3, 0)])
def test_maingo_is_told_whole_seconds_that_are_left(monkeypatch, seconds, told):
    """MAiNGO is told whole seconds that are left.

    A second run of a question whose time is up ends at once, and not a second later.
    """
    maingopy = pytest.importorskip("maingopy")
    options = {}

    class Told(maingopy.MAiNGO):
        def set_option(self, name, value):
            options[name] = value
            return super().set_option(name, value)

    monkeypatch.setattr(maingopy, "MAiNGO", Told)
    posed = GlobalNlp(engine="maingo").build(Question(Scenario(0, 0, 0, 1, 0.3, 1)))

    result = ENGINES["maingo"].load()(Settings(1e-6, 1e-8))(posed.programs[0], seconds)

    assert options["maxTime"] == told
    assert told or result.claim is Claim.LIMIT


_NAMES = """
from pyomo.environ import Constraint
from dubins_study import Question, Scenario
from dubins_study.solvers.registry import load
model = load("disjunctive").build(Question(Scenario(target_x=4, target_y=2, via=[(1, 3)])))
print([each.name for each in model.pyomo.component_data_objects(Constraint, descend_into=True)])
"""


@pytest.mark.slow
def test_a_program_is_the_same_in_every_process():
    """The order of a model's rows does not depend on the hashes of texts.

    SCIP takes three to thirty seconds for one question, by the order.
    """
    names = {
        subprocess.run(
            [sys.executable, "-c", _NAMES],
            env=os.environ | {"PYTHONHASHSEED": seed},
            capture_output=True,
            check=True,
            text=True,
        ).stdout
        for seed in "123"
    }

    assert len(names) == 1
    assert "cosine" in names.pop()

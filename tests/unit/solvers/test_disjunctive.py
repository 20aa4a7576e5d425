"""disjunctive: the model, the point made to meet the target, and what is claimed of it."""

from __future__ import annotations

import math
import os
import time
from unittest.mock import Mock

import pytest
from cases import PAPER, scenarios
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.course import body_course
from dubins_study.solvers.engines import ENGINES, MINLP_ENGINES, Engine
from dubins_study.solvers.global_minlp.disjunctive import Disjunctive
from dubins_study.solvers.global_minlp.model import WORDS, gdp_model
from dubins_study.solvers.minlp_engines import scip
from dubins_study.solvers.minlp_engines.program import ProvenResult
from dubins_study.solvers.protocol import Question
from dubins_study.study.closed_form.shortest import margin, shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Verdict

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


def ask(X, Y, branch="best", **changed):
    return attempt(Disjunctive(**changed), Question(Scenario(0, 0, 0, X, Y, 1), branch))


def test_without_quadrants_the_arcs_have_the_sines():
    answer = ask(3, 2, quadrants=False)

    course = body_course(Scenario(0, 0, 0, 3, 2, 1))
    assert not hasattr(gdp_model(course, quadrants=False), "quadrant")
    assert (answer.claim, answer.verdict) == (Claim.OPTIMAL, Verdict.OPTIMAL)


@pytest.mark.parametrize(("x", "y"), [(-0.8, 0.5), (0.8, -1.5), (-0.4, -0.8), (0.4, 1.1)])
def test_discs_are_proven(x, y):
    """In both discs, to the gap that the setting promises and as the closed form says."""
    answer = ask(x, y)

    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert abs(answer.gap) < 1e-12  # polished to rounding
    assert answer.lower_bound <= answer.reference <= answer.lower_bound * (1 + 1e-6)
    # SCIP's own point is off by its tolerance, amplified at most tenfold away from the circles
    assert answer.claimed_length == pytest.approx(answer.reference, rel=10 * FEASTOL)


@pytest.mark.parametrize("target", CUT_OFF)
def test_no_optimum_is_cut_off(target):
    """The bound does not exceed the shortest length, and a path is found."""
    answer = ask(*target)

    assert answer.verdict is Verdict.OPTIMAL
    assert not answer.false_claim
    # a target that is nearer to the start than SCIP's tolerance is one that it cannot tell apart
    assert answer.claim is (Claim.OPTIMAL if math.hypot(*target) > 1e-6 else Claim.FEASIBLE)
    assert answer.lower_bound <= answer.reference


@pytest.mark.parametrize("angle", [0.3, 2.0, 4.0])
@pytest.mark.parametrize("factor", [1.0, -1.0])
def test_on_a_circle_the_arc_is_proven(angle, factor):
    """Every word shares the one arc there, and LS and RL have double solutions."""
    answer = ask(math.sin(angle), factor * (1 - math.cos(angle)))

    assert answer.claim is Claim.OPTIMAL, answer.message
    # where solutions meet, lengths are known to the square root of rounding, in their difference
    assert answer.length == pytest.approx(angle, abs=1e-7)
    assert answer.lower_bound <= angle * (1 + 1e-15)


@pytest.mark.parametrize("angle", [0.3, 2.0])
def test_inside_a_circle_by_less_than_the_tolerance_nothing_is_proven(angle):
    """The shortest path is nearly a full turn longer than one that misses by 1e-10: no proof."""
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
    """Away from where words begin and end, the claim is the closed form's and the bound holds."""
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


@pytest.mark.parametrize("engine", INSTALLED)
@pytest.mark.parametrize("transformation", ["bigm", "hull"])
@pytest.mark.parametrize("target", [(3.0, 2.0), (0.3, 1.2)])
def test_every_engine_proves_the_disjunction(engine, transformation, target, capfd):
    """Outside and inside a disc, in silence; one program, whose run is the one that wins."""
    # MAiNGO closes no gap near its tolerance
    close = {"gap": 1e-4, "feastol": 1e-8 if engine == "maingo" else 1e-6}
    answer = ask(*target, engine=engine, transformation=transformation, **close)

    if "maximum is 200" in answer.message:  # rows and columns that the licence in a wheel allows
        assert (engine, transformation, answer.claim) == ("xpress", "hull", Claim.FAILED)
        return
    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert not answer.false_bound
    assert (answer.subproblems, answer.subproblem_runs) == ("all words", [1.0])
    assert answer.best_run_s == answer.subproblem_s[0] <= answer.solve_s
    assert capfd.readouterr() == ("", "")


def test_far_away_nothing_is_claimed_to_be_proven():
    """Here SCIP's bound is 2e-6 above the shortest length (`solvers.global_minlp.disjunctive`)."""
    answer = ask(25.422563016520616, -2538547.0079247607)

    assert answer.claim is Claim.FEASIBLE
    assert answer.lower_bound is None
    assert answer.verdict is Verdict.OPTIMAL


@pytest.mark.parametrize("branch", ["LS", "RS"])
def test_far_away_no_word_is_called_infeasible(branch):
    """Both reach a target 1.4e9 R away; SCIP's tolerances cannot tell."""
    answer = attempt(Disjunctive(), Question(Scenario(0, 0, 1, 1e9, -1e9, 1), branch))

    assert answer.claim is not Claim.INFEASIBLE
    assert not answer.false_claim


def test_the_time_limit_is_kept_and_said():
    """Stopped at once, SCIP has proven little, and what it has proven holds."""
    question = Question(PAPER["problem 3"])
    solver = Disjunctive()

    found = solver.solve(solver.build(question), 1e-6)

    assert found.claim is Claim.LIMIT
    assert found.native_status == "timelimit"
    assert 0 <= found.lower_bound <= shortest(question.scenario).total


@pytest.mark.slow
def test_soplex_writes_87_000_bytes_that_nobody_sees(capfd):
    """More than a pipe holds."""
    ask(0.3382875641532451, -0.058957228594529676)

    assert capfd.readouterr() == ("", "")


def test_the_error_output_is_the_callers_again(capfd):
    """After a solve, and where the caller has closed it."""
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
    """They come as bare exceptions; one that is not SCIP's is not swallowed."""
    model = Mock()
    monkeypatch.setattr(scip, "_translated", lambda program: (model, None))
    model.optimize.side_effect = Exception("SCIP: error in LP solver!")
    assert ask(3, 2).claim is Claim.FAILED
    assert "LP solver" in ask(3, 2).native_status
    assert model.optimize.call_count == 4  # each time with a looser tolerance too
    assert ask(3, 2).subproblem_runs == [2]
    model.optimize.side_effect = Exception("something else")
    assert "something else" in ask(3, 2).message


def test_ctrl_c_goes_through(monkeypatch):
    """SCIP catches the signal and stops, which is no time limit."""
    model = Mock(**{"getStatus.return_value": "userinterrupt"})
    monkeypatch.setattr(scip, "_translated", lambda program: (model, None))

    with pytest.raises(KeyboardInterrupt):
        ask(3, 2)


def test_the_second_run_gets_the_time_that_is_left(monkeypatch):
    """An infeasible word is asked again with a looser tolerance, within the one limit."""
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
    """Whatever the target: no claim above what the check finds, no bound above the optimum."""
    answer = attempt(Disjunctive(), Question(scenario))

    assert not answer.false_claim
    assert answer.verdict is Verdict.OPTIMAL
    assert answer.lower_bound <= shortest(scenario).total * scenario.radius
    if margin(scenario) > 1e-6:
        assert answer.claim is Claim.OPTIMAL


@pytest.mark.parametrize("final", [-2.0, 1.0, 3.0])
@pytest.mark.parametrize("target", [(5, 1), (1.5, -0.5), (0.2, 0.3)])
def test_a_final_heading_is_proven(target, final):
    """Of all six words, the ones of three arcs among them where the target is near."""
    answer = attempt(Disjunctive(), Question(Scenario(0, 0, 0.7, *target, 1, final_heading=final)))

    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert not answer.false_bound
    assert answer.lower_bound <= answer.reference_high


@pytest.mark.slow
@pytest.mark.parametrize("via", [(5, 0.5), (1.5, 0.5)])
def test_two_legs_are_proven(via):
    """It takes a hundred times as long as one leg."""
    scenario = Scenario(0, 0, 0, via[0] + 4, 3, 1, via=[via])
    answer = attempt(Disjunctive(gap=1e-4, feastol=1e-7), Question(scenario), 120.0)

    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert answer.lower_bound <= answer.reference_high


def test_a_route_out_of_time_claims_nothing_and_its_bound_holds():
    via = [(1.5, 0.5), (0.5, 3), (2, 4)]
    answer = attempt(Disjunctive(), Question(Scenario(0, 0, 0, 1, 2, 1, via=via)), 2.0)

    assert answer.claim in (Claim.LIMIT, Claim.OPTIMAL)
    assert not answer.false_claim
    assert not answer.false_bound

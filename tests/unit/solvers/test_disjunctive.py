"""disjunctive: the model, the point made to meet the target, and what is claimed of it."""

from __future__ import annotations

import math
import os
import time
from unittest.mock import Mock

import numpy as np
import pytest
from cases import PAPER, scenarios
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dubins_study.experiments.solve import solve
from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.engines import ENGINES, MINLP_ENGINES
from dubins_study.solvers.global_minlp.disjunctive import Disjunctive
from dubins_study.solvers.global_minlp.model import WORDS, gdp_model, transformed
from dubins_study.solvers.minlp_engines import scip
from dubins_study.solvers.minlp_engines.program import ProvenResult
from dubins_study.solvers.paper_nlp.polish import meet_target
from dubins_study.solvers.protocol import Question
from dubins_study.study.closed_form.shortest import margin, shortest
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import TURN, Claim, Verdict

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

# where SoPlex writes 87 000 bytes to the error output: more than a pipe holds
LOUD = (0.3382875641532451, -0.058957228594529676)


def ask(X, Y, branch="best", **changed):
    return attempt(Disjunctive(**changed), Question(Scenario(0, 0, 0, X, Y, 1), branch))


@settings(max_examples=40)
@given(st.sampled_from(WORDS), st.floats(0, 6.28), st.floats(0, 6.28))
def test_the_disjunct_of_a_word_holds_at_its_end(word, first, second):
    """Every constraint of the word, of its arcs' quadrants and of sine and cosine: zero residual.

    The end is that of the controls driven by `study.path`, which knows nothing of the model.
    """
    from pyomo.environ import Constraint, value

    end = Path((0, 0, 0), [TURN[c] for c in word], [first, second]).end
    m = gdp_model(end.x, end.y, (word,))
    letters = dict.fromkeys("LRS", 0.0) | dict(zip(word, (first, second), strict=True))
    m.z[3].set_value(letters["S"])
    blocks = [m.word[word]]
    for i, angle in ((1, letters["L"]), (2, letters["R"])):
        k, q = divmod(angle, math.pi / 2)
        values = {m.z: angle, m.q: q, m.cos_q: math.cos(q), m.sin_q: math.sin(q)}
        for variable, number in (values | {m.c: math.cos(angle), m.s: math.sin(angle)}).items():
            variable[i].set_value(number)
        blocks += [m.quadrant[i, int(k)]]
    constraints = [c for b in blocks for c in b.component_data_objects(Constraint)]
    constraints += [*m.cosine.values(), *m.sine.values()]

    assert len(constraints) == 3 + 2 * 3 + 4
    for constraint in constraints:
        # coordinates of up to 10 radii, each rounded a few times
        assert value(constraint.body) == pytest.approx(value(constraint.upper), abs=1e-14)


def test_the_model_of_all_words_transforms_into_linear_disjunctions():
    """Four words and four quadrants for each arc are binaries; only four equations are curved."""
    from pyomo.environ import Constraint, Var

    m = transformed(gdp_model(3, 2))
    binaries = [v for v in m.component_data_objects(Var, descend_into=True) if v.is_binary()]
    curved = [
        c
        for c in m.component_data_objects(Constraint, active=True, descend_into=True)
        if c.body.polynomial_degree() != 1
    ]

    assert len(binaries) == 4 + 2 * 4
    assert len(curved) == 4


def test_without_quadrants_the_arcs_have_the_sines():
    """The same lengths solve the model: 4 words, no quadrants, and the four curved equations."""
    from pyomo.environ import Constraint, value

    m = gdp_model(3, 2, quadrants=False)
    for i, angle in ((1, 0.7), (2, 5.0)):
        for variable, number in ((m.z, angle), (m.c, math.cos(angle)), (m.s, math.sin(angle))):
            variable[i].set_value(number)

    assert len(list(m.component_data_objects(Constraint))) == 4
    for constraint in (*m.cosine.values(), *m.sine.values()):
        assert value(constraint.body) == pytest.approx(0, abs=1e-15)
    assert not hasattr(m, "quadrant")
    answer = ask(3, 2, quadrants=False)
    assert (answer.claim, answer.verdict) == (Claim.OPTIMAL, Verdict.OPTIMAL)


@settings(max_examples=60)
@given(st.sampled_from(WORDS), st.floats(0.1, 6), st.floats(0.1, 6), st.integers(0, 3))
def test_a_point_near_a_path_is_led_onto_the_target(word, first, second, seed):
    """From 1e-6 off, as SCIP's default tolerance leaves it, to rounding, by about as much."""
    assume(word[1] == "S" or abs(second - math.pi) > 0.1)  # there the two solutions meet
    end = Path((0, 0, 0), [TURN[c] for c in word], [first, second]).end
    letters = dict.fromkeys("LRS", 0.0) | dict(zip(word, (first, second), strict=True))
    z = np.array([letters[c] for c in "LRS"])
    off = z + (z > 0) * np.random.default_rng(seed).uniform(-1e-6, 1e-6, 3)

    found, polished = meet_target(Scenario(0, 0, 0, *end[:2], 1), (word,), word, off)

    assert found == word
    assert polished.meets
    # the derivative's inverse is at most 1 / |cos(a2 / 2)| < 21 for two arcs, 1 / s <= 10 else
    assert abs(polished.z.sum() - z.sum()) < 21 * 2e-6


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("x", [-0.8, -0.4, 0.0, 0.4, 0.8])
@pytest.mark.parametrize("y", [-0.5, -0.2, 0.1, 0.3, 0.5])
def test_discs_are_proven(side, x, y):
    """On a grid in both discs, to the gap that the setting promises and as the closed form says."""
    answer = ask(x, side * (1 + y))

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


@pytest.mark.parametrize("problem", PAPER)
def test_settings_agree(problem):
    """Both transformations and every profile find the same path, and bounds on one side of it."""
    found = [
        solve(PAPER[problem], spec, profile=profile)
        for spec, profile in (
            ("disjunctive", "default"),
            ("disjunctive[transformation=hull]", "default"),
            ("disjunctive", "fast"),
            ("disjunctive", "accurate"),
        )
    ]

    for answer, gap in zip(found, (1e-6, 1e-6, 1e-4, 1e-7), strict=True):
        assert answer.claim is Claim.OPTIMAL
        assert answer.length == pytest.approx(answer.reference, rel=1e-12)
        assert 0 <= answer.reference - answer.lower_bound <= gap * answer.reference


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
def test_scip_is_silent(capfd):
    """Neither Pyomo nor SCIP nor its linear programs' solver write to the terminal."""
    ask(0.2, 1.3, feastol=1e-9)
    ask(*LOUD)

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

    monkeypatch.setattr(scip, "scip", lambda settings: engine)
    solver = Disjunctive()
    solver.solve(solver.build(Question(Scenario(0, 0, 0, 0, 1, 1), "LS")), 5.0)

    assert limits[0] == 5.0
    assert limits[1] <= 4.9


@pytest.mark.slow
@settings(max_examples=400)
@given(scenario=scenarios(far=1000.0))
def test_no_claim_is_false(scenario):
    """Whatever the target: no claim above what the check finds, no bound above the optimum."""
    answer = attempt(Disjunctive(), Question(scenario))

    assert not answer.false_claim
    assert answer.verdict is Verdict.OPTIMAL
    assert answer.lower_bound <= shortest(scenario).total * scenario.radius
    if margin(scenario) > 1e-6:
        assert answer.claim is Claim.OPTIMAL

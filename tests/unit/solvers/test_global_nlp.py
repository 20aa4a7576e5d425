"""global-nlp: what is handed to the engines, and what is claimed of all their answers together."""

from __future__ import annotations

import importlib
import math
import time
from unittest.mock import Mock

import numpy as np
import pytest
from cases import PAPER

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.engines import ENGINES, MINLP_ENGINES, Engine
from dubins_study.solvers.global_minlp.disjunctive import Disjunctive
from dubins_study.solvers.global_minlp.global_nlp import GlobalNlp
from dubins_study.solvers.minlp_engines.program import (
    MixedProgram,
    ProvenResult,
    Row,
    Settings,
    Written,
)
from dubins_study.solvers.protocol import Question
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Proof, Verdict

INSTALLED = [name for name in MINLP_ENGINES if ENGINES[name].unavailable() is None]


def ask(X, Y, branch="best", limit=20.0, **settings):
    question = Question(Scenario(0, 0, 0, X, Y, 1), branch)
    return attempt(GlobalNlp(**settings), question, limit)


@pytest.mark.parametrize("engine", INSTALLED)
@pytest.mark.parametrize("model", ["joint", "words"])
@pytest.mark.parametrize("target", [(3.0, 2.0), (-1.0, 2.5), (0.4, -1.9)])
def test_the_optimum_is_proven(engine, model, target):
    """Outside, behind and inside a disc: the closed form's length, and a bound up to it."""
    answer = ask(*target, engine=engine, model=model, gap=1e-4, feastol=1e-6)

    assert answer.claim is Claim.OPTIMAL, answer.message
    assert answer.verdict is Verdict.OPTIMAL
    assert answer.gap < 1e-12  # polished to rounding
    # above by the tolerance, times ten as an arc's end may move; below by the gap that was asked
    # for, and as much again: each engine has a formula of its own for it
    assert answer.reference * (1 - 2e-4) <= answer.lower_bound <= answer.reference + 1e-5
    names = "LRS RLS" if model == "joint" else "LS RS LR RL"
    assert answer.subproblems == names
    assert answer.best_run_s in answer.subproblem_s


@pytest.mark.parametrize("engine", [name for name in INSTALLED if name != "maingo"])
def test_a_limit_is_kept_and_claimed(engine):
    """0.02 s is less than any engine takes for both orders of this question at a gap of 1e-12."""
    solver = GlobalNlp(engine=engine, gap=1e-12, feastol=1e-9)
    assert solver.keeps_limit
    solver.build(Question(PAPER["problem 2"]))
    began = time.process_time()  # a busy machine takes the wall clock, not the processor
    answer = attempt(solver, Question(PAPER["problem 2"]), 0.02)

    assert time.process_time() - began < 1.5  # the limit, a second, and the library's first import
    assert answer.claim is Claim.LIMIT, answer.message
    assert not answer.false_claim


def test_one_order_alone_proves_nothing():
    """(4.12) has no RL: inside the left disc its optimum is longer, and no bound is passed on."""
    answer = ask(0.3, 1.2, order="LRS", feastol=1e-6)

    assert answer.claim is Claim.LOCAL
    assert answer.verdict is Verdict.LONGER
    assert answer.lower_bound is None
    assert answer.proof is not Proof.BOUNDED
    assert answer.formulation == "joint NLP, LRS"
    at_start = ask(0.0, 0.0, order="LRS")
    assert (at_start.claim, at_start.lower_bound) == (Claim.LOCAL, None)
    both = ask(0.0, 0.0)
    assert (both.claim, both.lower_bound) == (Claim.OPTIMAL, 0.0)


def test_a_raw_point_is_the_engines():
    """Without polish the path misses by up to the tolerance, and has the engine's length."""
    raw = ask(3.0, 2.0, polish=False, gap=1e-4, feastol=1e-6, engine="scip")
    polished = ask(3.0, 2.0, gap=1e-4, feastol=1e-6, engine="scip")

    assert 0 < raw.miss <= 2e-6
    # a length that the engine leaves below zero by its tolerance is not driven
    assert raw.length == pytest.approx(raw.claimed_length, abs=2e-6)
    assert polished.miss < 1e-14


@pytest.mark.parametrize("heading", ["expression", "variable"])
def test_both_ways_of_posing_the_heading_are_one_model(heading):
    answer = ask(0.4, -1.9, heading=heading, gap=1e-4, feastol=1e-6)

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
    """The least bound of the four words, if all have one; optimal only if all are solved."""
    left = iter(results)
    monkeypatch.setattr(Engine, "load", lambda engine: lambda settings: lambda *_: next(left))
    solver = GlobalNlp(model="words", polish=False)
    question = Question(Scenario(0, 0, 0, 3.0, 2.0, 10.0))
    solution = solver.solve(solver.build(question), 10.0)

    assert solution.claim is claim
    assert solution.lower_bound == (None if bound is None else 10.0 * bound)
    assert (solution.path is not None) == (results[0] is FOUND)
    assert ("licence expired" in solution.message) == any(one is BROKEN for one in results)


SETTINGS = Settings(1e-6, 1e-6)


def linear(n):
    """A linear program of n variables and n equations, whose optimum is n."""

    def write(x, functions):
        return Written(sum(x), [Row(variable, 1.0, 1.0) for variable in x])

    return MixedProgram(np.zeros(n), np.full(n, 2.0), np.zeros(n, bool), write)


@pytest.mark.parametrize("name", INSTALLED)
@pytest.mark.parametrize("lean", [False, True])
def test_a_program_with_binaries_and_curves(name, lean):
    """min x - b with x >= sin(2) b, b binary, x^2 + cos(x) <= 2: the bound meets the optimum.

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


@pytest.mark.parametrize("name", [name for name in ("gurobi", "xpress") if name in INSTALLED])
def test_a_program_too_large_for_the_licence_is_a_message(name):
    """The wheels' licences end at 2 000 (Gurobi) and 5 000 (Xpress) variables and constraints."""
    result = ENGINES[name].load()(SETTINGS)(linear(6000), 20.0)

    if result.claim is Claim.OPTIMAL:  # here is a licence without limits
        assert result.bound == pytest.approx(6000)
    else:
        assert result.claim is Claim.FAILED
        assert result.x is None
        assert any(words in result.message for words in ("size-limited license", "maximum is"))


@pytest.mark.parametrize(
    ("name", "starter", "error", "message"),
    [
        ("gurobi", "_environment", ("gurobipy", "GurobiError"), "License expired 2020-01-01"),
        ("xpress", "_start", ("xpress", "InterfaceError"), "Failed to initialise: no licence"),
    ],
)
def test_a_licence_that_has_expired_or_is_missing_is_a_message(
    name, starter, error, message, monkeypatch
):
    library, kind = pytest.importorskip(error[0]), error[1]
    module = importlib.import_module(f"dubins_study.solvers.minlp_engines.{name}")
    raised = getattr(library, kind)(*[10009] * (name == "gurobi"), message)
    monkeypatch.setattr(module, starter, Mock(side_effect=raised))
    result = ENGINES[name].load()(SETTINGS)(linear(2), 20.0)

    assert result.claim is Claim.FAILED
    assert message in result.message


@pytest.mark.parametrize("engine", INSTALLED)
@pytest.mark.parametrize("solver", [GlobalNlp, Disjunctive])
def test_a_word_without_a_path_is_called_infeasible(solver, engine):
    """No LS path ends inside the left disc: its own program says so."""
    question = Question(Scenario(0, 0, 0, 0.3, 1.2, 1), "LS")
    none = attempt(solver(engine=engine, feastol=1e-6), question, 20.0)

    assert none.claim is Claim.INFEASIBLE, none.message
    assert none.verdict is Verdict.NONE_EXISTS
    assert none.path is None

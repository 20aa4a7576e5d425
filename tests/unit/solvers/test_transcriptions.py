"""What the transcriptions share: where a search begins, what each subproblem cost, the claim."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from cases import EDGES, PAPER

from dubins_study.experiments.solve import solve
from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.optimal_control.arcs import Elements
from dubins_study.solvers.optimal_control.multiple_shooting import MultipleShooting
from dubins_study.solvers.optimal_control.transcription import Transcribed
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.study.words import Claim, Verdict

TRANSCRIPTIONS = ("collocation", "multiple-shooting", "turn-rates[n=20]")
PLACE = EDGES["many turns of heading"]


def kinds(spec: str, kind: str) -> str:
    """The spec with an initial guess."""
    name, _, rest = spec.partition("[")
    return f"{name}[{kind},{rest}" if rest else f"{name}[{kind}]"


@pytest.mark.parametrize("spec", [*TRANSCRIPTIONS, "turn-rate-qp"])
def test_efforts_add_up(spec):
    """All words are named; the runs' evaluations sum to the whole; one of them is the answer's."""
    answer = solve(PAPER["problem 2"], spec)

    assert set(answer.subproblems.split()) == {"LS", "RS", "LR", "RL"}
    assert sum(answer.subproblem_evaluations) == answer.evaluations
    assert all(runs >= 1 for runs in answer.subproblem_runs)
    assert 0 < answer.best_run_evaluations <= max(answer.subproblem_evaluations)
    assert 0 < answer.best_run_s <= sum(answer.subproblem_s) <= answer.solve_s


@pytest.mark.parametrize("spec", [*TRANSCRIPTIONS, "turn-rate-qp"])
def test_a_warm_path_is_a_subproblem_of_its_own(spec):
    """It goes first, and the row says warm; from its own answer an engine has little left to do."""
    cold = solve(PAPER["problem 2"], spec)

    answer = solve(PAPER["problem 2"], spec, initial_guess=cold.path)

    assert answer.subproblems.split()[0] == "warm"
    assert answer.guess == "warm"
    assert answer.length == pytest.approx(cold.length, rel=1e-6)
    assert answer.subproblem_evaluations[0] < cold.best_run_evaluations


@pytest.mark.parametrize("spec", TRANSCRIPTIONS)
def test_from_nothing(spec):
    """Zero is one run of no word; the answer is judged as any other."""
    answer = solve(PAPER["problem 3"], kinds(spec, "initial_guess=zero"))

    assert answer.subproblems == "zero"
    assert answer.subproblem_runs == [1]
    assert answer.guess == "zero"
    # problem 3 is solved from there by all of them (the path turns to the target's side)
    assert answer.claim is Claim.LOCAL


@pytest.mark.parametrize("spec", TRANSCRIPTIONS)
def test_from_random_points(spec):
    """So many runs as asked for; the same repeat draws the same points, another one others."""
    solver = load(kinds(spec, "initial_guess=random,count=3,seed=5"))

    first, again, other = (
        attempt(solver, Question(PLACE, "LS", repeat=repeat)) for repeat in (1, 1, 2)
    )

    assert first.subproblems == "random"
    assert first.subproblem_runs == [3]
    assert first.evaluations == again.evaluations
    assert first.path == again.path
    assert first.evaluations != other.evaluations


def test_given_guesses_are_the_only_ones():
    """Kind `given` tries the path alone; without one it is `bearing`."""
    path, spec = solve(PLACE, "analytic").path, "multiple-shooting[initial_guess=given]"

    assert solve(PLACE, spec, initial_guess=path).subproblems == "warm"
    assert set(solve(PLACE, spec).subproblems.split()) == {"LS", "RS", "LR", "RL"}


@pytest.mark.parametrize(
    ("claims", "branch", "expected"),
    [
        ([Claim.INFEASIBLE], "best", Claim.INFEASIBLE),
        ([Claim.INFEASIBLE], "LS", Claim.FAILED),  # rates of one sign reach every target
        ([Claim.INFEASIBLE, Claim.LIMIT], "best", Claim.FAILED),
        ([Claim.FEASIBLE], "best", Claim.FAILED),
        ([Claim.OPTIMAL], "best", Claim.FAILED),
    ],
)
def test_a_miss_is_no_solution_and_infeasible_only_if_all_runs_say_so(claims, branch, expected):
    """Whatever the engine says of straights that a correction cannot bring to the target."""
    solver = MultipleShooting()
    model = solver.build(Question(PLACE, branch))
    answers = iter(claims * 20)

    class Straight:
        shares = None

        def solve(self, guess, rates, course, until):
            native = EngineResult(np.zeros(1), next(answers), None, 1, 1, "", "")
            return Transcribed(Elements(np.zeros(3), np.zeros(3)), native)

    solution = solver.solve(model._replace(template=Straight()), 10.0)

    assert solution.claim is expected
    assert (solution.path is None) == (expected is Claim.INFEASIBLE)


def test_numbers_that_are_not_finite_are_a_failure():
    """An engine that returns NaN leaves no path."""
    solver = MultipleShooting()
    model = solver.build(Question(PLACE))
    model = model._replace(template=replace(model.template, engine=_broken))

    solution = solver.solve(model, 10.0)

    assert solution.claim is Claim.FAILED
    assert solution.path is None
    assert solution.claimed_length is None


def _broken(program, guess, seconds):
    return EngineResult(np.full(guess.size, math.nan), Claim.LOCAL, None, None, None, "", "no")


@pytest.mark.parametrize("engine", ["slsqp", "uno-filtersqp"])
def test_collocation_by_other_engines(engine):
    """Ipopt's answer, duals included, by an engine that sees equations with slacks only."""
    if load(f"collocation[engine={engine}]").unavailable() is not None:
        return
    spec = f"collocation[n=3,points=4,engine={engine}]"

    answer = solve(PAPER["problem 1"], spec, "RS")
    ipopt = solve(PAPER["problem 1"], "collocation[n=3,points=4]", "RS")

    assert answer.verdict is ipopt.verdict is Verdict.OPTIMAL
    assert answer.engine != "Ipopt"
    assert answer.length == pytest.approx(ipopt.length, rel=1e-7)
    assert answer.multiplier_x == pytest.approx(ipopt.multiplier_x, abs=1e-4)
    assert answer.multiplier_y == pytest.approx(ipopt.multiplier_y, abs=1e-4)

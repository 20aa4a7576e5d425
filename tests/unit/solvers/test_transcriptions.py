"""Shared parts of the transcriptions.

They are where a search begins, what each subproblem cost, and the claim.

The equations of multiple shooting beside an ODE integrator, and its engines.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dubins_study.asking.attempt import attempt
from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.solve import solve
from dubins_study.solvers.arcs import Elements
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES, Engine
from dubins_study.solvers.optimal_control.multiple_shooting import MultipleShooting, expressions
from dubins_study.solvers.optimal_control.transcription import Template, Transcribed
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.solvers.runs import EngineResult
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import Claim, Outcome, Verdict
from tests.brute_force import integrated
from tests.cases import EDGES, PAPER, engine_params

TRANSCRIPTIONS = ("collocation", "multiple-shooting", "turn-rates[n=20]")
PLACE = EDGES["many turns of heading"]


@pytest.mark.many(2)
@pytest.mark.parametrize("spec", [*TRANSCRIPTIONS, "turn-rate-qp"])
def test_efforts_add_up(spec):
    """Efforts add up.

    All words are named; the runs' evaluations sum to the whole; one of them is the answer's.
    """
    answer = solve(PAPER["problem 2"], spec)

    assert set(answer.subproblems.split()) == {"LS", "RS", "LR", "RL"}
    assert sum(answer.subproblem_evaluations) == answer.evaluations
    assert all(runs >= 1 for runs in answer.subproblem_runs)
    assert 0 < answer.best_run_evaluations <= max(answer.subproblem_evaluations)
    assert 0 < answer.best_run_s <= sum(answer.subproblem_s) <= answer.solve_s


@pytest.mark.many(1)
@pytest.mark.parametrize("spec", [*TRANSCRIPTIONS, "turn-rate-qp"])
def test_a_warm_path_is_a_subproblem_of_its_own(spec):
    """A warm path is a subproblem of its own.

    It goes first, and the row says warm; from its own answer an engine has little left to do.
    """
    cold = solve(PAPER["problem 2"], spec)

    answer = solve(PAPER["problem 2"], spec, initial_guess=cold.path)

    assert answer.subproblems.split()[0] == "warm"
    assert answer.guess == "warm"
    assert answer.length == pytest.approx(cold.length, rel=1e-6)
    assert answer.subproblem_evaluations[0] < cold.best_run_evaluations


NUMBERS = st.floats(0, 4) | st.sampled_from([1e-12, 1e6])


@settings(max_examples=15)
@given(
    arcs=st.lists(st.tuples(st.floats(-3, 3), NUMBERS), max_size=5),
    spec=st.sampled_from(["multiple-shooting", "collocation", "turn-rates", "turn-rate-qp"]),
    via=st.sampled_from([(), ((4.0, 1.0),)]),
)
def test_any_path_is_a_guess(arcs, spec, via):
    """Any path is a guess.

    It may be of no arcs, of no length, of another radius, or long: nothing is raised.
    """
    guess = Path(Pose(0, 0, 0), [rate for rate, _ in arcs], [length for _, length in arcs])
    scenario = Scenario(target_x=8.0, target_y=0.0, via=via)

    answer = attempt(load(spec), Question(scenario, initial_guess=guess), 5.0)

    assert answer.outcome is Outcome.RETURNED, answer.message


UNDRIVABLE = {
    "infinite": ([0.0], [math.inf]),
    "nan rate": ([math.nan], [1.0]),
    "nan length": ([0.0, 1.0], [math.nan, 2.0]),
    "negative": ([1.0], [-1.0]),
    "longer than doubles place": ([1.0], [1e308]),
    "turned more than doubles hold": ([1e308], [1.0]),
}
LEG = Scenario(heading=0.4, target_x=8.0, target_y=3.0, radius=2.0)
POSED = Scenario(target_x=8.0, target_y=0.0, final_heading=1.0)
WARM = {
    "multiple-shooting": POSED,
    "collocation": POSED,
    "turn-rates": LEG,
    "turn-rate-qp": LEG,
    "slsqp": LEG,
    "shooting": LEG,
}


@pytest.mark.many(2)
@pytest.mark.parametrize("spec", WARM)
@pytest.mark.parametrize("arcs", UNDRIVABLE)
def test_a_path_that_nobody_can_drive_is_no_guess(arcs, spec):
    """A path that cannot be driven is no guess.

    In a run a solver begins cold; `solve` says what was expected.
    """
    guess = Path(Pose(0, 0, 0), *UNDRIVABLE[arcs])
    cold, warm = (
        attempt(load(spec), Question(WARM[spec], initial_guess=given), 5.0)
        for given in (None, guess)
    )

    assert warm.outcome is Outcome.RETURNED
    assert warm.length == cold.length

    with pytest.raises(DubinsStudyError, match=r"cannot be driven; expected finite numbers"):
        solve(WARM[spec], spec, initial_guess=guess)


def test_a_guess_is_refused_where_none_is_used():
    with pytest.raises(DubinsStudyError, match="'analytic' takes no initial_guess; expected None"):
        solve(PAPER["problem 1"], "analytic", initial_guess=Path(Pose(0, 0, 0), [], []))


@pytest.mark.parametrize("spec", ["collocation[", "multiple-shooting[", "turn-rates[n=20,"])
@pytest.mark.parametrize(("guess", "runs"), [("zero", 1), ("random,count=3,seed=5", 3)])
def test_from_nothing(spec, guess, runs):
    """Guesses from nothing.

    Zero is one run of no word, random as many as asked for; judged as any other.

    Problem 3 is solved from there by all of them (the path turns to the target's side).
    """
    answer = solve(PAPER["problem 3"], f"{spec}initial_guess={guess}]")

    assert answer.subproblems == guess.partition(",")[0]
    assert answer.subproblem_runs == [runs]
    assert answer.claim is Claim.LOCAL


def test_given_guesses_are_the_only_ones():
    """Given guesses are the only ones.

    Kind `given` tries the path alone; without one it is `bearing`.
    """
    path = solve(PLACE, "analytic").path
    spec = "multiple-shooting[initial_guess=given]"

    assert solve(PLACE, spec, initial_guess=path).subproblems == "warm"
    assert set(solve(PLACE, spec).subproblems.split()) == {"LS", "RS", "LR", "RL"}


@pytest.mark.parametrize(
    ("claims", "branch", "expected"),
    [
        ([Claim.LOCALLY_INFEASIBLE], "best", Claim.LOCALLY_INFEASIBLE),
        ([Claim.LOCALLY_INFEASIBLE, Claim.LIMIT], "best", Claim.FAILED),
        ([Claim.INFEASIBLE], "best", Claim.FAILED),  # of a transcription, not of the problem
        ([Claim.FEASIBLE], "best", Claim.FAILED),
        ([Claim.OPTIMAL], "best", Claim.FAILED),
    ],
)
def test_a_miss_is_no_solution_and_infeasible_only_if_all_runs_say_so(claims, branch, expected):
    """A miss is no solution.

    The word is infeasible only if all runs say so, whatever the engine says of straights that a
    correction cannot bring to the target.
    """
    solver = MultipleShooting()
    model = solver.build(Question(PLACE, branch))
    answers = iter(claims * 20)

    def straight(guess, rates, until):
        native = EngineResult(np.zeros(1), next(answers), None, 1, 1, "", "")
        return Transcribed(Elements(np.zeros(3), np.zeros(3)), native)

    solution = solver.solve(model._replace(template=Template(None, straight)), 10.0)

    assert solution.claim is expected
    assert (solution.path is None) == (expected is Claim.LOCALLY_INFEASIBLE)


def test_numbers_that_are_not_finite_are_a_failure(monkeypatch):
    """An engine that returns NaN leaves no path."""
    monkeypatch.setattr(Engine, "load", lambda engine: lambda *settings: _broken)
    solver = MultipleShooting()

    solution = solver.solve(solver.build(Question(PLACE)), 10.0)

    assert solution.claim is Claim.FAILED
    assert solution.path is None
    assert solution.claimed_length is None


def _broken(program, guess, seconds):
    return EngineResult(np.full(guess.size, math.nan), Claim.LOCAL, None, None, None, "", "no")


@given(st.integers(1, 5), st.integers(0, 10_000), st.booleans())
@settings(max_examples=30, deadline=None)
def test_equations_are_the_gaps_between_driven_segments(n, seed, equal):
    """An adaptive integrator drives every segment."""
    random = np.random.default_rng(seed)
    controls = random.uniform(0, 1, (n, 3))
    left, right, straight = controls.T
    starts = np.vstack((np.zeros(3), random.normal(size=(n - 1, 3))))
    target = random.normal(size=2)
    program = expressions(n, (1, -1), equal, 1, 0)
    x = np.hstack((starts, controls)).ravel()[3:]

    gaps = program.functions(target).equations(x)

    length = left + right + straight
    turn = left - right
    ends = np.array([arc_end(*state) for state in zip(starts, turn, length, strict=True)])
    expected = []
    for k in range(n):
        if k < n - 1:
            expected += list(starts[k + 1] - ends[k])
        if equal and k > 0:
            expected.append(length[k] - length[k - 1])
    assert gaps == pytest.approx([*expected, *(target - ends[-1, :2])], abs=1e-10)
    assert program.functions(target).objective(x) == pytest.approx(length.sum())


def arc_end(pose, turn, length):
    """The pose at the end of an arc.

    An adaptive integrator computes it.
    """
    return integrated(Path(Pose(*pose), [turn / length], [length]))


# Engines that may end without a solution of three segments, and why: two build models from values
# alone and stop at the limit; L-BFGS within the augmented Lagrangian gives up at its rounding.
MAY_FAIL = {"cobyqa", "nlopt-cobyla", "nlopt-auglag"}
ENGINE_LIMIT_S = 3.0  # the others take a few hundredths


@pytest.mark.parametrize("engine", engine_params(name for name in NLP_ENGINES if name != "sleqp"))
def test_every_engine_of_the_table(engine):
    """Every engine of the table.

    It has a solution of problem 1, or at least no false claim; a missing engine has a reason.
    """
    solver = MultipleShooting(n=3, engine=engine, max_iter=100)
    if (reason := solver.unavailable()) is not None:
        assert reason.strip()
        return

    answer = attempt(solver, Question(PAPER["problem 1"], "RS"), ENGINE_LIMIT_S)

    assert answer.outcome is Outcome.RETURNED, answer.message
    assert answer.engine == ENGINES[engine].label
    assert not answer.false_claim
    if answer.claim is Claim.LOCAL:
        assert answer.verdict is Verdict.OPTIMAL
    else:
        assert engine in MAY_FAIL, (answer.claim, answer.message)

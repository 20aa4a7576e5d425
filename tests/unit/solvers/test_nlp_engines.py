"""Every engine of nonlinear programs on the words of (4.12), SciPy's and casadi's in particular."""

from __future__ import annotations

import importlib.util
import math
import time

import numpy as np
import pytest
from cases import PAPER
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.solvers.course import FULL_TURN
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES
from dubins_study.solvers.nlp_engines import casadi_nlpsol
from dubins_study.solvers.nlp_engines.program import EngineResult
from dubins_study.solvers.paper_nlp.local_nlp import Case
from dubins_study.solvers.paper_nlp.model import SUBPROBLEMS, target
from dubins_study.solvers.paper_nlp.nlp import Nlp
from dubins_study.solvers.paper_nlp.program import expressions, program, solve
from dubins_study.solvers.registry import entries, load
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim

# Its library breaks others in the same process: tests/processes asks it in one of its own.
ALONE = ("sleqp",)
AVAILABLE = [
    name for name in NLP_ENGINES if name not in ALONE and ENGINES[name].unavailable() is None
]
TOLERANCE = 1e-9  # the default of `nlp`

# Problem 1's RS, from a guess as rough as `bearing`.
WORD = (0.0, 1.5, 11.0)

# Engines that reach the solution and do not call it one: fatrop ends after 20 iterations that
# change nothing, with status 1; the augmented Lagrangian of NLopt with FAILURE.
SILENT_ON_WORDS = {"fatrop", "nlopt-auglag"}
# Engines with a test for it whose claim no other test sees.
SAY_INFEASIBLE = {"uno-filtersqp", "apopt"}


def case(name: str, scenario: Scenario, unit: float = 1.0) -> Case:
    subproblem = SUBPROBLEMS[name]
    upper = np.where(subproblem.mask, (FULL_TURN, FULL_TURN, math.inf), 0.0)
    return Case(subproblem, upper, target(scenario, subproblem.mirrored), unit)


def run(name: str, word: str, scenario: Scenario, guess: tuple[float, ...]) -> EngineResult:
    engine = ENGINES[name].load()(TOLERANCE, 200)
    return solve(case(word, scenario), np.array(guess), 20.0, engine)


def first_word() -> tuple[float, float]:
    """The arc and the straight of problem 1's RS, radii."""
    answer = shortest(PAPER["problem 1"], "RS")
    assert answer is not None
    return tuple(answer.segments)


lengths = st.tuples(st.floats(0, 6), st.floats(0, 6), st.floats(0, 20)).map(np.array)
weights = st.tuples(st.floats(-3, 3), st.floats(-3, 3)).map(np.array)


@given(
    name=st.sampled_from(sorted(SUBPROBLEMS)),
    unit=st.sampled_from([1.0, 2.5]),
    **{"z": lengths, "weights": weights, "X": st.floats(-9, 9), "Y": st.floats(-9, 9)},
)
def test_the_written_functions_are_those_of_the_expressions(name, unit, z, weights, X, Y):
    """By hand and by casadi's derivatives, in radii and in another unit."""
    given_case = case(name, Scenario(0, 0, 0, X, Y, 1), unit)
    posed = program(given_case)
    x = unit * z[list(given_case.subproblem.free)]
    assert posed.written is not None
    derived = posed.expressions.functions(posed.p)

    assert posed.written.objective(x) == pytest.approx(derived.objective(x), rel=1e-15)
    for one, other in zip(posed.written[1:4], derived[1:4], strict=True):
        np.testing.assert_allclose(one(x), other(x), atol=1e-12 * (1 + z[2]))
    np.testing.assert_allclose(
        posed.written.hessian(x, weights), derived.hessian(x, weights), atol=1e-12 * (1 + z[2])
    )


def test_one_set_of_free_lengths_has_one_set_of_expressions():
    """So that an engine compiles it once, for every target and either order of turns."""
    near, far = Scenario(0, 0, 0, 1, 3, 1), Scenario(0, 0, 0, -9, 3, 1)

    assert program(case("LR", near)).expressions is program(case("RL", far)).expressions
    assert program(case("LS", near)).expressions is not program(case("RS", near)).expressions
    assert expressions((0, 2)) is not expressions((0, 2), scaled=True)


@pytest.mark.parametrize("name", [name for name in AVAILABLE if name != "cobyqa"])
def test_a_word_is_solved(name):
    """Problem 1's RS, to the tolerance that was asked for (in the objective, half its digits)."""
    point = run(name, "RS", PAPER["problem 1"], WORD)

    assert point.claim is (Claim.FAILED if name in SILENT_ON_WORDS else Claim.LOCAL)
    assert point.x[1:] == pytest.approx(first_word(), abs=1e-6)
    assert point.x[0] == 0
    if point.duals is not None:
        # the path ends straight, so that the duals are the direction of its end
        heading = -point.x[1]
        direction = math.cos(heading), math.sin(heading)
        assert point.duals[:2] == pytest.approx(direction, abs=1e-5)


@pytest.mark.parametrize("name", AVAILABLE)
def test_a_word_without_a_path_is_not_claimed(name):
    """LS to a target inside the left disc: its last point is no solution, whatever it says."""
    point = run(name, "LS", Scenario(0, 0, 0, 0.2, 1.0, 1), (1.0, 0.0, 0.5))

    assert point.claim is not Claim.LOCAL
    if name in SAY_INFEASIBLE:
        assert point.claim is Claim.INFEASIBLE


@pytest.mark.parametrize("name", [n for n in AVAILABLE if ENGINES[n].keeps_limit])
def test_without_time_a_run_ends(name):
    """At most a second late, on a program that would take some engines longer than that."""
    engine, guess = ENGINES[name].load()(1e-14, 10**6), np.array((3.0, 3.0, 1.0))
    solve(case("RS", PAPER["problem 1"]), np.array(WORD), 1e-3, engine)  # loads the library
    began = time.process_time()  # a busy machine takes the wall clock, not the processor

    solve(case("LRS", Scenario(0, 0, 0, 0.2, 1.0, 1)), guess, 1e-3, engine)

    assert time.process_time() - began < 1e-3 + 1.0


# What each says of the joint model from zero, where the two gradients are parallel; measured with
# the versions of the lock. Not of trust-constr, where rounding decides.
FROM_ZERO = {
    "slsqp": Claim.FAILED,
    "cobyqa": Claim.LOCAL,
    "ipopt": Claim.INFEASIBLE,
    "uno": Claim.INFEASIBLE,
    "fatrop": Claim.FAILED,
    "alpaqa": Claim.LIMIT,
    "bonmin": Claim.INFEASIBLE,
    "sqpmethod": Claim.FAILED,
    "qrsqp": Claim.FAILED,
}


@pytest.mark.parametrize("name", FROM_ZERO)
def test_what_an_engine_says_from_zero(name):
    """A path exists, so that "infeasible" is false: a finding, which no option hides."""
    point = run(name, "LRS", PAPER["problem 1"], (0.0, 0.0, 0.0))

    assert point.claim is FROM_ZERO[name]


@pytest.mark.parametrize(
    ("plugin", "status", "unified", "claim"),
    [
        ("ipopt", "Restoration_Failed", "UNKNOWN", Claim.FAILED),
        ("uno", "Terminated with not optimal point", "LIMITED", Claim.LIMIT),
        ("uno", "Terminated with unbounded problem", "UNKNOWN", Claim.FAILED),
        ("fatrop", "0", "SUCCESS", Claim.LOCAL),
        ("sleqp", "iteration limit", "SUCCESS", Claim.LIMIT),
        ("sleqp", "optimal", "SUCCESS", Claim.LOCAL),
        # casadi calls it a success; SLEQP itself calls it an abort
        ("sleqp", "deadpoint", "SUCCESS", Claim.FAILED),
        ("sqpmethod", "Maximum_Iterations_Exceeded", "LIMITED", Claim.LIMIT),
        ("qrsqp", "Search_Direction_Becomes_Too_Small", "UNKNOWN", Claim.FAILED),
    ],
)
def test_statuses_become_claims(plugin, status, unified, claim):
    stats = {"return_status": status, "unified_return_status": f"SOLVER_RET_{unified}"}

    assert casadi_nlpsol.claim_of(plugin, stats) is claim


def test_cobyqa_solves_most_words_and_claims_no_other():
    """Its trust region may shrink to nothing before the equations hold, which it says itself."""
    bearings = np.linspace(-3, 3, 8)
    solved = 0
    for bearing in bearings:
        X, Y = 10 * math.cos(bearing), 10 * math.sin(bearing)
        scenario = Scenario(0, 0, 0, X, Y, 1)
        guess = (bearing + 0.1) % FULL_TURN, 0.0, 10.5
        point = run("cobyqa", "LS", scenario, guess)
        answer = shortest(scenario, "LS")
        assert answer is not None
        if point.claim is Claim.LOCAL:
            assert point.x[[0, 2]] == pytest.approx(tuple(answer.segments), abs=1e-6)
            solved += 1

    assert solved >= bearings.size / 2


def test_a_tolerance_is_no_less_than_the_equations_rounding():
    """At 10^5 radii rounding leaves more of the equations than a tolerance of 1e-14 allows."""
    far = case("LS", Scenario(0, 0, 0, 3e4, 9e4, 1))

    point = solve(far, np.array((1.2, 0.0, 9e4)), 5.0, ENGINES["slsqp"].load()(1e-14))

    assert point.claim is Claim.LOCAL


@pytest.mark.parametrize("name", NLP_ENGINES)
def test_every_engine_is_a_setting_of_nlp(name):
    solver = load(f"nlp[engine={name}]")

    assert solver.method[:2] == ("one NLP a word", ENGINES[name].label)
    assert solver.runs is None
    assert solver.unavailable() == ENGINES[name].unavailable()
    assert set(ENGINES[name].packages) <= set(Nlp.packages)


def test_the_list_has_a_line_for_every_engine():
    engines = {(entry.formulation, entry.engine) for entry in entries()}

    assert {("one NLP a word", ENGINES[name].label) for name in NLP_ENGINES} <= engines
    assert ("one NLP a word", "KNITRO") in engines
    # the paper's own solver has a line beside `nlp`, with the reason for its absence
    lines = {entry.name: entry.reason for entry in entries()}
    assert lines["nlp"] is None
    assert lines["nlp[engine=knitro]"] == Nlp(engine="knitro").unavailable()


@pytest.mark.parametrize("name", ENGINES)
def test_a_missing_package_is_a_reason(name, monkeypatch):
    absent, find = ENGINES[name].packages[-1], importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda package: None if package == absent else find(package)
    )

    assert ENGINES[name].unavailable() == f"the package {absent} is not installed"

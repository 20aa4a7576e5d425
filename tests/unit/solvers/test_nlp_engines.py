"""Every engine of nonlinear programs on words.

The words are those of (4.12); SciPy's and casadi's engines are tested in particular.

casadi's expressions carried out with other operands.
"""

import importlib.util
import math
import time

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.solvers.engines import ENGINES, NLP_ENGINES, names
from dubins_study.solvers.nlp_engines.expressions import algebra_text
from dubins_study.solvers.nlp_engines.program import Expressions, Program
from dubins_study.solvers.one_leg.model import SUBPROBLEMS, Case, case_of
from dubins_study.solvers.paper_nlp.case_program import program, solve
from dubins_study.solvers.registry import entries, load
from dubins_study.solvers.runs import EngineResult
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import DERIVATIVE_FREE, SAMPLING, Claim
from tests.cases import PAPER

# Its library breaks others in the same process: tests/processes asks it in one of its own.
ALONE = ("sleqp",)
AVAILABLE = [
    name for name in NLP_ENGINES if name not in ALONE and ENGINES[name].unavailable() is None
]
TOLERANCE = 1e-9  # the default of `nlp`

LISTED = {(entry.formulation, entry.engine, entry.reason) for entry in entries()}

# Problem 1's RS, from a guess as rough as `bearing`.
WORD = (0.0, 1.5, 11.0)

# Engines that reach the solution and do not call it one: fatrop ends after 20 iterations that
# change nothing, with status 1; the augmented Lagrangian of NLopt with FAILURE.
SILENT_ON_WORDS = {"fatrop", "nlopt-auglag"}
# Engines with a test for it whose claim no other test sees, and those without any.
SAY_INFEASIBLE = {"uno-filtersqp", "apopt"}
NEVER_SAY_INFEASIBLE = {"trust-constr", "slsqp", "cobyqa"}


def case(name: str, scenario: Scenario) -> Case:
    return case_of(name, local(scenario))


def run(name: str, word: str, scenario: Scenario, guess: tuple[float, ...]) -> EngineResult:
    engine = ENGINES[name].load()(TOLERANCE, 200)
    return solve(case(word, scenario), np.array(guess), 20.0, engine)


def first_word() -> tuple[float, float]:
    """Arc and straight (radii) of problem 1's RS."""
    answer = shortest(PAPER["problem 1"], "RS")
    assert answer is not None
    return tuple(answer.segments)


lengths = st.tuples(st.floats(0, 6), st.floats(0, 6), st.floats(0, 20)).map(np.array)
weights = st.tuples(st.floats(-3, 3), st.floats(-3, 3)).map(np.array)


@given(
    name=st.sampled_from(sorted(SUBPROBLEMS)),
    **{"z": lengths, "weights": weights, "X": st.floats(-9, 9), "Y": st.floats(-9, 9)},
)
def test_the_written_functions_are_those_of_the_expressions(name, z, weights, X, Y):
    """Written functions are those of the expressions.

    They are compared by hand and by casadi's derivatives.
    """
    given_case = case(name, Scenario(0, 0, 0, X, Y, 1))
    posed = program(given_case)
    x = z[list(given_case.subproblem.free)]
    assert posed.written is not None
    derived = posed.expressions.functions(posed.p)

    assert posed.written.objective(x) == pytest.approx(derived.objective(x), rel=1e-15)
    for one, other in zip(posed.written[1:4], derived[1:4], strict=True):
        np.testing.assert_allclose(one(x), other(x), atol=1e-12 * (1 + z[2]))
    np.testing.assert_allclose(
        posed.written.hessian(x, weights), derived.hessian(x, weights), atol=1e-12 * (1 + z[2])
    )


@pytest.mark.parametrize("name", [name for name in AVAILABLE if name != "cobyqa"])
def test_a_word_is_solved(name):
    """A word is solved.

    It is problem 1's RS, to the tolerance that was asked for (in the objective, half its digits).
    """
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
    """A word without a path is not claimed.

    LS goes to a target inside the left disc: its last point is no solution, whatever the engine
    says.
    """
    point = run(name, "LS", Scenario(0, 0, 0, 0.2, 1.0, 1), (1.0, 0.0, 0.5))

    assert point.claim is not Claim.LOCAL
    if name in SAY_INFEASIBLE:
        assert point.claim is Claim.LOCALLY_INFEASIBLE
    if name in NEVER_SAY_INFEASIBLE:
        assert point.claim is not Claim.LOCALLY_INFEASIBLE


@pytest.mark.parametrize("name", [n for n in AVAILABLE if ENGINES[n].keeps_limit])
def test_without_time_a_run_ends(name):
    """Without time a run ends.

    It ends at most a second late, on a program that would take some engines longer than that.
    """
    engine = ENGINES[name].load()(1e-14, 10**6)
    guess = np.array((3.0, 3.0, 1.0))
    solve(case("RS", PAPER["problem 1"]), np.array(WORD), 1e-3, engine)  # loads the library
    began = time.process_time()  # a busy machine takes the wall clock, not the processor

    solve(case("LRS", Scenario(0, 0, 0, 0.2, 1.0, 1)), guess, 1e-3, engine)

    assert time.process_time() - began < 1e-3 + 1.0


# What each says of the joint model from zero, where the two gradients are parallel; measured with
# the versions of the lock. Not of trust-constr, where rounding decides.
FROM_ZERO = {
    "slsqp": Claim.FAILED,
    "cobyqa": Claim.LOCAL,
    "ipopt": Claim.LOCALLY_INFEASIBLE,
    "uno": Claim.LOCALLY_INFEASIBLE,
    "fatrop": Claim.FAILED,
    "alpaqa": Claim.LIMIT,
    "bonmin": Claim.LOCALLY_INFEASIBLE,
    "sqpmethod": Claim.FAILED,
    "qrsqp": Claim.FAILED,
}


@pytest.mark.parametrize("name", FROM_ZERO)
def test_what_an_engine_says_from_zero(name):
    """An engine's claim from zero.

    A path exists, which a local engine denies: a finding, which no option hides.
    """
    point = run(name, "LRS", PAPER["problem 1"], (0.0, 0.0, 0.0))

    assert point.claim is FROM_ZERO[name]


def test_a_tolerance_is_no_less_than_the_equations_rounding():
    """A tolerance is no less than equations' rounding.

    At 10^5 radii rounding leaves more of the equations than a tolerance of 1e-14 allows.
    """
    far = case("LS", Scenario(0, 0, 0, 3e4, 9e4, 1))

    point = solve(far, np.array((1.2, 0.0, 9e4)), 5.0, ENGINES["slsqp"].load()(1e-14))

    assert point.claim is Claim.LOCAL


@pytest.mark.parametrize(
    ("spec", "formulation", "name"),
    [
        *((f"nlp[engine={name}]", "one NLP a word", name) for name in (*NLP_ENGINES, "knitro")),
        *(
            (f"penalty[engine={name}]", "penalty", name)
            for name in names(SAMPLING, DERIVATIVE_FREE)
        ),
    ],
)
def test_every_engine_is_a_setting_and_has_a_line_in_the_list(spec, formulation, name):
    """Every engine is a setting and is listed.

    The list has the reason for its absence, if there is one.
    """
    solver = load(spec)
    engine = ENGINES[name]

    assert solver.method[:2] == (formulation, engine.label)
    assert solver.runs is None
    assert solver.unavailable() == engine.unavailable()
    assert set(engine.packages) <= set(solver.packages)
    assert (formulation, engine.label, engine.unavailable()) in LISTED


@pytest.mark.parametrize("name", ENGINES)
def test_a_missing_package_is_a_reason(name, monkeypatch):
    absent = ENGINES[name].packages[-1]
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda package: None if package == absent else find(package)
    )

    assert ENGINES[name].unavailable() == f"the package {absent} is not installed"


def every_operation(p=(0.7, 1.3)):
    """A program with every operation of the walk.

    It has three variables.
    """
    x = casadi.SX.sym("x", 3)
    q = casadi.SX.sym("q", 2)
    f = x[0] + 2 * x[1] + x[2] ** 2 + casadi.sqrt(x[0]) - casadi.exp(-x[1]) / x[2]
    turn = casadi.sin(x[0] - x[1]) * q[0] - casadi.cos(x[0]) * casadi.sin(q[1])
    powers = x[1] ** 1.5 + casadi.log(x[2]) + 1 / x[0] + x[0] ** x[2]
    inverse = casadi.atan(x[1]) + casadi.tan(q[0]) - casadi.asin(0.1 * x[2]) * casadi.acos(0.5)
    g = casadi.vertcat(turn, casadi.SX(0), powers, inverse)
    return Program(Expressions(x, q, f, g), np.array(p), np.full(3, 0.1), np.full(3, 5.0))


@pytest.mark.parametrize("weight", [0.0, 0.5, 1.0])
def test_the_objective_has_its_weight_in_the_hessian(weight):
    """The objective has its weight in the Hessian.

    Central differences are the comparison; Uno gives it the weight 0 to look for a feasible point.
    """
    posed = every_operation()
    h = 1e-6
    functions = posed.functions
    entries = functions.entries
    x = np.array((0.4, 1.1, 2.3))
    weights = np.array((0.3, -2.0, 1.5, 0.7))
    lower = np.zeros((3, 3))

    def slope(x):
        return weight * functions.gradient(x) + weights @ functions.jacobian(x)

    bend = [(slope(x + step) - slope(x - step)) / (2 * h) for step in h * np.eye(3)]
    lower[tuple(entries.hessian_at)] = entries.hessian(x, weight, weights)

    np.testing.assert_allclose(lower, np.tril(bend), atol=1e-6)


def test_an_operation_that_is_not_known_is_named():
    x = casadi.SX.sym("x")
    bound = np.ones(1)
    expressions = Expressions(x, casadi.SX.sym("p", 0), casadi.floor(x), x)

    with pytest.raises(KeyError, match="OP_FLOOR"):
        algebra_text(Program(expressions, np.zeros(0), -bound, bound))

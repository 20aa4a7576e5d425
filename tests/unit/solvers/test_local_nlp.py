"""slsqp and ipopt on the paper's model.

Tested are derivatives, the joint model's minima and bias, and guesses.

Guesses are a factor of their own: equal for two formulations, blind, and named in the row.
"""

import math
from importlib.util import find_spec

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.experiments.solve import solve
from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.one_leg.initial_guesses import INITIAL_GUESSES, initial_guesses
from dubins_study.solvers.one_leg.model import SUBPROBLEMS, Case, as_path, case_of, equations
from dubins_study.solvers.paper_nlp.nlp import Nlp
from dubins_study.solvers.paper_nlp.pyomo_model import solve_in_pyomo
from dubins_study.solvers.protocol import Method, Question
from dubins_study.solvers.registry import load, stated_method
from dubins_study.study.body_coordinates import local
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome, Verdict
from tests.cases import PAPER, scenarios

lengths = st.tuples(st.floats(0, 6), st.floats(0, 6), st.floats(0, 20)).map(np.array)
NLP = ("slsqp", "ipopt")


@given(lengths, st.sampled_from(sorted(SUBPROBLEMS)), scenarios())
def test_the_equations_are_those_of_the_path(z, name, scenario):
    """The equations are those of the path.

    (4.10) and (4.11) vanish exactly where the path's controls lead: paper against rollout.
    """
    subproblem = SUBPROBLEMS[name]
    z = np.where(np.isin(np.arange(3), subproblem.free), z, 0.0)
    end = as_path(scenario, subproblem, z).end
    moved = Scenario(*scenario.start, end.x, end.y, scenario.radius)

    X, Y, _ = case_of(name, local(moved)).target
    residual = equations(z, X, Y)

    # coordinates lie up to 100 radii from the origin, so they carry errors of 1e-14 radii
    np.testing.assert_allclose(residual, 0, atol=1e-11)


@pytest.mark.parametrize("spec", ["ipopt", "nlp[engine=ipopt]"])
@pytest.mark.parametrize(
    ("branch", "target"), [("LS", (0.3, 0.8)), ("RS", (0.3, -0.8)), ("LR", (9, 2)), ("RL", (9, -2))]
)
def test_ipopt_recognises_a_word_that_does_not_exist(spec, branch, target, capfd):
    """Ipopt recognises a word that does not exist.

    It is infeasible by theory, and Ipopt says so: a success. Nothing of the way there is printed.
    """
    answer = solve(Scenario(0, 0, 0, *target, 1), spec, branch, isolated=False)

    assert answer.claim is Claim.LOCALLY_INFEASIBLE
    assert answer.violation_slope < 1e-5
    assert answer.verdict is Verdict.NONE_EXISTS
    assert "Infeasible" in answer.native_status
    assert capfd.readouterr() == ("", "")


def test_random_guesses_are_drawn_one_by_one():
    """Random guesses are drawn one by one.

    A billion of them take neither memory nor time before the first.
    """
    for limit in (0.1, 1.0, 10.0):  # on a busy machine the first may take more than a tenth
        answer = solve(
            PAPER["problem 1"], "slsqp[initial_guess=random,count=1000000000]", limit=limit
        )
        if answer.claim is not Claim.LIMIT:
            break

    assert answer.outcome == "returned"
    assert answer.claim is Claim.LOCAL


@given(
    kind=st.sampled_from(INITIAL_GUESSES),
    name=st.sampled_from(sorted(SUBPROBLEMS)),
    scenario=scenarios(),
)
def test_starting_points_are_admissible(kind, name, scenario):
    """Starting points are admissible.

    They are not negative, have arcs within a full turn, and are zero where a length is fixed.
    """
    subproblem = SUBPROBLEMS[name]
    case = case_of(name, local(scenario))
    points = list(initial_guesses(Question(scenario), case, kind, seed=1, count=5))

    for z in points:
        assert (z >= 0).all()
        assert (z[:2] <= 2 * math.pi).all()
        assert not np.delete(z, subproblem.free).any()
    assert len(points) == (5 if kind == "random" else len(points)) >= 1


@pytest.mark.parametrize("name", [*NLP, "shooting"])
def test_a_warm_start_saves_evaluations(name):
    """A warm start saves evaluations.

    Started from the solution's own segments, a word takes fewer of them than from cold.
    """
    problem = PAPER["problem 4"]
    start = solve(problem, "analytic", "LS").path

    cold, warm = solve(problem, name, "LS"), solve(problem, name, "LS", initial_guess=start)

    assert warm.length == pytest.approx(cold.length, rel=1e-8)
    assert warm.evaluations < cold.evaluations


@pytest.mark.parametrize("name", ["slsqp", "ipopt"])
@pytest.mark.parametrize("radius", [1e-3, 1.0, 1e3])
def test_the_model_in_the_papers_units(name, radius):
    """The model works in the paper's units.

    Posed in the scenario's unit, easy scales have the same answers.
    """
    scenario = Scenario(0, 0, 0.4, 5 * radius, 3 * radius, radius)
    answer = solve(scenario, f"{name}[units=scenario]")

    assert answer.verdict is Verdict.OPTIMAL
    assert answer.gap < 1e-6


def test_a_given_start_is_the_only_one():
    """A given start is the only one.

    The solver starts where it is told to and nowhere else; without one, as by default.
    """
    scenario = PAPER["problem 2"]
    path = Path(scenario.start, [1, -1, 0], [0.6, 1e-3, 6.0])
    joint = case_of("LRS", local(scenario))

    def points(question, kind):
        return [z.tolist() for z in initial_guesses(question, joint, kind, 0, 3)]

    assert points(Question(scenario, initial_guess=path), "given") == [[0.6, 1e-3, 6.0]]
    assert points(Question(scenario), "given") == points(Question(scenario), "bearing")
    answer = solve(scenario, "ipopt[model=joint,order=LRS,initial_guess=given]", initial_guess=path)
    assert answer.verdict is Verdict.OPTIMAL


# trust-constr takes seconds for a word without a path
EASY_AND_HARD = ["nlp", pytest.param("nlp[engine=trust-constr]", marks=pytest.mark.slow)]


@pytest.mark.parametrize("spec", EASY_AND_HARD)
@pytest.mark.parametrize("target", [(1, 1), (0, 2), (-1, 1)])
@pytest.mark.parametrize("branch", ["best", "LS"])
def test_a_double_root_is_not_taken_for_infeasible(branch, target, spec):
    """A double root is not taken for infeasible.

    On the left circle LS has no straight, and the violation is flat there without a gradient.
    """
    answer = solve(Scenario(0, 0, 0, *target, 1), spec, branch)

    assert answer.claim is Claim.LOCAL
    assert answer.verdict is Verdict.OPTIMAL


@pytest.mark.parametrize("spec", EASY_AND_HARD)
def test_a_far_target_is_met(spec):
    """A far target is met.

    A tolerance that grew with the distance would miss these, 10^4 to 10^5 radii away.
    """
    for x, y, heading in ((13994, -7553, -6.3204), (-28211, -12892, 0.4288), (-7e4, 8e4, 1)):
        answer = solve(Scenario(0, 0, heading, x, y, 1), spec)

        assert answer.verdict is Verdict.OPTIMAL
        assert answer.miss < 1e-6


def test_absence_has_its_reason():
    """A name that PATH does not have."""
    assert Nlp().unavailable() is None
    answer = solve(PAPER["problem 1"], "nlp[engine=no-such-solver]")
    assert answer.outcome is Outcome.UNAVAILABLE
    assert answer.message.startswith("no executable 'no-such-solver' on PATH, and no engine of")


@pytest.mark.skipif(find_spec("knitro") is None, reason="the package knitro is not installed")
def test_knitro_without_a_licence_says_exactly_that(capfd):
    """KNITRO without a licence says exactly that.

    Its wheel installs without one; its own pages of text about it stay out of the output.
    """
    reason = ENGINES["knitro"].unavailable()
    if reason is None:
        pytest.skip("there is a licence")

    assert (
        reason == "knitro is installed, but no licence was found (its wheel installs without one)"
    )
    printed = capfd.readouterr()
    assert printed.out + printed.err == ""
    answer = solve(PAPER["problem 1"], "nlp[engine=knitro]")
    assert answer.outcome is Outcome.UNAVAILABLE
    assert answer.message == reason


def _ls(scenario: Scenario) -> Case:
    return case_of("LS", local(scenario))


def test_knitros_route_with_a_solver_that_needs_no_licence():
    """KNITRO's route works with a free solver.

    Pyomo's direct interfaces answer alike; SCIP's stands in for KNITRO's.
    """
    start = np.array((1.0, 0.0, 5.0))

    point = solve_in_pyomo(_ls(PAPER["problem 1"]), start, 20.0, "scip_direct")
    none = solve_in_pyomo(_ls(Scenario(0, 0, 0, 0.3, 0.8, 1)), start, 20.0, "scip_direct")

    expected = shortest(PAPER["problem 1"], "LS")
    assert point.claim is Claim.LOCAL
    # SCIP meets equations to 1e-6
    assert point.x[[0, 2]] == pytest.approx(tuple(expected.segments), abs=1e-5)
    assert point.x[1] == 0
    assert none.claim is Claim.INFEASIBLE
    assert np.isnan(none.x).all()


@pytest.mark.skipif(find_spec("knitro") is None, reason="the package knitro is not installed")
def test_knitro_losing_its_licence_in_a_run_is_a_failure():
    """KNITRO losing its licence is a failure.

    A seat is gone between the question whether there is one and the solve.
    """
    if ENGINES["knitro"].unavailable() is None:
        pytest.skip("there is a licence")

    point = solve_in_pyomo(_ls(PAPER["problem 1"]), np.ones(3), 5.0, "knitro_direct")

    assert point.claim is Claim.FAILED
    assert "not available" in point.message


WORDS, ORDERS = ("LS", "RS", "LR", "RL"), ("LRS", "RLS")
AHEAD = Scenario(x=0, y=0, heading=0.4, target_x=5, target_y=3)


def begun(scenario, subproblems, kind):
    """Paths that the searches begin with.

    They are a set of tuples: their arcs of some length.
    """
    question = Question(scenario)
    target = local(scenario)
    return sorted(
        tuple(
            (rate, length)
            for rate, length in zip(path.curvatures.tolist(), path.lengths.tolist(), strict=True)
            if length > 0
        )
        for name in subproblems
        for z in initial_guesses(
            question, case_of(name, target), kind, 0, 3, both=len(subproblems) > 1
        )
        for path in [as_path(scenario, SUBPROBLEMS[name], z)]
    )


@given(scenario=scenarios())
def test_words_and_joint_model_begin_with_the_same_paths(scenario):
    """Words and joint model begin with equal paths.

    With `words` one NLP a word and the joint model in both orders get the same four guesses.
    """
    assert begun(scenario, ORDERS, "words") == begun(scenario, WORDS, "words")
    assert len(begun(scenario, ORDERS, "words")) == 4


@given(scenario=scenarios())
def test_one_order_begins_with_the_words_that_it_holds(scenario):
    """One order begins with its own words.

    LRS has paths of LS, RS and LR, RLS of LS, RS and RL.
    """
    for order, held in (("LRS", ("LS", "RS", "LR")), ("RLS", ("LS", "RS", "RL"))):
        assert begun(scenario, [order], "words") == begun(scenario, held, "words")


@given(scenario=scenarios())
def test_one_is_a_single_path(scenario):
    """`one` is a single path.

    Both orders of the joint model begin with it, and each word with its own part of it.
    """
    (first,), (second,) = (begun(scenario, [order], "one") for order in ORDERS)
    assert first == second
    for word in WORDS:
        (part,) = begun(scenario, [word], "one")
        assert set(part) <= set(first)


@given(
    kind=st.sampled_from(["straight", "zero", "random"]),
    bearing=st.floats(-math.pi, math.pi),
    distance=st.floats(0.1, 100),
)
def test_a_blind_guess_knows_no_direction(kind, bearing, distance):
    """A blind guess knows no direction.

    It is the same for all targets at one distance.
    """
    there = distance * math.cos(bearing), distance * math.sin(bearing)
    for name in SUBPROBLEMS:
        z, ahead = (
            list(initial_guesses(Question(asked), case_of(name, local(asked)), kind, 1, 3))
            for asked in (Scenario(0, 0, 0, *target, 1) for target in (there, (distance, 0.0)))
        )
        assert len(z) == len(ahead) == (3 if kind == "random" else 1), name
        for one, other in zip(z, ahead, strict=True):
            assert one == pytest.approx(other, rel=1e-12)


@pytest.mark.parametrize(
    ("spec", "guesses", "knows"),
    [
        ("slsqp", "several", "words"),
        ("slsqp[initial_guess=words]", "words", "words"),
        ("slsqp[initial_guess=one,presolve=true]", "one", "words presolve"),
        ("slsqp[initial_guess=straight]", "blind", "words"),
        ("slsqp[model=joint]", "one", "shape"),
        ("slsqp[model=joint,initial_guess=words]", "words", "shape words"),
        ("slsqp[model=joint,initial_guess=random]", "several blind", "shape"),
        ("shooting", "several", "words"),
        ("multiple-shooting", "several", "words"),
        ("turn-rate-qp[initial_guess=words]", "words", "words"),
        ("turn-rates[initial_guess=one]", "one", ""),
        ("collocation[initial_guess=straight]", "blind", ""),
        ("disjunctive", "none", "words"),
        ("analytic", "none", "formula"),
    ],
)
def test_a_row_says_what_its_method_knows(spec, guesses, knows):
    """A row tells what its method knows.

    The factor, the presolve and the knowledge are columns, derived from the solver.
    """
    columns = stated_method(load(spec)).columns(Question(AHEAD))
    presolve = "presolve=true" in spec
    assert (columns["guesses"], columns["presolve"], columns["knows"]) == (
        *(guesses, presolve, knows),
    )


def test_a_route_has_no_guesses_of_words():
    """A route has no guesses of words.

    Direct methods begin with one guess, which knows nothing of the words.
    """
    route = Question(Scenario(x=0, y=0, heading=0, target_x=9, target_y=3, via=[(4, 1)]))
    columns = stated_method(load("multiple-shooting")).columns(route)
    assert (columns["guess"], columns["guesses"], columns["knows"]) == ("bearing", "one", "")


def test_the_row_of_an_answer_has_the_factor():
    """Asked warm, the guess is the question's own."""
    spec = "slsqp[model=joint,initial_guess=words]"
    row = solve(AHEAD, spec).row()
    assert (row["guess"], row["guesses"], row["knows"]) == ("words", "words", "shape words")
    warm = solve(AHEAD, spec, initial_guess=solve(AHEAD, "analytic").path).row()
    assert (warm["guess"], warm["guesses"], warm["knows"]) == ("warm", "warm", "shape")


def test_a_plug_in_states_its_guesses_by_their_kind():
    """A plug-in states its guesses by kind.

    A plain tuple suffices; what no table knows stays as it is.
    """
    assert Method("mine", "m", "random").columns()["guesses"] == "several blind"
    assert Method("mine", "m", "crystal ball").columns()["guesses"] == "crystal ball"


@pytest.mark.parametrize("kind", ["one", "words", "straight"])
@pytest.mark.parametrize("model", ["words", "joint"])
def test_a_plain_target_is_reached_from_every_kind(kind, model):
    """A plain target is reached from every kind.

    Outside the discs and ahead, no kind of guess costs the answer.
    """
    answer = solve(AHEAD, f"ipopt[model={model},initial_guess={kind}]")
    assert answer.verdict == "optimal"

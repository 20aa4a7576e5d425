"""Guesses are a factor of their own: equal for two formulations, blind, and named in the row."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study import Scenario, solve
from dubins_study.solvers.paper_nlp.initial_guesses import initial_guesses
from dubins_study.solvers.paper_nlp.model import SUBPROBLEMS, as_path
from dubins_study.solvers.protocol import Method, Question
from dubins_study.solvers.registry import load, stated_method
from tests.cases import scenarios

WORDS, ORDERS = ("LS", "RS", "LR", "RL"), ("LRS", "RLS")
AHEAD = Scenario(x=0, y=0, heading=0.4, target_x=5, target_y=3)


def begun(scenario, subproblems, kind):
    """The paths that the searches begin with, as their arcs of some length: a set of tuples."""
    question = Question(scenario)
    return sorted(
        tuple(
            (rate, length)
            for rate, length in zip(path.curvatures.tolist(), path.lengths.tolist(), strict=True)
            if length > 0
        )
        for name in subproblems
        for z in initial_guesses(question, SUBPROBLEMS[name], kind, 0, 3, both=len(subproblems) > 1)
        for path in [as_path(scenario, SUBPROBLEMS[name], z)]
    )


@given(scenario=scenarios())
def test_words_and_joint_model_begin_with_the_same_paths(scenario):
    """With `words` one NLP a word and the joint model in both orders get the same four guesses."""
    assert begun(scenario, ORDERS, "words") == begun(scenario, WORDS, "words")
    assert len(begun(scenario, ORDERS, "words")) == 4


@given(scenario=scenarios())
def test_one_order_begins_with_the_words_that_it_holds(scenario):
    """LRS has paths of LS, RS and LR, RLS of LS, RS and RL."""
    for order, held in (("LRS", ("LS", "RS", "LR")), ("RLS", ("LS", "RS", "RL"))):
        assert begun(scenario, [order], "words") == begun(scenario, held, "words")


@given(scenario=scenarios())
def test_one_is_a_single_path(scenario):
    """Both orders of the joint model begin with it, and each word with its own part of it."""
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
    """It is the same for all targets at one distance."""
    there = distance * math.cos(bearing), distance * math.sin(bearing)
    for name, subproblem in SUBPROBLEMS.items():
        z, ahead = (
            list(initial_guesses(Question(Scenario(0, 0, 0, *target, 1)), subproblem, kind, 1, 3))
            for target in (there, (distance, 0.0))
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
    """The factor, the presolve and the knowledge are columns, derived from the solver."""
    columns = stated_method(load(spec)).columns(Question(AHEAD))
    presolve = "presolve=true" in spec
    assert (columns["guesses"], columns["presolve"], columns["knows"]) == (
        *(guesses, presolve, knows),
    )


def test_a_route_has_no_guesses_of_words():
    """Direct methods begin with one guess, which knows nothing of the words."""
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
    """A plain tuple suffices; what no table knows stays as it is."""
    assert Method("mine", "m", "random").columns()["guesses"] == "several blind"
    assert Method("mine", "m", "crystal ball").columns()["guesses"] == "crystal ball"


@pytest.mark.parametrize("kind", ["one", "words", "straight"])
@pytest.mark.parametrize("model", ["words", "joint"])
def test_a_plain_target_is_reached_from_every_kind(kind, model):
    """Outside the discs and ahead, no kind of guess costs the answer."""
    answer = solve(AHEAD, f"ipopt[model={model},initial_guess={kind}]")
    assert answer.verdict == "optimal"

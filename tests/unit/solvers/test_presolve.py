"""The presolve is right, and marked.

It is right by brute force, silent near a circle, and the same for every engine.
"""

import math

import numpy as np
import pytest
from flint import arb, ctx
from hypothesis import given, settings
from hypothesis import strategies as st

from dubins_study.asking.attempt import attempt
from dubins_study.asking.reply import ask
from dubins_study.cli.solving.answer_text import answer_json, answer_text
from dubins_study.solvers.presolve import WORDS, unreachable
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import available_solvers, load
from dubins_study.solvers.registry import settings as settings_of
from dubins_study.study.body_coordinates import local
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import TURN, Claim, Outcome, Verdict
from tests.cases import engine_params, placed

# they look for LS and RS among all paths that turn one way
TRANSCRIPTIONS = ["turn-rate-qp", "turn-rates", "multiple-shooting", "collocation"]
# of solvers that answer words
ENGINES = [
    name for name in available_solvers() if name != "analytic" and "LS" in load(name).branches
]
# branch -> targets (radii) that no path of the branch ends at: inside, and out of reach
WITHOUT_A_PATH = {
    "LS": [(0.3, 0.8), (-0.6, 1.3)],
    "RS": [(0.3, -0.8), (-0.6, -1.3)],
    "LR": [(0.3, 0.8), (0.0, 5.0), (-40.0, 3.0)],
    "RL": [(0.3, -0.8), (0.0, -5.0), (-40.0, 3.0)],
}
QUESTIONS = [
    Question(placed(X, Y, 2, -1, 0.7, 2.5), branch)
    for branch, targets in WITHOUT_A_PATH.items()
    for X, Y in targets
]


def presolving(name: str):
    return load(f"{name}[presolve=true]")


@pytest.mark.parametrize("question", QUESTIONS, ids=lambda q: f"{q.branch}")
def test_every_engine_gives_the_same_answer_and_it_is_marked(question):
    """Every engine gives the same marked answer.

    Compared are claim, message and counts, what the check finds of it, and the row. By default it
    is off.
    """
    assert not any(settings_of(load(name))["presolve"] for name in ENGINES)
    solvers = [presolving(name) for name in ENGINES]
    asked = [solver for solver in solvers if question.branch in solver.branches]

    assert asked
    assert len({ask(solver, question).solution for solver in asked}) == 1
    for solver in asked:
        answer = attempt(solver, question)
        assert answer.outcome is Outcome.RETURNED
        assert (answer.claim, answer.verdict) == (Claim.INFEASIBLE, Verdict.NONE_EXISTS)
        assert (answer.iterations, answer.evaluations, answer.path) == (0, 0, None)
        assert answer.presolved
        assert answer.row()["presolved"] is True
        assert answer.proof == "none"
        assert answer.message.startswith("presolve: the target is ")


@pytest.mark.parametrize("name", TRANSCRIPTIONS)
def test_a_transcription_called_directly_gives_the_same_answer(name):
    """A transcription that is called directly presolves by itself."""
    solver = presolving(name)
    question = Question(placed(0.3, 0.8, 2, -1, 0.7, 2.5), "LS")

    assert solver.solve(solver.build(question), 1.0) == ask(solver, question).solution


@pytest.mark.slow
@pytest.mark.parametrize("name", TRANSCRIPTIONS)
def test_turning_one_way_into_the_circle_is_not_called_the_word(name):
    """Turning one way into the circle is not LS.

    Straight first and then left leads into the rear half at any depth, and LS does not.

    On the circle and outside, down to 1e-15 R, where the word's equations become singular, the
    word exists and is found.
    """
    solver = load(name)
    for distance in (
        0.0,
        *(side * 10.0**-exponent for exponent in range(1, 16) for side in (1, -1)),
    ):
        for arc in (3.5, 5.9):
            r = 1 + distance
            scenario = Scenario(0, 0, 0, r * math.sin(arc), 1 - r * math.cos(arc), 1)
            answer = attempt(solver, Question(scenario, "LS"))
            assert not answer.false_claim, (distance, arc)
            assert distance < 0 or "turning to one side" not in answer.message, (distance, arc)
    for place in [(-0.4499593609480958, 1.8930490319658606), (-7.604903753467853e-08, 3.9e-15)]:
        answer = attempt(solver, Question(Scenario(0, 0, 0, *place, 1), "LS"))
        # at the second, 2e-15 R inside the circle, the path of one arc of multiple-shooting misses
        # by the rounding of four arcs, less than what the check allows a word to be off
        assert not answer.false_claim or name == "multiple-shooting"


@pytest.mark.parametrize("name", engine_params(ENGINES, ("ipopt", "multiple-shooting", "shooting")))
@pytest.mark.parametrize("target", [(0.3, 0.8), pytest.param((-3, 0.5), marks=pytest.mark.slow)])
def test_the_best_path_is_found_without_the_words_that_cannot_exist(name, target):
    """The best path needs no impossible words.

    No shortest path is lost with them, and the answer is the engine's own.
    """
    scenario = Scenario(0, 0, 0, *target, 1)
    with_all = attempt(load(name), Question(scenario))
    answer = attempt(presolving(name), Question(scenario))

    assert not answer.presolved
    assert answer.verdict is with_all.verdict
    assert answer.length == pytest.approx(with_all.length, rel=1e-6)


STEPS = 3000


def nearest(word: str, X: float, Y: float) -> float:
    """Least distance (radii) from target to a word's paths.

    The paths have many first turns.

    The first turn is driven; of the second piece, a ray or a circle, the nearest point is taken.
    """
    turn = TURN[word[0]]
    path = Path(Pose(0.0, 0.0, 0.0), [turn], [2 * math.pi])
    x, y, heading = path.at(np.linspace(0.0, 2 * math.pi, STEPS)).T
    along = (X - x) * np.cos(heading) + (Y - y) * np.sin(heading)
    across = (Y - y) * np.cos(heading) - (X - x) * np.sin(heading)
    if word[1] == "S":
        return float(np.hypot(across, np.minimum(along, 0.0)).min())
    return float(np.abs(np.hypot(along, across - TURN[word[1]]) - 1).min())


# to 1e-6, so that 1 - |T - C|^2 is zero or at least 1e-12, far above the rounding of `nearest`
places = st.one_of(
    st.tuples(st.floats(-5, 5), st.floats(-5, 5)),
    st.tuples(st.floats(-1, 1), st.floats(-2, 2)),
).map(lambda place: (round(place[0], 6), round(place[1], 6)))


@given(place=places, word=st.sampled_from(WORDS))
@settings(max_examples=200)
def test_what_it_says_is_right_by_brute_force(place, word):
    """It is right by brute force.

    It says that a word does not exist just where no path of many comes near the target.
    """
    distance = nearest(word, *place)
    scenario = Scenario(0, 0, 0, *place, 1)

    if unreachable(local(scenario), word):
        assert distance > local(scenario).delta
    else:
        # the paths' ends are at most 6 radii from the centre of the turn, a step apart in angle
        assert distance < 2 * math.pi / STEPS * 8


def exact_distances(scenario: Scenario, word: str) -> tuple[float, float]:
    """Distances (radii) of a target from two circles.

    They have radius 1 and 3 about the first turn's centre, and are balls of 300 bits.
    """
    before = ctx.prec
    ctx.prec = 300
    try:
        cos, sin = arb(scenario.heading).cos(), arb(scenario.heading).sin()
        dx = arb(scenario.target_x) - arb(scenario.x)
        dy = arb(scenario.target_y) - arb(scenario.y)
        X = (dx * cos + dy * sin) / arb(scenario.radius)
        Y = (dy * cos - dx * sin) / arb(scenario.radius) - arb(TURN[word[0]])
        distance = (X * X + Y * Y).sqrt()
        return float(abs(distance - 1)), float(abs(distance - 3))
    finally:
        ctx.prec = before


@pytest.mark.slow
@given(
    word=st.sampled_from(WORDS),
    size=st.sampled_from((1, 3)),
    angle=st.floats(-4, 4),
    steps=st.integers(-12, 12),
    start=st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)) | st.just((0.0, 0.0)),
    heading=st.floats(-50, 50) | st.just(0.0),
    radius=st.floats(1e-3, 1e3),
)
@settings(max_examples=300)
def test_it_is_silent_within_delta_of_a_circle(word, size, angle, steps, start, heading, radius):
    """It is silent within delta of a circle.

    Targets lie within a few delta of the circles of radius 1 and 3. Where it speaks, all of
    delta's square around the target is on the far side, by the exact distance.
    """
    delta = local(Scenario(*start, heading, *start, radius)).delta + 1e-14
    r = size + steps * delta
    X, Y = r * math.sin(angle), TURN[word[0]] - r * math.cos(angle)
    scenario = placed(X, Y, *start, heading, radius)
    from_1, from_3 = exact_distances(scenario, word)
    reason = unreachable(local(scenario), word)

    if reason:
        limit = from_1 if "inside" in reason else from_3
        assert limit > math.sqrt(2) * local(scenario).delta
        assert size == (1 if "inside" in reason else 3)


def test_the_command_says_who_answered():
    for presolve in ("true", "false"):
        solver = load(f"slsqp[presolve={presolve}]")
        answer = attempt(solver, Question(Scenario(0, 0, 0, 0.3, 0.8, 1), "LS"))

        assert ("presolve    answered" in answer_text(answer)) is (presolve == "true")
        assert f'"presolved": {presolve}' in answer_json(answer)

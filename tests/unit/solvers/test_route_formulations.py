"""Formulations of one leg that take routes and final headings: judged by the check."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from dubins_study.solvers.attempt import attempt
from dubins_study.solvers.course import body_course
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES, names
from dubins_study.solvers.optimal_control.arcs import Elements, missed, rollout, slopes
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import available_solvers, load
from dubins_study.solvers.route import joint
from dubins_study.solvers.route.grid import layers
from dubins_study.solvers.route.legs import route_of
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path as DrivenPath
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import NEEDS, QP, Claim, Outcome, Verdict

VIA = [(12, 4), (14, -8)]  # all legs above 4 radii
FREE = Scenario(1, 2, "30deg", 22, 9, 2, via=VIA)
GIVEN = Scenario(1, 2, "30deg", 22, 9, 2, via=VIA, final_heading="90deg")
NEAR = Scenario(0, 0, 0, 1, 2, 1, via=[(1.5, 0.5), (0.5, 3)], final_heading=2.0)
POSE = Scenario(0, 0, 0.7, 5, 1, 1, final_heading=-2.0)
SOLVED = (Claim.OPTIMAL, Claim.LOCAL, Claim.FEASIBLE)
# spec -> the largest gap that its steps leave
GAPS = {
    "multiple-shooting": 1e-8,
    "multiple-shooting[initial_guess=straight]": 1e-8,
    "multiple-shooting[initial_guess=zero]": 1e-8,
    "collocation": 1e-8,
    "collocation[initial_guess=straight]": 1e-8,
    "turn-rates[mesh=graded,n=30]": 1e-4,
    "turn-rate-qp": 1e-5,
    "turn-rate-qp[initial_guess=random,count=3]": 1e-5,
}
GAPS |= {
    "route-nlp[model=words,initial_guess=words]": 1e-8,
    "route-nlp[model=words]": 1e-8,
    "route-nlp[initial_guess=straight]": 1e-8,
    "route-nlp[initial_guess=zero]": 1e-8,
}
GAPS |= dict.fromkeys(
    [
        *("route-nlp", "headings[engine=powell]"),
        *("headings[engine=differential-evolution]", "headings[engine=trust-constr]"),
        *("headings[engine=uno-filtersqp]", "headings[engine=nlopt-auglag]"),
    ],
    1e-8,
)
# Its library breaks others in the same process.
ALONE = ("sleqp",)
EVERY_ENGINE = [
    *(f"multiple-shooting[engine={name}]" for name in NLP_ENGINES if name not in ALONE),
    *(f"collocation[engine={name},n=3]" for name in ("slsqp", "uno", "fatrop")),
    *(f"turn-rates[engine={name},n=12]" for name in ("slsqp", "uno", "nlopt-slsqp")),
    *(f"turn-rate-qp[engine={name},n=20]" for name in names(QP)),
    *(f"route-nlp[engine={name},model=words]" for name in NLP_ENGINES if name not in ALONE),
    *(f"route-nlp[engine={name}]" for name in NLP_ENGINES if name not in ALONE),
    *("headings", *type(load("headings")).variants),
]
AVAILABLE = [spec for spec in EVERY_ENGINE if load(spec).unavailable() is None]


@pytest.fixture(autouse=True)
def _one_thread():
    with threadpool_limits(1):
        yield


@pytest.mark.parametrize("spec", GAPS)
@pytest.mark.parametrize("scenario", [FREE, GIVEN], ids=["free", "given"])
def test_far_points_have_the_shortest_route(spec, scenario):
    """No longer than the certified search's, from guesses that know no word."""
    if load(spec).unavailable() is not None:
        pytest.skip(f"{spec}: {load(spec).unavailable()}")
    answer = attempt(load(spec), Question(scenario), 20.0)

    assert answer.verdict is Verdict.OPTIMAL
    assert answer.claim in (Claim.LOCAL, Claim.FEASIBLE)
    assert not answer.false_claim
    assert abs(answer.gap) < GAPS[spec]


@pytest.mark.parametrize("spec", ["multiple-shooting", "collocation", "turn-rate-qp"])
def test_one_leg_with_a_final_heading_is_a_route_too(spec):
    answer = attempt(load(spec), Question(POSE), 20.0)

    assert answer.verdict is Verdict.OPTIMAL
    assert abs(answer.gap) < 1e-6


@pytest.mark.parametrize("spec", AVAILABLE)
def test_every_engine_answers_or_says_that_it_does_not(spec):
    """A path that arrives where it claims one, and nothing stronger than what is so."""
    answer = attempt(load(spec), Question(NEAR), 5.0)

    assert answer.outcome is Outcome.RETURNED, answer.message
    assert not answer.false_claim
    assert answer.verdict in (Verdict.OPTIMAL, Verdict.LONGER) or answer.claim not in SOLVED
    assert answer.engine == ENGINES[load(spec).engine].label


@pytest.mark.parametrize("scenario", [FREE, NEAR], ids=["free", "given"])
def test_what_is_missed_and_its_slopes_are_those_of_the_path(scenario):
    """Against the path driven leg by leg, and differences of every element's turn and growth."""
    course, random, n, h = body_course(scenario), np.random.default_rng(4), 4, 1e-6
    length = random.uniform(0.1, 3, n * course.legs)
    elements = Elements(random.uniform(-1, 1, length.size) * length, length)
    turned = DrivenPath(Scenario(0, 0, 0, 1, 1).start, elements.rate, length)
    ends = turned.at(np.cumsum(length)[n - 1 :: n])
    c, s = math.cos(scenario.heading), math.sin(scenario.heading)
    away = (scenario.points[1:] - scenario.points[0]) / scenario.radius @ [[c, -s], [s, c]]

    gaps = missed(elements, course)

    assert gaps[: 2 * course.legs] == pytest.approx((away - ends[:, :2]).ravel(), abs=1e-12)
    if scenario.final_heading is not None:
        left = scenario.final_heading - scenario.heading - ends[-1, 2]
        assert gaps[-1] == pytest.approx(math.remainder(left, 2 * math.pi), abs=1e-12)
    by_turn, by_growth = slopes(elements, course, rollout(elements))
    for k, unit in enumerate(h * np.eye(length.size)):
        both = [missed(Elements(elements.turn + s, length), course) for s in (unit, -unit)]
        assert by_turn[:, k] == pytest.approx((both[1] - both[0]) / (2 * h), abs=1e-7)
        grown = [Elements(elements.turn * (1 + s), length * (1 + s)) for s in (unit, -unit)]
        both = [missed(each, course) for each in grown]
        assert by_growth[:, k] == pytest.approx((both[1] - both[0]) / (2 * h), abs=1e-7)


@pytest.mark.parametrize("spec", ["multiple-shooting", "turn-rate-qp"])
def test_a_path_through_the_points_is_a_warm_guess(spec):
    """It is cut at the points, and an engine that begins there has less to do."""
    cold = attempt(load(spec), Question(GIVEN), 20.0)
    warm = attempt(load(spec), Question(GIVEN, initial_guess=cold.path), 20.0)

    assert warm.subproblems.split()[0] == "warm"
    assert warm.length == pytest.approx(cold.length, rel=1e-6)
    assert warm.subproblem_evaluations[0] < cold.evaluations


def test_the_grid_of_headings_takes_routes():
    """Its gap is the grid's, a thousandth, with points and final headings met exactly."""
    for scenario in (FREE, GIVEN, NEAR, POSE):
        answer = attempt(load("heading-milp[headings=48]"), Question(scenario), 20.0)
        assert answer.claim is Claim.LOCAL
        assert answer.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
        assert 0 <= answer.gap < 2e-3


@pytest.mark.parametrize("target", [(5, 1), (-3, 0.2), (-0.2, 0.6), (0.4, -1.2), (2, -5)])
def test_the_words_of_one_free_leg_are_the_four(target):
    """From the grid's path the engine comes to the closed form's shortest path."""
    scenario = Scenario(0, 0, 0.0, *target, 1)
    answer = attempt(load("route-nlp[model=words,initial_guess=words]"), Question(scenario), 10.0)

    assert answer.formulation == "one NLP a word"
    assert answer.length == pytest.approx(shortest(scenario).total, abs=1e-7)


@pytest.mark.parametrize("scenario", [FREE, NEAR], ids=["free", "given"])
def test_the_program_of_known_words_is_the_joint_one_without_the_other_arcs(scenario):
    """Its equations hold on the grid's path, and its derivatives are exact."""
    route = route_of(scenario)
    known = layers(route, 24).shortest()
    places = joint.word_places(route, known)
    program, everything = joint.program(route, places), joint.program(route)
    point = joint.words_guess(route, known)
    functions, x = program.functions, joint._kept(point, places)

    if scenario.final_heading is not None:  # else the last arc is left out
        assert np.abs(functions.equations(x)).max() < 1e-12
    full = joint._arcs(x, places)
    whole = np.column_stack((full, point.reshape(-1, 6)[:, 5])).ravel()
    expected = everything.functions.equations(whole)
    assert functions.equations(x) == pytest.approx(expected, abs=1e-12)
    h, weights = 1e-6, np.random.default_rng(1).normal(size=expected.size)
    both = [(x + step, x - step) for step in h * np.eye(x.size)]
    slope = np.transpose([functions.equations(a) - functions.equations(b) for a, b in both])
    bend = [weights @ (functions.jacobian(a) - functions.jacobian(b)) for a, b in both]
    np.testing.assert_allclose(functions.jacobian(x), slope / (2 * h), atol=1e-6)
    np.testing.assert_allclose(functions.hessian(x, weights), np.array(bend) / (2 * h), atol=1e-5)


def test_every_solver_takes_routes_or_the_documentation_says_why_not():
    """By name, in the table of `docs/formulations/index.md`."""
    text = (Path(__file__).parents[3] / "docs/formulations/index.md").read_text()
    section = text.split("## Which take routes")[1].split("## Which one")[0]
    taking, table = section.split("| solver | why not |")

    for name in available_solvers():
        where = taking if load(name).takes == frozenset(NEEDS) else table
        assert f"`{name}`" in where, name

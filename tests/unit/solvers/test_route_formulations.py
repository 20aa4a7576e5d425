"""Formulations that take routes.

Tested are derivatives, equations, and every engine, judged by the check.

heading-milp beside brute force over its grid, linear programming, and the closed form; the best
headings on the way to an answer (`trace=true`).
"""

import math
from dataclasses import replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog
from threadpoolctl import threadpool_limits

from dubins_study import solve
from dubins_study.asking.attempt import attempt
from dubins_study.asking.reply import ask
from dubins_study.experiments.isolation.messages import decode_reply, encode_reply
from dubins_study.solvers.arcs import Elements, missed, rollout, slopes
from dubins_study.solvers.course import body_course, path_of
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES, names
from dubins_study.solvers.legs import WORD_TURNS, route_of
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError, available_solvers, load
from dubins_study.solvers.route import headings, joint
from dubins_study.solvers.route.grid import HeadingMilp
from dubins_study.solvers.tour.order_headings import headings_on_grid
from dubins_study.solvers.tour.places import places_of
from dubins_study.study.closed_form.pose import WORDS6, pose_path, shortest_to_pose
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path as DrivenPath
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.words import IN_ORDER, QP, Claim, Outcome, Verdict
from tests.cases import QUICK_ENGINES, engine_params, walked

VIA = [(12, 4), (14, -8)]  # all legs above 4 radii
FREE = Scenario(1, 2, "30deg", 22, 9, 2, via=VIA)
GIVEN = Scenario(1, 2, "30deg", 22, 9, 2, via=VIA, final_heading="90deg")
NEAR = Scenario(0, 0, 0, 1, 2, 1, via=[(1.5, 0.5), (0.5, 3)], final_heading=2.0)
POSE = Scenario(0, 0, 0.7, 5, 1, 1, final_heading=-2.0)
# spec -> the largest gap that its steps leave
GAPS = dict.fromkeys(
    [
        *("multiple-shooting", "multiple-shooting[initial_guess=straight]"),
        *("multiple-shooting[initial_guess=zero]", "collocation"),
        *("collocation[initial_guess=straight]", "route-nlp", "route-nlp[model=words]"),
        *("route-nlp[model=words,initial_guess=words]", "route-nlp[initial_guess=straight]"),
        *("route-nlp[initial_guess=zero]", "headings[engine=powell]"),
        *("headings[engine=differential-evolution]", "headings[engine=trust-constr]"),
        *("headings[engine=uno-filtersqp]", "headings[engine=nlopt-auglag]"),
    ],
    1e-8,
)
GAPS |= {"turn-rates[mesh=graded,n=30]": 1e-4, "turn-rate-qp": 1e-5}
GAPS |= {"turn-rate-qp[initial_guess=random,count=3]": 1e-5}
# Its library breaks others in the same process.
ALONE = ("sleqp",)
EVERY_ENGINE = [
    *(f"multiple-shooting[engine={name}]" for name in NLP_ENGINES if name not in ALONE),
    *(f"collocation[engine={name},n=3]" for name in ("slsqp", "uno")),
    "collocation[engine=fatrop,n=3,max_iter=30]",  # as one dense stage: 0.15 s an iteration
    *(f"turn-rates[engine={name},n=12]" for name in ("slsqp", "uno", "nlopt-slsqp")),
    *(f"turn-rate-qp[engine={name},n=20]" for name in names(QP)),
    *(f"route-nlp[engine={name},model=words]" for name in NLP_ENGINES if name not in ALONE),
    *(f"route-nlp[engine={name}]" for name in NLP_ENGINES if name not in ALONE),
    *("headings", *type(load("headings")).variants),
]
ASKED = [
    pytest.param(
        *(spec, scenario),
        marks=()
        if scenario is NEAR and getattr(load(spec), "engine", "") in QUICK_ENGINES
        else pytest.mark.slow,
    )
    for spec in EVERY_ENGINE
    if load(spec).unavailable() is None
    for scenario in ((NEAR, FREE, GIVEN) if spec.startswith(("headings", "route-nlp")) else (NEAR,))
]


@pytest.fixture(autouse=True)
def _one_thread():
    with threadpool_limits(1):
        yield


@pytest.mark.parametrize("spec", GAPS)
@pytest.mark.parametrize("scenario", [FREE, GIVEN], ids=["free", "given"])
def test_far_points_have_the_shortest_route(spec, scenario):
    """Far points have the shortest route.

    It is no longer than the certified search's, from guesses that know no word.
    """
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


@pytest.mark.many(6)
@pytest.mark.parametrize(("spec", "scenario"), ASKED)
def test_every_engine_answers_or_says_that_it_does_not(spec, scenario):
    """Every engine answers or says that it cannot.

    A path arrives where it claims one; of headings there is one.

    What an engine calls infeasible is passed on, with no path, by models of the question itself.
    """
    engine = ENGINES[load(spec).engine]
    # in this process nothing would end, say, fatrop, which goes on for minutes
    answer = solve(scenario, spec, limit=3.0, isolated=not engine.keeps_limit)
    solved = answer.claim in (Claim.LOCAL, Claim.FEASIBLE)

    stopped = answer.outcome is Outcome.TIMEOUT and not engine.keeps_limit
    assert stopped or answer.outcome is Outcome.RETURNED, answer.message
    assert answer.claim is not Claim.OPTIMAL
    assert answer.false_claim == (answer.claim is Claim.INFEASIBLE)
    assert not (answer.false_claim and "model=words" in spec)
    assert not solved or answer.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
    assert solved or not spec.startswith("headings")
    assert answer.engine == engine.label


@pytest.mark.parametrize("scenario", [FREE, NEAR], ids=["free", "given"])
def test_what_is_missed_and_its_slopes_are_those_of_the_path(scenario):
    """Misses and their slopes are the path's.

    They are compared with the path driven leg by leg, and differences of every element's turn and
    growth.
    """
    course = body_course(scenario)
    random = np.random.default_rng(4)
    n = 4
    h = 1e-6
    length = random.uniform(0.1, 3, n * course.legs)
    rate = random.uniform(-1, 1, length.size) * (np.arange(length.size) % 3 > 0)  # some straights
    elements = Elements(rate * length, length)
    turned = DrivenPath(Scenario(0, 0, 0, 1, 1).start, elements.rate, length)
    ends = turned.at(np.cumsum(length)[n - 1 :: n])
    c, s = math.cos(scenario.heading), math.sin(scenario.heading)
    away = (scenario.points[1:] - scenario.points[0]) / scenario.radius @ [[c, -s], [s, c]]

    gaps = missed(elements, course)

    assert gaps[: 2 * course.legs] == pytest.approx((away - ends[:, :2]).ravel(), abs=1e-12)
    if scenario.final_heading is not None:
        left = scenario.final_heading - scenario.heading - ends[-1, 2]
        assert gaps[-1] == pytest.approx(math.remainder(left, 2 * math.pi), abs=1e-12)
    rolled = rollout(elements)
    across = np.array([-rolled.chords[1], rolled.chords[0]])  # by both headings a chord swings
    assert rolled.by_before + rolled.by_after == pytest.approx(across, abs=1e-12)
    by_turn, by_growth = slopes(elements, course, rolled)
    for k, unit in enumerate(h * np.eye(length.size)):
        both = [missed(Elements(elements.turn + s, length), course) for s in (unit, -unit)]
        assert by_turn[:, k] == pytest.approx((both[1] - both[0]) / (2 * h), abs=1e-7)
        grown = [Elements(elements.turn * (1 + s), length * (1 + s)) for s in (unit, -unit)]
        both = [missed(each, course) for each in grown]
        assert by_growth[:, k] == pytest.approx((both[1] - both[0]) / (2 * h), abs=1e-7)


@pytest.mark.parametrize("spec", ["multiple-shooting", "turn-rate-qp"])
def test_a_path_through_the_points_is_a_warm_guess(spec):
    """A path through the points is a warm guess.

    It is cut at the points, and an engine that begins there has less to do.
    """
    cold = attempt(load(spec), Question(GIVEN), 20.0)
    warm = attempt(load(spec), Question(GIVEN, initial_guess=cold.path), 20.0)

    assert warm.subproblems.split()[0] == "warm"
    assert warm.length == pytest.approx(cold.length, rel=1e-6)
    assert warm.subproblem_evaluations[0] < cold.evaluations


def test_the_grid_of_headings_takes_routes():
    """The grid of headings takes routes.

    Its gap is the grid's, a thousandth, with points and final headings met exactly.
    """
    for scenario in (FREE, GIVEN, NEAR, POSE):
        answer = attempt(load("heading-milp[headings=48]"), Question(scenario), 20.0)
        assert answer.claim is Claim.LOCAL
        assert answer.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
        assert 0 <= answer.gap < 2e-3


def test_a_dynamic_program_finds_the_optimum_of_the_integer_program():
    """The dynamic program finds the integer optimum.

    HiGHS solves the same grid; refined it is as short as the search's shortest route.
    """
    for scenario in (FREE, GIVEN, NEAR, POSE):
        grid = attempt(load("heading-grid[headings=24]"), Question(scenario), 20.0)
        milp = attempt(load("heading-milp[headings=24]"), Question(scenario), 20.0)
        refined = attempt(load("heading-grid[refine=true]"), Question(scenario), 20.0)

        assert grid.length == pytest.approx(milp.length, rel=1e-9)
        assert refined.verdict is Verdict.OPTIMAL
        assert refined.gap < 1e-8


@pytest.mark.parametrize("target", [(5, 1), (-3, 0.2), (-0.2, 0.6), (0.4, -1.2), (2, -5)])
def test_the_words_of_one_free_leg_are_the_four(target):
    """The words of one free leg are four.

    From the grid's path the engine comes to the closed form's shortest path.
    """
    scenario = Scenario(0, 0, 0.0, *target, 1)
    answer = attempt(load("route-nlp[model=words,initial_guess=words]"), Question(scenario), 10.0)

    assert answer.formulation == "one NLP a word"
    assert answer.length == pytest.approx(shortest(scenario).total, abs=1e-7)


def best_of_grid(scenario, count):
    """Best headings of a grid.

    The shortest route takes so many at each point.
    """
    places = places_of(scenario)
    return headings_on_grid(places, list(range(places.count)), count)


@pytest.mark.parametrize("scenario", [FREE, NEAR], ids=["free", "given"])
def test_the_program_of_known_words_is_the_joint_one_without_the_other_arcs(scenario):
    """The program of known words is a joint one.

    It is the joint program without the other arcs. Its equations hold on the grid's path.
    """
    route = route_of(scenario)
    known = best_of_grid(scenario, 24)
    places = joint.word_places(route, known)
    program = joint.program(route, places)
    everything = joint.program(route)
    point = joint.words_guess(route, known)
    functions = program.functions
    x = joint._unknowns_of(point, places)

    if scenario.final_heading is not None:  # else the last arc is left out
        assert np.abs(functions.equations(x)).max() < 1e-12
    full = joint._arcs(x, places)
    whole = np.column_stack((full, point.reshape(-1, 6)[:, 5])).ravel()
    expected = everything.functions.equations(whole)
    assert functions.equations(x) == pytest.approx(expected, abs=1e-12)


def test_every_solver_takes_routes_or_the_documentation_says_why_not():
    """Every solver takes routes or is documented.

    The table of `docs/formulations/index.md` names it.
    """
    text = (Path(__file__).parents[3] / "docs/formulations/index.md").read_text()
    section = text.split("## Which take routes")[1].split("## Which one")[0]
    taking, table = section.split("| solver | why not |")

    for name in available_solvers():
        where = taking if load(name).takes >= IN_ORDER else table
        assert f"`{name}`" in where, name


def random_route(random: np.random.Generator, legs: int, low: float, high: float) -> Scenario:
    directions = random.uniform(-math.pi, math.pi, legs)
    points = walked(random.uniform(low, high, legs), directions)[1:]
    final = random.uniform(-3, 3) if random.uniform() < 0.5 else None
    return Scenario(0, 0, 0.7, *points[-1], 1, via=points[:-1], final_heading=final)


@pytest.mark.parametrize("low", [0.3, 4.0])
def test_slopes_and_curvatures_of_a_route_are_those_of_its_length(low):
    """Slopes and curvatures are those of the length.

    Central differences are taken wherever no word changes between their points.
    """
    random = np.random.default_rng(3)
    compared = 0
    for _ in range(60):
        route = route_of(random_route(random, 4, low, low + 4))
        x = random.uniform(-3, 3, route.unknowns)
        h = 1e-5
        functions = headings.program(route).functions
        steps = h * np.eye(x.size)
        words = {
            tuple(route.shortest(route.headings(x + s))[1]) for s in (*steps, *-steps, 0 * steps[0])
        }
        curved = functions.hessian(x, np.empty(0))
        if len(words) > 1 or not np.abs(curved).max() < 50:
            continue
        compared += 1
        both = [(x + step, x - step) for step in steps]
        slope = [(functions.objective(a) - functions.objective(b)) / (2 * h) for a, b in both]
        bend = [(functions.gradient(a) - functions.gradient(b)) / (2 * h) for a, b in both]
        # errors of differences: third derivatives times h^2, which grow with the curvature
        np.testing.assert_allclose(functions.gradient(x), slope, atol=1e-5)
        np.testing.assert_allclose(curved, bend, atol=1e-3)

    assert compared > 30


@pytest.mark.parametrize("low", [0.3, 4.0])
@pytest.mark.parametrize("posed", [joint.program, headings.program])
def test_entries_are_those_of_the_whole_derivatives(posed, low):
    """Entries are those of the whole derivatives.

    Engines of sparse programs are given every entry that is not zero, so many a leg.

    Whole matrices come from the same entries, or from functions written by hand.
    """
    random = np.random.default_rng(5)
    legs = 20
    program = posed(route_of(random_route(random, legs, low, low + 4)))
    functions = program.functions
    n = program.lower.size
    entries = functions.entries
    x = random.uniform(0.1, 3, n)
    weights = random.uniform(-2, 2, functions.equations(x).size)
    jacobian, hessian = np.zeros((weights.size, n)), np.zeros((n, n))

    jacobian[tuple(entries.jacobian_at)] = entries.jacobian(x)
    hessian[tuple(entries.hessian_at)] = entries.hessian(x, 1.0, weights)

    np.testing.assert_array_equal(jacobian, functions.jacobian(x))
    np.testing.assert_array_equal(hessian, np.tril(functions.hessian(x, weights)))
    assert entries.jacobian_at.shape[1] + entries.hessian_at.shape[1] < 50 * legs


@pytest.mark.parametrize("final", [None, 1.0])
def test_derivatives_of_a_route_are_those_of_its_equations(final):
    """Derivatives of a route are those of its equations.

    They are compared with central differences.
    """
    random = np.random.default_rng(7)
    h = 1e-6
    scenario = replace(random_route(random, 5, 4.0, 8.0), final_heading=final)
    program = joint.program(route_of(scenario))
    functions = program.functions
    n = program.lower.size
    x = random.uniform(0.1, 3, n)
    weights = random.uniform(-2, 2, functions.equations(x).size)
    both = [(x + step, x - step) for step in h * np.eye(n)]

    slope = [(functions.equations(a) - functions.equations(b)) / (2 * h) for a, b in both]
    bend = [weights @ (functions.jacobian(a) - functions.jacobian(b)) / (2 * h) for a, b in both]

    np.testing.assert_allclose(functions.jacobian(x), np.transpose(slope), atol=1e-7)
    np.testing.assert_allclose(functions.hessian(x, weights), bend, atol=1e-6)


@pytest.mark.parametrize("engine", ["uno-filtersqp", "trust-constr"])
def test_engines_of_sparse_programs_are_given_no_whole_matrix(engine):
    """Engines of sparse programs get no whole matrix.

    At 200 legs those took Uno 5 s of 5.2, and trust-constr all of its time.
    """
    if reason := ENGINES[engine].unavailable():
        pytest.skip(reason)
    points = [(8.0 * i, (-1) ** i) for i in range(1, 31)]
    scenario = Scenario(0, 0, 0, *points[-1], 1, via=points[:-1])
    route = route_of(scenario)
    known = best_of_grid(scenario, 24)
    places = joint.word_places(route, known)
    program = joint.program(route, places)
    guess = joint._unknowns_of(joint.words_guess(route), places)
    functions = program.functions._replace(jacobian=None, hessian=None)

    result = ENGINES[engine].load()(1e-6)(replace(program, written=functions), guess, 20.0)

    assert result.claim is Claim.LOCAL


def test_many_headings_at_once_have_the_lengths_of_each():
    route = route_of(NEAR)
    box = headings.LengthInBox(route, np.array((0.3, -2.0)))
    points = np.random.default_rng(1).uniform(0, 2 * math.pi, (2, 40))

    each = [box.at(point) for point in points.T]

    np.testing.assert_allclose(box.at_each(points), each, rtol=1e-14)


@pytest.mark.parametrize("seed", range(8))
def test_the_program_holds_all_six_words(seed):
    """The program holds all six words.

    The arcs of the shortest legs satisfy the equations, and are driven to the same end.
    """
    random = np.random.default_rng(seed)
    scenario = random_route(random, 12, 0.2, 4.0)
    route = route_of(scenario)
    program = joint.program(route)
    point = joint.words_guess(route)

    segments, words = route.shortest(route.headings(route.toward_next()))
    driven = path_of(scenario, WORD_TURNS[words].ravel(), segments.T.ravel())

    assert np.abs(program.functions.equations(point)).max() < 1e-12
    assert program.functions.objective(point) == pytest.approx(segments.sum(), rel=1e-14)
    assert driven.end[:2] == pytest.approx((scenario.target_x, scenario.target_y), abs=1e-11)
    assert len({*words}) > 1
    assert {*words} <= {*range(len(WORDS6))}


@pytest.mark.parametrize("guess", [joint.turned_guess, joint.random_guess])
def test_the_equations_are_what_the_arcs_leave(guess):
    """The equations are what the arcs leave.

    They are compared with the path driven leg by leg from the point where the leg begins.
    """
    scenario = GIVEN
    random = np.random.default_rng(5)
    route = route_of(scenario)
    point = guess(route, random) if guess is joint.random_guess else guess(route)
    left = joint.program(route).functions.equations(point)
    arcs = point.reshape(-1, 6)[:, :5]
    heading = route.first

    for leg, step in enumerate(route.steps):
        start = Scenario(0, 0, heading, 1, 1)
        end = path_of(start, (1, -1, 0, 1, -1), arcs[leg]).end
        heading = point[6 * leg + 5]
        assert left[3 * leg] == pytest.approx(heading - end.heading, abs=1e-12)
        assert left[3 * leg + 1 :][:2] == pytest.approx(step - np.array(end[:2]), abs=1e-12)
    assert abs(left[-1]) == pytest.approx(2 * abs(math.sin((heading - math.pi / 2) / 2)))


def test_the_final_heading_may_be_turns_away():
    """The final heading may be turns away.

    Its equation holds after a whole turn more, and not at the opposite.
    """
    route = route_of(GIVEN)
    program = joint.program(route)
    point = joint.turned_guess(route)
    assert program.functions.equations(point)[-1] == pytest.approx(0, abs=1e-12)
    for turn, left in ((2 * math.pi, 0.0), (4 * math.pi, 0.0), (math.pi, 2.0)):
        moved = point.copy()
        moved[-1] += turn
        assert abs(program.functions.equations(moved)[-1]) == pytest.approx(left, abs=1e-12)


def test_without_an_unknown_heading_no_engine_is_asked():
    scenario = Scenario(0, 0, 0.3, 1, 5, 1, final_heading=2.0)
    solution = ask(load("headings[engine=cma-es]"), Question(scenario), 10.0).solution

    assert solution.claim is Claim.FEASIBLE
    assert solution.evaluations == 1
    shortest_leg = shortest_to_pose(scenario.start, Pose(1, 5, 2.0), 1.0)
    assert solution.claimed_length == pytest.approx(shortest_leg.total, rel=1e-14)


def test_turns_below_zero_are_given_to_their_neighbours():
    """Turns below zero are given to their neighbours.

    The turn of a leg stays; cut off, it would turn every leg after it.
    """
    arcs = np.array([[-1e-8, 0.5, 3.0, 1.0, -2e-8], [0.2, 0.0, -1e-8, -1e-9, 0.4]])
    driven = joint._driven(arcs)
    turns = np.array((1, -1, 0, 1, -1))

    assert (driven >= 0).all()
    np.testing.assert_allclose(driven @ turns, arcs @ turns, atol=1e-16)


@pytest.mark.parametrize("spec", ["headings[engine=shgo]", "headings[engine=ipopt]"])
def test_engines_that_cannot_read_headings_are_refused(spec):
    with pytest.raises(SolverError, match="expected one of"):
        load(spec)


def of_all_choices(scenario: Scenario, count: int) -> float:
    """Shortest of all ways through the grid.

    Each leg is solved by the scalar closed form.
    """
    grid = scenario.heading + np.arange(count) * 2 * math.pi / count
    given = scenario.final_heading
    free = [grid] * (scenario.legs - (given is not None))
    ends = free if given is None else [*free, [given]]
    points = scenario.points
    least = math.inf
    known: dict[tuple[int, float, float], float] = {}

    def length(leg: int, a: float, b: float) -> float:
        if (leg, a, b) not in known:
            (x, y), (u, v) = points[leg : leg + 2]
            ends = Pose(x, y, a), Pose(u, v, b)
            known[leg, a, b] = pose_path(*ends, scenario.radius).length
        return known[leg, a, b]

    for chosen in product(*ends):
        pairs = enumerate(pairwise((scenario.heading, *chosen)))
        least = min(least, sum(length(leg, float(a), float(b)) for leg, (a, b) in pairs))
    return least


@pytest.mark.parametrize("scenario", [NEAR, FREE], ids=["near", "far"])
def test_the_answer_is_the_shortest_way_through_the_grid(scenario):
    answer = attempt(HeadingMilp(headings=10), Question(scenario), 20.0)

    assert answer.length == pytest.approx(of_all_choices(scenario, 10), rel=1e-9)
    assert answer.claim is Claim.LOCAL
    assert not answer.false_claim


@pytest.mark.parametrize("scenario", [NEAR, FREE], ids=["near", "far"])
def test_its_relaxation_is_integral_and_the_dynamic_programs(scenario):
    """Its relaxation is integral.

    A linear program has the dynamic program's vertex: this is why the integer program is only a
    check.
    """
    _, program = HeadingMilp(headings=12).build(Question(scenario))

    relaxed = linprog(program.cost, A_eq=program.rows, b_eq=program.least, method="highs-ds")
    segments, _ = route_of(scenario).shortest(best_of_grid(scenario, 12))

    assert np.abs(relaxed.x - np.round(relaxed.x)).max() < 1e-9
    assert relaxed.fun == pytest.approx(segments.sum(), rel=1e-9)


@pytest.mark.slow
def test_the_gap_falls_with_the_square_of_the_headings():
    """The gap falls with the square of headings.

    There are eight times the headings; a grid that happens to hold the best headings is averaged
    out.
    """
    gaps = [
        [attempt(HeadingMilp(headings=k), Question(scenario), 20.0).gap for k in (n, n + 1, n + 3)]
        for scenario in (FREE, NEAR)
        for n in (8, 64)
    ]

    for coarse, fine in zip(gaps[::2], gaps[1::2], strict=True):
        assert 16 < np.mean(coarse) / np.mean(fine) < 256


def test_the_bound_is_of_the_grid_and_is_not_passed_off_as_the_scenarios():
    """The bound is the grid's, not the scenario's.

    The bound in the message is the path's length, which is above the shortest one.
    """
    answer = attempt(HeadingMilp(), Question(NEAR), 20.0)
    bound = float(answer.message.split("bound ")[1].split()[0])

    assert answer.lower_bound is None
    assert "not for the scenario" in answer.message
    assert bound == pytest.approx(answer.length, rel=1e-6)
    assert bound > answer.reference_high


def test_every_engine_finds_the_same_optimum(capfd):
    """Every engine finds the same optimum in silence."""
    answer, highs = (attempt(HeadingMilp(name, 16), Question(FREE)) for name in ("scip", "highs"))

    assert answer.claim is highs.claim is Claim.LOCAL
    assert answer.length == pytest.approx(highs.length, rel=1e-6)  # their gap
    assert capfd.readouterr() == ("", "")


TRACED_ROUTE = Scenario(heading=0.5, target_x=10, target_y=5, via=[(4, 1), (6, -2), (3, 3)])
TRACED = ("nelder-mead", "differential-evolution", "cma-es", "slsqp", "nlopt-cobyla")


@pytest.mark.parametrize("engine", engine_params(TRACED))
def test_a_trace_gets_better_until_the_answer(engine):
    """A trace gets better until the answer.

    Evaluations grow, lengths fall, the last is the answer's, and tracing changes no answer.
    """
    spec = f"headings[engine={engine}]"
    traced, plain = solve(TRACED_ROUTE, f"{spec[:-1]},trace=true]"), solve(TRACED_ROUTE, spec)

    assert plain.trace_evaluations is None
    assert plain.length == traced.length
    assert np.all(np.diff(traced.trace_evaluations) > 0)
    assert np.all(np.diff(traced.trace_lengths) < 0)
    assert traced.trace_lengths[-1] == pytest.approx(traced.length, rel=1e-12)
    assert len(traced.trace_lengths) > 3


@pytest.mark.parametrize("engine", ["nelder-mead", "powell"])
def test_a_trace_is_what_smaller_budgets_give(engine):
    """A trace is what smaller budgets give.

    A search that may evaluate no more than N times returns what the trace has at N.
    """
    traced = solve(TRACED_ROUTE, f"headings[engine={engine},trace=true]")

    for place in (1, len(traced.trace_lengths) // 2):
        budget = int(traced.trace_evaluations[place])
        short = solve(TRACED_ROUTE, f"headings[engine={engine},evaluations={budget}]")
        assert short.length == pytest.approx(traced.trace_lengths[place], rel=1e-12)


def test_runs_from_several_guesses_are_counted_one_after_another():
    """Runs from several guesses are counted in turn.

    What the second run finds has been paid for by all of the first.
    """
    spec = "headings[engine=nelder-mead,initial_guess=random,seed=1,trace=true,count={}]"
    one, both = (solve(TRACED_ROUTE, spec.format(count)) for count in (1, 2))

    later = [n for n in both.trace_evaluations if n > one.trace_evaluations[-1]]
    assert both.length < one.length
    assert later
    assert min(later) > one.evaluations


def test_a_trace_travels_with_its_reply():
    """A trace travels with its reply.

    It has plain values, path by path.
    """
    reply = ask(load("headings[engine=nelder-mead,trace=true]"), Question(TRACED_ROUTE))

    sent = decode_reply(encode_reply(reply))

    assert sent.solution.trace == reply.solution.trace
    assert len(reply.solution.trace) > 3

"""`headings` and `route-nlp`: derivatives, equations, every engine on small routes.

The lengths are compared with a dynamic program over a fine grid of headings, which is no solver's.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from dubins_study.solvers.course import path_of
from dubins_study.solvers.engines import ENGINES, NLP_ENGINES
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import SolverError, load
from dubins_study.solvers.reply import ask
from dubins_study.solvers.route import headings, joint
from dubins_study.solvers.route.legs import WORD_TURNS, route_of
from dubins_study.study.closed_form.pose import WORDS6
from dubins_study.study.closed_form.pose_kernel import pose_rows
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome

# Its library breaks others in the same process.
ALONE = ("sleqp",)
HEADINGS = [load("headings").engine, *(v[16:-1] for v in type(load("headings")).variants)]
SPECS = [
    *(f"headings[engine={name}]" for name in HEADINGS),
    *(f"route-nlp[engine={name}]" for name in NLP_ENGINES if name not in ALONE),
]
AVAILABLE = [spec for spec in SPECS if load(spec).unavailable() is None]
FAR = Scenario(1, 2, "30deg", 22, 9, 2, via=[(12, 4), (14, -8)])  # all legs above 4 radii
SCENARIOS = {
    "free": FAR,
    "given": Scenario(1, 2, "30deg", 22, 9, 2, via=FAR.via, final_heading="90deg"),
    "near": Scenario(0, 0, 0, 1, 2, 1, via=[(1.5, 0.5), (0.5, 3)], final_heading=2.0),
}


@pytest.fixture(autouse=True)
def _one_thread():
    with threadpool_limits(1):
        yield


def random_route(random: np.random.Generator, legs: int, low: float, high: float) -> Scenario:
    directions = random.uniform(-math.pi, math.pi, legs)
    steps = np.array((np.cos(directions), np.sin(directions))) * random.uniform(low, high, legs)
    points = np.cumsum(steps, axis=1).T
    final = random.uniform(-3, 3) if random.uniform() < 0.5 else None
    return Scenario(0, 0, 0.7, *points[-1], 1, via=points[:-1], final_heading=final)


def least_on_a_grid(scenario: Scenario, count: int = 360) -> float:
    """The shortest route over a grid of headings at each point (length unit)."""
    grid = np.arange(count) * 2 * math.pi / count
    cost, first = np.zeros(1), np.array([scenario.heading])
    points = scenario.points
    for leg, ((x, y), (tx, ty)) in enumerate(pairwise(points)):
        last = grid
        if leg == scenario.legs - 1 and scenario.final_heading is not None:
            last = np.array([scenario.final_heading])
        a, b = (each.ravel() for each in np.meshgrid(first, last, indexing="ij"))
        same = np.ones(a.size)
        ends = x * same, y * same, a, tx * same, ty * same, scenario.radius * same, b
        lengths = pose_rows(*ends).length.reshape(first.size, last.size)
        cost, first = (cost[:, None] + lengths).min(0), last
    return float(cost.min())


def missed(scenario: Scenario, path: Path) -> float:
    """The largest distance (length unit) by which a path passes a point aside, in their order."""
    x, y, heading = (np.asarray(column) for column in path.sample(20_001).T)
    begin, largest = 0, 0.0
    for px, py in scenario.points[1:]:
        dx, dy = px - x[begin:], py - y[begin:]
        away = np.hypot(dx, dy)
        # the first place that is near, if there is one
        near = np.flatnonzero(away < 0.01 * scenario.radius)
        least = int(near[0] + np.argmin(away[near[0] : near[0] + 50])) if near.size else 0
        aside = dy * np.cos(heading[begin:]) - dx * np.sin(heading[begin:])
        largest = max(largest, abs(float(aside[least])) if near.size else float(away.min()))
        begin += least
    return largest


@pytest.mark.parametrize("low", [0.3, 4.0])
def test_slopes_and_curvatures_of_a_route_are_those_of_its_length(low):
    """Against central differences, wherever no word changes between their points."""
    random, compared = np.random.default_rng(3), 0
    for _ in range(60):
        route = route_of(random_route(random, 4, low, low + 4))
        x, h = random.uniform(-3, 3, route.unknowns), 1e-5
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


def test_many_headings_at_once_have_the_lengths_of_each():
    route = route_of(SCENARIOS["near"])
    box = headings.LengthInBox(route, np.array((0.3, -2.0)))
    points = np.random.default_rng(1).uniform(0, 2 * math.pi, (2, 40))

    each = [box.at(point) for point in points.T]

    np.testing.assert_allclose(box.at_each(points), each, rtol=1e-14)


@pytest.mark.parametrize("seed", range(8))
def test_the_program_holds_all_six_words(seed):
    """The arcs of the shortest legs satisfy the equations, and are driven to the same end."""
    random = np.random.default_rng(seed)
    scenario = random_route(random, 12, 0.2, 4.0)
    route = route_of(scenario)
    program, point = joint.program(route), joint.words_guess(route)

    segments, words = route.shortest(route.headings(route.toward_next()))
    driven = path_of(scenario, WORD_TURNS[words].ravel(), segments.T.ravel())

    assert np.abs(program.functions.equations(point)).max() < 1e-12
    assert program.functions.objective(point) == pytest.approx(segments.sum(), rel=1e-14)
    assert driven.end[:2] == pytest.approx((scenario.target_x, scenario.target_y), abs=1e-11)
    assert len({*words}) > 1
    assert {*words} <= {*range(len(WORDS6))}


@pytest.mark.parametrize("guess", [joint.turned_guess, joint.random_guess])
def test_the_equations_are_what_the_arcs_leave(guess):
    """Against the path driven leg by leg from the point where the leg begins."""
    scenario, random = SCENARIOS["given"], np.random.default_rng(5)
    route = route_of(scenario)
    point = guess(route, random) if guess is joint.random_guess else guess(route)
    left = joint.program(route).functions.equations(point)
    arcs, heading = point.reshape(-1, 6)[:, :5], route.first

    for leg, step in enumerate(route.steps):
        start = Scenario(0, 0, heading, 1, 1)
        end = path_of(start, (1, -1, 0, 1, -1), arcs[leg]).end
        heading = point[6 * leg + 5]
        assert left[3 * leg : 3 * leg + 2] == pytest.approx(step - np.array(end[:2]), abs=1e-12)
        assert left[3 * leg + 2] == pytest.approx(end.heading - heading, abs=1e-12)
    assert abs(left[-1]) == pytest.approx(2 * abs(math.sin((heading - math.pi / 2) / 2)))


@pytest.mark.parametrize("final", [None, 1.0])
def test_the_programs_derivatives_are_sparse_and_exact(final):
    """Against differences of every variable; 5 legs have no entry that a chain of legs has not."""
    points = np.cumsum(np.random.default_rng(2).uniform(1, 4, (5, 2)), axis=0)
    route = route_of(Scenario(0, 0, 0, *points[-1], 1, via=points[:-1], final_heading=final))
    program = joint.program(route)
    x = joint.random_guess(route, np.random.default_rng(4))
    functions, h = program.functions, 1e-6
    steps = h * np.eye(x.size)
    differences = np.array(
        [(functions.equations(x + s) - functions.equations(x - s)) / (2 * h) for s in steps]
    ).T
    weights = np.random.default_rng(6).normal(size=len(differences))
    sloped = [
        (weights @ functions.jacobian(x + s) - weights @ functions.jacobian(x - s)) / (2 * h)
        for s in steps
    ]

    np.testing.assert_allclose(functions.jacobian(x), differences, atol=1e-7)
    np.testing.assert_allclose(functions.hessian(x, weights), sloped, atol=1e-6)

    import casadi

    pattern = casadi.jacobian(program.expressions.g, program.expressions.x).sparsity()
    dense = np.array(casadi.DM(pattern, 1.0).full(), dtype=bool)
    assert not differences[~dense].any()
    # 7 + 7 - 2 entries for the end of a leg, whose own heading the first equations see as well,
    # 6 for the heading after it; the start's heading is given
    assert pattern.nnz() <= 5 * 20 + (final is not None)


@pytest.mark.parametrize("spec", AVAILABLE)
@pytest.mark.parametrize("name", SCENARIOS)
def test_a_route_is_found_and_nothing_false_is_claimed(spec, name):
    """A path through all points with the final heading, no shorter than any can be."""
    scenario = SCENARIOS[name]
    reply = ask(load(spec), Question(scenario), 10.0)
    solution, radius = reply.solution, scenario.radius
    least = least_on_a_grid(scenario)

    assert reply.outcome is Outcome.RETURNED, solution.message
    assert solution.claim not in (Claim.OPTIMAL, Claim.INFEASIBLE)
    if spec.startswith("headings"):
        assert solution.claim in (Claim.LOCAL, Claim.FEASIBLE)
    if solution.claim not in (Claim.LOCAL, Claim.FEASIBLE):
        return
    path = solution.path
    assert path is not None
    # sampled 0.003 lengths apart, a path bends aside by the square of that
    assert missed(scenario, path) < 1e-5 * radius
    if scenario.final_heading is not None:
        assert math.remainder(path.end.heading - scenario.final_heading, 2 * math.pi) == (
            pytest.approx(0, abs=1e-6)
        )
    assert solution.claimed_length == pytest.approx(path.length, abs=1e-5 * radius)
    # the grid's route is longer than the shortest by about the square of its step, where D is
    # smooth; the paths found are local minima at the grid's or longer
    assert path.length > least - 0.02 * radius


def test_the_final_heading_may_be_turns_away():
    """The equation of a final heading holds after a whole turn more, and not at the opposite."""
    route = route_of(SCENARIOS["given"])
    program, point = joint.program(route), joint.turned_guess(route)
    assert program.functions.equations(point)[-1] == pytest.approx(0, abs=1e-12)
    for turn, left in ((2 * math.pi, 0.0), (4 * math.pi, 0.0), (math.pi, 2.0)):
        moved = point.copy()
        moved[-1] += turn
        assert abs(program.functions.equations(moved)[-1]) == pytest.approx(left, abs=1e-12)


@pytest.mark.parametrize("spec", ["headings[engine=powell]", "headings[engine=slsqp]", "route-nlp"])
def test_one_leg_with_a_free_final_heading_is_a_route_too(spec):
    scenario = Scenario(0, 0, 0.3, 1, 5, 1)
    solution = ask(load(spec), Question(scenario), 10.0).solution

    assert solution.path is not None
    assert solution.path.length == pytest.approx(shortest(scenario).total, abs=1e-6)
    if spec == "route-nlp":
        # The duals of the end are the direction in which the path arrives; an interior point is
        # 1e-3 rad off, since an arc that costs the cube of its length is not quite zero.
        heading = solution.path.end.heading
        expected = math.cos(heading), math.sin(heading)
        assert solution.multipliers == pytest.approx(expected, abs=1e-3)


def test_without_an_unknown_heading_no_engine_is_asked():
    scenario = Scenario(0, 0, 0.3, 1, 5, 1, final_heading=2.0)
    solution = ask(load("headings[engine=cma-es]"), Question(scenario), 10.0).solution

    assert solution.claim is Claim.FEASIBLE
    assert solution.evaluations == 1
    assert solution.claimed_length == pytest.approx(least_on_a_grid(scenario), rel=1e-14)


def test_turns_below_zero_are_given_to_their_neighbours():
    """The turn of a leg stays; cut off, it would turn every leg after it."""
    arcs = np.array([[-1e-8, 0.5, 3.0, 1.0, -2e-8], [0.2, 0.0, -1e-8, -1e-9, 0.4]])
    driven = joint._driven(arcs)
    turns = np.array((1, -1, 0, 1, -1))

    assert (driven >= 0).all()
    np.testing.assert_allclose(driven @ turns, arcs @ turns, atol=1e-16)


@pytest.mark.parametrize("spec", ["headings[engine=shgo]", "headings[engine=ipopt]"])
def test_engines_that_cannot_read_headings_are_refused(spec):
    with pytest.raises(SolverError, match="expected one of"):
        load(spec)


@pytest.mark.parametrize("spec", SPECS)
def test_a_solver_names_its_formulation_and_engine(spec):
    solver = load(spec)
    expected = "headings" if spec.startswith("headings") else "joint NLP, LRSLR a leg"

    assert solver.method[:2] == (expected, ENGINES[solver.engine].label)

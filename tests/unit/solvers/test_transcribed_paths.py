"""Paths of every transcription.

Each has the closed form's length up to its tolerance or its steps. Turning to one side proves
nothing of the words LS and RS. Collocation and turn rates stand beside an integrator; the engines
of turn-rate-qp are tested.
"""

import math
from time import process_time

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from dubins_study.asking.attempt import attempt
from dubins_study.experiments.solve import solve
from dubins_study.solvers.arcs import RATES
from dubins_study.solvers.engines import ENGINES as TABLE
from dubins_study.solvers.engines import names
from dubins_study.solvers.optimal_control.turn_rate_qp import TurnRateQp
from dubins_study.solvers.optimal_control.turn_rate_template import (
    EngineError,
    Numbers,
    template,
)
from dubins_study.solvers.optimal_control.turn_rates import expressions
from dubins_study.solvers.protocol import Question, Solution
from dubins_study.solvers.registry import load
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.judging.judge import judge
from dubins_study.study.path import Path
from dubins_study.study.rows.schema import Judgement
from dubins_study.study.scenario import Pose, Scenario
from dubins_study.study.scenario_frame import scenario_of
from dubins_study.study.words import QP, Claim, Proof, Verdict
from tests.brute_force import integrated
from tests.cases import EDGES, QUICK_ENGINES, margin, placed
from tests.hard_cases import hard_frame

# The gap that the engine's tolerance of 1e-9 leaves of free lengths; of free elements a few 1e-11
# an element, and 3e-8 at most over 900 questions of the hard frame, on a circle, where convergence
# is slowest.
TINY = {"multiple-shooting": 1e-8, "collocation": 1e-7}
SLOW_COLLOCATION = ["multiple-shooting", pytest.param("collocation", marks=pytest.mark.slow)]
LEFT = Scenario(0, 0, 0, -0.2, 0.6, 1)


@pytest.mark.many(8)
@pytest.mark.parametrize("spec", TINY)
@pytest.mark.parametrize("branch", RATES)
@pytest.mark.parametrize("edge", EDGES)
def test_every_branch_at_every_kind_of_target(edge, branch, spec):
    """Every branch works at every kind of target.

    It finds the closed form's length, and turns to the branch's side only; else the search fails.
    """
    answer = solve(EDGES[edge], spec, branch)

    assert not answer.false_claim
    if shortest(EDGES[edge], branch) is None:
        assert answer.claim in (Claim.FAILED, Claim.INFEASIBLE)
        assert answer.iterations > 0
        return
    assert answer.verdict is Verdict.OPTIMAL
    assert abs(answer.gap) <= TINY[spec]
    rate = answer.path.curvatures * EDGES[edge].radius
    # dividing by the radius and multiplying again may cost a rounding
    assert rate.min(initial=0) >= RATES[branch].lower - 1e-15
    assert rate.max(initial=0) <= RATES[branch].upper + 1e-15


@pytest.mark.slow
@pytest.mark.parametrize("spec", TINY)
def test_hard_scenarios(spec):
    """Hard scenarios are solved.

    Radii are from 1e-6 to 1e6, targets on circles, next to them, at the start and 1e9 radii away.
    """
    for row in hard_frame(24, seed=3).itertuples():
        scenario = scenario_of(row._asdict())
        for branch in RATES:
            answer = attempt(load(spec), Question(scenario, branch), 60.0)
            assert not answer.false_claim, (scenario, branch)
            assert not answer.wrong_basin, (scenario, branch)
            exists = shortest(scenario, branch) is not None
            assert not exists or answer.verdict is Verdict.OPTIMAL, (scenario, branch)


@pytest.mark.parametrize("spec", SLOW_COLLOCATION)
def test_equal_elements_gain_with_their_number(spec):
    """Equal elements gain with their number.

    A switch inside an element costs; 8 times more elements cost 20 times less, or better.

    64 would be the second order's; where in an element the switch falls decides the rest.
    """
    more = "points=3," if spec == "collocation" else ""
    coarse, fine = (solve(LEFT, f"{spec}[{more}mesh=equal,n={n}]").gap for n in (10, 80))

    assert TINY[spec] < fine < coarse / 20


@pytest.mark.many(2)
@pytest.mark.parametrize("place", [(5, 1, 0.7), (-3, 0, 0), (-0.2, 0.6, 0)])
@pytest.mark.parametrize(
    ("spec", "steps", "factor"),
    [("turn-rates", (12, 24, 72, 144), 15), ("turn-rate-qp", (12, 24, 192, 384), 100)],
)
def test_the_gap_falls_with_the_square_of_the_step(spec, steps, factor, place):
    """The gap falls with the square of steps.

    6 or 16 times more steps: 15 or 100 times smaller where order two would give 36 or 256.
    """
    X, Y, heading = place
    gaps = [solve(Scenario(0, 0, heading, X, Y, 1), f"{spec}[n={n}]").gap for n in steps]

    coarse, fine = gaps[0] + gaps[1], gaps[2] + gaps[3]  # where a step ends matters: average
    assert 0 < fine < coarse / factor


@pytest.mark.many(2)
@pytest.mark.parametrize("spec", ["turn-rates", "turn-rate-qp"])
@pytest.mark.parametrize("mesh", ["equal", "graded"])
def test_far_targets_need_a_graded_mesh(spec, mesh):
    """Far targets need a graded mesh.

    1000 R behind, equal steps are 20 R long: the turn is too wide, and the gap says so.
    """
    answer = solve(Scenario(0, 0, 0, -950, 300, 1), f"{spec}[mesh={mesh}]")

    assert answer.claim is Claim.LOCAL
    assert 1e-3 < answer.gap < 0.05 if mesh == "equal" else answer.gap < 1e-5


@pytest.mark.many(3)
@pytest.mark.parametrize("spec", ["collocation", "turn-rate-qp"])
@pytest.mark.parametrize(
    ("curvature", "length"),
    [([1.0, 0.0] * 4, [0.5] * 8), ([math.nan], [1.0]), ([], []), ([1.0], [0.0]), ([5.0], [3.0])],
)
def test_a_useless_warm_start_does_no_harm(spec, curvature, length):
    """A useless warm start does no harm.

    It has more arcs than elements, or is broken, of no length, or turns too hard.
    """
    behind = EDGES["behind"]

    guess = Path(behind.start, curvature, length)
    answer = attempt(load(spec), Question(behind, initial_guess=guess), 10.0)

    assert answer.verdict is Verdict.OPTIMAL


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spec", "limit"),
    [
        ("collocation[n=160,mesh=equal]", 0.1),  # without the limit 4 s
        ("multiple-shooting[n=20,mesh=equal]", 1e-3),
        ("turn-rates[n=50]", 1e-3),
    ],
)
def test_time_runs_out(spec, limit):
    """The engine stops between two iterations."""
    solver = load(spec)
    model = solver.build(Question(LEFT))
    solver.solve(model, limit)  # compiled
    began = process_time()  # a busy machine takes the wall clock, not the processor

    solution = solver.solve(model, limit)

    assert process_time() - began < 1.0 + limit
    assert solution.claim is Claim.LIMIT
    if spec.startswith("collocation"):  # keeps the point that it has
        assert solution.path is not None


# inside the circle of the first turn, which no path of the word enters
INSIDE = [(0.0, 1.0), (0.3, 0.6), (-0.5, 1.2)]


def one_sided(X, Y):
    """A one-sided path to a target in the disc.

    It goes straight on, and then less than a full turn to the left.
    """
    ahead = X + math.sqrt(1 - (Y - 1) ** 2)
    return Path((0.0, 0.0, 0.0), [0.0, 1.0], [ahead, math.atan2(X - ahead, 1 - Y) % (2 * math.pi)])


@pytest.mark.many(2)
@pytest.mark.parametrize(("X", "Y"), INSIDE)
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("name", ["turn-rates", "collocation", "multiple-shooting", "turn-rate-qp"])
def test_no_claim_about_the_word(name, side, X, Y):
    """No claim is made about the word.

    With rates on one side a path exists, so a solver that calls that infeasible has failed.

    The word has none: `none exists` would be right by accident, and proved by nobody.
    """
    there = one_sided(X, Y)
    assert (there.end.x, there.end.y) == pytest.approx((X, Y), abs=1e-12)
    assert there.lengths[0] > 0
    answer = solve(Scenario(0, 0, 0, X, side * Y, 1), name, "LS" if side > 0 else "RS")

    assert answer.claim not in (Claim.INFEASIBLE, Claim.OPTIMAL, Claim.LOCAL)
    assert answer.verdict is not Verdict.NONE_EXISTS
    assert answer.proof is Proof.NONE
    assert not answer.false_claim


def test_the_transcription_is_an_ode_solved_by_quadrature():
    """The transcription is the ODE, by quadrature.

    The end point that Ipopt meets is the ODE's, up to the miss that is reported before closing.

    An adaptive integrator drives the raw controls; with 3 points an arc cannot be hit by chance.
    """
    answer = solve(LEFT, "collocation[n=4,points=3,correct=false]")
    x, y, _ = integrated(answer.path)
    off = math.hypot(x - LEFT.target_x, y - LEFT.target_y)

    assert answer.path.length == pytest.approx(answer.claimed_length, rel=1e-12)
    assert off == pytest.approx(answer.miss, rel=1e-6)
    assert f"missed by {off:.1e} radii" in answer.message
    assert answer.verdict is Verdict.MISSES


@pytest.mark.many(1)
@pytest.mark.parametrize("points", [2, 3, 4])
def test_the_miss_falls_as_radaus_order_says(points):
    """The miss falls as Radau's order says.

    The order is 2 p - 1 in the elements (Hairer and Wanner 1996, sec. IV.5), switch or no switch.
    """
    misses = [
        solve(LEFT, f"collocation[n={n},points={points},correct=false]").miss for n in (4, 12)
    ]

    order = math.log(misses[0] / misses[1], 3)
    # each order is seen a few tenths off, since the elements at either arc's end differ in size
    assert order == pytest.approx(2 * points - 1, abs=1.5)


@given(st.integers(2, 12), st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_equations_are_the_gap_at_the_end(n, seed):
    """An adaptive integrator drives the steps one after another."""
    random = np.random.default_rng(seed)
    rate = random.uniform(-1, 1, n)
    whole = random.uniform(0.5, 8)
    share = random.dirichlet(np.ones(n))
    target = random.normal(size=2)
    pose = integrated(Path(Pose(0, 0, 0), rate, share * whole))

    functions = expressions(n, 1, 0).functions(np.concatenate((target, share)))
    x = np.append(rate, whole)

    assert functions.equations(x) == pytest.approx(target - pose[:2], abs=1e-8)
    assert functions.objective(x) == pytest.approx(whole)


DEFAULT = TurnRateQp()
ENGINES = names(QP)
# in radii, from the origin facing +x
PLACES = {
    "left": (4.0, 3.0),
    "right": (2.0, -5.0),
    "behind": (-3.0, 0.0),
    "ahead": (4.0, 0.0),
    "left centre": (0.0, 1.0),
    "right centre": (0.0, -1.0),
    "left disc": (-0.2, 0.6),
    "right disc": (0.4, -1.2),
    "near": (2e-3, 1e-3),
    "at the start": (0.0, 0.0),
}


def scenario_at(X: float, Y: float, radius: float = 1.0) -> Scenario:
    """A target at (X, Y) radii of the vehicle.

    The start is away from the origin.
    """
    return placed(X, Y, 2 * radius, -radius, 0.7, radius)


def ask(
    scenario: Scenario, branch: str = "best", solver: TurnRateQp = DEFAULT
) -> tuple[Solution, Judgement]:
    solution = solver.solve(solver.build(Question(scenario, branch)), 20.0)
    return solution, judge(scenario, solution.path, solution.claim, branch)


def check_path(scenario: Scenario, solution: Solution, found: Judgement, n: int) -> None:
    """Check the promises of every path.

    It has n steps from the start, ends on the target, and keeps rates in bounds.
    """
    assert solution.path.start == scenario.start
    assert solution.path.curvatures.size in (0, n)  # at the start there is nothing to drive
    # dividing by the radius and multiplying again may cost a rounding
    assert found.curvature_excess <= 1e-15
    assert found.miss <= 1e-8 * scenario.radius + 1e-13 * scenario.extent


@pytest.mark.many(4)
@pytest.mark.parametrize(
    ("engine", "place"),
    [
        pytest.param(
            *(engine, place),
            marks=() if engine in QUICK_ENGINES else pytest.mark.slow,
        )
        for engine in ENGINES
        for place in PLACES
    ],
)
def test_every_engine_answers_everywhere(engine: str, place: str) -> None:
    """Every engine answers everywhere.

    It has a path with a small gap, or at least a claim that says there is none.
    """
    scenario = scenario_at(*PLACES[place])
    solver = TurnRateQp(n=30, engine=engine, options="tuned")

    solution, found = ask(scenario, solver=solver)

    assert not found.false_claim
    if solution.claim == Claim.FAILED:
        assert engine in ("osqp", "highs")  # the other two solve all of these
    else:
        assert found.gap is not None
        assert found.gap <= 3e-3
        check_path(scenario, solution, found, solver.n)


@pytest.mark.parametrize("branch", ["LS", "RS"])
@pytest.mark.parametrize("distance", [1e-9, 1e-4, 0.02])
def test_one_sided_turns_near_the_start(branch: str, distance: float) -> None:
    """One-sided turns near the start.

    It is almost a full circle to a point just beside the start on the other side.
    """
    sign = -1.0 if branch == "LS" else 1.0
    scenario = scenario_at(-0.9 * distance, sign * 0.4 * distance)

    solution, found = ask(scenario, branch)

    assert solution.claim == Claim.LOCAL
    assert found.verdict == Verdict.OPTIMAL


@pytest.mark.parametrize("engine", ENGINES)
def test_failing_engine_is_a_claim(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A failing engine is a claim.

    Starts are given up one by one; nothing is raised.
    """

    def fail(*_: object) -> None:
        raise EngineError("numerical trouble")

    monkeypatch.setattr(template(20, 1, False, engine), "solve", fail, raising=True)

    solution, found = ask(scenario_at(-3.0, 2.0), solver=TurnRateQp(n=20, engine=engine))

    assert solution.claim in (Claim.FAILED, Claim.FEASIBLE)  # the correction alone may arrive
    assert "numerical trouble" in solution.message
    assert not found.false_claim


@pytest.mark.parametrize("engine", ENGINES)
def test_compiled_qp_solves_what_cvxpy_solves(engine: str) -> None:
    """The compiled QP solves what cvxpy solves.

    Values written into the engine's arrays give the answer that cvxpy's own path gives.
    """
    n = 12
    qp = template(6, 2, True, engine)
    random = np.random.default_rng(5)
    numbers = Numbers(
        G=random.normal(size=(2, n)) / n,
        P=random.normal(size=(2, 2)) / n,
        q=np.array([[0.8, 0.5], [0.3, -0.6]]),
        r=np.array([[0.05, 0.01], [-0.02, 0.03]]),
        w=np.array([0.7, 1.3]),
        upper=np.full(n, 0.1),
        lower=np.full(n, -0.1),
        above=random.uniform(0.05, 0.15, n),
        below=random.uniform(0.05, 0.15, n),
        c=np.full(n, 0.02),
        penalty=np.array([10.0]),
        reach=np.array([0.5]),
        stretch=np.array([0.4]),
        h=np.array([0.5]),
        r_h=np.array([0.04]),
    )
    ours = qp.solve(numbers, TABLE[engine].options.of("tuned"), 10.0)

    problem, _ = qp.stated(numbers)
    value = problem.solve(solver="CLARABEL")

    tolerance = 1e-3 if engine == "osqp" else 1e-6  # what they are asked for, times the penalty
    assert ours.value == pytest.approx(value, abs=tolerance)
    assert ours.z == pytest.approx(qp.z.value, abs=30 * tolerance)


targets = st.one_of(
    st.tuples(st.floats(-10, 10), st.floats(-10, 10)),
    st.tuples(st.floats(-1, 1), st.floats(-2, 2)),  # both discs and between
)


@pytest.mark.slow
@given(
    targets, st.floats(-6, 6), st.sampled_from((20, 50, 120)), st.sampled_from(("piqp", "clarabel"))
)
@settings(max_examples=40)
def test_random_scenarios(target: tuple[float, float], exponent: float, n: int, engine: str):
    """Random scenarios are answered in the right basin.

    Every branch, target and radius has a path that arrives.

    By the two engines that are expected never to fail.
    """
    scenario = scenario_at(*target, radius=10.0**exponent)
    solver = TurnRateQp(n=n, engine=engine)
    # nearer than the miss that is allowed, one may stand for the other side or for staying; beside
    # the axis ahead, straight on stands for the turn to the other side, which takes a full circle
    assume(margin(scenario) > 1e-8 and math.hypot(*target) > 1e-8)
    assume(target[1] == 0 or abs(target[1]) > 1e-8)
    for branch in RATES:
        solution, found = ask(scenario, branch, solver)
        assert not found.false_claim
        # straight behind the two basins tie, and a coarse answer in either is a good one; beside a
        # circle the shorter basin is narrower than a coarse step
        beside = margin(scenario) < 0.01
        assert beside or not found.wrong_basin or (found.gap or 1.0) < 5e-3
        if shortest(scenario, branch) is None:
            # the last program of a sequence may be infeasible: a word on its neighbourhood
            assert solution.claim in (Claim.FAILED, Claim.LOCALLY_INFEASIBLE)
        else:
            assert solution.claim == Claim.LOCAL
            check_path(scenario, solution, found, solver.n)
            assert found.gap is not None
            assert found.gap > -1e-6  # a path that is too short to be true would be a bug

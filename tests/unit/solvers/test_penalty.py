"""penalty: its function, and engines over seeds.

The function is compared with driven paths, grids and theory.
"""

import math
from itertools import count

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from dubins_study.asking.attempt import attempt
from dubins_study.solvers.engines import ENGINES, names
from dubins_study.solvers.one_leg.model import SUBPROBLEMS, as_path, case_of
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.solvers.stochastic import penalty_function
from dubins_study.solvers.stochastic.penalty_function import PenaltyFunction
from dubins_study.study.body_coordinates import local
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import DERIVATIVE_FREE, SAMPLING, Claim, Verdict
from tests.cases import EDGES, PAPER

SEARCHES = names(SAMPLING, DERIVATIVE_FREE)
AVAILABLE = [name for name in SEARCHES if ENGINES[name].unavailable() is None]
LEFT_DISC = EDGES["centre of the left disc"]
SCENARIOS = {
    "ahead to the left": Scenario(0, 0, 0, 3, 2, 1),
    "behind to the right": Scenario(1, 1, 2, 4, -1, 0.7),
    "left disc": LEFT_DISC,
    "right disc": EDGES["rear of the right disc"],
}


@pytest.fixture(autouse=True)
def _one_thread():
    """One thread, as in every run.

    On a busy machine the threads of a tiny matrix wait for each other.
    """
    with threadpool_limits(1):
        yield


def function_of(scenario: Scenario, name: str, weight: float) -> PenaltyFunction:
    return PenaltyFunction(case_of(name, local(scenario)), weight)


def spec(engine: str, **others: object) -> str:
    return f"penalty[{','.join(f'{k}={v}' for k, v in {'engine': engine, **others}.items())}]"


@pytest.mark.parametrize("name", SUBPROBLEMS)
def test_the_function_is_length_plus_weighted_miss_of_the_driven_path(name):
    """The function is length plus weighted miss.

    It is compared with the driven path's own end, one point at a time and many at once, to
    rounding.
    """
    scenario = SCENARIOS["behind to the right"]
    function = function_of(scenario, name, 3.0)
    points = np.random.default_rng(1).uniform(size=(function.upper.size, 50))
    points *= function.upper[:, None]

    expected = []
    for point in points.T:
        path = as_path(scenario, SUBPROBLEMS[name], function.lengths(point))
        miss = math.hypot(path.end.x - scenario.target_x, path.end.y - scenario.target_y)
        expected.append((path.length + 3.0 * miss) / scenario.radius)

    np.testing.assert_allclose(function.at_each(points), expected, rtol=1e-13)
    np.testing.assert_allclose([function.at(point) for point in points.T], expected, rtol=1e-13)


@pytest.mark.parametrize("name", AVAILABLE)
def test_every_engine_in_a_disc(name):
    """Every engine works in a disc.

    Where the search stops short, the claim says so; a path that arrives is no shorter.

    No search evaluates more often than it may; what each order cost is told.
    """
    answer = attempt(load(spec(name, evaluations=200, rounds=2)), Question(LEFT_DISC))

    assert not answer.false_claim
    if answer.claim is Claim.FEASIBLE:
        assert answer.verdict in (Verdict.OPTIMAL, Verdict.LONGER)
        assert answer.gap >= -1e-12
    else:
        assert answer.claim in (Claim.LIMIT, Claim.FAILED)
        assert answer.verdict is Verdict.MISSES
    assert answer.subproblems == "LRS RLS"
    costs = zip(answer.subproblem_evaluations, answer.subproblem_runs, strict=True)
    assert all(0 < evaluations <= 200 * runs <= 400 for evaluations, runs in costs)
    assert sum(answer.subproblem_evaluations) == answer.evaluations
    assert answer.best_run_evaluations <= 200


@pytest.mark.parametrize("name", AVAILABLE)
def test_the_time_limit_ends_the_search(name, monkeypatch):
    """The time limit ends the search.

    By a clock that goes on by 0.1 s at every look, 1 s is over after 11 evaluations.
    """
    clock = count()
    monkeypatch.setattr(penalty_function, "perf_counter", lambda: next(clock) * 0.1)
    function = penalty_function.CountedFunction(function_of(LEFT_DISC, "LRS", 2.0), 100_000, 1.0)

    guess = np.ones(3) if ENGINES[name].kind == DERIVATIVE_FREE else None
    with pytest.raises(penalty_function.SearchEndError, match="out of time"):
        ENGINES[name].load()()(penalty_function.Task(function, guess, np.random.default_rng(0)))

    evaluated_at_once = 45  # differential evolution's generation
    assert function.evaluations <= 11 * evaluated_at_once
    assert next(clock) == 12


def test_raw_points_are_the_engine_s_own():
    """Raw points are the engine's own.

    Without the correction they miss by what the engine left; with it by rounding.
    """
    question = Question(PAPER["problem 1"])
    raw = attempt(load(spec("direct", evaluations=500, polish="false")), question)
    moved = attempt(load(spec("direct", evaluations=500)), question)

    assert raw.claim is Claim.LIMIT
    assert raw.verdict is Verdict.MISSES
    assert raw.miss > 1e-6
    assert moved.miss < 1e-12
    assert moved.claim is Claim.FEASIBLE


def test_a_word_without_a_path_is_never_called_infeasible_by_a_search():
    """Only the presolve says so; no sample can."""
    answer = attempt(load("penalty[evaluations=500]"), Question(LEFT_DISC, "LS"))

    assert answer.claim in (Claim.LIMIT, Claim.FAILED)

"""`convex`: engines of frozen problems, and freezing.

The packaged problems stand beside what freezing gives.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from benchmarks.freeze_convex import best_drive, chosen, fastest
from dubins_study.asking.attempt import attempt
from dubins_study.solvers.convex.adapters import ENGINES, Ask, prepare
from dubins_study.solvers.convex.solver import INTERFACES, Convex
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.setting_checks import missing_package
from dubins_study.study.convex.problem import matching, read
from dubins_study.study.convex.proof import reference, residuals, upper_bound
from dubins_study.study.kinds.frozen import FROZEN_PROBLEM
from dubins_study.study.path import Path
from dubins_study.study.scenario import Pose
from dubins_study.study.words import FROZEN, Claim, Outcome, Verdict
from tests.cases import FROZEN_ROUTE

QP, TUBE, TIME = "qp-50-random-6-0", "tube-50-cluster-9-38", "time-50-survey-6"
CONIC = [name for name, engine in ENGINES.items() if engine.cones]


def route(label):
    """The route that a problem comes from."""
    return matching([label])[0]


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize(
    ("engine", "name"),
    [*((engine, QP) for engine in ENGINES), *product(CONIC, (TUBE, TIME))],
)
def test_every_engine_meets_the_proven_optimum(engine, interface, name):
    """Every engine meets the proven optimum.

    Point and multipliers keep the tolerance in every sign and order of rows.
    """
    if reason := missing_package(ENGINES[engine].package, "cvxpy"):
        pytest.skip(reason)
    problem = read(name)
    tolerance = 1e-6

    reply = prepare(engine, interface, problem)(Ask(tolerance, 60.0))
    residual = residuals(problem, reply.point)

    assert reply.claim is Claim.OPTIMAL, reply.status
    apart = 100 * tolerance if engine == "proxqp" else 10 * tolerance  # it does not check the gap
    assert residual.primal <= tolerance
    assert residual.dual <= 10 * tolerance  # Clarabel's and ECOS's tolerance is relative
    assert residual.gap <= apart
    assert abs(upper_bound(problem, reply.point.x) - reference(name)[1]) <= 2 * apart


@pytest.mark.parametrize(("engine", "least"), [("osqp", 1e-12), ("proxqp", 1e-8)])
def test_tuned_options_are_those_that_the_makers_advise(engine, least):
    """Tuned options are those that makers advise.

    Polishing brings OSQP from three digits to rounding; ProxQP looks at the gap.
    """
    reply = prepare(engine, "own", read(QP))(Ask(1e-3 if engine == "osqp" else 1e-9, 60.0, True))

    assert reply.claim is Claim.OPTIMAL
    assert max(residuals(read(QP), reply.point)) <= least
    assert "expected one of: osqp, proxqp" in Convex(engine="piqp", options="tuned").unavailable()


def test_the_questions_of_the_kit_are_packaged_problems():
    """The questions of the kit are packaged problems.

    Each example is the route of the problem that its name tells.
    """
    for name, scenario in FROZEN_PROBLEM.examples.items():
        assert route(name) == replace(scenario, label=name)
    assert route(FROZEN_ROUTE.label) == FROZEN_ROUTE


def test_an_attempt_is_judged_by_the_proof():
    """An attempt is judged by the proof.

    The row's numbers are those of the proven problem; no other label is answered.
    """
    solver = Convex(engine="clarabel", tolerance=1e-6)
    low = reference(QP)[0]

    answer = attempt(solver, Question(route(QP), FROZEN))
    other = attempt(solver, Question(replace(route(QP), label="my route"), FROZEN))
    path = attempt(solver, Question(route(QP)))

    assert (answer.outcome, answer.verdict) == (Outcome.RETURNED, Verdict.OPTIMAL)
    assert answer.reference_low == low
    assert low <= answer.length <= low + 1e-6
    assert max(answer.miss, answer.dual_residual, answer.duality_gap) <= 1e-6
    assert 0 <= answer.certified_gap <= 2e-6
    assert (other.outcome, other.verdict) == (Outcome.RAISED, Verdict.NONE)
    assert "no convex problem named 'my route'" in other.message
    assert path.outcome is Outcome.UNSUPPORTED


def test_no_engine_is_given_the_answer(monkeypatch):
    """No engine is given the answer.

    The problem that a solver builds holds neither the proven point nor the interior.
    """
    given = []
    monkeypatch.setattr(
        "dubins_study.solvers.convex.solver.prepare",
        lambda engine, interface, problem: given.append(problem) or (lambda ask: None),
    )

    Convex().build(Question(route(QP), FROZEN))

    assert given
    for problem in given:
        assert sum(getattr(problem, name).size for name in ("interior", *"xyzw")) == 0


def test_an_engine_without_cones_refuses_them():
    answer = attempt(Convex(engine="piqp"), Question(route(TUBE), FROZEN))

    assert answer.outcome is Outcome.RAISED
    assert "PIQP takes no cones" in answer.message


@pytest.mark.parametrize("family", ["qp", "tube", "time"])
def test_packaged_problems_are_those_that_freezing_gives(family, made_anew):
    """Freezing gives the packaged problems.

    They are equal up to the rounding of the machine that wrote them.
    """
    problem = made_anew[family]
    stored = read(problem.name)

    assert replace(problem.route, label=problem.name) == route(problem.name)
    for name in ("p", "q", "l", "u", "lb", "ub", "d"):
        anew = getattr(problem.problem, name)
        before = getattr(stored, name)
        assert anew == pytest.approx(before, rel=1e-5, abs=1e-9)
    for name in ("A", "C"):
        difference = getattr(problem.problem, name) - getattr(stored, name)
        assert np.abs(difference.toarray()).max(initial=0) <= 1e-6


@pytest.fixture(scope="module")
def made_anew():
    """The last problem of each family, frozen here.

    It has 50 variables.
    """
    return {made.name.split("-")[0]: made for made in chosen(50)}


def test_the_fastest_drive_by_hand():
    """The fastest drive by hand.

    From rest's neighbour a straight is driven at full acceleration, then at full braking.

    Along 2 radii, from v^2 = 0.01 to 0.01: with 1/2 up and 1 down the top is where both meet, at
    two thirds of the way, and v^2 = 0.01 + 4/3.
    """
    steps = 300
    path = Path(Pose(0.0, 0.0, 0.0), np.zeros(steps), np.full(steps, 2 / steps))
    drive = best_drive(fastest(path))
    top = np.sqrt(0.01 + 4 / 3)
    slow = 0.1
    seconds = (top - slow) / 0.5 + (top - slow) / 1.0

    reply = prepare("clarabel", "own", fastest(path))(Ask(1e-8, 60.0))

    assert drive.x[: steps + 1].max() == pytest.approx(top**2, rel=1e-12)
    assert fastest(path).q @ drive.x == pytest.approx(seconds / 2, rel=1e-9)
    assert fastest(path).q @ reply.point.x == pytest.approx(seconds / 2, rel=1e-6)

"""`convex`: engines of frozen problems, and these beside what freezing gives."""

import numpy as np
import pytest

from benchmarks.freeze_convex import CASES, frozen
from dubins_study.asking.attempt import attempt
from dubins_study.solvers.convex.adapters import ENGINES, Ask, prepare
from dubins_study.solvers.convex.solver import INTERFACES, Convex
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.setting_checks import missing_package
from dubins_study.study.convex.problem import read
from dubins_study.study.convex.proof import reference, residuals, upper_bound
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import FROZEN, Claim, Outcome, Verdict

WELL = CASES["well"].points
# OSQP takes seconds for three digits, and minutes for six
QUICK = [name for name in ENGINES if name != "osqp"]
CONIC = [name for name, engine in ENGINES.items() if engine.cones]


def route(label):
    return Scenario(via=WELL[:-1], target_x=WELL[-1][0], target_y=WELL[-1][1], label=label)


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize(
    ("engine", "name", "tolerance"),
    [
        *((engine, "qp-50-well", 1e-6) for engine in QUICK),
        *((engine, "socp-50-well", 1e-6) for engine in CONIC),
        pytest.param("osqp", "qp-50-well", 1e-3, marks=pytest.mark.slow),
    ],
)
def test_every_engine_meets_the_proven_optimum(engine, interface, name, tolerance):
    """Point and multipliers keep the tolerance in every sign and order of rows."""
    if reason := missing_package(ENGINES[engine].package, "cvxpy"):
        pytest.skip(reason)
    problem = read(name)

    reply = prepare(engine, interface, problem)(Ask(tolerance, 60.0))
    found = residuals(problem, reply.point)

    assert reply.claim is Claim.OPTIMAL, reply.status
    assert found.primal <= tolerance
    assert found.dual <= 10 * tolerance  # Clarabel's and ECOS's tolerance is relative
    assert found.gap <= 10 * tolerance
    assert abs(upper_bound(problem, reply.point.x) - reference(name)[1]) <= 20 * tolerance


def test_an_attempt_is_judged_by_the_proof():
    """The row's numbers are those of the proven problem; no other label is answered."""
    solver, low = Convex(engine="clarabel", tolerance=1e-6), reference("qp-50-well")[0]

    answer = attempt(solver, Question(route("qp-50-well"), FROZEN))
    other = attempt(solver, Question(route("my route"), FROZEN))
    path = attempt(solver, Question(route("qp-50-well")))

    assert (answer.outcome, answer.verdict) == (Outcome.RETURNED, Verdict.OPTIMAL)
    assert answer.reference_low == low
    assert low <= answer.length <= low + 1e-6
    assert max(answer.miss, answer.dual_residual, answer.duality_gap) <= 1e-6
    assert 0 <= answer.certified_gap <= 2e-6
    assert (other.outcome, other.verdict) == (Outcome.RAISED, Verdict.NONE)
    assert "no convex problem named 'my route'" in other.message
    assert path.outcome is Outcome.UNSUPPORTED


def test_no_engine_is_given_the_answer(monkeypatch):
    """The problem that a solver builds holds neither the proven point nor the interior."""
    given = []
    monkeypatch.setattr(
        "dubins_study.solvers.convex.solver.prepare",
        lambda engine, interface, problem: given.append(problem) or (lambda ask: None),
    )

    Convex().build(Question(route("qp-50-well"), FROZEN))

    assert given
    for problem in given:
        assert sum(getattr(problem, name).size for name in ("interior", *"xyzw")) == 0


def test_an_engine_without_cones_refuses_them():
    answer = attempt(Convex(engine="piqp"), Question(route("socp-50-well"), FROZEN))

    assert answer.outcome is Outcome.RAISED
    assert "PIQP takes no cones" in answer.message


@pytest.mark.parametrize("state", CASES)
@pytest.mark.parametrize("kind", ["qp", "socp"])
def test_packaged_problems_are_those_that_freezing_gives(kind, state):
    """Up to the rounding of the machine that wrote them."""
    made, stored = frozen(CASES[state], 50, kind == "socp"), read(f"{kind}-50-{state}")

    for name in ("p", "q", "l", "u", "lb", "ub", "d"):
        assert getattr(made, name) == pytest.approx(getattr(stored, name), rel=1e-5, abs=1e-9)
    for name in ("A", "C"):
        difference = getattr(made, name) - getattr(stored, name)
        assert np.abs(difference.toarray()).max(initial=0) <= 1e-6

"""slsqp and ipopt on the paper's model: derivatives, starts, the joint model's minima and bias."""

from __future__ import annotations

import math
from importlib.util import find_spec

import numpy as np
import pytest
from cases import EDGES, PAPER, scenarios
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.experiments.solve import solve
from dubins_study.solvers.course import FULL_TURN
from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.paper_nlp.initial_guesses import INITIAL_GUESSES, initial_guesses
from dubins_study.solvers.paper_nlp.local_nlp import Case
from dubins_study.solvers.paper_nlp.model import SUBPROBLEMS, as_path, equations, target
from dubins_study.solvers.paper_nlp.nlp import Nlp
from dubins_study.solvers.paper_nlp.program import solve_in_pyomo
from dubins_study.solvers.protocol import Question
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.path import Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome, Verdict

lengths = st.tuples(st.floats(0, 6), st.floats(0, 6), st.floats(0, 20)).map(np.array)
NLP = ("slsqp", "ipopt")


@given(lengths, st.sampled_from(sorted(SUBPROBLEMS)), scenarios())
def test_the_equations_are_those_of_the_path(z, name, scenario):
    """(4.10) and (4.11) vanish exactly where the path's controls lead: paper against rollout."""
    subproblem = SUBPROBLEMS[name]
    z = np.where(np.isin(np.arange(3), subproblem.free), z, 0.0)
    end = as_path(scenario, subproblem, z).end
    moved = Scenario(*scenario.start, end.x, end.y, scenario.radius)

    residual = equations(z, *target(moved, subproblem.mirrored))

    # coordinates lie up to 100 radii from the origin, so they carry errors of 1e-14 radii
    np.testing.assert_allclose(residual, 0, atol=1e-11)


@pytest.mark.parametrize("spec", ["ipopt", "nlp[engine=ipopt]"])
@pytest.mark.parametrize(
    ("branch", "target"), [("LS", (0.3, 0.8)), ("RS", (0.3, -0.8)), ("LR", (9, 2)), ("RL", (9, -2))]
)
def test_ipopt_recognises_a_word_that_does_not_exist(spec, branch, target, capfd):
    """Infeasible by theory, and said so: a success; nothing of the way there is printed."""
    answer = solve(Scenario(0, 0, 0, *target, 1), spec, branch, isolated=False)

    assert answer.claim is Claim.INFEASIBLE
    assert answer.verdict is Verdict.NONE_EXISTS
    assert "Infeasible" in answer.native_status
    assert capfd.readouterr() == ("", "")


@pytest.mark.slow
def test_the_papers_order_is_not_mirror_symmetric():
    """L R S does not contain RL: wrong in the left disc only (docs/derivation.md, section 7)."""
    left, right = Scenario(0, 0, 0, 0, 1, 1), Scenario(0, 0, 0, 0, -1, 1)
    paper = "ipopt[model=joint,order=LRS,initial_guess=random,count=40]"
    both = "ipopt[model=joint,order=both,initial_guess=random,count=40]"

    assert solve(left, paper).verdict is Verdict.LONGER
    assert solve(left, paper).word.startswith("R")
    assert solve(right, paper).verdict is Verdict.OPTIMAL
    assert solve(left, both).verdict is Verdict.OPTIMAL


def test_an_interior_point_leaves_its_barrier_in_the_degenerate_arc():
    """In units of the radius 1.357e-3 at Ipopt's default tolerance (docs/derivation.md, section 7),
    and the length does not show it."""
    answer = solve(Scenario(0, 0, 0, 2e3, 4e3, 1e3), "ipopt[model=joint,order=LRS,options=default]")

    assert answer.word == "LRS"
    assert answer.path.lengths[1] / 1e3 == pytest.approx(1.357e-3, rel=0.05)
    assert answer.gap < 1e-8


def test_random_guesses_are_drawn_one_by_one():
    """A billion of them take neither memory nor time before the first."""
    for limit in (0.1, 1.0, 10.0):  # on a busy machine the first may take more than a tenth
        answer = solve(
            PAPER["problem 1"], "slsqp[initial_guess=random,count=1000000000]", limit=limit
        )
        if answer.claim is not Claim.LIMIT:
            break

    assert answer.outcome == "returned"
    assert answer.claim is Claim.LOCAL


def test_slsqp_gets_nowhere_from_the_zero_that_ampl_starts_at():
    """At z = 0 the two gradients are parallel: SLSQP stops with a singular matrix."""
    answer = solve(
        PAPER["problem 1"], "slsqp[model=joint,order=LRS,initial_guess=zero,capped=false]"
    )

    assert answer.claim is Claim.FAILED
    assert answer.verdict is Verdict.MISSES


@given(
    kind=st.sampled_from(INITIAL_GUESSES),
    name=st.sampled_from(sorted(SUBPROBLEMS)),
    scenario=scenarios(),
)
def test_starting_points_are_admissible(kind, name, scenario):
    """Not negative, arcs within a full turn, and zero where a length is fixed."""
    subproblem = SUBPROBLEMS[name]
    points = list(initial_guesses(Question(scenario), subproblem, kind, seed=1, count=5))

    for z in points:
        assert (z >= 0).all()
        assert (z[:2] <= 2 * math.pi).all()
        assert not np.delete(z, subproblem.free).any()
    assert len(points) == (5 if kind == "random" else len(points)) >= 1


@pytest.mark.parametrize("name", NLP)
def test_a_warm_start_saves_iterations(name):
    """Started from the solution's own segments, a word takes fewer iterations than from cold."""
    problem = PAPER["problem 4"]
    start = solve(problem, "analytic", "LS").path

    cold, warm = solve(problem, name, "LS"), solve(problem, name, "LS", initial_guess=start)

    assert warm.length == pytest.approx(cold.length, rel=1e-8)
    assert warm.iterations < cold.iterations


@pytest.mark.parametrize(("mu", "radius"), [(1e-9, 0.5), (1e-7, 1.0), (1e-5, 20.0)])
def test_the_interior_point_bias_is_the_cube_root_of_mu_r_squared(mu, radius):
    """At LS the reduced cost of z2 is zero and f grows like z2^3 / (3 R^2) (docs/derivation.md,
    section 7), so a barrier of mu leaves z2 = (mu R^2)^(1/3), in the paper's own units. To first
    order: the next term is a share z2 / R smaller."""
    scenario = Scenario(0, 0, 0, -3 * radius, 4 * radius, radius)
    spec = f"ipopt[model=joint,order=LRS,units=scenario,mu_target={mu},tol=1e-12]"
    answer = solve(scenario, spec)

    assert answer.word == "LRS"
    right = answer.path.lengths[1]
    expected = (mu * radius**2) ** (1 / 3)
    assert right == pytest.approx(expected, rel=0.1 + 2 * expected / radius)
    assert answer.gap < expected  # the length is right far beyond what the segments are


@pytest.mark.parametrize("name", ["slsqp", "ipopt"])
@pytest.mark.parametrize("radius", [1e-3, 1.0, 1e3])
def test_the_model_in_the_papers_units(name, radius):
    """Posed in the scenario's unit, easy scales have the same answers."""
    scenario = Scenario(0, 0, 0.4, 5 * radius, 3 * radius, radius)
    answer = solve(scenario, f"{name}[units=scenario]")

    assert answer.verdict is Verdict.OPTIMAL
    assert answer.gap < 1e-6


def test_a_given_start_is_the_only_one():
    """From where it is told to start and from nowhere else; without one, as by default."""
    scenario = PAPER["problem 2"]
    path = Path(scenario.start, [1, -1, 0], [0.6, 1e-3, 6.0])
    joint = SUBPROBLEMS["LRS"]

    def points(question, kind):
        return [z.tolist() for z in initial_guesses(question, joint, kind, 0, 3)]

    assert points(Question(scenario, initial_guess=path), "given") == [[0.6, 1e-3, 6.0]]
    assert points(Question(scenario), "given") == points(Question(scenario), "bearing")
    answer = solve(scenario, "ipopt[model=joint,order=LRS,initial_guess=given]", initial_guess=path)
    assert answer.verdict is Verdict.OPTIMAL


LEFT_DISC = EDGES["centre of the left disc"]


@pytest.mark.parametrize("engine", ["trust-constr", "slsqp", "cobyqa"])
def test_scipy_is_charged_with_no_claim_that_it_does_not_make(engine):
    """Inside the left disc LS has no path; none of SciPy's methods has a status that says so."""
    answer = solve(LEFT_DISC, f"nlp[engine={engine}]", "LS")

    assert answer.claim in (Claim.FAILED, Claim.LIMIT)
    assert not answer.false_claim


@pytest.mark.parametrize("target", [(1, 1), (0, 2), (-1, 1)])
@pytest.mark.parametrize("branch", ["best", "LS"])
def test_a_double_root_is_not_taken_for_infeasible(branch, target):
    """On the left circle LS has no straight, and the violation is flat there without a gradient."""
    answer = solve(Scenario(0, 0, 0, *target, 1), "nlp", branch)

    assert answer.claim is Claim.LOCAL
    assert answer.verdict is Verdict.OPTIMAL


def test_a_far_target_is_met():
    """A tolerance that grew with the distance would miss these, 10^4 to 10^5 radii away."""
    for x, y, heading in ((13994, -7553, -6.3204), (-28211, -12892, 0.4288), (-7e4, 8e4, 1)):
        answer = solve(Scenario(0, 0, heading, x, y, 1), "nlp")

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
    """Its wheel installs without one; its own pages of text about it stay out of the output."""
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
    upper = np.array((FULL_TURN, 0.0, math.inf))
    return Case(SUBPROBLEMS["LS"], upper, target(scenario, False))


def test_knitros_route_with_a_solver_that_needs_no_licence():
    """Pyomo's direct interfaces answer alike; SCIP's stands in for KNITRO's."""
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
    """A seat that is gone between the question whether there is one and the solve."""
    if ENGINES["knitro"].unavailable() is None:
        pytest.skip("there is a licence")

    point = solve_in_pyomo(_ls(PAPER["problem 1"]), np.ones(3), 5.0, "knitro_direct")

    assert point.claim is Claim.FAILED
    assert "not available" in point.message


def test_a_question_costs_the_same_whenever_it_is_asked():
    """Ipopt's evaluations are those of the question, not of all questions before."""
    costs = {(a.iterations, a.evaluations) for a in (solve(EASY_RS, "ipopt") for _ in range(3))}

    assert len(costs) == 1


EASY_RS = Scenario(0, 0, 2, 10, 5, 1)

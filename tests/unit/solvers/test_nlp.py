"""nlp: trust-constr, executables found on PATH and run as AMPL runs them, KNITRO's absence."""

from __future__ import annotations

import math
import time
from importlib.util import find_spec

import numpy as np
import pytest
from cases import EDGES, PAPER

from dubins_study.experiments.solve import solve
from dubins_study.solvers.engines import ENGINES
from dubins_study.solvers.nlp_engines.scipy_minimize import trust_constr
from dubins_study.solvers.paper_nlp.ampl import read_sol
from dubins_study.solvers.paper_nlp.local_nlp import Case
from dubins_study.solvers.paper_nlp.model import FULL_TURN, SUBPROBLEMS, target
from dubins_study.solvers.paper_nlp.nlp import Nlp
from dubins_study.solvers.paper_nlp.program import solve as solve_program
from dubins_study.solvers.paper_nlp.pyomo_case import solve as solve_direct
from dubins_study.solvers.registry import SolverError, entries, load
from dubins_study.study.closed_form.shortest import shortest
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome, Verdict

LEFT_DISC = EDGES["centre of the left disc"]


def test_trust_constr_recognises_a_word_that_does_not_exist():
    """At the disc's centre every LS arc ends equally far away: stationary, and said so."""
    answer = solve(LEFT_DISC, "nlp", "LS")

    assert answer.claim is Claim.INFEASIBLE
    assert answer.verdict is Verdict.NONE_EXISTS
    assert answer.path is None
    assert "stationary" in answer.message


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


def test_trust_constr_keeps_its_limit_and_says_so():
    """A hundred random starts on the joint model take seconds; a fifth of one is all there is."""
    began = time.process_time()  # a busy machine takes the wall clock, not the processor

    answer = solve(PAPER["problem 4"], "nlp[model=joint,initial_guess=random,count=100]", limit=0.2)

    # one iteration, some milliseconds, may pass before the clock is looked at again
    assert time.process_time() - began < 0.2 + 1.0
    assert answer.outcome is Outcome.RETURNED
    assert solve(PAPER["problem 4"], "nlp", limit=1e-9).claim is Claim.LIMIT
    within = solve_program(_ls(PAPER["problem 4"]), np.ones(3), 0.0, trust_constr(1e-9, 200))
    assert (within.claim, within.iterations) == (Claim.LIMIT, 1)


def test_a_sol_file_with_a_tolerance_among_its_options():
    """ASL's writesol.c: a 3 in second place announces one more number, counted as two."""
    text = "a\nb\n\nOptions\n5\n1\n3\n0\n1\n1\n2\n2\n1e-6\n0.25\n1.5\n2.5\nobjno 0 0\nsuffix 0\n"

    assert read_sol(text) == ("a b", [0.25], [1.5, 2.5], 0)


def test_absence_has_its_reason():
    """A name that PATH does not have."""
    assert Nlp().unavailable() is None
    answer = solve(PAPER["problem 1"], "nlp[engine=no-such-solver]")
    assert answer.outcome is Outcome.UNAVAILABLE
    assert answer.message.startswith("no executable 'no-such-solver' on PATH, and no engine of")
    with pytest.raises(SolverError, match="no folders"):
        load("nlp[engine=./x]")


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

    point = solve_direct(_ls(PAPER["problem 1"]), start, 20.0, "scip_direct")
    none = solve_direct(_ls(Scenario(0, 0, 0, 0.3, 0.8, 1)), start, 20.0, "scip_direct")

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

    point = solve_direct(_ls(PAPER["problem 1"]), np.ones(3), 5.0, "knitro_direct")

    assert point.claim is Claim.FAILED
    assert "not available" in point.message


def test_the_papers_own_solver_has_a_line_of_its_own():
    """KNITRO is listed beside `nlp`, with the reason for its absence if it is absent."""
    lines = {entry.name: entry.reason for entry in entries()}

    assert lines["nlp"] is None
    assert lines["nlp[engine=knitro]"] == Nlp(engine="knitro").unavailable()

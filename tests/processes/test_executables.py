"""Executables found on PATH, run as AMPL runs them: honest ones, broken ones, endless ones."""

from __future__ import annotations

import os
import time

import pytest
from cases import EDGES, PAPER
from live_run import wait_for
from stand_in import put_program, put_solver

from dubins_study.experiments.solve import solve
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome, Verdict

LEFT_DISC = EDGES["centre of the left disc"]  # no path LS ends there


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """A folder in front of PATH."""
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    return tmp_path


@pytest.mark.slow
def test_an_executable_solves_the_papers_model(programs):
    """Its path, duals, status and message come back; the duals are those of Ipopt in process."""
    put_solver(programs, "snopt")
    problem = PAPER["problem 4"]

    ours, same = solve(problem, "nlp[engine=snopt]"), solve(problem, "ipopt[via=library]")

    assert (ours.word, ours.verdict, ours.claim) == ("RS", Verdict.OPTIMAL, Claim.LOCAL)
    assert ours.length == pytest.approx(same.length, rel=1e-9)
    # multipliers are right to the root of the tolerance at most
    assert ours.multiplier_x == pytest.approx(same.multiplier_x, abs=1e-6)
    assert ours.multiplier_y == pytest.approx(same.multiplier_y, abs=1e-6)
    assert ours.native_status == "solve_result_num 0"
    assert "stand-in" in ours.message


@pytest.mark.slow
def test_an_executable_in_the_left_disc(programs):
    """RL is found there, in a mirror; LS does not exist, and the solver's 200 says so."""
    put_solver(programs, "snopt")

    best = solve(Scenario(0, 0, 0.4, 0, 1, 1), "nlp[engine=snopt]", "RL")
    none = solve(LEFT_DISC, "nlp[engine=snopt]", "LS")

    assert best.word == "RL"
    assert best.verdict is Verdict.OPTIMAL
    assert none.claim is Claim.INFEASIBLE
    assert none.verdict is Verdict.NONE_EXISTS
    assert none.native_status == "solve_result_num 200"


@pytest.mark.parametrize("program", ["ls", "true", "cat", "yes"])
def test_an_executable_that_is_no_solver_is_a_failure_with_a_message(program):
    answer = solve(PAPER["problem 1"], f"nlp[engine={program}]", "LS", limit=5)

    assert answer.outcome is Outcome.RETURNED
    assert answer.claim is Claim.FAILED
    assert answer.verdict is Verdict.NONE
    assert answer.path is None
    assert f"{program} wrote no .sol file" in answer.message
    assert "exit code" in answer.native_status


def test_an_executable_that_never_ends_is_stopped_with_its_children(programs):
    """At the time limit, and the process that it left behind dies with it."""
    mark = programs / "child"
    put_program(programs, "slow", f"#!/bin/sh\nsleep 60 &\necho $! > {mark}\nwait\n")
    # on a busy machine a process may take longer to start than half a second, or to end than two
    for limit in (0.5, 3.0, 20.0):
        mark.unlink(missing_ok=True)
        began = time.perf_counter()
        answer = solve(PAPER["problem 1"], "nlp[engine=slow]", limit=limit)
        late = time.perf_counter() - began - limit
        if late < 2 and mark.exists() and mark.read_text():
            break

    assert late < 2
    assert answer.claim is Claim.LIMIT
    assert answer.path is None
    child = int(mark.read_text())
    wait_for(lambda: not _running(child))  # until whoever adopted it has looked


def _running(pid: int) -> bool:
    try:
        with open(f"/proc/{pid}/stat") as stream:  # noqa: PTH123
            return stream.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no 'Options' line"),
        ("nonsense\nOptions\nthree\n", "invalid literal"),
        ("m\nOptions\n3\n1\n1\n0\n2\n2\n2\n2\n0.5\n", "could not convert string to float"),
        ("m\nOptions\n3\n1\n1\n0\n0\n0\n0\n0\n", "expected 'objno'"),
    ],
)
def test_a_broken_sol_file_is_a_failure_with_a_message(programs, text, message):
    """Whatever a program writes, it is read or refused."""
    put_program(
        programs, "broken", f"#!/bin/sh\nprintf '{text!r}' > model.sol\n".replace("''", "'")
    )

    answer = solve(PAPER["problem 1"], "nlp[engine=broken]", "LS")

    assert answer.outcome is Outcome.RETURNED
    assert answer.claim is Claim.FAILED
    assert message in answer.message


@pytest.mark.parametrize(
    ("code", "claim"),
    [
        (2, Claim.LOCAL),
        (103, Claim.FAILED),  # it says feasible, of a point that does not arrive
        (200, Claim.INFEASIBLE),
        (300, Claim.FAILED),
        (401, Claim.LIMIT),
        (500, Claim.FAILED),
        (-7, Claim.FAILED),
    ],
)
def test_ampls_result_codes_are_claims(programs, code, claim):
    """AMPL book, section 14.2. The claimed point, z = (1, 1), is judged like any other."""
    sol = f"said so\\n\\nOptions\\n3\\n1\\n1\\n0\\n2\\n0\\n2\\n2\\n1\\n1\\nobjno 0 {code}\\n"
    put_program(programs, "says", f"#!/bin/sh\nprintf '{sol}' > model.sol\n")

    answer = solve(PAPER["problem 1"], "nlp[engine=says]", "LS")

    assert answer.claim is claim
    assert answer.message == "LS: said so"
    assert answer.verdict is (Verdict.NONE if claim is Claim.INFEASIBLE else Verdict.MISSES)
    assert answer.multiplier_x is None


@pytest.mark.parametrize(("solver", "branch"), [("ipopt", "best"), ("collocation", "RS")])
def test_an_ipopt_on_path_is_used(programs, solver, branch):
    """It comes before the library; its answers, duals included, are the library's."""
    put_solver(programs, "ipopt")
    library = solve(PAPER["problem 1"], f"{solver}[via=library]", branch)
    executable = solve(PAPER["problem 1"], solver, branch)

    assert executable.verdict is Verdict.OPTIMAL, executable.message
    assert "stand-in" in executable.message
    assert executable.length == pytest.approx(library.length, rel=1e-8)
    assert executable.multiplier_x == pytest.approx(library.multiplier_x, abs=1e-6)


def test_an_ipopt_on_path_that_finds_nothing(programs):
    put_solver(programs, "ipopt")

    answer = solve(LEFT_DISC, "ipopt", "LS")
    assert answer.verdict in (Verdict.NONE_EXISTS, Verdict.MISSES)

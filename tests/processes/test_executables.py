"""Executables on PATH, run as AMPL runs them.

They are honest, broken or endless.
"""

import os
import sys
import time
from pathlib import Path

import pytest

from dubins_study.experiments.solve import solve
from dubins_study.solvers.engines import EXECUTABLES
from dubins_study.solvers.registry import SolverError
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim, Outcome, Verdict
from tests.cases import PAPER
from tests.live_run import wait_for

pytestmark = pytest.mark.smoke

# An AMPL solver: reads an NL file, solves it with casadi's Ipopt, writes a .sol.
STAND_IN = """#!{python}
import sys
import casadi
stub = next(a for a in sys.argv[1:] if not a.startswith("-") and "=" not in a)
stub = stub.removesuffix(".nl")
nl = casadi.NlpBuilder()
nl.import_nl(stub + ".nl")
nlp = dict(x=casadi.vertcat(*nl.x), f=nl.f, g=casadi.vertcat(*nl.g))
options = dict(print_level=0, sb="yes", bound_relax_factor=0)
solver = casadi.nlpsol("s", "ipopt", nlp, dict(print_time=False, ipopt=options))
found = solver(x0=nl.x_init, lbx=nl.x_lb, ubx=nl.x_ub, lbg=nl.g_lb, ubg=nl.g_ub)
x, y = found["x"].full().ravel(), -found["lam_g"].full().ravel()  # ASL's sign of duals
code = 0 if solver.stats()["success"] else 200
lines = ["", "Ipopt 3.14.0 (stand-in): " + solver.stats()["return_status"], "", "Options", "3",
         "1", "1", "0", str(len(y)), str(len(y)), str(len(x)), str(len(x))]
lines += [repr(float(v)) for v in (*y, *x)] + ["objno 0 " + str(code)]
open(stub + ".sol", "w").write("\\n".join(lines) + "\\n")
"""


# One for integers: SCIP reads the NL file, and names the variables by their places.
MIXED_STAND_IN = """#!{python}
import sys
import pyscipopt
stub = sys.argv[1]
scip = pyscipopt.Model()
scip.hideOutput()
scip.readProblem(stub + ".nl")
scip.setParam("numerics/feastol", 1e-9)
scip.optimize()
columns, rows = open(stub + ".nl").read().splitlines()[1].split()[:2]
named = {{int(v.name[1:]): scip.getVal(v) for v in scip.getVars()}}
lines = ["", "SCIP (stand-in): " + scip.getStatus(), "", "Options", "3", "1", "1", "0",
         rows, "0", columns, columns, *(repr(named[i]) for i in range(int(columns))), "objno 0 0"]
open(stub + ".sol", "w").write("\\n".join(lines) + "\\n")
"""


def put_solver(folder: Path, name: str) -> None:
    """Put the stand-in into a folder.

    It is an executable of this name.
    """
    put_program(folder, name, STAND_IN.format(python=sys.executable))


def put_program(folder: Path, name: str, text: str) -> None:
    """Put a script into a folder.

    It is an executable of this name.
    """
    file = folder / name
    file.write_text(text)
    file.chmod(0o755)


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """A folder in front of PATH."""
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    return tmp_path


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
    """An endless executable is stopped with its children.

    It is stopped at the time limit, and the process that it left behind dies with it.
    """
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
        (200, Claim.LOCALLY_INFEASIBLE),
        (300, Claim.FAILED),
        (401, Claim.LIMIT),
        (500, Claim.FAILED),
        (-7, Claim.FAILED),
    ],
)
def test_ampls_result_codes_are_claims(programs, code, claim):
    """AMPL's result codes are claims.

    They are those of the AMPL book, section 14.2. The claimed point, z = (1, 1), is judged like
    any other.
    """
    sol = f"said so\\n\\nOptions\\n3\\n1\\n1\\n0\\n2\\n0\\n2\\n2\\n1\\n1\\nobjno 0 {code}\\n"
    put_program(programs, "says", f"#!/bin/sh\nprintf '{sol}' > model.sol\n")

    answer = solve(PAPER["problem 1"], "nlp[engine=says]", "LS")

    assert answer.claim is claim
    assert answer.message == "LS: said so"
    assert answer.verdict is (Verdict.NONE if claim is Claim.LOCALLY_INFEASIBLE else Verdict.MISSES)
    assert answer.multiplier_x is None


@pytest.mark.slow
def test_an_executable_on_path_is_used(programs):
    """An executable on PATH is used.

    Its answers, duals included, are those of Ipopt's library, which the stand-in calls.
    """
    put_solver(programs, "snopt")
    library = solve(PAPER["problem 1"], "ipopt")
    executable = solve(PAPER["problem 1"], "nlp[engine=snopt]")

    assert executable.claim is Claim.LOCAL
    assert executable.verdict is Verdict.OPTIMAL, executable.message
    assert "stand-in" in executable.message
    assert executable.length == pytest.approx(library.length, rel=1e-8)
    # multipliers are right to the root of the tolerance at most
    assert executable.multiplier_x == pytest.approx(library.multiplier_x, abs=1e-6)
    assert executable.multiplier_y == pytest.approx(library.multiplier_y, abs=1e-6)


ROUTE = Scenario(heading=0.3, via=[(4, 1)], target_x=10, target_y=5, final_heading=1.5)


@pytest.mark.parametrize("name", ["route-nlp", "multiple-shooting", "collocation"])
def test_an_executable_solves_the_programs_of_routes(programs, name):
    """An executable solves the programs of routes.

    It is as good as Ipopt's library, which the stand-in calls, on the same program.
    """
    put_solver(programs, "snopt")

    answer = solve(ROUTE, f"{name}[engine=snopt]", limit=20)

    assert answer.claim is Claim.LOCAL
    assert answer.verdict is Verdict.OPTIMAL, answer.message
    assert "stand-in" in answer.message
    assert answer.engine == "snopt"
    assert answer.tolerance is None  # nobody knows what it calls its tolerances


def test_an_executable_solves_the_disjunction_and_proves_nothing(programs):
    """An executable solves the disjunction without proof.

    Its point is the shortest path; without a bound it is not claimed to be.
    """
    put_program(programs, "couenne", MIXED_STAND_IN.format(python=sys.executable))

    answer = solve(PAPER["problem 1"], "disjunctive[engine=couenne]", limit=60)

    assert answer.verdict is Verdict.OPTIMAL, answer.message
    assert answer.claim is Claim.FEASIBLE
    assert answer.lower_bound == 0.0
    assert answer.proves is None


@pytest.mark.parametrize(
    ("spec", "expected"),
    [
        ("route-nlp[engine=ipopt-hsl]", {"tol": 1e-9, "constr_viol_tol": 1e-9}),
        ("route-nlp[engine=ipopt-hsl,tol=1e-5,max_iter=7]", {"dual_inf_tol": 1e-5, "max_iter": 7}),
        ("collocation[engine=uno_ampl]", {"primal_tolerance": 1e-9, "dual_tolerance": 1e-9}),
        ("disjunctive[engine=knitroampl]", {"feastol": 1e-8, "mip_opt_gap_rel": 1e-7}),
        ("nlp[engine=minos]", {}),
    ],
)
def test_tolerances_and_the_limit_are_passed_by_the_makers_names(programs, spec, expected):
    """Tolerances and limit have the makers' names.

    The time is that which is left, rounded down; what has no name is not passed.
    """
    name = spec.partition("engine=")[2].rstrip("]").partition(",")[0]
    put_program(programs, name, f'#!/bin/sh\necho "$@" >> {programs}/asked\n')

    solve(ROUTE if "nlp[engine=minos" not in spec else PAPER["problem 1"], spec, limit=3)

    first, second, *options = (programs / "asked").read_text().splitlines()[0].split()
    asked = {key: float(value) for key, value in (each.split("=") for each in options)}
    assert (first, second) == ("model", "-AMPL")
    assert {key: asked[key] for key in expected} == expected
    seconds = {"max_cpu_time", "time_limit", "maxtime_real"} & asked.keys()
    assert all(0 < asked[key] <= 3 for key in seconds)
    assert len(seconds) == bool(expected)


@pytest.mark.parametrize("name", ["route-nlp", "disjunctive", "multiple-shooting"])
def test_a_name_that_is_neither_engine_nor_executable_is_told(name):
    """A name of no engine and no executable.

    A slip that may be a program's name is unavailable; a path is refused at once.
    """
    answer = solve(ROUTE, f"{name}[engine=scipp]")
    assert answer.outcome is Outcome.UNAVAILABLE
    assert "no executable 'scipp' on PATH" in answer.message
    with pytest.raises(SolverError, match=r"expected one of: .*, or the name of an executable"):
        solve(ROUTE, f"{name}[engine=./ipopt]")


def test_the_page_names_every_option_that_is_passed():
    page = (Path(__file__).parents[2] / "docs" / "reference-set.md").read_text()
    for begin, names in EXECUTABLES.items():
        options = names.options
        options_of_engine = (
            begin,
            *options.feasibility,
            *options.optimality,
            names.gap,
            names.seconds,
        )
        assert [name for name in options_of_engine if name and f"`{name}`" not in page] == []


def test_engines_of_another_kind_are_no_executables():
    """Engines of another kind are no executables.

    `highs` is an engine of the table, which reads no such program.
    """
    with pytest.raises(SolverError, match="engine is 'highs'"):
        solve(ROUTE, "route-nlp[engine=highs]")

"""Limits hold for a solver asked from Python.

It is asked in the caller's process, or in a worker.
"""

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import pandas as pd
import pytest

from dubins_study import Scenario, Solver, solve, solve_frame
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.solvers.registry import available_solvers, load
from tests.cases import PAPER, question_for, scenario_frame
from tests.marked import left_behind, marked
from tests.plugin_files import spec

EASY = PAPER["problem 1"]

# Where SCIP's linear solver printed more than a pipe holds, while Pyomo read that pipe only after
# the solve: `solve` did not return. The first is of another machine, whose sines differ.
HANGING = [
    Scenario(
        1.1160744177164355,
        0.12454346748196027,
        0.14228680946011707,
        1.2241364773600056,
        -0.6297907303945911,
        0.38101754905372,
    ),
    Scenario(target_x=0.3382875641532451, target_y=-0.058957228594529676),
]
# near a circle, behind, next to the start, far
HARD = [
    HANGING[1],
    Scenario(target_x=0.3330851689323447, target_y=1.9428967353481148),
    Scenario(heading=0.5, target_x=-5e3, target_y=1e-9, radius=3),
    Scenario(target_x=3.2e-08, target_y=2.2e-07),
    Scenario(target_x=7e5, target_y=-4e9),
]


def plugin(name: str) -> str:
    return spec("hanging", name)


def timed(call, bound):
    """Result of a call and its seconds.

    They are of the first try that ends within the bound.

    On a busy machine any try may be held up; what is slow by itself is so in all three.
    """
    for _ in range(3):
        began = time.monotonic()
        result = call()
        seconds = time.monotonic() - began
        if seconds < bound:
            break
    return result, seconds


def script(text: str, **options) -> subprocess.CompletedProcess[str]:
    """A program without `if __name__ == "__main__"`.

    It is read from stdin as a notebook's cell is.
    """
    done = subprocess.run(
        [sys.executable, "-"], input=text, capture_output=True, text=True, timeout=120, **options
    )
    assert done.returncode == 0, done.stderr
    return done


# --- the solvers of this package -----------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("scenario", HANGING)
def test_a_loud_solve_does_not_hang(scenario):
    """A loud solve does not hang.

    It runs in a process of its own: the hang could not be interrupted.
    """
    done = script(
        f"from dubins_study import *\nprint(solve({scenario!r}, 'disjunctive', limit=100))"
    )

    assert "outcome returned" in done.stdout
    assert "verdict optimal" in done.stdout
    assert done.stderr == ""


@pytest.mark.slow
@pytest.mark.parametrize(("limit", "hard"), [(0.05, HARD), (0.5, HARD[:2])])
@pytest.mark.parametrize(
    "spec",
    [
        *(name for name in available_solvers() if load(name).keeps_limit),
        *("disjunctive[transformation=hull]", "disjunctive[emphasis=default]"),
        "slsqp[maxiter=1000000,ftol=1e-14]",
        "ipopt[max_iter=1000000,model=joint,initial_guess=zero,capped=False]",
        "shooting[max_evaluations=1000000,tol=1e-12,root=lm]",
        "nlp[max_iter=1000000,tol=1e-14]",
    ],
)
def test_every_promise_is_kept(spec, limit, hard):
    """Every promise is kept to the second.

    Solvers run in this process: by default, with the largest settings for which the promise is
    made, and with those that loop for long.
    """
    solver = load(spec)
    assert solver.keeps_limit
    # loads the libraries, which are no part of the limit
    solve(EASY, spec, solver.branches[0], limit=2)
    for i, scenario in enumerate(hard):
        branch = solver.branches[i % len(solver.branches)]
        call = partial(solve, scenario, spec, branch, limit=limit, isolated=False)
        answer, seconds = timed(call, limit + 1)
        assert answer.outcome == "returned"
        assert seconds < limit + 1, (scenario, branch)


@pytest.mark.parametrize(
    "spec",
    [
        # of any number of legs
        *("turn-rate-qp", "heading-milp", "collocation", "multiple-shooting", "turn-rates"),
        *("route-nlp", "headings[engine=cobyqa]"),
    ],
)
def test_large_settings_promise_nothing(spec):
    """Compiling a large model takes longer than a second."""
    assert not load(spec).keeps_limit


@pytest.mark.many(4)
@pytest.mark.parametrize(
    "name",
    # OR-tools and highspy cannot be loaded in one process, such as that of the tests
    sorted({*available_solvers()} - {"analytic", "tour-circuit", "tour-routing"}),
)
def test_a_worker_answers_alike(name):
    """A worker answers alike.

    That holds even within a limit shorter than loading the libraries takes.
    """
    for limit in (0.4, 2.0, 10.0):  # on a busy machine the shortest may end one of the two early
        here, there = (
            solve(*question_for(name, EASY), limit=limit, isolated=isolated)
            for isolated in (False, True)
        )
        length = here.length and pytest.approx(here.length, rel=1e-12)
        alike = ("returned", here.message, length)
        if length is not None and (there.outcome, there.message, there.length) == alike:
            break

    assert (there.outcome, there.message, there.length) == alike


@pytest.mark.smoke
def test_analytic_is_never_isolated():
    assert solve(EASY, isolated=True).length == solve(EASY).length
    assert len(solve_frame(scenario_frame([EASY] * 3), isolated=True)) == 3


# --- plug-ins ------------------------------------------------------------------------------------


@pytest.mark.many(1)
@pytest.mark.parametrize("name", ["Sleeps", "Spins"])
def test_a_plugin_that_hangs_is_stopped_by_default(name):
    """A plug-in that hangs is stopped by default.

    It is stopped a tenth of a second after the limit, and at most a second.
    """
    solve(EASY, plugin("Repeats"))  # starts the server of the workers

    answer, seconds = timed(partial(solve, EASY, plugin(name), limit=0.5), 1.5)

    assert answer.outcome == "timeout"
    assert answer.verdict == "none"
    assert "the limit is 0.5 s" in answer.message
    assert seconds < 1.5


@pytest.mark.smoke
def test_a_killed_worker_is_an_outcome():
    answer = solve(EASY, plugin("Dies"))

    assert (answer.outcome, answer.native_status) == ("crashed", "SIGKILL")


@pytest.mark.smoke
def test_a_plugin_promises_for_itself_only():
    """A plug-in promises for itself only.

    Its promise counts where its own class makes it; the base class makes none.
    """
    assert not Solver().keeps_limit
    assert load("analytic").keeps_limit
    assert not describe_solver(plugin("Repeats")).keeps_limit
    assert describe_solver(plugin("Promises")).keeps_limit


@pytest.mark.parametrize("isolated", [None, True, False])
@pytest.mark.parametrize("name", ["Repeats", "Promises"])
def test_where_a_plugin_is_asked(name, isolated):
    """A plug-in's promise decides where it is asked.

    The initial guess comes along.
    """
    here = name == "Promises" if isolated is None else not isolated
    guess = solve(EASY).path

    answer = solve(EASY, plugin(name), initial_guess=guess, isolated=isolated)

    assert (answer.message == f"process {os.getpid()}") is here
    assert answer.path == guess
    assert answer.verdict == "optimal"


@pytest.mark.smoke
def test_a_frame_has_one_worker_for_all_rows():
    """A frame has one worker for all rows.

    Rows come in order, under their index; a row that hangs ends its worker and has its own limit.
    """
    scenarios = [Scenario(target_x=x, target_y=1, label=str(x)) for x in (4, 3, -2, 5, -1, 6)]
    frame = scenario_frame(scenarios).set_index(pd.Index(list("abcdef")))

    rows, seconds = timed(partial(solve_frame, frame, plugin("Moody"), limit=0.5), 10)

    assert list(rows.index) == list("abcdef")
    assert list(rows["label"]) == [scenario.label for scenario in scenarios]
    assert list(rows["outcome"] == "timeout") == [x < 0 for x in rows["target_x"]]
    assert rows["message"][["a", "b"]].nunique() == 1
    assert rows["message"][list("abdf")].nunique() == 3
    assert seconds < 10
    assert str(os.getpid()) not in " ".join(rows["message"].astype(str))


# --- callers -------------------------------------------------------------------------------------


def test_from_threads():
    """Each thread has a worker of its own.

    None waits for another.
    """
    with ThreadPoolExecutor(3) as pool:
        asked = [pool.submit(solve, EASY, plugin("Spins"), limit=0.5) for _ in range(3)]

        assert [answer.result(60).outcome for answer in asked] == ["timeout"] * 3


def _send(connection):
    hanging = solve(EASY, plugin("Spins"), limit=0.5)
    connection.send(f"{hanging.outcome}, {solve(EASY, 'slsqp', isolated=True).verdict}")


@pytest.mark.slow
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_from_a_daemon_process(method):
    """A daemon process can ask.

    It may have no children by `multiprocessing`; it is forked after this process had workers.
    """
    solve(EASY, plugin("Repeats"))
    context = multiprocessing.get_context(method)
    end, other_end = context.Pipe()
    process = context.Process(target=_send, args=(other_end,), daemon=True)
    process.start()

    assert end.poll(100)
    assert end.recv() == "timeout, optimal"
    process.join(60)
    assert process.exitcode == 0
    assert solve(EASY, plugin("Dies")).outcome == "crashed"  # our own server is still there


@pytest.mark.slow
def test_from_a_script_without_a_main_guard():
    """A script without a guard runs once.

    It is not run again in the worker.
    """
    done = script(f"from dubins_study import *\nprint(solve({EASY!r}, {plugin('Repeats')!r}))")

    assert done.stdout.count("Answer(") == 1


def test_inside_a_worker():
    """A plug-in may ask inside a worker.

    It is isolated, and so are those that it asks.
    """
    answer = solve(EASY, plugin("Asks"), limit=30)

    assert answer.message == "timeout, returned"
    assert answer.verdict == "optimal"


@pytest.mark.many(1)
@pytest.mark.parametrize(
    ("spec", "scenario"),
    [
        (plugin("Spins"), EASY),
        ("ipopt", EASY),  # casadi turns the exception into a warning
        pytest.param("collocation", EASY, marks=pytest.mark.slow),
        # OSQP and SCIP catch the signal
        pytest.param("turn-rate-qp[n=640,engine=osqp]", HARD[-1], marks=pytest.mark.slow),
        pytest.param("disjunctive", HANGING[1], marks=pytest.mark.slow),
        pytest.param("heading-milp", EASY, marks=pytest.mark.slow),
    ],
)
def test_ctrl_c_goes_through(spec, scenario):
    """Ctrl-C goes through.

    It passes a worker and a library, without waiting for the limit; nothing is left behind.
    """
    mark, environment = marked()
    text = f"from dubins_study import *\nsolve({EASY!r}, {spec!r}, 'LS', limit=0.1)\n"
    text += f"print('now', flush=True)\nwhile True: solve({scenario!r}, {spec!r}, limit=100)"
    process = subprocess.Popen(
        [sys.executable, "-c", text],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=os.environ | environment,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "now\n"
    time.sleep(0.3)  # most likely inside a solve by then; the outcome is the same before it
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=80)  # the limit is 100 s

    assert errors.endswith("KeyboardInterrupt\n")
    assert process.returncode == -signal.SIGINT
    assert left_behind(mark) == []


def test_what_is_no_choice_is_refused():
    with pytest.raises(ValueError, match="isolated is 'yes'; expected True, False or None"):
        solve(EASY, "slsqp", isolated="yes")


def test_a_plugin_may_print_while_it_is_loaded(tmp_path):
    """A plug-in may print while it is loaded.

    It prints more than a pipe holds: nobody waits for a reader.
    """
    plugin = tmp_path / "loud.py"
    plugin.write_text(
        "from dataclasses import dataclass\n"
        "from dubins_study import Claim, Path, Solution, Solver\n"
        "print('x' * 2**21)\n"
        "@dataclass(frozen=True)\n"
        "class Loud(Solver):\n"
        "    name = 'loud'\n"
        "    def solve(self, question, limit):\n"
        "        return Solution(Claim.FEASIBLE, Path(question.scenario.start, [0.0], [1.0]))\n",
        encoding="utf-8",
    )

    assert solve(EASY, f"{plugin}:Loud", limit=5.0).outcome == "returned"

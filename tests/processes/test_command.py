"""The command line, as a user runs it.

Tested are output and exit codes; there is never a traceback.
"""

import json
import math
import re
import subprocess
import sys
from contextlib import chdir
from pathlib import Path

import pytest

from dubins_study import load_results
from dubins_study.solvers.export import export
from dubins_study.study.rows.schema import ROW, names
from dubins_study.study.scenario import Scenario
from tests.fuzz.watched import command
from tests.live_run import finished, output, quick_experiment
from tests.plugin_files import copied


def dubins_here(*arguments: str, cwd=None) -> subprocess.CompletedProcess[str]:
    """Run the command in this process.

    That suits what starts no other process and loads no plug-in.
    """
    with chdir(cwd or Path.cwd()):
        ended = command(*arguments)
    return subprocess.CompletedProcess(arguments, ended.code, ended.out, ended.err)


PROBLEM_1 = ("solve", "10", "5", "--from", "0", "0", "120deg", "--radius", "1")


@pytest.mark.smoke
@pytest.mark.parametrize("solver", ["analytic", "ipopt"])
def test_solve_json(solver):
    """The JSON object for the paper's first problem."""
    answer = json.loads(output(dubins_here(*PROBLEM_1, "--solver", solver, "--json")))

    assert answer["word"] == "RS"
    assert answer["length"] == pytest.approx(11.868088817, abs=1e-8)
    assert answer["travel_time"] == answer["length"]
    assert [s["turn"] for s in answer["segments"]] == ["R", "S"]
    assert sum(s["length"] for s in answer["segments"]) == pytest.approx(answer["length"])
    assert (answer["verdict"], answer["solver"], answer["branch"]) == ("optimal", solver, "best")
    assert answer["claim"] == ("optimal" if solver == "analytic" else "local")
    assert answer["region"] == "outside"
    assert {"gap", "miss", "margin"} <= answer.keys()


def test_solve_text_tells_the_tie_straight_behind():
    assert "LS  (tied with RS)" in output(dubins_here("solve", "-5", "0"))


@pytest.mark.smoke
def test_solvers():
    listed = json.loads(output(dubins_here("solvers", "--json")))

    assert {"analytic", "slsqp", "ipopt", "turn-rate-qp"} <= {entry["name"] for entry in listed}
    assert all(entry["available"] == (entry["reason"] is None) for entry in listed)
    assert "turn-rate-qp" in output(dubins_here("solvers"))


@pytest.mark.smoke
def test_export(tmp_path):
    """The Python call, to standard output or a file."""
    pose = ("-6", "3", "--from", "1", "-2", "120deg", "--radius", "2")
    shown = output(dubins_here("export", *pose, "--format", "mod", "--order", "RLS"))
    wrote = output(
        dubins_here("export", *pose, "--model", "disjunctive", "--out", "a.nl", cwd=tmp_path)
    )

    scenario = Scenario(1, -2, 2 * math.pi / 3, -6, 3, 2)
    assert shown == export(scenario, "paper", "mod", "RLS")
    assert "subject to" in shown
    assert wrote == ""
    assert (tmp_path / "a.nl").read_text() == export(scenario, "disjunctive", "nl")


def test_run_status_and_report(tmp_path):
    """An experiment from a file, run twice, reported."""
    file = quick_experiment(tmp_path, 2, 'analytic", "slsqp')
    first = output(finished("run", file, cwd=tmp_path))
    assert "4 of 4 cells done, finished" in first
    assert output(finished("run", file, cwd=tmp_path)) == first
    assert "optimal" in output(finished("status", "results/quick", cwd=tmp_path))

    shown = output(finished("report", "results/quick", cwd=tmp_path))

    page = tmp_path / "results" / "quick" / "report" / "index.html"
    assert "index.html" in shown
    assert "slsqp" in shown
    assert "is it kept?" in page.read_text(encoding="utf-8")
    rows = load_results(tmp_path / "results" / "quick")
    assert {"experiment", *names(ROW)} - {"versions", "machine", "run_id"} <= set(rows.columns)
    assert all(sum(lengths) > 0 for lengths in rows["lengths"])


DRIVE = "target_x,target_y,x,y,heading,radius\n10,5,0,0,120deg,1\n-3,-2,0,0,pi/3,2\n"


@pytest.mark.slow
def test_scenarios_of_a_file(tmp_path):
    """Scenarios of a file are asked once.

    They are skipped when asked again, and asked by another solver too. Other scenarios are
    refused.
    """
    file = tmp_path / "drive.csv"
    file.write_text(DRIVE)
    run = ("run", "--scenarios", "drive.csv", "--solver")
    assert "2 of 2 cells done, finished" in output(finished(*run, "analytic", cwd=tmp_path))
    assert "2 of 2 cells done, finished" in output(finished(*run, "analytic", cwd=tmp_path))
    assert "4 of 4 cells done" in output(finished(*run, "shooting", cwd=tmp_path))

    rows = load_results(tmp_path / "results" / "drive")
    assert sorted(set(rows["heading"])) == [math.pi / 3, 2 * math.pi / 3]
    assert set(rows["verdict"]) == {"optimal"}
    file.write_text(DRIVE.replace("10,5", "10,6"))
    done = finished(*run, "analytic", cwd=tmp_path)
    assert done.returncode == 2
    assert "results/drive holds results of another text of experiment" in done.stderr
    assert "choose another --out, or --restart" in done.stderr


@pytest.fixture
def plugin(tmp_path):
    return str(copied("failing", tmp_path))


@pytest.mark.slow
def test_what_a_solver_prints_is_no_result(plugin, tmp_path):
    done = finished("solve", "1", "2", "--solver", f"{plugin}:Loud", "--json")

    assert json.loads(done.stdout)["verdict"] == "optimal"
    assert "from Python" not in done.stderr
    assert "from below" not in done.stderr
    file = quick_experiment(tmp_path, 2)
    shown = output(finished("run", file, "--solver", f"{plugin}:Loud", cwd=tmp_path))
    assert shown.startswith("results/quick: 2 of 2 cells done")
    assert "from" not in shown


def test_nobody_has_to_listen():
    """A closed stdout is no error."""
    program = "from dubins_study.cli.app import main; main()"
    done = subprocess.run(
        ["sh", "-c", '"$0" -c "$1" solve 1 2 >&-', sys.executable, program],
        stderr=subprocess.PIPE,
        text=True,
    )

    assert (done.returncode, done.stderr) == (0, "")


def test_a_false_claim_is_told(plugin):
    assert "false claim" in output(finished("solve", "1", "2", "--solver", f"{plugin}:Liar"))
    assert "false claim" not in output(finished("solve", "1", "2"))


@pytest.mark.slow
def test_a_solver_that_was_not_asked_gives_no_answer(plugin):
    """A solver that was not asked gives no answer.

    The reason is on stderr and the exit code is 2; with --json the object is there, too.
    """
    done = finished("solve", "1", "2", "--solver", f"{plugin}:Absent", "--plot", "unused.svg")
    assert (done.returncode, done.stdout) == (2, "")
    assert "is unavailable: no licence" in done.stderr

    done = finished("solve", "1", "2", "--solver", f"{plugin}:Absent", "--json")
    assert done.returncode == 2
    assert json.loads(done.stdout)["outcome"] == "unavailable"
    assert "is unavailable: no licence" in done.stderr


@pytest.mark.slow
def test_a_solver_that_cannot_run_is_refused_before_a_run(plugin, tmp_path):
    """A solver that cannot run is refused first.

    It may be of another package, or one among several; an experiment's own are recorded.
    """
    file = quick_experiment(tmp_path, 2)
    absent = f"{plugin}:Absent"
    for spec, said in ((absent, "no licence"), ("nlp[engine={ipopt,nothing}]", "no executable")):
        done = finished("run", file, "--solver", "slsqp", "--solver", spec, cwd=tmp_path)
        assert (done.returncode, done.stdout) == (2, "")
        assert re.search(f"solver .* is unavailable: {said}", done.stderr)
        assert not (tmp_path / "results").exists()


@pytest.mark.slow
def test_rows_of_another_limit_are_named(tmp_path):
    """Rows of another limit are named.

    They stay, and the run says of which limit they are; restarted, none are left.
    """
    file = quick_experiment(tmp_path, 2)
    asked = ("run", file, "--solver", "slsqp", "--time-limit")
    assert "rows are there" not in finished(*asked, "5", cwd=tmp_path).stderr

    done = finished(*asked, "7", cwd=tmp_path)
    assert "rows are there of a time limit of 5 s, and stay beside 7 s" in done.stderr
    assert "rows are there" not in finished(*asked, "7", "--restart", cwd=tmp_path).stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "outcome", "message"),
    [
        ("Full", "out_of_memory", "MemoryError: no message"),
        *(("Gone", "crashed", "."), ("Stuck", "timeout", ".")),
    ],
)
def test_a_solver_that_failed_ends_with_1(plugin, name, outcome, message):
    """A solver that failed ends with 1.

    Nobody who calls it from a script takes a defect for an answer.
    """
    asked = ("solve", "1", "2", "--solver", f"{plugin}:{name}", "--time-limit", "1", "--json")
    done = finished(*asked)

    assert done.returncode == 1
    assert json.loads(done.stdout)["outcome"] == outcome
    assert re.match(message, json.loads(done.stdout)["message"])


def test_brackets_in_names_are_no_markup(tmp_path):
    """Brackets in names are no markup.

    The bar that shows an experiment's name would take them for colours, and fail.
    """
    (tmp_path / "[").mkdir()
    quick_experiment(tmp_path, 2).rename(tmp_path / "[" / "red].toml")

    output(finished("run", "[/red].toml", "--out", "out", cwd=tmp_path))


ODD = """
import math
from dubins_study import Claim, Path, Solution, Solver

class Odd(Solver):
    name = "odd"

    def solve(self, question, limit):
        return Solution(Claim.FEASIBLE, Path(question.scenario.start, [{curvature}], [{length}]))
"""


CONTROLS = {"nan": ("math.nan", "1.0"), "turn": ("math.inf", "1.0"), "long": ("0.0", "math.inf")}


@pytest.mark.slow
def test_controls_that_are_not_finite_cost_their_own_row_alone(tmp_path):
    """Controls that are not finite cost one row.

    The answer is printed, nothing is drawn, and the folder of a run can be read.
    """
    specs = []
    for name, (curvature, length) in CONTROLS.items():
        (tmp_path / f"{name}.py").write_text(ODD.format(curvature=curvature, length=length))
        specs.append(f"{tmp_path}/{name}.py:Odd")
        drawing = ("--plot", str(tmp_path / "z.svg"))

        done = finished("solve", "3", "4", "--solver", specs[-1], "--json", *drawing)

        assert done.returncode == 1
        assert json.loads(done.stdout)["verdict"] == "misses"
        assert json.loads(done.stdout)["segments"] == []
        assert "is not written: there is no finite path" in done.stderr

    chosen = [word for spec in ("analytic", *specs) for word in ("--solver", spec)]
    output(finished("run", quick_experiment(tmp_path, 2), *chosen, "--out", tmp_path / "out"))
    output(finished("report", tmp_path / "out"))


def test_a_full_disk_for_the_output_is_one_message():
    """The device that is always full."""
    if not Path("/dev/full").exists():
        pytest.skip("there is no /dev/full")
    with Path("/dev/full").open("w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "dubins_study", "solve", "1", "2", "--json"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
        )
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "dubins-study: the output cannot be written: No space left on device"
    ]

"""Runs: a row for every cell, and resuming.

Nothing is there twice, and what is done stays done.
"""

import json
import math
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest

from dubins_study import run
from dubins_study.asking.reply import no_answer
from dubins_study.experiments.definition.experiment import ExperimentError, read
from dubins_study.experiments.executors import local
from dubins_study.experiments.executors.executor import WorkUnit
from dubins_study.experiments.executors.local import solve_chains
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import WorkerPool
from dubins_study.experiments.plan.cells import chains
from dubins_study.experiments.plan.run_plan import RunSettings
from dubins_study.experiments.store.folder import done, read_rows
from dubins_study.experiments.store.part_writer import write_part
from dubins_study.solvers.registry import SolverError
from dubins_study.study.rows.parts import ResultsError
from dubins_study.study.rows.schema import ROW, names
from dubins_study.study.words import Outcome
from tests.live_run import manifest

pytestmark = pytest.mark.smoke

SMALL = """
title = "small"
question = "does it run?"
solvers = ["analytic", "slsqp"]
branches = ["best", "LS"]
initial_guesses = ["cold", "warm"]

[[scenarios]]
label = "sweep"
target_x = 0
target_y = 3
radius = { linear = [1.0, 2.0, 4] }
"""
CELLS = 2 * 4 + 2 * 2 * 4  # analytic has no warm starts


@pytest.fixture
def small(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return str(file)


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    """Folder of a finished run.

    No test changes it.
    """
    file = tmp_path_factory.mktemp("original") / "small.toml"
    file.write_text(SMALL)
    return run(str(file), file.parent / "out")


def rows(folder):
    return read_rows(folder).to_pandas()


def test_every_cell_becomes_a_judged_row(original):
    table = rows(original)
    assert list(table.columns) == names(ROW)
    assert len(table) == CELLS
    assert not table.duplicated(subset=["solver", "branch", "initial_guess", "radius"]).any()
    assert set(table["outcome"]) == {"returned"}
    best = table[table["branch"] == "best"]
    assert set(best["verdict"]) == {"optimal"}
    # R = 2 puts the target into the left disc, where LS does not exist
    gone = table[(table["radius"] == 2.0) & (table["branch"] == "LS")]
    assert set(gone[gone["solver"] == "analytic"]["verdict"]) == {"none exists"}
    assert (table["threads"] == 1).all()
    assert (table["wall_s"] > 0).all()
    assert json.loads(table["versions"][0])["numpy"]


def test_a_finished_run_is_one_part_and_a_second_run_changes_nothing(small, folder, monkeypatch):
    before = rows(folder)
    entries = (folder / "manifest.json").read_text()
    assert len(list((folder / "parts").iterdir())) == 1
    monkeypatch.setattr(local, "solve_chains", lambda *a: pytest.fail("solved again"))

    run(small, folder)

    assert rows(folder).equals(before)
    assert (folder / "manifest.json").read_text() == entries


def test_rows_without_a_solve_are_interrupted_too(small):
    """Rows without a solve are interrupted too.

    They are of a solver that is not tried again: thousands of rows hold up neither Ctrl-C nor
    news.
    """
    cells = chains(read(small).experiment) * 400
    reply = no_answer(Outcome.CRASHED, "no more")
    unit = WorkUnit(RunSettings("r", 60.0), cells)

    def rows_made(until):
        stop = Interruption()
        rows = 0
        with WorkerPool(1) as pool:
            pool._unloadable |= {(chain[0].solver, chain[0].profile): reply for chain in cells}
            for made in solve_chains(pool, unit, stop):
                rows += len(made)
                stop.requested = rows >= until
        return rows

    assert 300 <= rows_made(300) < 310
    assert rows_made(math.inf) == sum(map(len, cells))


def test_a_run_cut_short_is_completed(small, original, tmp_path, monkeypatch):
    """A run cut short is completed.

    Whatever is done stays; the rest is added; a warm sweep is solved again.
    """
    whole = rows(original)
    solved = local.solve_chains

    def cut_short(*arguments):
        for rows in solved(*arguments):
            yield rows
            if any(row["initial_guess"] == "warm" and row["radius"] > 1 for row in rows):
                raise KeyboardInterrupt

    monkeypatch.setattr(local, "solve_chains", cut_short)
    with pytest.raises(KeyboardInterrupt):
        run(small, tmp_path / "cut")
    monkeypatch.undo()
    cells = done(tmp_path / "cut")
    assert 0 < len(cells) < CELLS
    assert not manifest(tmp_path / "cut")["finished"]

    again = rows(run(small, tmp_path / "cut"))

    key = ["scenario_id", "solver", "branch", "initial_guess"]
    same = [*key, "length", "verdict", "evaluations"]
    order = whole.sort_values(key)[same].reset_index(drop=True)
    assert again.sort_values(key)[same].reset_index(drop=True).equals(order)


def test_several_processes_find_the_same(small, original, tmp_path):
    columns = ["scenario_id", "solver", "branch", "initial_guess", "length", "verdict"]
    key = columns[:4]
    one = rows(original)[columns].sort_values(key, ignore_index=True)
    two = rows(run(small, tmp_path / "two", jobs=2))[columns].sort_values(key, ignore_index=True)

    assert one.equals(two)


def test_folders_that_cannot_be_used(small, folder, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    (other / "thesis.txt").write_text("mine")
    with pytest.raises(ResultsError, match=r"holds other files and no manifest\.json"):
        run(small, other)
    assert [f.name for f in other.iterdir()] == ["thesis.txt"]

    file = tmp_path / "file"
    file.write_text("")
    with pytest.raises(ResultsError, match="cannot write to"):
        run(small, file / "out")

    Path(small).write_text(SMALL.replace("small", "changed"))
    with pytest.raises(ResultsError, match="holds results of another text of experiment"):
        run(small, folder)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"jobs": 0}, "jobs is 0"),
        ({"jobs": 1.5}, "jobs is 1.5; expected a whole number"),
        ({"experiment": None}, "experiment is None; expected a name or the path"),
        ({"time_limit": "long"}, "^time_limit_s is 'long': expected a valid number"),
        ({"solvers": "slsqp"}, "^solvers is 'slsqp': expected a valid list"),
        ({"experiment": None, "scenarios": "a.csv"}, r"without solvers; expected solvers \(--sol"),
        ({"executor": "ray"}, "executor is 'ray'; expected one of: local, dask"),
        ({"executor": None}, "executor is None; expected one of"),
        ({"executor": "dask"}, "scheduler is None and executor 'dask'; expected executor 'dask'"),
        ({"executor": "dask", "scheduler": ""}, "scheduler is '' and executor 'dask'; expected"),
        ({"scheduler": "tcp://x:1"}, "scheduler is 'tcp://x:1' and executor 'local'; expected"),
        ({"executor": "dask", "scheduler": "tcp://x:1", "jobs": 2}, "jobs is 2; how many"),
    ],
)
def test_requests_that_are_refused_leave_no_folder(small, tmp_path, change, message):
    with pytest.raises(ExperimentError, match=message):
        run(**{"experiment": small, "out": tmp_path / "out"} | change)
    assert not (tmp_path / "out").exists()


def test_the_old_word_for_the_executor_is_taken_with_a_hint(small, tmp_path):
    """The old word for the executor gives a hint.

    The hint is at the caller's line, whether the request is then refused or not.
    """
    with pytest.warns(FutureWarning, match=r"run\(executor='dask'\)") as found:
        run(small, tmp_path / "out", solvers=["analytic"], engine="local")
    assert found[0].filename == __file__
    [entry] = manifest(tmp_path / "out")["runs"]
    assert entry["executor"] == "local"
    assert "engine" not in entry
    with (
        pytest.warns(FutureWarning, match="the old word, engine, is taken for this release only"),
        pytest.raises(ExperimentError, match="executor is 'ray'"),
    ):
        run(small, engine="ray")


def test_errors_name_the_file_unless_the_caller_is_to_blame(small, tmp_path):
    with pytest.raises(SolverError, match=r"^solver 'ipopt' has no setting 'steps'"):
        run(small, solvers=["ipopt[steps=1]"])
    Path(small).write_text(SMALL.replace('"analytic"', '"anal"'))
    with pytest.raises(ValueError, match=r"small\.toml: line \d+: solvers: no solver named 'anal'"):
        run(small, tmp_path / "out")
    assert not (tmp_path / "out").exists()


MISFITS = """
import os
from dataclasses import dataclass
from dubins_study import Claim, Solution
from dubins_study.solvers.paper_nlp.nlp import Slsqp
class NoBranches(Slsqp):
    branches = ()
@dataclass(frozen=True)
class Infinite(Slsqp):
    patience: float = float("inf")
class Counts(Slsqp):
    def solve(self, model, limit): return Solution(Claim.NONE, evaluations="x")
class Deadly(Slsqp):
    def solve(self, model, limit): os._exit(1)
class Raising(Slsqp):
    def solve(self, model, limit): raise OSError("no licence")
"""


@pytest.mark.slow
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_plugin_that_breaks_its_promise_spoils_no_other_row(small, tmp_path, jobs):
    plugin = tmp_path / "misfits.py"
    plugin.write_text(MISFITS)
    expected = {
        "NoBranches": ("raised", None),
        "Infinite": ("returned", None),
        "Counts": ("raised", "TypeError: evaluations is 'x'; expected a count or None"),
        "Deadly": ("crashed", None),
        "Raising": ("raised", "OSError: no licence"),
    }
    specs = [f"{plugin}:{name}" for name in expected]
    table = rows(run(small, tmp_path / "out", solvers=["analytic", *specs], jobs=jobs))

    assert len(table) == 8 + 5 * 16
    by_solver = dict(list(table.groupby("solver")))
    assert set(by_solver["analytic"]["outcome"]) == {"returned"}
    for name, (outcome, message) in expected.items():
        part = by_solver[f"{plugin}:{name}"]
        assert set(part["outcome"]) == {outcome}
        assert message is None or set(part["message"]) == {message}
        assert outcome == "returned" or set(part["verdict"]) == {"none"}
    assert set(by_solver[f"{plugin}:Deadly"]["native_status"]) == {"exit 1"}


def test_progress_counts_every_cell(small, tmp_path):
    messages = []
    run(small, tmp_path / "out", progress=lambda n, total: messages.append((n, total)))

    assert messages[-1] == (CELLS, CELLS)
    assert [n for n, _ in messages] == sorted(n for n, _ in messages)


LATE = """
from dataclasses import replace
from dubins_study.solvers.paper_nlp.nlp import Slsqp
class Warmed(Slsqp):
    def solve(self, model, limit):
        scenario, start = model.leg.question.scenario, model.leg.question.initial_guess
        if scenario.radius == 2 and FAILS:
            raise ValueError("the second fails")
        solution = super().solve(model, limit)
        told = "none" if start is None else f"{start.lengths.sum():.6f}"
        return replace(solution, message=told)
"""


@pytest.mark.slow
def test_a_resumed_sweep_starts_where_an_unbroken_one_would(tmp_path):
    """A resumed sweep starts like an unbroken one.

    It starts from the last path that was found before, after a failure and across holes.
    """
    plugin = tmp_path / "late.py"
    file = tmp_path / "sweep.toml"
    plugin.write_text(LATE.replace("FAILS", "True"))
    file.write_text(
        'title = "sweep"\nquestion = "?"\nsolvers = ["analytic"]\ninitial_guesses = ["warm"]\n'
        "[[scenarios]]\ntarget_x = 9\ntarget_y = 3\nradius = [1, 2, 3, 4, 5]\n"
    )
    spec = f"{plugin}:Warmed"
    whole = rows(run(file, tmp_path / "out", solvers=[spec])).sort_values("radius")
    started = whole["message"].tolist()
    assert started[1] == "ValueError: the second fails"
    assert started[0] == "none" not in started[2:]

    for gone in ([3.0, 4.0, 5.0], [3.0, 5.0], [4.0], [2.0, 3.0]):
        part = next((tmp_path / "out" / "parts").glob("*.parquet"))
        table = pq.read_table(part)
        rest = table.filter(pc.invert(pc.is_in(table["radius"], value_set=pa.array(gone))))
        name = part.stem
        part.unlink()
        write_part(tmp_path / "out", name, rest)

        again = rows(run(file, tmp_path / "out", solvers=[spec])).sort_values("radius")

        assert again["message"].tolist() == started
        assert len(again) == 5


@pytest.mark.slow
def test_engines_whose_libraries_clash_share_no_worker(tmp_path):
    """Engines with clashing libraries share no worker.

    SLEQP loads another HiGHS than highspy's: in one process HiGHS then answers nothing.

    SLEQP takes a minute where a word has no path.
    """
    experiment = tmp_path / "clash.toml"
    experiment.write_text(
        'title = "t"\nquestion = "?"\nseed = 1\nrepeats = 2\n'
        'solvers = ["nlp[engine=sleqp,presolve=true]", "heading-milp",'
        '"turn-rate-qp[engine=highs,n=10]"]\n'
        "[[scenarios]]\ntarget_x = [3, 4]\ntarget_y = 2\n"
    )

    rows = read_rows(run(experiment, tmp_path / "out"), ["solver", "gap", "message"]).to_pandas()

    assert rows["gap"].notna().all(), set(rows["message"])

"""The text of `status` about a folder.

It is counted by hand, and estimated from what the folder holds.
"""

import json
import re
from dataclasses import replace

import pytest

from dubins_study import run, status
from dubins_study.cli.status import status_text
from dubins_study.experiments.store.part_writer import write_part
from dubins_study.study.rows.parts import read_part, rows_table
from dubins_study.study.rows.schema import RUN_ID
from tests.live_run import finished, manifest, parts, quick_experiment

pytestmark = pytest.mark.smoke

CELLS = 10


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    place = tmp_path_factory.mktemp("status")
    experiment = quick_experiment(place, CELLS, 'analytic", "slsqp", "shooting')
    return run(str(experiment), place / "out")


def rewrite(folder, edit):
    """Put edited rows into a folder.

    `edit` makes them of its own.
    """
    (part,) = parts(folder)
    rows = edit(read_part(part).to_pylist())
    part.unlink()
    write_part(folder, "edited", rows_table(rows), {RUN_ID: "x"})


def amend(folder, **changes):
    file = folder / "manifest.json"
    file.write_text(json.dumps(manifest(folder) | changes))


def test_done_left_and_failing_are_counted(folder):
    """Done, left and failing cells are counted.

    Of 30 cells: 2 of slsqp and all of shooting left, 3 timed out, 1 of earlier code.
    """

    def edit(rows):
        rows = [row for row in rows if row["solver"] != "shooting"]
        solver_rows = [row for row in rows if row["solver"] == "slsqp"]
        for row in solver_rows[:3]:
            row |= {"outcome": "timeout", "claim": "none", "verdict": "none"}
        solver_rows[3]["code_digest"] = "ffffffffffff"
        rows.remove(solver_rows[4])
        return rows

    rewrite(folder, edit)
    progress = status(folder)

    assert (progress.cells, progress.done, progress.stale) == (3 * CELLS, 2 * CELLS - 2, 1)
    assert progress.left == {"slsqp": 2, "shooting": CELLS}
    assert progress.failing == {"timeout": 3}
    assert progress.verdicts["slsqp"] == {"timeout": 3, "optimal": CELLS - 5}
    assert progress.verdicts["analytic"] == {"optimal": CELLS}


def test_a_folder_that_has_lost_rows_is_not_finished(folder):
    """A folder that lost rows is not finished.

    A part of a run that had finished is cut short: the cells of its rows are left.
    """
    assert status(folder).finished
    (part,) = parts(folder)
    part.write_bytes(part.read_bytes()[:100])

    cut = status(folder)
    assert (cut.damaged, sum(cut.left.values())) == (1, cut.cells)
    assert not cut.finished
    assert "not finished: run it again" in status_text(cut)


def test_the_time_left_is_that_of_the_cells_so_far(folder):
    """8 cells of 2 s done, 2 left."""

    def edit(rows):
        rows = [row for row in rows if row["solver"] == "slsqp"][: CELLS - 2]
        return [row | {"wall_s": 2.0, "run_id": "r"} for row in rows]

    rewrite(folder, edit)
    solvers = {"slsqp": manifest(folder)["solvers"]["slsqp"]}
    entry = {"run_id": "r", "seconds": 20.0, "jobs": 1, "state": "finished"}
    amend(folder, solvers=solvers, cells=CELLS, runs=[entry])
    assert status(folder).seconds_left == pytest.approx(4.0)
    text = finished("status", folder).stdout
    assert "time left   about 4 s; jobs: 1" in text
    assert "left        2: slsqp 2" in text

    amend(folder, runs=[entry | {"jobs": 2}])
    assert status(folder).seconds_left == pytest.approx(2.0)
    assert status(folder).jobs == 2


def test_how_long_a_killed_run_took_is_not_known(folder):
    """A killed run's duration is not known.

    Its entry holds the time at which it last wrote the manifest.
    """
    amend(folder, runs=[{"run_id": "r", "state": "running", "seconds": 0.001}])
    (entry,) = status(folder).runs

    assert (entry.state, entry.seconds) == ("killed", None)
    assert "1 ms" not in status_text(status(folder))


def test_of_many_solvers_the_text_names_the_five_with_most_cells_left(folder):
    """The benchmark has 179 solvers; `--json` names them all."""
    left = {f"s{number}": number for number in range(1, 10)}
    text = status_text(replace(status(folder), left=left))

    assert "left        45: s9 9, s8 8, s7 7, s6 6, s5 5 and 4 more\n" in text


def test_without_rows_no_time_is_made_up(folder):
    rewrite(folder, lambda rows: [row for row in rows if row["solver"] == "analytic"])
    amend(folder, solvers={"slsqp": manifest(folder)["solvers"]["slsqp"]}, cells=CELLS)
    progress = status(folder)

    assert progress.seconds_left is None
    assert (
        "time left   unknown: no row is done yet to judge by" in finished("status", folder).stdout
    )


def test_json_is_one_object_with_the_same(folder):
    rewrite(folder, lambda rows: rows[:-3])
    amend(folder, finished=None)
    process = finished("status", folder, "--json")
    content = json.loads(process.stdout)

    assert process.returncode == 0
    assert (content["cells"], content["done"], content["left"]) == (3 * CELLS, 3 * CELLS - 3, 3)
    assert sum(content["left_by_solver"].values()) == 3
    assert content["seconds_left"] > 0
    assert {"failing", "stale", "damaged", "runs", "jobs"} <= content.keys()
    assert content["runs"][0]["state"] == "finished"
    assert not content["finished"]


def test_a_noisy_run_says_so(folder):
    runs = manifest(folder)["runs"]
    runs[0]["probes"] = [[i, 1e-3 * (1 + 0.3 * (i % 2))] for i in range(40)]
    amend(folder, runs=runs)
    text = finished("status", folder).stdout

    assert re.search(rf"{runs[0]['run_id']} .* 26.1 %", text)


@pytest.mark.slow
def test_subsets_and_repeats_keep_count(tmp_path):
    """Subsets and repeats keep count.

    A run of one solver alone does not make the folder finished, nor forget the others.
    """
    experiment = str(quick_experiment(tmp_path, 4, 'analytic", "slsqp'))
    folder = run(experiment, tmp_path / "out")
    rewrite(folder, lambda rows: [row for row in rows if row["solver"] == "analytic"])
    amend(folder, finished=None)
    created = manifest(folder)["created"]

    run(experiment, folder, solvers=["shooting"])

    assert manifest(folder)["created"] == created
    assert set(manifest(folder)["solvers"]) == {"analytic", "slsqp", "shooting"}
    progress = status(folder)
    assert (progress.cells, progress.done, progress.finished) == (12, 8, False)
    assert progress.left == {"slsqp": 4}
    entries = len(manifest(folder)["runs"])
    run(experiment, folder, solvers=["shooting"])  # there is nothing to do
    assert len(manifest(folder)["runs"]) == entries
    run(experiment, folder)
    assert status(folder).finished
    run(experiment, folder, repeats=2)
    assert status(folder).cells == status(folder).done == 4 + 16

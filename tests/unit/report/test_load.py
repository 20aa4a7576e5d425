"""Results folders are read or refused.

A refusal is one clear message. Where rows were made counts too.

`elsewhere` was made by a run with two threads and another scipy (and so other code digests).
"""

import json
import shutil
from pathlib import Path as FilePath

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from dubins_study import load_results, render, solve, status
from dubins_study.report.data.rejudged import judged_anew, same_set_up
from dubins_study.report.data.results import load
from dubins_study.report.topics.appendix import runs_section
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.rows.manifest import read_manifest
from dubins_study.study.rows.parts import ResultsError, read_part
from dubins_study.study.rows.schema import VERSION
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import FROZEN, Claim
from tests.unit.report.results_folder import SCHEMA, attempt, paper_scenarios, write_folder
from tests.unit.report.topic_page import topic_page


def test_a_cell_that_two_folders_hold_counts_once(tmp_path, results):
    """A cell that two folders hold counts once.

    Merging folders is a union of cells, and paths stay with their rows.
    """
    one, two, three = paper_scenarios()[:3]
    first = results("paper", [attempt(one, path=None), attempt(two)])
    second = write_folder(tmp_path / "again", "paper", [attempt(two), attempt(three)])

    found = load([first, second])

    assert found.rows["label"].tolist() == [one.label, two.label, three.label]
    assert [found.path(place) for place in (0, 2)] == [None, shortest_path(three)]


def test_a_folder_of_results_folders_stands_for_them(tmp_path):
    """A folder of results folders stands for them.

    `results/benchmark` is one: its suites are folders of their own.
    """
    one, two, three = paper_scenarios()[:3]
    first = write_folder(tmp_path / "suites" / "a", "leg", [attempt(one)])
    second = write_folder(tmp_path / "suites" / "b", "pose", [attempt(two), attempt(three)])

    joined, apart = load(tmp_path / "suites"), load([first, second])

    assert joined.rows.equals(apart.rows)
    assert joined.rows["experiment"].tolist() == ["leg", "pose", "pose"]
    with pytest.raises(ResultsError, match=r"has no manifest\.json"):
        load(tmp_path)


def test_a_solver_that_the_manifest_does_not_name_counts_nowhere(results):
    """A solver missing in the manifest counts nowhere.

    Nobody knows whether such rows are of its current code; the report and `status` agree.
    """
    one, two = paper_scenarios()[:2]
    named = {"analytic": {"code_digest": "0123456789ab", "cells": 1}}
    folder = results("paper", [attempt(one), attempt(two, "slsqp")], solvers=named)
    (read,) = load([folder]).folders
    counted = status(folder)

    assert load([folder]).rows["solver"].unique().tolist() == ["analytic"]
    assert (read.rows.current, read.rows.stale) == (counted.done, counted.stale) == (1, 1)


def _change_manifest(**changes):
    def spoil(folder):
        manifest = json.loads((folder / "manifest.json").read_text())
        (folder / "manifest.json").write_text(json.dumps(manifest | changes))

    return spoil


def _change_table(change):
    def spoil(folder):
        part = folder / "parts" / "1.parquet"
        pq.write_table(change(pq.read_table(part)), part)

    return spoil


def _much(table):
    """Rows whose gap is a text."""
    place = table.column_names.index("gap")
    return table.set_column(place, "gap", pa.array(["much"] * table.num_rows))


LATER = ["lower_bound", "subproblems", "evaluations", "presolved", "subproblem_s"]


@pytest.mark.parametrize("lacking", [(1,), (1, 2)])
def test_a_column_that_a_part_lacks_is_null(results, lacking):
    """A column that a part lacks is null.

    Columns of every type are left out, in one part of a folder or in all.
    """
    one, two = paper_scenarios()[:2]
    folder = results("paper", [attempt(one, lower_bound=1.0)])
    pq.write_table(
        pa.Table.from_pylist([attempt(two, lower_bound=1.0)], schema=SCHEMA),
        folder / "parts" / "2.parquet",
    )
    for number in lacking:
        part = folder / "parts" / f"{number}.parquet"
        pq.write_table(pq.read_table(part).drop_columns(LATER), part)
    found = load([folder])
    whole = read_part(folder / "parts" / "1.parquet")

    assert found.rows[LATER[:-1]].isna().all(axis=1).sum() == len(lacking)
    assert found.rows["lower_bound"].sum() == 2 - len(lacking)
    assert whole.schema.equals(SCHEMA)
    assert read_part(folder / "parts" / "1.parquet", LATER[:1]).to_pylist() == [
        {"lower_bound": None}
    ]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda f: (f / "manifest.json").unlink(), "has no manifest.json"),
        (lambda f: (f / "manifest.json").write_text("{"), "cannot be read"),
        (lambda f: (f / "manifest.json").write_text("[]"), "valid dictionary"),
        (lambda f: (f / "manifest.json").write_text("[" * 100_000), "cannot be read"),
        (lambda f: (f / "manifest.json").write_text("9" * 5_000), "cannot be read"),
        (lambda f: (f / "manifest.json").write_bytes(b"\xff\xfe\x00"), "cannot be read"),
        (_change_manifest(schema=VERSION + 1), f"schema is {VERSION + 1}: Input should be"),
        (_change_manifest(experiment={}), "experiment.name is {}: Field required"),
        (lambda f: (f / "parts" / "1.parquet").unlink(), "has no rows"),
        (lambda f: pq.write_table(SCHEMA.empty_table(), f / "parts" / "1.parquet"), "has no rows"),
        (lambda f: (f / "parts" / "1.parquet").write_bytes(b"PAR1 no"), "cannot be read"),
        (lambda f: (f / "parts" / "1.parquet").write_bytes(b""), "cannot be read"),
        (_change_table(lambda t: t.drop_columns(["solver"])), "it has no column 'solver'"),
        (_change_table(lambda t: t.append_column("extra", t["gap"])), "it has a column 'extra'"),
        (_change_table(_much), "cannot be read"),
    ],
)
def test_a_spoilt_folder_is_refused(results, spoil, message):
    """A spoilt folder is refused.

    Whatever is wrong with a folder, one error names it and the place.
    """
    folder = results("paper", [attempt(paper_scenarios()[0])])
    spoil(folder)

    with pytest.raises(ResultsError, match="paper") as caught:
        load([folder])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_page_says_which_rows_are_left_out(tmp_path):
    """The page names the rows left out.

    They are rows of earlier code, and rows of a cell that a folder before holds, by other code or
    by this.
    """
    one, two, three = map(attempt, paper_scenarios()[:3])
    other = {"code_digest": "f" * 12}
    named = {"analytic": {"code_digest": "0123456789ab"}}
    folders = [
        write_folder(tmp_path / "1", "paper", [one, two, three | other], solvers=named),
        write_folder(tmp_path / "2", "paper", [one | other, two | other]),
        write_folder(tmp_path / "3", "paper", [one | {"outcome": "raised"}]),
        write_folder(tmp_path / "4", "paper", [two | {"claim": "local"}]),
    ]
    counts = [folder.rows for folder in load(folders).folders]
    render(folders, tmp_path / "page")

    assert [each.stale for each in counts] == [1, 0, 0, 0]
    assert [each.replaced for each in counts] == [0, 2, 0, 0]
    assert [each.contradicting for each in counts] == [0, 0, 1, 1]
    text = (tmp_path / "page" / "index.html").read_text(encoding="utf-8")
    assert "2 rows of cells that an earlier folder has, made by other code" in text
    assert text.count("It contradicts an earlier folder in 1 cell, with the same code") == 2


def test_a_gap_that_differs_contradicts(tmp_path):
    """A gap that differs contradicts.

    It differs by more than the tolerance, where everything else agrees; whichever row comes first.
    """
    rows = [attempt(scenario) for scenario in paper_scenarios()]
    near = [row | {"gap": row["gap"] + 0.5e-4} for row in rows]
    far = [row | {"gap": row["gap"] + 1.5e-4 * (i < 3)} for i, row in enumerate(rows)]
    one, near, far = (
        write_folder(tmp_path / str(number), "paper", own)
        for number, own in enumerate((rows, near, far))
    )

    assert [f.rows.contradicting for f in load([one, near, far]).folders] == [0, 0, 3]
    assert [f.rows.contradicting for f in load([far, one]).folders] == [0, 3]


ELSEWHERE = FilePath(__file__).parent / "elsewhere"


@pytest.fixture
def here(tmp_path):
    rows = [attempt(scenario, "ipopt") for scenario in paper_scenarios()]
    return write_folder(tmp_path / "here", "here", rows)


def changed(place: FilePath, change) -> FilePath:
    """A copy of the folder with one changed answer.

    The first answer is changed.
    """
    shutil.copytree(ELSEWHERE, place)
    (file,) = (place / "parts").iterdir()
    table = pq.read_table(file)
    records = table.to_pylist()
    answer = next(record for record in records if record["outcome"] == "returned")
    answer |= change(answer)
    pq.write_table(pa.Table.from_pylist(records, schema=table.schema), file)
    return place


def recheck_of(*folders: FilePath):
    *_, last = load(folders).folders
    return last.recheck


def test_its_rows_are_what_the_check_finds_here(here):
    """Its rows are the check's results here.

    There are legs, poses and a route, from two engines; a question that a solver does not take is
    not judged.
    """
    recheck = recheck_of(here, ELSEWHERE)

    assert (recheck.judged, recheck.left, recheck.changed) == (19, 0, 0)
    rows = load_results([here, ELSEWHERE])
    assert set(rows.loc[rows["experiment"] == "theirs", "threads"]) == {2}


@pytest.mark.parametrize(
    ("change", "differing"),
    [
        (lambda row: {"verdict": "longer"}, {"verdict": 1}),
        (lambda row: {"length": 0.5 * row["length"], "gap": -0.5}, {"length": 1, "gap": 1}),
        (lambda row: {"false_claim": True}, {"false_claim": 1}),
        (lambda row: {"branch": FROZEN}, {}),
    ],
)
def test_what_differs_is_counted_and_corrected(here, tmp_path, change, differing):
    """Differences are counted and corrected.

    The page has the check's numbers; a convex problem's answer is not in its row.
    """
    theirs = changed(tmp_path / "theirs", change)
    recheck = recheck_of(here, theirs)
    answers = "experiment == 'theirs' and outcome == 'returned'"
    row = load_results([here, theirs]).query(answers).iloc[0]

    assert recheck.differing == differing
    assert (recheck.changed, recheck.left) == ((1, 0) if differing else (0, 1))
    if differing:
        assert (row["verdict"], row["false_claim"]) == ("optimal", False)
        assert abs(row["gap"]) < 1e-4


POINTS = [(4, 1, "90deg"), (6, -2), (-3, 5)]


def test_tours_and_free_starts_are_judged_anew_as_they_were(tmp_path):
    """Tours and free starts are judged anew alike.

    From a part come back the path's start heading, the order and the headings at points.
    """
    asked = [
        Scenario(target_x=9, target_y=2, via=POINTS, order="free"),
        Scenario(heading=None, via=POINTS, order="free"),
        Scenario(heading=2, via=POINTS, order="free", closed=True),
        Scenario(via=POINTS, closed=True),
        Scenario(heading=None, target_x=9, target_y=2, via=POINTS, final_heading=1),
    ]
    rows = [attempt(one, path=None, claim=Claim.NONE) | solve(one).row() for one in asked]
    folder = write_folder(tmp_path / "tours", "tours", rows)
    (file,) = (folder / "parts").iterdir()

    table, recheck = judged_anew(read_part(file), read_manifest(folder))

    assert (recheck.judged, recheck.changed) == (len(asked), 0)
    lines = table.to_pylist()
    assert {row["verdict"] for row in lines} == {"optimal"}
    for name in ("visits", "visit_order", "start_heading", "reference_word"):
        assert [row[name] for row in lines] == [row[name] for row in rows], name


def test_what_did_not_return_has_no_path(here, tmp_path):
    theirs = changed(tmp_path / "theirs", lambda row: {"outcome": "crashed"})
    row = load_results([here, theirs]).query("outcome == 'crashed'").iloc[0]

    assert row["verdict"] == "none"


def test_a_folder_of_the_same_set_up_is_believed(here, tmp_path):
    """A folder of the same set-up is not judged.

    One's own runs are judged when they are made; so is the first folder, whoever made it.
    """
    theirs = changed(tmp_path / "theirs", lambda row: {"verdict": "longer"})

    assert recheck_of(ELSEWHERE, theirs) is None
    assert load([theirs, here]).folders[0].recheck is None


def test_a_package_that_one_folder_alone_records_is_no_other_set_up():
    """A package in one folder alone changes no set-up.

    Two experiments of one machine ask different engines; another version of one is another set-up.
    """
    one = read_manifest(ELSEWHERE)
    name, *others = one.versions
    fewer = one.model_copy(update={"versions": {key: one.versions[key] for key in others}})
    newer = one.model_copy(update={"versions": one.versions | {name: "0.0"}})

    assert same_set_up(one, fewer)
    assert not same_set_up(one, newer)


def test_the_page_says_what_differs_with_machine_and_versions(here, tmp_path):
    theirs = changed(tmp_path / "theirs", lambda row: {"verdict": "longer"})
    page = topic_page([here, theirs], tmp_path / "out", "summary").read_text(encoding="utf-8")

    assert "(judged anew)" in page
    assert "1 row of 19 differ from what the folder says (verdict 1)" in page
    assert "AMD EPYC" in page
    assert "scipy 1.16.3" in page


def entry(run_id="abc", probes=(), **changes):
    return {
        "run_id": run_id,
        "state": "finished",
        "machine": {"system": "Linux x86_64", "processor": "Z80", "cores": 4, "usable_cores": 2},
        "governor": "performance",
        "load_start": [0.25, 0.1, 0.1],
        "load_end": [1.5, 0.2, 0.1],
        "probes": [[2.0 * i, took] for i, took in enumerate(probes)],
    } | changes


STEADY = [1e-3 * (1 + 0.001 * (i % 3)) for i in range(40)]
NOISY = [1e-3 * (1 + 0.3 * (i % 2)) for i in range(40)]


@pytest.fixture
def section(load_rows):
    def written(*entries):
        return runs_section(load_rows("paper", [attempt(paper_scenarios()[0])], runs=entries))

    return written


def test_a_noisy_run_is_marked(section):
    """A noisy run is marked.

    A machine that varied by 30 % (between two speeds) is marked; a quiet one is not.
    """
    written = section(entry("quiet", STEADY), entry("loud", NOISY))

    # the 5th and 95th percentile are the two speeds, the median lies between them
    varied = 0.3 / np.median([1, 1.3])
    (table,) = written.blocks
    rows = table.frame.set_index("run")
    assert rows["spread"].to_dict() == pytest.approx({"quiet": 0.002, "loud": varied}, rel=0.01)
    assert rows.loc["loud", "where"] == "Z80, Linux x86_64, 2 of 4 cores; governor performance"
    assert rows.loc["loud", "load"] == "0.25 to 1.50"
    assert table.marks == {(1, "spread"): "bad"}


def test_a_run_without_an_end_is_running_or_killed(section):
    """How long a killed one took is not known."""
    (table,) = section(entry(state="running", seconds=0.001), entry(seconds=3.0)).blocks

    assert table.frame["state"].tolist() == ["running, or killed", "finished"]
    assert table.frame["seconds"].tolist() == pytest.approx([float("nan"), 3.0], nan_ok=True)

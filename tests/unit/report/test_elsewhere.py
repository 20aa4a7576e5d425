"""Where rows were made: folders from elsewhere are judged anew; how steady machines were is said.

`elsewhere` was made by a run with two threads and another scipy (and so other code digests).
"""

from __future__ import annotations

import shutil
from pathlib import Path as FilePath

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from dubins_study import load_results
from dubins_study.report.data.rejudged import same_set_up
from dubins_study.report.data.results import load
from dubins_study.report.topics.appendix import runs_section
from dubins_study.study.rows.manifest import read_manifest
from dubins_study.study.words import FROZEN
from tests.unit.report.results_folder import attempt, paper_scenarios, write_folder
from tests.unit.report.topic_page import topic_page

ELSEWHERE = FilePath(__file__).parent / "elsewhere"


@pytest.fixture
def here(tmp_path):
    rows = [attempt(scenario, "ipopt") for scenario in paper_scenarios()]
    return write_folder(tmp_path / "here", "here", rows)


def changed(place: FilePath, change) -> FilePath:
    """A copy of the folder whose first answer is changed."""
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
    """Legs, poses and a route, from two engines; what a solver does not take is not judged."""
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
    """The page has the check's numbers; a convex problem's answer is not in its row."""
    theirs = changed(tmp_path / "theirs", change)
    recheck = recheck_of(here, theirs)
    answers = "experiment == 'theirs' and outcome == 'returned'"
    row = load_results([here, theirs]).query(answers).iloc[0]

    assert recheck.differing == differing
    assert (recheck.changed, recheck.left) == ((1, 0) if differing else (0, 1))
    if differing:
        assert (row["verdict"], row["false_claim"]) == ("optimal", False)
        assert abs(row["gap"]) < 1e-4


def test_what_did_not_return_has_no_path(here, tmp_path):
    theirs = changed(tmp_path / "theirs", lambda row: {"outcome": "crashed"})
    row = load_results([here, theirs]).query("outcome == 'crashed'").iloc[0]

    assert row["verdict"] == "none"


def test_a_folder_of_the_same_set_up_is_believed(here, tmp_path):
    """One's own runs are judged when they are made; so is the first folder, whoever made it."""
    theirs = changed(tmp_path / "theirs", lambda row: {"verdict": "longer"})

    assert recheck_of(ELSEWHERE, theirs) is None
    assert load([theirs, here]).folders[0].recheck is None


def test_a_package_that_one_folder_alone_records_is_no_other_set_up():
    """Two experiments of one machine ask different engines; another version of one is another."""
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


def test_a_noisy_run_says_so_in_words(section):
    """A machine that varied by 30 % (between two speeds) is named; a quiet one is not."""
    written = section(entry("quiet", STEADY), entry("loud", NOISY))

    # the 5th and 95th percentile are the two speeds, the median lies between them
    varied = 0.3 / np.median([1, 1.3])
    assert f"Run loud of paper varied by {100 * varied:.1f} %" in written.text
    assert "Run quiet" not in written.text
    (table,) = written.blocks
    rows = table.frame.set_index("run")
    assert rows["spread"].to_dict() == pytest.approx({"quiet": 0.002, "loud": varied}, rel=0.01)
    assert rows.loc["loud", "where"] == "Z80, Linux x86_64, 2 of 4 cores; governor performance"
    assert rows.loc["loud", "load"] == "0.25 to 1.50"
    assert table.marks == {(1, "spread"): "bad"}


@pytest.mark.parametrize(
    ("probes", "sentence"),
    [
        (STEADY, "No run varied by more than 5.0 %"),
        (NOISY[:4], "No run here was long enough to tell."),
    ],
    ids=["quiet", "short"],
)
def test_a_run_that_is_not_known_to_be_noisy(section, probes, sentence):
    assert sentence in section(entry(probes=probes)).text


def test_a_run_without_an_end_is_running_or_killed(section):
    """How long a killed one took is not known."""
    (table,) = section(entry(state="running", seconds=0.001), entry(seconds=3.0)).blocks

    assert table.frame["state"].tolist() == ["running, or killed", "finished"]
    assert table.frame["seconds"].tolist() == pytest.approx([float("nan"), 3.0], nan_ok=True)

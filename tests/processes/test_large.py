"""Folders of streams: numbers of all rows, single rows of some, whatever their number."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest

from dubins_study import render, run
from dubins_study.experiments.plan import streams
from dubins_study.report.data.plane_map import CELLS, REACH, WORDS
from dubins_study.report.data.results import load as load_results
from dubins_study.report.data.results import part_files
from dubins_study.study.rows.files import ResultsError
from tests.unit.report.results_folder import attempts_of
from tests.unit.report.test_attempts import alike

EXPERIMENT = """
title = "Many"
question = "How long is it?"
solvers = ["analytic"]
branches = ["best", "LS"]
[[scenarios]]
label = "many"
heading = [0.3, 2]
radius = [1, 2]
target_x = { linear = [-4, 4, 40] }
target_y = { linear = [-4, 4, 40] }
[[scenarios]]
label = "few"
target_x = 3
target_y = { linear = [1, 9, 9] }
"""
ROWS = 2 * (6400 + 9)


@pytest.fixture
def many(tmp_path, monkeypatch):
    """A folder of streamed chunks and single cells."""
    monkeypatch.setattr(streams, "CHUNK_ROWS", 1000)
    (tmp_path / "many.toml").write_text(EXPERIMENT, encoding="utf-8")
    return run(str(tmp_path / "many.toml"), tmp_path / "out")


@pytest.fixture
def sampling(monkeypatch):
    """Rows are kept whole up to 5000, of more about 2000."""
    monkeypatch.setattr("dubins_study.report.data.results.MOST_ROWS", 5000)
    monkeypatch.setattr("dubins_study.report.data.results.SAMPLE_ROWS", 2000)


def every_row(folder):
    return pd.concat([pq.read_table(f).to_pandas() for f in sorted((folder / "parts").iterdir())])


@pytest.mark.slow
def test_numbers_are_of_all_rows_and_rows_a_sample_of_scenarios(many, sampling, tmp_path):
    """The counts of the parts are those of single cells; a scenario is in the sample or is not."""
    found = load_results([many])
    rows = every_row(many).assign(experiment="many")

    assert len(rows) == ROWS == found.attempts.count
    assert found.sampled
    alike(found.attempts, attempts_of(tmp_path / "cells", rows))
    assert 1500 < len(found.rows) < 2500
    counted = rows.groupby("scenario_id").size()
    kept = found.rows.groupby("scenario_id").size()
    assert kept.equals(counted[kept.index])
    expected = rows.set_index(["scenario_id", "branch"])["length"]
    of_sample = found.rows.set_index(["scenario_id", "branch"])["length"]
    assert np.array_equal(of_sample, expected[of_sample.index], equal_nan=True)
    first = found.rows[found.rows["gap"].notna()].index[0]
    assert found.path(first).total_length == found.rows["length"][first]


@pytest.mark.slow
def test_the_sample_does_not_depend_on_the_order_of_parts(many, sampling, monkeypatch):
    """Nor do the numbers."""
    one = load_results([many])
    monkeypatch.setattr(
        "dubins_study.report.data.results.part_files", lambda folder: part_files(folder)[::-1]
    )
    other = load_results([many])

    alike(one.attempts, other.attempts)
    assert set(one.rows["scenario_id"]) == set(other.rows["scenario_id"])


@pytest.mark.slow
@pytest.mark.parametrize("kept", [5000, 10**6])
def test_what_two_folders_hold_counts_once(many, tmp_path, kept, monkeypatch):
    """Chunks are known by their metadata, cells by their keys; whole rows or a sample of them."""
    monkeypatch.setattr("dubins_study.report.data.results.MOST_ROWS", kept)
    once, twice = load_results([many]), load_results([many, many])

    alike(once.attempts, twice.attempts)
    if kept > ROWS:
        assert len(twice.rows) == ROWS
    assert [folder.rows.stale for folder in twice.folders] == [0, 0]


def test_rows_of_earlier_code_are_told_and_left_out(many, sampling):
    """Chunk by chunk, as cell by cell."""
    manifest = json.loads((many / "manifest.json").read_text())
    manifest["solvers"]["analytic"]["code_digest"] = "changed"
    (many / "manifest.json").write_text(json.dumps(manifest))

    with pytest.raises(ResultsError, match="no rows but of earlier code"):
        load_results([many])


@pytest.mark.slow
def test_the_page_says_what_it_leaves_out(many, sampling, tmp_path):
    """With both numbers, in the sections that it concerns; tables count every attempt."""
    page = render([many], tmp_path / "page").read_text(encoding="utf-8")
    table = pd.read_csv(tmp_path / "page" / "tables" / "summary.csv")
    rows = every_row(many)

    existence = pd.read_csv(tmp_path / "page" / "tables" / "existence.csv")

    kept = len(load_results([many]).rows)
    without = (rows["verdict"] == "none exists").sum()  # the closed form is right everywhere
    assert without > 0
    assert table["attempts"].tolist() == [ROWS - without]
    assert existence["reached"].tolist() == [without]
    assert existence["right_share"].tolist() == [1.0]
    spaced = f"{kept:,}".replace(",", "\u202f")
    time = page.split('<section id="time"')[1].split("<figure")[0]
    assert f"they are {spaced} of the 12\u202f818:" in time
    assert "quartiles and medians are of all" in time
    assert "Where single attempts" not in page.split('<section id="summary"')[1].split("<table")[0]


@pytest.mark.slow
def test_small_folders_are_read_whole(many, tmp_path):
    """No sample, no word about one; the numbers are those of the rows."""
    found = load_results([many])
    page = render([many], tmp_path / "page").read_text(encoding="utf-8")

    assert not found.sampled
    assert len(found.rows) == ROWS
    assert "Where single attempts" not in page
    assert 'id="map"' not in page
    whole = every_row(many).assign(experiment="many")
    alike(found.attempts, attempts_of(tmp_path / "cells", whole))


@pytest.mark.slow
def test_the_plane_is_counted_by_cells(many):
    """Against each row by hand, turned into the vehicle's frame by complex numbers."""
    rows = every_row(many)
    rows = rows[(rows["branch"] == "best") & rows["length"].notna()]
    found = load_results([many]).attempts.planes()["many"]
    expected = np.zeros_like(found.counts)
    for row in rows.itertuples():
        target = complex(row.target_x - row.x, row.target_y - row.y) / row.radius
        seen = target * np.exp(-1j * row.heading)
        column, line = (int((v + REACH) / (2 * REACH) * CELLS // 1) for v in (seen.real, seen.imag))
        if 0 <= column < CELLS and 0 <= line < CELLS and abs(seen.real) < REACH > abs(seen.imag):
            expected[WORDS.index(row.word), line, column] += 1
            assert found.least[line, column] <= row.length / row.radius
            assert row.length / row.radius <= found.largest[line, column]

    # a target on the edge of a cell may fall on either side of it
    assert np.abs(found.counts - expected).sum() <= 0.01 * expected.sum()


PEAK = """
import resource, sys
from dubins_study import run
from dubins_study import render
run(sys.argv[1], sys.argv[2])
render([sys.argv[2]])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_a_report_of_millions_stays_within_its_memory(tmp_path):
    """Run and report of three million rows in one process, and a map in the page."""
    (tmp_path / "large.toml").write_text(
        'title = "t"\nquestion = "q?"\nsolvers = ["analytic"]\n[[scenarios]]\n[scenarios.sample]\n'
        'method = "sobol"\ncount = 3000000\nseed = 3\n[scenarios.sample.ranges]\n'
        "target_x = { linear = [-4, 4] }\ntarget_y = { linear = [-4, 4] }\n",
        encoding="utf-8",
    )
    words = [sys.executable, "-c", PEAK, str(tmp_path / "large.toml"), str(tmp_path / "out")]
    done = subprocess.run(words, capture_output=True, text=True, check=True)

    assert int(done.stdout.split()[-1]) / 1024 < 1500
    page = (tmp_path / "out" / "report" / "index.html").read_text(encoding="utf-8")
    assert '<section id="map"' in page
    assert "3\u202f000\u202f000 attempts" in page

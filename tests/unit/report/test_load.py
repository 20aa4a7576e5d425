"""Results folders: what is read, and what is refused with one clear message."""

from __future__ import annotations

import json

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from dubins_study import render, status
from dubins_study.report.data.results import load
from dubins_study.study.closed_form.shortest import shortest_path
from dubins_study.study.rows.parts import ResultsError, read_part
from dubins_study.study.rows.schema import VERSION
from tests.unit.report.results_folder import SCHEMA, attempt, paper_scenarios, write_folder


def test_a_cell_that_two_folders_hold_counts_once(tmp_path, results):
    """Merging folders is a union of cells, and paths stay with their rows."""
    one, two, three = paper_scenarios()[:3]
    first = results("paper", [attempt(one, path=None), attempt(two)])
    second = write_folder(tmp_path / "again", "paper", [attempt(two), attempt(three)])

    found = load([first, second])

    assert found.rows["label"].tolist() == [one.label, two.label, three.label]
    assert [found.path(place) for place in (0, 2)] == [None, shortest_path(three)]


def test_a_folder_of_results_folders_stands_for_them(tmp_path):
    """As `results/benchmark`, whose suites are folders of their own."""
    one, two, three = paper_scenarios()[:3]
    first = write_folder(tmp_path / "suites" / "a", "leg", [attempt(one)])
    second = write_folder(tmp_path / "suites" / "b", "pose", [attempt(two), attempt(three)])

    joined, apart = load(tmp_path / "suites"), load([first, second])

    assert joined.rows.equals(apart.rows)
    assert joined.rows["experiment"].tolist() == ["leg", "pose", "pose"]
    with pytest.raises(ResultsError, match=r"has no manifest\.json"):
        load(tmp_path)


def test_a_solver_that_the_manifest_does_not_name_counts_nowhere(results):
    """Nobody knows whether such rows are of its current code; the report and `status` agree."""
    one, two = paper_scenarios()[:2]
    named = {"analytic": {"code_digest": "0123456789ab", "cells": 1}}
    folder = results("paper", [attempt(one), attempt(two, "slsqp")], solvers=named)
    (read,), counted = load([folder]).folders, status(folder)

    assert load([folder]).solvers == ("analytic",)
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
    """The same rows with a gap that is a text."""
    place = table.column_names.index("gap")
    return table.set_column(place, "gap", pa.array(["much"] * table.num_rows))


LATER = ["lower_bound", "subproblems", "evaluations", "presolved", "subproblem_s"]


@pytest.mark.parametrize("lacking", [(1,), (1, 2)])
def test_a_column_that_a_part_lacks_is_null(results, lacking):
    """Of every type, in one part of a folder or in all."""
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
        (lambda f: (f / "manifest.json").write_text("{"), "cannot be read as JSON"),
        (lambda f: (f / "manifest.json").write_text("[]"), "expected an object"),
        (lambda f: (f / "manifest.json").write_text("[" * 100_000), "cannot be read as JSON"),
        (lambda f: (f / "manifest.json").write_text("9" * 5_000), "cannot be read as JSON"),
        (lambda f: (f / "manifest.json").write_bytes(b"\xff\xfe\x00"), "cannot be read as JSON"),
        (_change_manifest(schema=VERSION + 1), f"has schema {VERSION + 1}; expected {VERSION}"),
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
    """Whatever is wrong with a folder, one error names it and the place."""
    folder = results("paper", [attempt(paper_scenarios()[0])])
    spoil(folder)

    with pytest.raises(ResultsError, match="paper") as caught:
        load([folder])
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_page_says_which_rows_are_left_out(tmp_path):
    """Rows of earlier code; rows of a cell that a folder before holds, by other code or by this."""
    one, two, three = map(attempt, paper_scenarios()[:3])
    other, named = {"code_digest": "f" * 12}, {"analytic": {"code_digest": "0123456789ab"}}
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
    for page in ("index.html", "report.md"):
        text = (tmp_path / "page" / page).read_text(encoding="utf-8")
        assert "2 rows of cells that a folder before this one holds, made by other code" in text
        assert text.count("It contradicts a folder before it in 1 cell, by the same code") == 2


def test_a_gap_that_differs_contradicts(tmp_path):
    """By more than the tolerance; where everything else agrees, and whichever comes first."""
    rows = [attempt(scenario) for scenario in paper_scenarios()]
    near = [row | {"gap": row["gap"] + 0.5e-4} for row in rows]
    far = [row | {"gap": row["gap"] + 1.5e-4 * (i < 3)} for i, row in enumerate(rows)]
    one, near, far = (
        write_folder(tmp_path / str(number), "paper", own)
        for number, own in enumerate((rows, near, far))
    )

    assert [f.rows.contradicting for f in load([one, near, far]).folders] == [0, 0, 3]
    assert [f.rows.contradicting for f in load([far, one]).folders] == [0, 3]

"""Errors of a results folder, in one sentence.

The sentence names the file.
"""

import json
import shutil

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from dubins_study import run
from dubins_study.experiments.store import folder as store
from dubins_study.experiments.store.folder import done, read_rows
from dubins_study.study.rows.manifest import read_manifest
from dubins_study.study.rows.parts import ARROW_SCHEMA, ResultsError
from tests.live_run import CELLS, finished, output

pytestmark = pytest.mark.smoke


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": 99}, "schema is 99: Input should be"),
        ({"cells": -1}, "cells is -1: Input should be greater than or equal to 0"),
    ],
)
def test_a_manifest_that_is_not_one(experiment, folder, change, message):
    """A manifest that is none is refused.

    Every reader says the same, naming manifest.json, and nothing is lost.
    """
    file = folder / "manifest.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    before = done(folder)
    for read in (read_manifest, lambda f: run(experiment, f)):
        with pytest.raises(ResultsError) as error:
            read(folder)
        assert "manifest.json" in str(error.value)
        assert message in str(error.value)
        assert "\n" not in str(error.value)
    assert done(folder) == before


def _broken(folder, column, values):
    part = next((folder / "parts").iterdir())
    table = pq.read_table(part)
    place = table.column_names.index(column)
    pq.write_table(table.set_column(place, column, pa.array(values)), part)


def test_a_part_with_a_column_of_another_type_is_refused(folder):
    _broken(folder, "length", ["a"] * CELLS)
    for columns in (None, ["length"]):
        with pytest.raises(ResultsError, match=r"\.parquet cannot be read: it is no Parquet file"):
            read_rows(folder, columns)


def test_a_column_that_another_program_wrote_wider_is_read(folder):
    before = read_rows(folder)
    part = next((folder / "parts").iterdir())
    wide = pa.schema([f.with_type(pa.large_string()) if pa.types.is_string(f.type) else f
                      for f in ARROW_SCHEMA])  # fmt: skip
    pq.write_table(pq.read_table(part).cast(wide), part)

    assert read_rows(folder).equals(before)


def test_parts_that_were_deleted_are_solved_again(experiment, folder):
    shutil.rmtree(folder / "parts")

    assert len(read_rows(folder)) == 0
    assert f"0 of {CELLS} cells done" in output(finished("status", folder))
    run(experiment, folder)  # finished, says the manifest; its rows are gone all the same
    assert len(done(folder)) == CELLS


def test_no_room_for_one_part_leaves_the_many(experiment, folder, monkeypatch):
    """A failed union of parts leaves the many.

    There is no room for one part. The many hold the same rows: nothing is lost, so nothing is
    said.
    """
    run(experiment, folder, solvers=["slsqp"])
    (whole,) = (folder / "parts").iterdir()
    rows = pq.read_table(whole)
    whole.unlink()
    for number in range(2):
        pq.write_table(rows.slice(CELLS * number, CELLS), folder / "parts" / f"{number}.parquet")
    before = sorted((folder / "parts").iterdir())
    real = store.write_part

    def full(*arguments):
        raise ResultsError("No space left on device")

    monkeypatch.setattr(store, "write_part", full)
    store.compact(folder, "run")
    assert sorted((folder / "parts").iterdir()) == before
    monkeypatch.setattr(store, "write_part", real)
    store.compact(folder, "run")

    (one,) = (folder / "parts").iterdir()
    assert pq.read_table(one, columns=rows.column_names).equals(rows)

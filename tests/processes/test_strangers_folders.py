"""Results folders made to do harm: refused or told of, and nothing hangs or escapes."""

from __future__ import annotations

import json
import os
import shutil

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from live_run import finished, manifest, parts, quick_experiment

from dubins_study import merge, run, status
from dubins_study.experiments.store.lock import is_locked, locked
from dubins_study.report.data.results import load
from dubins_study.study.rows.files import ResultsError
from dubins_study.study.rows.schema import VERSION


@pytest.fixture(scope="module")
def experiment(tmp_path_factory):
    return str(quick_experiment(tmp_path_factory.mktemp("strangers"), 3, "analytic"))


@pytest.fixture(scope="module")
def original(experiment, tmp_path_factory):
    return run(experiment, tmp_path_factory.mktemp("strangers") / "out")


@pytest.fixture
def folder(original, tmp_path):
    shutil.copytree(original, tmp_path / "out")
    return tmp_path / "out"


def amended(folder, **changes):
    (folder / "manifest.json").write_text(json.dumps(manifest(folder) | changes))


def nested(levels):
    return json.loads("[" * levels + "]" * levels)


@pytest.mark.parametrize("name", ["manifest.json", "parts/z.parquet"])
def test_a_pipe_is_not_waited_for(folder, name):
    (folder / name).unlink(missing_ok=True)
    os.mkfifo(folder / name)

    for read in (status, lambda place: load([place])):
        with pytest.raises(ResultsError, match=name.rpartition("/")[2]):
            read(folder)


def test_a_lock_that_is_no_file_is_refused(folder, tmp_path):
    (folder / ".lock").unlink(missing_ok=True)
    os.mkfifo(folder / ".lock")
    assert not is_locked(folder)
    with pytest.raises(ResultsError, match="no file"), locked(folder):
        pass

    (folder / ".lock").unlink()
    (tmp_path / "elsewhere").write_text("kept")
    (folder / ".lock").symlink_to(tmp_path / "elsewhere")
    with pytest.raises(ResultsError, match="cannot lock"), locked(folder):
        pass
    assert (tmp_path / "elsewhere").read_text() == "kept"


def test_counts_that_no_float_holds_are_refused(folder):
    for cells in (10**400, -1, True):
        amended(folder, cells=cells)
        with pytest.raises(ResultsError, match="cells is"):
            status(folder)


def test_a_manifest_that_could_not_be_written_again_is_refused(folder, tmp_path):
    amended(folder, machine=nested(200))

    with pytest.raises(ResultsError, match="nested more than"):
        merge([folder, folder], tmp_path / "union")
    with pytest.raises(ResultsError, match="nested more than"):
        load([folder])
    (folder / "manifest.json").write_text(
        f'{{"schema": {VERSION}, "a": ' + "[" * 10**5 + "]" * 10**5 + "}"
    )
    with pytest.raises(ResultsError, match="cannot be read"):
        load([folder])


def spoilt_text(folder):
    """A part of which one text is no UTF-8."""
    (part,) = parts(folder)
    table = pq.read_table(part)
    place = table.column_names.index("verdict")
    offsets = pa.py_buffer(bytes(4) + b"\2\0\0\0" * len(table))
    texts = pa.StringArray.from_buffers(len(table), offsets, pa.py_buffer(b"\xff\xfe"))
    pq.write_table(table.set_column(place, "verdict", texts), part)


def spoilt_type(folder):
    """A part with a column of a type that pandas reads, once it is asked for such things."""
    import pandas.core.arrays.arrow.extension_types  # noqa: F401

    (part,) = parts(folder)
    table = pq.read_table(part)
    place = table.column_names.index("length")
    named = {"ARROW:extension:name": "pandas.interval", "ARROW:extension:metadata": "{}"}
    field = pa.field("length", table["length"].type, metadata=named)
    pq.write_table(table.set_column(place, field, table["length"]), part, store_schema=True)


@pytest.mark.parametrize("spoil", [spoilt_text, spoilt_type])
def test_a_part_that_arrow_reads_and_python_does_not_is_damaged(folder, experiment, spoil):
    spoil(folder)

    assert status(folder).damaged == 1
    with pytest.raises(ResultsError, match="cannot be read"):
        load([folder])
    run(experiment, folder)
    assert (status(folder).done, status(folder).aside) == (3, 1)


def test_names_of_parts_do_not_reach_the_terminal(folder, experiment):
    (folder / "parts" / "\x1b[31mz.parquet").write_bytes(b"no part")

    said = finished("run", experiment, "--out", folder)

    assert said.returncode == 0
    assert "\x1b" not in said.stderr
    assert "\\x1b[31mz.parquet is damaged" in said.stderr


@pytest.mark.parametrize("name", ["**", "[a]", "n" * 300])
def test_any_name_may_be_merged_into_or_is_refused(original, folder, tmp_path, name):
    if len(name) > 255:
        with pytest.raises(ResultsError, match="cannot"):
            merge([original, folder], tmp_path / name)
    else:
        assert status(merge([original, folder], tmp_path / name).folder).done == 3


def test_a_merge_clears_up_only_after_itself(original, folder, tmp_path):
    """A name with a star is no pattern: what others left is theirs."""
    other = tmp_path / ".other.merging-x"
    other.mkdir()
    (other / ".lock").touch()

    merge([original, folder], tmp_path / "*")

    assert other.is_dir()


def test_a_name_too_long_is_no_folder():
    for read in (status, lambda place: load([place])):
        with pytest.raises(ResultsError, match=r"n{300}"):
            read("n" * 300)

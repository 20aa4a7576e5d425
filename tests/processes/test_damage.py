"""Damaged folders are mended or refused.

A folder that cannot be mended is left alone.
"""

import errno
import os
import shutil
import subprocess
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from dubins_study import run, status
from dubins_study.cli.status import status_text
from dubins_study.experiments.store import part_writer
from dubins_study.experiments.store.folder import done, read_rows
from dubins_study.experiments.store.part_writer import write_part
from dubins_study.report.data.results import load
from dubins_study.study.rows.parts import ARROW_SCHEMA, ResultsError, read_part
from dubins_study.study.rows.schema import RUN_ID, VERSION, VERSION_KEY
from tests.live_run import CELLS, finished, manifest, parts, quick_experiment

pytestmark = pytest.mark.smoke


@pytest.fixture
def folder(folder):
    """A run in two parts.

    A run that is cut short leaves such a folder.
    """
    (part,) = parts(folder)
    table = read_part(part)
    part.unlink()
    for name, half in (("a", table.slice(0, CELLS // 2)), ("b", table.slice(CELLS // 2))):
        write_part(folder, name, half, {RUN_ID: table["run_id"][0].as_py()})
    return folder


def files(folder):
    """Names and contents, but for the lock's."""
    return {
        f.relative_to(folder): f.read_bytes()
        for f in folder.rglob("*")
        if f.is_file() and f.name != ".lock"
    }


def test_parts_say_what_they_are(folder, experiment):
    run(experiment, folder, restart=True)
    (part,) = parts(folder)
    (entry,) = manifest(folder)["runs"]

    stated = pq.read_metadata(part).metadata
    assert stated[VERSION_KEY.encode()] == str(VERSION).encode()
    assert stated[RUN_ID.encode()] == entry["run_id"].encode()
    assert set(read_part(part)["run_id"].to_pylist()) == {entry["run_id"]}


def flipped(content: bytes) -> bytes:
    """A part with one flipped bit.

    It lies in the pages of a column that resuming does not read.
    """
    file = pq.ParquetFile(pa.BufferReader(content))
    place = ARROW_SCHEMA.names.index("wall_s")
    column = file.metadata.row_group(0).column(place)
    changed = bytearray(content)
    first = column.dictionary_page_offset or column.data_page_offset
    changed[first + column.total_compressed_size - 1] ^= 1
    return bytes(changed)


DAMAGE = {
    "truncated": lambda content: content[: len(content) // 2],
    "no end": lambda content: content[:-1],
    "empty": lambda content: b"",
    "flipped": flipped,
}


@pytest.mark.slow
@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_part_is_put_aside_and_its_cells_are_solved_again(folder, experiment, damage):
    """Damaged parts are put aside and solved again.

    One warning names the part, nothing is deleted, and the table is whole again.
    """
    before = read_rows(folder).to_pandas().sort_values("scenario_id", ignore_index=True)
    part = folder / "parts" / "b.parquet"
    spoilt = DAMAGE[damage](part.read_bytes())
    part.write_bytes(spoilt)
    assert "parts: 1; run again, and their" in status_text(status(folder))
    with pytest.raises(ResultsError, match=r"b\.parquet"):
        load([folder])

    process = finished("run", experiment, "--out", folder)

    assert process.returncode == 0
    (line,) = [line for line in process.stderr.splitlines() if "damaged" in line]
    assert line == (
        f"dubins-study: {part} is damaged: moved to {folder / 'damaged' / 'b.parquet'}, its cells "
        "are solved again"
    )
    assert (folder / "damaged" / "b.parquet").read_bytes() == spoilt
    after = read_rows(folder).to_pandas().sort_values("scenario_id", ignore_index=True)
    same = ["scenario_id", "solver", "code_digest", "verdict", "length", "word"]
    assert after[same].equals(before[same])
    assert len(set(after["run_id"])) == 2
    assert (status(folder).damaged, status(folder).aside) == (0, 1)
    assert len(load([folder]).rows) == CELLS


def foreign(folder, _):
    pq.write_table(pa.table({"price": [1.0]}), folder / "parts" / "zz.parquet")
    return "it has no column 'scenario_id'"


def wider(folder, table):
    table = table.append_column("price", pa.array([1.0] * len(table)))
    pq.write_table(table, folder / "parts" / "zz.parquet")
    return "it has a column 'price'"


def newer(folder, table):
    table = table.replace_schema_metadata({VERSION_KEY: str(VERSION + 1)})
    pq.write_table(table, folder / "parts" / "zz.parquet")
    return f"is of schema '{VERSION + 1}'; expected schema {VERSION}"


@pytest.mark.parametrize("put", [foreign, wider, newer])
@pytest.mark.parametrize("spoilt", [False, True])
def test_what_is_no_part_of_ours_is_refused_and_nothing_changes(folder, experiment, put, spoilt):
    """Foreign parts are refused, and nothing changes.

    Not even a damaged part beside it is moved, nor a run begun.
    """
    message = put(folder, read_part(parts(folder)[0]))
    if spoilt:
        (folder / "parts" / "a.parquet").write_bytes(b"")
    (folder / "parts" / ".c.parquet.dubins-study.tmp").write_bytes(b"left")
    before = files(folder)

    for act in (lambda: run(experiment, folder), lambda: status(folder)):
        with pytest.raises(ResultsError) as error:
            act()
        assert message in str(error.value)
        assert "zz.parquet" in str(error.value)
    assert files(folder) == before
    with pytest.raises(ResultsError, match=r"parquet"):
        load([folder])


def test_what_a_killed_run_left_half_written_is_removed(folder, experiment):
    """Half-written files of a killed run are removed.

    Only files of our own pattern are removed, and not before it is certain that the folder is
    good.
    """
    places = (folder / ".manifest.json", folder / "parts" / ".r-000001.parquet")
    ours = [place.with_name(f"{place.name}.dubins-study.tmp") for place in places]
    others = [folder / ".hidden.tmp", folder / "parts" / "notes.txt", folder / "x.parquet.1.tmp"]
    for file in (*ours, *others):
        file.write_text("half")

    run(experiment, folder)

    assert not any(file.exists() for file in ours)
    assert all(file.exists() for file in others)


def test_a_run_killed_before_its_first_manifest_leaves_a_folder_that_can_be_used(
    experiment, tmp_path
):
    out = tmp_path / "new"
    (out / "parts").mkdir(parents=True)
    (out / ".lock").write_text("{}")
    (out / ".manifest.json.dubins-study.tmp").write_text("{")

    run(experiment, out)

    assert len(done(out)) == CELLS


def test_a_file_that_cannot_be_finished_leaves_nothing(tmp_path):
    """An unfinished file leaves the old one."""
    final = tmp_path / "manifest.json"
    final.write_text("old")

    def write(file):
        file.write_text("ne")
        raise OSError(errno.ENOSPC, "full")

    with pytest.raises(OSError, match="full"):
        part_writer.write_whole(final, write)
    assert [f.name for f in tmp_path.iterdir()] == ["manifest.json"]
    assert final.read_text() == "old"


def test_names_are_synced_after_contents(tmp_path, monkeypatch):
    """Names are synced after contents.

    A power cut after `put` finds the file whole and under its name.
    """
    synced = []
    real = os.fsync

    def fsync(handle):
        synced.append(str(Path(f"/proc/self/fd/{handle}").readlink()))
        real(handle)

    if not Path("/proc/self/fd").is_dir():
        pytest.skip("no /proc here to see what is synced")
    monkeypatch.setattr(os, "fsync", fsync)
    part_writer.write_whole(tmp_path / "a.parquet", lambda file: file.write_text("x"))

    temporary, folder = synced
    assert temporary.startswith(str(tmp_path / ".a.parquet."))
    assert folder == str(tmp_path)


@pytest.mark.slow
def test_a_full_disk(tmp_path):
    """A full disk leaves a valid folder.

    The disk is a real one, of 160 KB: there is one message, and resuming completes the folder.
    """
    disk_of = tmp_path / "small"
    disk_of.mkdir()
    mount = shutil.which("mount")
    options = ("-t", "tmpfs", "-o", "size=160k", "tmpfs", str(disk_of))
    if mount is None or subprocess.run([mount, *options], capture_output=True).returncode:
        pytest.skip("mounting a small tmpfs is not permitted here")
    try:
        experiment = quick_experiment(tmp_path, 800, "slsqp[presolve=true]")
        out = disk_of / "out"
        failed = finished("run", experiment, "--out", out)
        assert failed.returncode == 2, failed.stderr
        lines = [line for line in failed.stderr.splitlines() if line.startswith("dubins-study")]
        assert len(lines) == 1
        assert "Traceback" not in failed.stderr
        assert ".parquet: No space left on device; " in lines[0]
        assert "rows not written yet are lost, all others are kept" in lines[0]
        assert not list(disk_of.rglob("*.tmp"))
        cells = done(out)
        assert 0 < len(cells) < 800
        assert finished("status", out).returncode == 0

        subprocess.run([mount, "-o", "remount,size=50m", str(disk_of)], check=True)
        again = finished("run", experiment, "--out", out)

        assert again.returncode == 0, again.stderr
        assert len(read_rows(out)) == 800
        assert cells <= done(out)
    finally:
        subprocess.run(["umount", "-l", str(disk_of)], check=True)

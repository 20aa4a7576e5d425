"""Folders of one experiment united.

Nothing is lost, nothing is twice, and no contradiction is swallowed.
"""

import json
import os
import shutil
import signal

import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study import merge, run, status
from dubins_study.experiments.store.folder import read_rows
from dubins_study.experiments.store.merge import merged_rows
from dubins_study.experiments.store.part_writer import write_part
from dubins_study.report.data.results import load
from dubins_study.study.rows.parts import ARROW_SCHEMA, ResultsError, read_part, rows_table
from dubins_study.study.rows.schema import KEY, ROW, RUN_ID, names
from tests.live_run import CELLS, finished, manifest, parts, slow_experiment, started, wait_for

pytestmark = pytest.mark.smoke

KEYS = names(KEY)
TOLERANCE = 1e-4


@pytest.fixture
def halves(original, tmp_path):
    """The same folder twice, with fewer rows.

    Each has five of its eight rows: two of them are in both.
    """
    return shard(original, tmp_path / "one", 0, 5), shard(original, tmp_path / "two", 3, 5)


def shard(original, folder, first, count):
    shutil.copytree(original, folder)
    (part,) = parts(folder)
    table = read_part(part)
    part.unlink()
    write_part(folder, "rows", table.slice(first, count), {RUN_ID: "x"})
    return folder


def change(folder, row, **values):
    """Change one row of a folder.

    Another attempt at the same cell would have such a row.
    """
    (part,) = parts(folder)
    table = read_part(part).to_pylist()
    table[row] |= {"run_id": "another", "started": "2030-01-01T00:00:00.000+00:00"} | values
    part.unlink()
    write_part(folder, "changed", rows_table(table), {RUN_ID: "another"})
    return table[row]


def frame(folder):
    return read_rows(folder).to_pandas().sort_values(KEYS, ignore_index=True)


def test_the_union_is_the_whole(original, halves, tmp_path):
    before = {f: f.read_bytes() for half in halves for f in half.rglob("*") if f.is_file()}
    union = merge(halves, tmp_path / "all")

    assert all(file.read_bytes() == content for file, content in before.items())
    assert (union.rows, union.agreeing_repeats, union.stale) == (CELLS, 0, 0)
    assert frame(union.folder).equals(frame(original))
    held = manifest(union.folder)
    one = manifest(original)
    assert held["finished"] == one["finished"]
    assert held["runs"] == one["runs"]  # the same run in both: once
    assert held["cells"] == CELLS
    assert status(union.folder).finished
    assert len(load([union.folder]).rows) == CELLS


def test_a_union_that_is_not_whole_can_be_completed(experiment, original, tmp_path):
    folders = [shard(original, tmp_path / str(first), first, 3) for first in (0, 2)]
    union = merge(folders, tmp_path / "part")
    assert union.rows == 5
    assert manifest(union.folder)["finished"] is None
    assert status(union.folder).left == {"analytic": CELLS - 5}

    run(experiment, union.folder)

    assert frame(union.folder)[KEYS].equals(frame(original)[KEYS])
    assert status(union.folder).finished


def test_of_attempts_that_agree_the_earlier_is_kept(halves, tmp_path):
    """Of attempts that agree the earlier is kept.

    The order of the folders does not matter. Wall times may differ, and the gap a little.
    """
    gap = read_rows(halves[1])["gap"][0].as_py()
    change(halves[1], 0, wall_s=9.0, gap=gap + TOLERANCE / 2)
    for order in (halves, halves[::-1]):
        union = merge(order, tmp_path / "all")
        assert (union.rows, union.agreeing_repeats) == (CELLS, 1)
        assert "another" not in set(read_rows(union.folder)["run_id"].to_pylist())
        shutil.rmtree(union.folder)


@pytest.mark.parametrize(
    ("column", "value"),
    [
        ("verdict", "longer"),
        ("outcome", "timeout"),
        ("claim", "failed"),
        ("word", None),
        ("gap", 0.5),
        ("gap", None),
    ],
)
def test_a_contradiction_is_refused(halves, tmp_path, column, value):
    """A contradiction is refused.

    The cell, the column and both values are named, and nothing is written.
    """
    before = read_rows(halves[1])[column][0].as_py()
    row = change(halves[1], 0, **{column: value})
    with pytest.raises(ResultsError) as error:
        merge(halves, tmp_path / "all")

    message = str(error.value)
    assert "contradict each other in 1 cell; nothing was merged" in message
    assert ", ".join(str(row[name]) for name in KEYS) in message
    assert f"{column} is " in message
    for found, folder in ((before, halves[0]), (value, halves[1])):
        shown = float("nan") if found is None else found
        assert f"{shown} in {folder}" in message
    assert {f.name for f in tmp_path.iterdir()} == {"one", "two"}


def test_contradictions_are_counted_and_the_first_five_listed(original, tmp_path):
    folders = [shard(original, tmp_path / name, 0, CELLS) for name in ("one", "two")]
    for row in range(7):
        change(folders[1], row, verdict="misses")
    process = finished("merge", *folders, "--out", tmp_path / "all")

    assert process.returncode == 2
    assert process.stdout == ""
    lines = process.stderr.splitlines()
    assert "contradict each other in 7 cells" in lines[0]
    assert len(lines) == 1 + 5 + 1
    assert lines[-1].strip() == "and 2 more"
    assert not (tmp_path / "all").exists()


def test_other_code_is_another_cell(halves, tmp_path):
    """Other code is another cell.

    Both rows are kept; the first folder's code counts, the other's rows are stale.
    """
    change(halves[1], 0, verdict="misses", code_digest="ffffffffffff")
    union = merge(halves, tmp_path / "all")

    assert (union.rows, union.agreeing_repeats, union.stale) == (CELLS + 1, 0, 1)
    assert status(union.folder).stale == 1
    assert len(load([union.folder]).rows) == CELLS


def _other(folder):
    data = manifest(folder)
    data["experiment"]["text"] += "# changed"
    (folder / "manifest.json").write_text(json.dumps(data))
    return "expected folders of one experiment, name and text"


def _nothing(folder):
    shutil.rmtree(folder)
    return "is no results folder"


def _damage(folder):
    parts(folder)[0].write_bytes(b"PAR1")
    return "it is no Parquet file, or damaged; run again for its rows"


@pytest.mark.parametrize("spoil", [_other, _damage, _nothing])
def test_folders_that_cannot_be_merged(halves, tmp_path, spoil):
    message = spoil(halves[1])
    with pytest.raises(ResultsError, match=message):
        merge(halves, tmp_path / "new" / "all")

    assert not any((tmp_path / "new").glob("*"))


def test_places_that_are_taken(halves, tmp_path):
    full = tmp_path / "full"
    full.mkdir()
    (full / "thesis.txt").write_text("mine")
    (tmp_path / "link").symlink_to(full)
    (tmp_path / "file").write_text("")
    for out, message in ((full, "not empty"), ("link", "not empty"), ("file", "no folder")):
        with pytest.raises(ResultsError, match=message):
            merge(halves, tmp_path / out)
    assert [f.name for f in full.iterdir()] == ["thesis.txt"]
    with pytest.raises(ResultsError, match="at least two"):
        merge(halves[:1], tmp_path / "new")
    (tmp_path / "empty").mkdir()
    assert merge(halves, tmp_path / "empty").rows == CELLS


def test_a_folder_in_use_is_left_alone(tmp_path):
    experiment = slow_experiment(tmp_path, nap=0.3, count=1000)
    out = tmp_path / "out"
    with started("run", experiment, "--trust-plugins", "--out", out):
        wait_for(lambda: parts(out))
        with pytest.raises(ResultsError, match="is in use by a run; merge it when that has ended"):
            merge([out, out], tmp_path / "all")


def test_a_merge_that_is_killed_leaves_nothing_at_its_place(halves, tmp_path, monkeypatch):
    """A killed merge leaves nothing at its place.

    What lies beside it is hidden, and in nobody's way.
    """
    out = tmp_path / "all"
    program = os.fork()
    if program == 0:
        monkeypatch.setattr(
            "dubins_study.experiments.store.merge.write_manifest",
            lambda *_: os.kill(os.getpid(), 9),
        )
        merge(halves, out)
    assert os.WTERMSIG(os.waitpid(program, 0)[1]) == signal.SIGKILL
    assert not out.exists()

    merge(halves, out)

    assert {f.name for f in tmp_path.glob("[!.]*")} == {"one", "two", "all"}
    assert len(read_rows(out)) == CELLS


def test_halves_that_no_run_finished_make_a_finished_whole(halves, tmp_path):
    for half in halves:
        (half / "manifest.json").write_text(json.dumps(manifest(half) | {"finished": None}))

    assert status(merge(halves, tmp_path / "all").folder).finished


WORDS = st.sampled_from(["optimal", "longer"])
ATTEMPTS = st.lists(
    st.tuples(st.integers(0, 4), st.integers(0, 3), WORDS, st.sampled_from([None, 0.0, 1.0])),
    max_size=12,
)


def table_of(attempts, folder):
    rows = [
        dict.fromkeys(names(ROW))
        | {"scenario_id": str(cell), "solver": "s", "repeat": 0, "code_digest": "c"}
        | {"verdict": verdict, "gap": gap, "run_id": f"{folder}", "started": f"2026-01-0{when + 1}"}
        for cell, when, verdict, gap in {attempt[0]: attempt for attempt in attempts}.values()
    ]
    return rows_table(rows) if rows else ARROW_SCHEMA.empty_table()


@given(ATTEMPTS, ATTEMPTS, ATTEMPTS)
def test_any_folders(one, two, three):
    """Any folders merge as a dictionary does.

    It has the earliest of each cell, or a refusal if two differ from it.
    """
    tables = [table_of(own, i) for i, own in enumerate((one, two, three))]
    best = {}
    clash = False
    every = [row for table in tables for row in table.to_pylist()]
    for row in sorted(every, key=lambda row: row["started"]):
        first = best.setdefault(row["scenario_id"], row)
        clash |= (first["verdict"], first["gap"]) != (row["verdict"], row["gap"])
    folders = [f"folder {i}" for i in range(3)]
    if clash:
        with pytest.raises(ResultsError, match="contradict"):
            merged_rows(tables, folders, TOLERANCE)
        return
    table, repeats = merged_rows(tables, folders, TOLERANCE)
    assert {row["scenario_id"]: row for row in table.to_pylist()} == best
    assert len(table) == len(best)
    assert repeats == len(every) - len(best)
    assert table.schema.equals(pa.schema(ARROW_SCHEMA))

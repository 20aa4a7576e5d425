"""Streams: rows as single cells have them, chunks that are done once, and nothing lost."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from dubins_study import run
from dubins_study.experiments.definition.experiment import ExperimentError, parse
from dubins_study.experiments.executors import stream
from dubins_study.experiments.executors.stream import streamed_totals
from dubins_study.experiments.plan import streams as stream_plan
from dubins_study.experiments.plan.cells import chains
from dubins_study.experiments.plan.scenario_ids import scenario_id
from dubins_study.experiments.plan.streams import streams
from dubins_study.experiments.solve import solve
from dubins_study.experiments.store.folder import done, read_rows
from dubins_study.experiments.store.part_writer import write_part
from dubins_study.experiments.store.status import status
from dubins_study.report.data.results import load
from dubins_study.solvers import frame
from dubins_study.solvers.frame import solve_frame
from dubins_study.study.rows.files import ResultsError
from dubins_study.study.rows.parts import read_chunks, read_footer
from dubins_study.study.rows.schema import CHUNK, KEY, ROW, arrow_schema, names
from dubins_study.study.scenario import COLUMNS, Scenario

HEAD = 'title = "t"\nquestion = "q?"\nsolvers = ["analytic"]\n'
GRID = """
[[scenarios]]
label = "grid"
heading = [0.4, 2]
target_x = { linear = [-4, 4, 50] }
target_y = { linear = [-4, 4, 30] }
"""
SOBOL = """
[[scenarios]]
[scenarios.sample]
method = "sobol"
count = COUNT
seed = 3
[scenarios.sample.ranges]
target_x = { linear = [-9, 9] }
target_y = { linear = [-9, 9] }
radius = { log = [0.1, 10] }
"""


@pytest.fixture
def experiment(tmp_path):
    """Writes an experiment's file."""

    def write(text=HEAD + GRID):
        file = tmp_path / "many.toml"
        file.write_text(text, encoding="utf-8")
        return str(file)

    return write


@pytest.fixture
def small_chunks(monkeypatch):
    """Chunks of 700 rows."""
    monkeypatch.setattr(stream_plan, "CHUNK_ROWS", 700)


def held(folder):
    """All streamed rows, in the order of the chunks, as text readers would see them."""
    parts = list(read_chunks(folder))
    return pa.concat_tables([pq.read_table(file) for file in parts]).to_pandas()


def expanded(text):
    return parse("many", "many.toml", text).experiment


def test_rows_are_those_of_single_cells(experiment, tmp_path, small_chunks):
    """Types and texts alike, numbers to rounding, proofs too."""
    found = held(run(experiment(HEAD + 'branches = ["best", "LS"]\n' + GRID), tmp_path / "out"))

    assert len(found) == 2 * 3000
    assert not found.duplicated(names(KEY)).any()
    for row in found.sample(60, random_state=1).itertuples():
        scenario = Scenario(**{name: getattr(row, name) for name in COLUMNS})
        answer = solve(scenario, branch=row.branch)
        assert row.scenario_id == scenario_id(scenario)
        for name in ("outcome", "claim", "verdict", "region", "message", "native_status", "proof"):
            assert getattr(row, name) == str(getattr(answer, name)), name
        assert (answer.word or None) == (row.word if isinstance(row.word, str) else None)
        assert (row.solver, row.initial_guess, row.repeat, row.threads) == (
            "analytic",
            "cold",
            0,
            1,
        )
        if answer.length is None:
            assert np.isnan([row.length, row.gap, row.travel_time]).all()
            continue
        assert row.length == pytest.approx(answer.length, rel=1e-13)
        assert row.reference_low <= answer.length * (1 + 1e-15)
        assert answer.length * (1 - 1e-15) <= row.reference_high
        assert row.pmp_residual == pytest.approx(answer.pmp_residual, abs=1e-11)
        assert list(row.lengths) == pytest.approx(answer.path.length, rel=1e-9)
        assert list(row.curvatures) == pytest.approx(answer.path.curvature)
    assert (found["wall_s"] > 0).all()
    assert found.groupby(["branch", "wall_s"]).size().tolist().count(700) == 2 * 4


def test_the_first_solve_is_not_recorded(experiment, tmp_path, small_chunks, monkeypatch):
    """What is compiled in a stream's first solve is nobody's time: one more frame than chunks."""
    solved, original = [], frame.solve_frame

    def counted(scenarios, **asked):
        solved.append(len(scenarios))
        return original(scenarios, **asked)

    monkeypatch.setattr(frame, "solve_frame", counted)
    run(experiment(), tmp_path / "out")

    assert solved == [700, 700, 700, 700, 700, 200]


def test_a_part_reads_like_any_other(experiment, tmp_path, small_chunks):
    """By its columns, their types, and nulls where a number is missing."""
    folder = run(experiment(HEAD + 'branches = ["RS"]\n' + GRID), tmp_path / "out")
    part = next(iter(read_chunks(folder)))
    table = pq.read_table(part)

    assert table.column_names == names(ROW)
    assert [f.type for f in table.schema] == [f.type for f in arrow_schema()]
    gone = table.filter(pa.compute.equal(table["verdict"], "none exists"))
    assert 0 < gone.num_rows < table.num_rows
    assert gone["length"].null_count == gone["lengths"].null_count == gone.num_rows
    for field in table.schema:
        if field.type == pa.float64():
            assert pa.compute.all(pa.compute.is_finite(table[field.name])).as_py() in (True, None)


def test_chunks_are_certified_as_their_frame_is(experiment, tmp_path, small_chunks):
    """Every row proved; lengths, bounds, residuals and costates to the last bit."""
    folder = run(experiment(HEAD + SOBOL.replace("COUNT", "6300")), tmp_path / "out")
    found = held(folder)

    assert set(found["proof"]) == {"proved"}
    assert found["pmp_residual"].max() < 1e-12
    assert [chunk.window for chunk in read_chunks(folder).values()] == [
        (i * 700, 700) for i in range(9)
    ]
    whole = solve_frame(found[list(COLUMNS)], certified=True)
    numbers = (
        "length",
        "gap",
        "miss",
        "reference_low",
        "reference_high",
        "costate_x",
        "cut_margin",
    )
    for name in numbers:
        assert np.array_equal(found[name], whole[name], equal_nan=True), name


def test_what_is_streamed_is_no_cell(small_chunks):
    """Only the closed form's large cold blocks; everything else is expanded as ever."""
    text = HEAD.replace('"]', '", "slsqp"]') + 'initial_guesses = ["cold", "warm"]\nrepeats = 2\n'
    text += GRID + '[[scenarios]]\nlabel = "few"\ntarget_x = 3\ntarget_y = { linear = [1, 9, 9] }\n'
    found = expanded(text)
    cells = [cell for chain in chains(found) for cell in chain]

    assert [(s.solver, s.repeat, s.rows) for s in streams(found)] == [
        ("analytic", 0, 3000),
        ("analytic", 1, 3000),
    ]
    assert sum(c.solver == "analytic" for c in cells) == 2 * 9
    assert sum(c.solver == "slsqp" for c in cells) == 2 * 2 * (3000 + 9)
    assert streams(expanded(text.replace('"cold", ', ""))) == []


def test_a_plugin_is_asked_cell_by_cell(tmp_path):
    """Even one that says it answers frames: its code is not run where the run is."""
    plugin = tmp_path / "framed.py"
    plugin.write_text(
        "from dubins_study.solvers.analytic import Analytic\nclass Framed(Analytic): pass\n"
    )
    found = expanded(HEAD.replace("analytic", f"{plugin}:Framed") + GRID)

    assert streams(found) == []
    assert len(chains(found)) == 3000


def test_names_of_streams_depend_on_what_is_asked(monkeypatch):
    """And not on who else is asked, or where in the file."""
    text = HEAD + GRID
    [one] = streams(expanded(text))
    [also] = streams(expanded(text.replace('"]', '", "slsqp"]')))
    first = '[[scenarios]]\nlabel = "a"\ntarget_x = 1\ntarget_y = 1\n'
    [later] = streams(expanded(HEAD + first + GRID))
    others = [
        streams(expanded(text.replace("50]", "51]")))[0],
        streams(expanded(text.replace('"grid"', '"grille"')))[0],
        streams(expanded('branches = ["LS"]\n' + text))[0],
        streams(expanded('profile = "fast"\n' + text))[0],
        streams(expanded("repeats = 2\n" + text))[1],
        one._replace(code_digest="other"),
    ]
    assert one.id == also.id == later.id
    assert len({one.id, *(other.id for other in others)}) == 1 + len(others)
    before = one.id
    monkeypatch.setattr(stream_plan, "CHUNK_ROWS", 999)
    assert one.id != before


TWICE = GRID.replace("[0.4, 2]", "[2, 7]")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            GRID.replace("[0.4, 2]", "[2, 2]"),
            "scenarios.0, scenario 1500: the same as",
        ),
        (GRID + TWICE, "scenarios.1, scenario 0: the same as scenarios.0, scenario 1500"),
        (
            GRID + '[[scenarios]]\nlabel = "grid"\nheading = 2\ntarget_x = 4\ntarget_y = 4\n',
            "scenarios.1, scenario 0: the same as scenarios.0, scenario 2999",
        ),
        (
            GRID.replace("heading", "radius = 1e200\nheading"),
            "scenarios.0, scenario 0: radius is 1e",
        ),
    ],
)
def test_blocks_that_repeat_a_scenario_are_refused(experiment, tmp_path, text, message):
    """Before anything is written: within a block, between two, and with a single cell's block."""
    with pytest.raises(ExperimentError, match=message):
        run(experiment(HEAD + text), tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("change", ['label = "other"', 'branches = ["LS"]', 'solvers = ["slsqp"]'])
def test_the_same_scenarios_may_be_asked_something_else(change):
    """Another label, branch or solver makes other keys."""
    other = GRID.replace(
        'label = "grid"', change if "label" in change else f'label="grid"\n{change}'
    )

    assert len(streams(expanded(HEAD + GRID + other))) == 2 - ("solvers" in change)


def test_counts_come_from_metadata(experiment, tmp_path, small_chunks, monkeypatch):
    """The manifest, the progress and the status tell streamed rows, and none of them is read."""
    told = []

    def tell(n, total):
        told.append((n, total))

    text = HEAD + 'branches = ["LS"]\n' + GRID
    text += '[[scenarios]]\nlabel = "few"\ntarget_x = 3\ntarget_y = { linear = [1, 9, 9] }\n'
    folder = run(experiment(text), tmp_path / "out", progress=tell)
    with monkeypatch.context() as patched:
        # no row of a stream is read
        patched.setattr(pq.ParquetFile, "read", _only_cells(pq.ParquetFile.read))
        patched.setattr(pq.ParquetFile, "iter_batches", _only_cells(pq.ParquetFile.iter_batches))
        found = status(folder)
        assert streamed_totals(folder, []).total() == 3000
        run(experiment(text), folder)

    assert json.loads((folder / "manifest.json").read_text())["cells"] == 3009
    assert told[-1] == (3009, 3009)
    assert [n for n, _ in told] == sorted(n for n, _ in told)
    assert len(done(folder)) == len(read_rows(folder)) == 9
    assert (found.cells, found.done, found.left, found.finished) == (3009, 3009, {}, True)
    verdicts = [*held(folder)["verdict"], *read_rows(folder, ["verdict"])["verdict"].to_pylist()]
    assert found.verdicts == {"analytic": dict(Counter(verdicts))}
    [part] = [f for f, chunk in read_chunks(folder).items() if chunk.first == 700]
    part = read_footer(part)
    rows = pq.read_table(part.file).to_pandas()
    assert sum(kind.wall_s for kind in part.chunk.kinds) == pytest.approx(rows["wall_s"].sum())
    assert {part.run_id} == set(rows["run_id"])


def _only_cells(read):
    def checked(file, *rest, **more):
        assert "stream" not in str(file.metadata.metadata)
        return read(file, *rest, **more)

    return checked


def test_a_finished_run_solves_nothing_again(experiment, tmp_path, small_chunks, monkeypatch):
    file = experiment()
    folder = run(file, tmp_path / "out")
    before = {file.name: file.stat().st_mtime_ns for file in read_chunks(folder)}
    with monkeypatch.context() as patched:
        patched.setattr(stream, "chunk_table", lambda *a, **k: pytest.fail("solved again"))
        run(file, folder)

    assert {file.name: file.stat().st_mtime_ns for file in read_chunks(folder)} == before
    run(file, folder, restart=True)
    assert all(file.stat().st_mtime_ns > before[file.name] for file in read_chunks(folder))


def _truncate(part):
    part.write_bytes(part.read_bytes()[:-100])


def _swap(part):
    other = min(part.parent.iterdir())
    part.write_bytes(other.read_bytes())


def _empty(part):
    part.write_bytes(b"")


@pytest.mark.parametrize("spoil", [_truncate, _swap, _empty, Path.unlink])
def test_exactly_the_missing_chunks_are_solved(
    experiment, tmp_path, small_chunks, monkeypatch, spoil
):
    """A chunk that is gone, cut off, or not what its name says is solved again, and no other."""
    file = experiment()
    folder = run(file, tmp_path / "out")
    before = held(folder)
    spoil(max((folder / "parts").iterdir()))
    solved, original = [], stream.chunk_table

    def counted(columns, *rest, **more):
        solved.append(len(columns["x"]))
        return original(columns, *rest, **more)

    monkeypatch.setattr(stream, "chunk_table", counted)
    run(file, folder)

    assert solved == [3000 - 4 * 700]
    after = held(folder)
    numbers = ["scenario_id", "length", "verdict", "proof"]
    assert after[numbers].equals(before[numbers])


def test_a_chunk_under_another_name_is_refused(experiment, tmp_path, small_chunks):
    """Beside the original its rows would count twice; where it is read as cells, unbounded."""
    file = experiment()
    folder = run(file, tmp_path / "out")
    first = sorted((folder / "parts").iterdir())[0]
    copy = first.with_name(f"copy of {first.name}")
    shutil.copyfile(first, copy)

    for use in (status, done, read_rows, lambda folder: run(file, folder)):
        with pytest.raises(ResultsError, match="a chunk of a stream under a name that is not its"):
            use(folder)
    copy.unlink()
    assert status(folder).done == 3000
    assert len(load([folder]).rows) == 3000


@pytest.mark.parametrize(
    "name", ["{stem}-copy.parquet", "stream-{none}-00000000000-000700.parquet"]
)
def test_a_chunk_under_another_chunks_name_is_put_aside(experiment, tmp_path, small_chunks, name):
    """Its own is there, or solved again; either way the folder is whole afterwards."""
    file = experiment()
    folder = run(file, tmp_path / "out")
    first = sorted((folder / "parts").iterdir())[0]
    copy = first.with_name(name.format(stem=first.stem, none="0" * 16))
    shutil.copyfile(first, copy)
    assert status(folder).damaged == 1

    run(file, folder)

    assert not copy.exists()
    assert (folder / "damaged" / copy.name).exists()
    found = status(folder)
    assert (found.done, found.damaged) == (3000, 0)


def test_an_interruption_finishes_the_chunk(experiment, tmp_path, small_chunks, monkeypatch):
    """What is being solved when the signal comes is written; the next run solves the rest."""
    original, solved = stream.chunk_table, []

    def interrupted(columns, *rest, **more):
        solved.append(1)
        if len(solved) == 2:
            signal.raise_signal(signal.SIGINT)
        return original(columns, *rest, **more)

    file, out = experiment(), tmp_path / "out"
    monkeypatch.setattr(stream, "chunk_table", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(file, out)
    assert [chunk.window for chunk in read_chunks(out).values()] == [(0, 700), (700, 700)]
    assert not json.loads((out / "manifest.json").read_text())["finished"]

    run(file, out)

    assert len(solved) == 5
    assert len(held(out)) == 3000


def test_a_full_disk_is_a_message(experiment, tmp_path, small_chunks, monkeypatch):
    """It comes out of the thread that writes; what was written before stays."""

    class Full(pq.ParquetWriter):
        def write_table(self, table, *rest):
            if "0000001400" in str(self.where):
                raise OSError(28, "No space left on device")
            super().write_table(table)

    monkeypatch.setattr(pq, "ParquetWriter", Full)
    with pytest.raises(ResultsError, match="No space left on device"):
        run(experiment(), tmp_path / "out")
    assert len(read_chunks(tmp_path / "out")) == 2


MAIN = "from dubins_study.cli.app import main; main()"


def started(file, out):
    process = subprocess.Popen(
        [sys.executable, "-c", MAIN, "run", file, "--out", str(out)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        env={**os.environ},
    )
    give_up = time.monotonic() + 120
    while len([*out.glob("parts/stream-*.parquet")]) < 2 and process.poll() is None:
        assert time.monotonic() < give_up
        time.sleep(0.01)
    return process


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_run_that_is_killed_goes_on_where_it_was(experiment, tmp_path, number):
    """For real: every row once, the chunks that were written untouched."""
    file, out = experiment(HEAD + SOBOL.replace("COUNT", "2500000")), tmp_path / "out"
    process = started(file, out)
    os.killpg(process.pid, number)
    process.communicate(timeout=60)
    assert process.returncode == (130 if number == signal.SIGINT else -signal.SIGKILL)
    before = {file.name: file.stat().st_mtime_ns for file in read_chunks(out)}
    assert 2 <= len(before) < 20

    run(file, out)

    chunks = read_chunks(out)
    files = list(chunks)
    assert [chunk.first for chunk in chunks.values()] == list(range(0, 2500000, 2**17))
    assert sum(chunk.count for chunk in chunks.values()) == 2500000
    assert all(files[i].stat().st_mtime_ns == t for i, t in enumerate(before.values()))
    assert not [*out.glob("parts/.*")] or number == signal.SIGKILL
    ids = pd.concat([pq.read_table(file, columns=["scenario_id"]).to_pandas() for file in files])
    assert ids["scenario_id"].nunique() == 2500000


PEAK = """
import resource, sys
from dubins_study import run
run(sys.argv[1], sys.argv[2])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


@pytest.mark.slow
def test_memory_does_not_grow_with_the_rows(experiment, tmp_path):
    """Peak memory of whole processes: five times the rows, no more than a tenth more memory."""
    peaks = []
    for count in ("1200000", "6000000"):
        file = experiment(HEAD + SOBOL.replace("COUNT", count))
        words = [sys.executable, "-c", PEAK, file, str(tmp_path / count)]
        done = subprocess.run(words, capture_output=True, text=True, check=True, env={**os.environ})
        peaks.append(int(done.stdout.split()[-1]) / 1024)
    assert peaks[1] < 1.1 * peaks[0] + 8 * 6.0  # the marks of 6 million scenarios, looked through
    assert peaks[1] < 1500


@pytest.mark.parametrize("digit", ["0", "f"])
def test_a_stale_chunk_hides_no_current_one(experiment, tmp_path, digit):
    """Whichever of the two comes first in the folder."""
    folder = run(experiment(HEAD + GRID), tmp_path / "out")
    (part,) = (folder / "parts").glob("*.parquet")
    table, about = pq.read_table(part), pq.read_metadata(part).metadata
    stream, code = part.stem.split("-")[1], table["code_digest"][0].as_py()
    other = digit * 12
    told = about[CHUNK.encode()].decode().replace(stream, other).replace(code, other)
    place = table.schema.get_field_index("code_digest")
    stale = table.set_column(place, "code_digest", pa.array([other] * len(table)))
    write_part(folder, part.stem.replace(stream, other), stale, {CHUNK: told})

    found = load([folder])

    assert len(found.rows) == len(table)

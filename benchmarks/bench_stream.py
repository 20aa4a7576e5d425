"""A stream of scenarios generated, solved, judged and stored, beside pyarrow writing alone."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.harness import Measurement, side_by_side
from dubins_study.experiments.definition.experiment import parse
from dubins_study.experiments.executors.stream import solve_streams
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.plan.streams import Stream, streams
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.experiments.store.part_writer import PartWriter
from dubins_study.study.rows.schema import arrow_schema

CHUNK, PARTS = 2**17, 10
SIZES = (2_000_000, 12_000_000)
_TEXT = """
title = "stream"
question = "how fast?"
solvers = ["analytic"]
[[scenarios]]
[scenarios.sample]
method = "sobol"
count = {count}
seed = 1
[scenarios.sample.ranges]
target_x = {{ linear = [-4, 4] }}
target_y = {{ linear = [-4, 4] }}
heading = {{ linear = ["-pi", "pi"] }}
radius = {{ log = [0.1, 10] }}
"""
_PEAK = """
import resource, sys
from dubins_study import run
run(sys.argv[1], sys.argv[2])
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


def measure() -> Iterable[Measurement]:
    with tempfile.TemporaryDirectory() as place:
        times = side_by_side(
            {"ours": _stored(Path(place)), "pyarrow": _written(Path(place))}, repeats=5
        )
    ours, peer = times["ours"], times["pyarrow"]
    rows = CHUNK * PARTS
    yield Measurement(
        f"a stream of {PARTS} parts of 2^17 rows, stored, against pyarrow writing random columns",
        ours=ours.least / rows * 1e6,
        peer=peer.least / rows * 1e6,
        unit="µs/row",
        ratio=peer.least / ours.least,
        target=0.2,
        at_most=False,
        note=f"peer / ours; of medians {peer.median / ours.median:.2f}",
    )
    small, large = (_peak(size) for size in SIZES)
    yield Measurement(
        f"peak memory of a run of {SIZES[1]:,} rows against one of {SIZES[0]:,}".replace(",", " "),
        ours=large,
        peer=small,
        unit="MB",
        ratio=large / small,
        target=1.15,
        note="processes of their own; at most 1500 MB wanted",
    )


def _stored(place: Path) -> Callable[[], None]:
    """Everything that a run does of a stream, in a new folder each time."""
    text = _TEXT.format(count=CHUNK * PARTS)
    wanted: list[Stream] = streams(parse("stream", "stream.toml", text).experiment)
    numbers = count()

    def store() -> None:
        with _folder(place / f"ours-{next(numbers)}") as folder:
            writer = PartWriter(folder, "bench", CHUNK * PARTS, None)
            solve_streams(folder, wanted, RunSettings("bench", 60.0), writer, Interruption())

    return store


def _written(place: Path) -> Callable[[], None]:
    """Random columns of the same schema, in as many parts, each synced."""
    table = _random_table()

    def write() -> None:
        with _folder(place / "peer") as folder:
            for number in range(PARTS):
                part = folder / "parts" / f"{number}.parquet"
                pq.write_table(table, part, compression="zstd")
                with part.open("rb") as file:
                    os.fsync(file.fileno())

    return write


@contextmanager
def _folder(folder: Path) -> Iterator[Path]:
    (folder / "parts").mkdir(parents=True)
    yield folder
    for part in (folder / "parts").iterdir():
        part.unlink()
    (folder / "parts").rmdir()
    folder.rmdir()


def _random_table() -> pa.Table:
    rng = np.random.default_rng(0)
    return pa.table([_random(field, rng) for field in arrow_schema()], schema=arrow_schema())


def _random(field: pa.Field, rng: np.random.Generator) -> Any:
    """Numbers of all digits; ids of their own; of texts, one of four, as most columns have."""
    kind = field.type
    if field.name == "scenario_id":
        return pa.array([rng.bytes(8).hex() for _ in range(CHUNK)])
    if kind == pa.string():
        return pa.array(["optimal", "longer", "misses", "none"]).take(
            pa.array(rng.integers(0, 4, CHUNK))
        )
    if kind == pa.bool_():
        return pa.array(rng.random(CHUNK) < 0.5)
    if kind == pa.int64():
        return pa.array(rng.integers(0, 1000, CHUNK))
    if pa.types.is_list(kind):
        offsets = pa.array(np.arange(0, 2 * CHUNK + 1, 2, dtype=np.int32))
        return pa.ListArray.from_arrays(offsets, pa.array(rng.random(2 * CHUNK)))
    return pa.array(rng.random(CHUNK))


def _peak(rows: int) -> float:
    """Largest resident set of a whole run in a process of its own, in MB."""
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "stream.toml"
        file.write_text(_TEXT.format(count=rows), encoding="utf-8")
        words = [sys.executable, "-c", _PEAK, str(file), str(Path(place) / "out")]
        done = subprocess.run(words, capture_output=True, text=True, check=True)
    return int(done.stdout.split()[-1]) / 1024

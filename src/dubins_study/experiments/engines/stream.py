"""Streams: blocks of many scenarios that the closed form answers chunk by chunk, in any number.

No cell is ever made of them. A chunk is generated as columns, solved and judged as a frame, and
written as one part while the next one is solved; the memory that takes does not depend on how many
chunks there are. What is done is known from the parts' names and metadata alone.
"""

from __future__ import annotations

import hashlib
import itertools
import json
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.experiments.definition.experiment import Block, Experiment
from dubins_study.experiments.engines.stream_table import chunk_table, warm_up
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.sandbox import THREADS
from dubins_study.experiments.plan.block_columns import Window, size, tiled, windows
from dubins_study.experiments.plan.cells import asked, streamed
from dubins_study.experiments.plan.repeated_scenarios import refuse_repeats
from dubins_study.experiments.plan.solver_description import described
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.experiments.store.part_writer import PartWriter, write_chunk
from dubins_study.study.rows.chunk import Chunk, row_kinds
from dubins_study.study.rows.parts import read_chunks

# Enclosing every reference takes ten times as long as all the rest together: 40 microseconds a row
# against 4. Streams of no more rows than these are proved, the others are certified without.
MOST_PROVED = 2**20
# rows of a chunk, which takes half a second either way
_CHUNK, _CHUNK_PROVED = 2**17, 2**14


class Stream(NamedTuple):
    """A block put to the closed form: one branch, one repeat, cold.

    Args:
        number: of the block in the experiment.
        code: digest of what makes the rows.
    """

    number: int
    block: Block
    solver: str
    profile: str
    branch: str
    repeat: int
    code_digest: str

    @property
    def where(self) -> str:
        return f"scenarios.{self.number}"

    @property
    def rows(self) -> int:
        return size(self.block)

    @property
    def proved(self) -> bool:
        """Whether every row's reference length is enclosed."""
        return self.rows <= MOST_PROVED

    @property
    def key(self) -> dict[str, Any]:
        """The columns of the key but the scenario's, the same for all rows."""
        return {
            "solver": self.solver,
            "profile": self.profile,
            "branch": self.branch,
            "initial_guess": "cold",
            "repeat": self.repeat,
            "code_digest": self.code_digest,
        }

    @property
    def chunk(self) -> int:
        return _CHUNK_PROVED if self.proved else _CHUNK

    def chunks(self) -> Iterator[Window]:
        """All its windows, in ascending order."""
        return tiled(self.rows, self.chunk)

    @property
    def id(self) -> str:
        """A name that depends on all that the rows and their chunks depend on."""
        # who else is asked does not matter, nor where in the file
        block = self.block.model_dump(mode="json", exclude={"solvers", "branches", "guess_lengths"})
        text = json.dumps([self.chunk, block, *self[2:]], sort_keys=True)
        return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()[:12]

    @property
    def question(self) -> str:
        """The same whatever code answers."""
        return self._replace(code_digest="").id


def streams(experiment: Experiment) -> list[Stream]:
    """What an experiment asks of the closed form in so many scenarios that they are streamed.

    Raises:
        ExperimentError: if a block holds a scenario that cannot be, or one twice (looked for in up
            to `overlap.MOST_LOOKED_THROUGH` rows).
        SolverError: if a solver's spec is not valid.
    """
    if "cold" not in experiment.initial_guesses:
        return []
    blocks, profile = experiment.scenarios, experiment.profile
    found: dict[str, Stream] = {}
    questions: list[set[tuple[str, str]]] = []
    for number, (block, specs) in enumerate(zip(blocks, asked(experiment), strict=True)):
        branches = block.branches or experiment.branches
        questions.append(set(itertools.product(specs, branches)))
        closed = [spec for spec in specs if streamed(block, spec, profile)]
        for spec, branch, repeat in itertools.product(closed, branches, range(experiment.repeats)):
            stream = Stream(
                number, block, spec, profile, branch, repeat, described(spec, profile).code_digest
            )
            found.setdefault(stream.id, stream)
    alike: dict[int, set[int]] = {}
    for stream in found.values():
        asks = (stream.solver, stream.branch)
        others = {i for i, own in enumerate(questions) if asks in own} - {stream.number}
        alike.setdefault(stream.number, set()).update(others)
    refuse_repeats(blocks, alike)
    return list(found.values())


def streamed_totals(folder: FilePath, wanted: list[Stream]) -> Counter[tuple[str, str]]:
    """Streamed rows that a folder will hold, by solver and code: what is wanted and what is there.

    Only metadata are read.
    """
    ids = {stream.id for stream in wanted}
    totals = Counter[tuple[str, str]]()
    for chunk in read_chunks(folder).values():
        if chunk.stream not in ids:
            totals[chunk.solver, chunk.code_digest] += chunk.count
    for stream in wanted:
        totals[stream.solver, stream.code_digest] += stream.rows
    return totals


def streams_done(folder: FilePath, wanted: list[Stream]) -> bool:
    """Whether a folder holds every chunk."""
    held = _held(folder)
    return all({(stream.id, window) for window in stream.chunks()} <= held for stream in wanted)


def _held(folder: FilePath) -> set[tuple[str, Window]]:
    return {(chunk.stream, chunk.window) for chunk in read_chunks(folder).values()}


def solve_streams(
    folder: FilePath, wanted: list[Stream], run: RunSettings, writer: PartWriter, stop: Interruption
) -> None:
    """Solve every chunk that the folder does not hold yet, and write each as a part of its own.

    Raises:
        ExperimentError: if a chunk holds a scenario that cannot be; the chunks before are kept.
        ResultsError: if the folder cannot be written.
        KeyboardInterrupt: if the run is interrupted, once the chunk being solved is written.
    """
    held = _held(folder)
    with _one_thread(), ThreadPoolExecutor(1) as pool:
        for stream in wanted:
            name = stream.id
            left = [window for window in stream.chunks() if (name, window) not in held]
            writer.skip(stream.rows - sum(count for _, count in left))
            _solve_chunks(folder, stream, left, run, writer, stop, pool)


def _solve_chunks(
    folder: FilePath,
    stream: Stream,
    left: list[Window],
    run: RunSettings,
    writer: PartWriter,
    stop: Interruption,
    pool: ThreadPoolExecutor,
) -> None:
    """One chunk is solved while the one before is compressed and written, never two before."""
    writing: Future[int] | None = None
    cold = True
    try:
        for window, columns in zip(left, windows(stream.block, stream.where, left), strict=True):
            stop.check()
            if cold:
                warm_up(columns, stream.key, run)
            cold = False
            table = chunk_table(columns, stream.block.label, stream.key, run, stream.proved)
            if stop.at_once:  # no row for an answer that a library gave since it was interrupted
                raise KeyboardInterrupt
            _written(writing, writer)
            writing = pool.submit(_write, folder, stream, window, table, run.run_id)
    finally:
        _written(writing, writer)
    stop.check()


def _written(writing: Future[int] | None, writer: PartWriter) -> None:
    if writing is not None:
        writer.skip(writing.result())


def _write(folder: FilePath, stream: Stream, window: Window, table: Any, run_id: str) -> int:
    first, count = window
    chunk = Chunk(
        stream=stream.id,
        question=stream.question,
        solver=stream.solver,
        code_digest=stream.code_digest,
        first=first,
        count=count,
        kinds=row_kinds(table),
    )
    write_chunk(folder, chunk, table, run_id)
    return count


@contextmanager
def _one_thread() -> Iterator[None]:
    """The kernels in one thread, as the rows say."""
    import numba

    threads = numba.get_num_threads()
    numba.set_num_threads(THREADS)
    try:
        yield
    finally:
        numba.set_num_threads(threads)

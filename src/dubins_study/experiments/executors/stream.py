"""Solve streams chunk by chunk; each chunk becomes one part of the results folder.

A chunk is computed as columns, solved and judged as a frame, and written while the next chunk is
solved. The names and metadata of the parts tell which chunks are done; their rows are not read.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path as FilePath

import pyarrow as pa

from dubins_study.experiments.executors.stream_table import chunk_table, warm_up
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.sandbox import THREADS
from dubins_study.experiments.plan.scenario_columns import Window, windows
from dubins_study.experiments.plan.streams import Stream
from dubins_study.experiments.run_settings import RunSettings
from dubins_study.experiments.store.part_writer import PartWriter, write_chunk
from dubins_study.study.rows.chunk import Chunk, row_kinds
from dubins_study.study.rows.parts import read_chunks


def streamed_totals(folder: FilePath, streams: list[Stream]) -> Counter[tuple[str, str]]:
    """How many streamed rows a folder will hold, by solver and code digest.

    All rows of `streams` count, and the rows of other streams that the folder holds already.
    """
    ids = {stream.id for stream in streams}
    totals = Counter[tuple[str, str]]()
    for chunk in read_chunks(folder).values():
        if chunk.stream not in ids:
            totals[chunk.solver, chunk.code_digest] += chunk.count
    for stream in streams:
        totals[stream.solver, stream.code_digest] += stream.rows
    return totals


def streams_done(folder: FilePath, streams: list[Stream]) -> bool:
    """Whether a folder holds every chunk of the streams."""
    done = _done_chunks(folder)
    return all({(stream.id, window) for window in stream.chunks()} <= done for stream in streams)


def _done_chunks(folder: FilePath) -> set[tuple[str, Window]]:
    """Stream id and window of every chunk that a folder holds."""
    return {(chunk.stream, chunk.window) for chunk in read_chunks(folder).values()}


def solve_streams(
    folder: FilePath,
    streams: list[Stream],
    settings: RunSettings,
    writer: PartWriter,
    stop: Interruption,
) -> None:
    """Solve every chunk that the folder does not hold, and write each chunk as one part.

    The writer counts the rows.

    Raises:
        ExperimentError: if a chunk holds a scenario that is not valid; earlier chunks are kept.
        ResultsError: if the folder cannot be written.
        KeyboardInterrupt: if the run is interrupted; the current chunk is written before.
    """
    if not streams:  # numba takes half a second to import
        return
    done = _done_chunks(folder)
    with _one_thread(), ThreadPoolExecutor(1) as pool:
        for stream in streams:
            stream_id = stream.id
            missing = [window for window in stream.chunks() if (stream_id, window) not in done]
            writer.skip(stream.rows - sum(rows for _, rows in missing))
            writing: Future[int] | None = None
            try:
                for window, table in _solved_chunks(stream, missing, settings, stop):
                    # Memory holds at most two chunks: one that was solved, one that is written.
                    _wait(writing, writer)
                    writing = pool.submit(_write, folder, stream, window, table, settings.run_id)
            finally:
                _wait(writing, writer)
            stop.check()


def _solved_chunks(
    stream: Stream, missing: list[Window], settings: RunSettings, stop: Interruption
) -> Iterator[tuple[Window, pa.Table]]:
    """The rows of the missing chunks of a stream, chunk by chunk."""
    columns_of = windows(stream.block, stream.block_key, missing)
    for window, columns in zip(missing, columns_of, strict=True):
        stop.check()
        if window == missing[0]:
            warm_up(columns, stream, settings)
        table = chunk_table(columns, stream, settings)
        if stop.immediate:  # a library may have swallowed the interrupt: the table may be wrong
            raise KeyboardInterrupt
        yield window, table


def _wait(writing: Future[int] | None, writer: PartWriter) -> None:
    """Wait until a chunk is written, and count its rows."""
    if writing is not None:
        writer.skip(writing.result())


def _write(folder: FilePath, stream: Stream, window: Window, table: pa.Table, run_id: str) -> int:
    """Write a chunk as a part; return its number of rows."""
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
    """Limit numba's kernels to `THREADS`, the number of threads that the rows record."""
    import numba

    threads = numba.get_num_threads()
    numba.set_num_threads(THREADS)
    try:
        yield
    finally:
        numba.set_num_threads(threads)

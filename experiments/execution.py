"""Solve the cells that are left: in batches, then chain by chain, in one process or in several."""

from __future__ import annotations

from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from itertools import pairwise
from multiprocessing import active_children, get_context
from pathlib import Path as FilePath
from queue import SimpleQueue
from typing import Any

from experiments.batch import batched, solve_batch
from experiments.grid import Chain, shuffled
from experiments.interruption import Interruption, interrupts_held_back
from experiments.rows import Row
from experiments.store import read_rows
from experiments.worker import Run, pinned_threads, solve_chain, solve_whole_chain, start_worker
from experiments.writer import Writer
from study.path import Path
from study.scenario import Pose
from study.schema import KEY, Key, names


class RunError(RuntimeError):
    """A run that could not go on; what was done is kept."""


def solve_left(
    folder: FilePath,
    groups: list[Chain],
    finished: set[Key],
    seed: int,
    shared: Run,
    writer: Writer,
    stop: Interruption,
) -> None:
    """Attempt every cell whose key is not finished; the writer gets the rows as they come.

    Raises:
        KeyboardInterrupt: if the run is interrupted.
        RunError: if a worker process dies.
    """
    left = [_left(group, finished) for group in groups]
    writer.skip(sum(map(len, groups)) - sum(map(len, left)))
    batches, single = batched([group for group in left if group])
    with pinned_threads():
        for batch in batches:
            try:
                table = solve_batch(batch, shared)
            except Exception:  # a plug-in's frame of answers, malformed: its cells one by one then
                single += [(cell,) for cell in batch]
            else:
                _refuse_if_cut(stop)
                writer.add_table(table)
            stop.check()
    before = _paths_before(folder, single, groups)
    ordered = shuffled(single, seed)
    if shared.jobs == 1:
        _solve_here(ordered, shared, before, writer, stop)
    elif ordered:
        _solve_with_processes(ordered, shared, before, writer, stop)


def _left(group: Chain, finished: set[Key]) -> Chain:
    return tuple(cell for cell in group if cell.key not in finished)


def _refuse_if_cut(stop: Interruption) -> None:
    """No row for an answer that a library gave because it was interrupted."""
    if stop.at_once:
        raise KeyboardInterrupt


def _solve_here(
    groups: list[Chain], shared: Run, before: dict[Key, Path], writer: Writer, stop: Interruption
) -> None:
    with pinned_threads():
        for group in groups:
            for row in solve_chain(group, shared, before.get(group[0].key)):
                _refuse_if_cut(stop)
                writer.add([row])
                stop.check()


def _row_path(row: Row) -> Path | None:
    """The path of a row, if it arrived."""
    if row["gap"] is None:
        return None
    return Path(Pose(row["x"], row["y"], row["heading"]), row["curvatures"], row["lengths"])


def _paths_before(folder: FilePath, left: list[Chain], groups: list[Chain]) -> dict[Key, Path]:
    """For every chain cut short: the path of the last cell done before the first one left."""
    cut = {group[0].key for group in left if group[0].start == "warm"}
    before = {
        cell.key: previous.key
        for group in groups
        for previous, cell in pairwise(group)
        if cell.key in cut
    }
    if not before:
        return {}
    columns = ["x", "y", "heading", "gap", "curvatures", "lengths"]
    rows = read_rows(folder, columns).to_pylist()
    paths: dict[Any, Path | None] = {
        tuple(row[name] for name in names(KEY)): _row_path(row) for row in rows
    }
    found = {key: paths.get(previous) for key, previous in before.items()}
    return {key: path for key, path in found.items() if path is not None}


# the rows of a chain, once a worker hands them back
_Future = Future[list[Row]]


def _solve_with_processes(
    groups: list[Chain], shared: Run, before: dict[Key, Path], writer: Writer, stop: Interruption
) -> None:
    context = get_context("spawn")  # a fork would carry over threads and solver state
    others = set(active_children())
    ended: SimpleQueue[_Future] = SimpleQueue()
    futures: list[_Future] = []
    whole = True
    with ProcessPoolExecutor(shared.jobs, mp_context=context, initializer=start_worker) as pool:
        try:
            try:
                for group in groups:
                    with interrupts_held_back():
                        start = before.get(group[0].key)
                        future = pool.submit(solve_whole_chain, group, shared, start)
                        future.add_done_callback(ended.put)
                        futures.append(future)
            except BrokenProcessPool:
                whole = False
            whole = _collect(futures, ended, writer, stop) and whole
        except BaseException:  # interrupted again, or no place for rows: wait for nobody
            for child in set(active_children()) - others:
                child.terminate()
            raise
    if not whole:
        raise RunError(
            "a worker process died; the rows written so far are kept, run again to go on"
        )
    stop.check()


def _collect(
    futures: list[_Future], ended: SimpleQueue[_Future], writer: Writer, stop: Interruption
) -> bool:
    """Write the rows of all chains as they end; whether every worker lived.

    Once the run is interrupted, the chains that no worker has begun are left out.
    """
    whole, cancelled = True, False
    for _ in futures:
        future = ended.get()
        if stop.asked and not cancelled:
            cancelled = True
            for other in futures:
                other.cancel()
        try:
            if not future.cancelled():
                writer.add(future.result())
        except BrokenProcessPool:
            whole = False
    return whole

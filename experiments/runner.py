"""Run an experiment: the cells that are not done yet, recorded as they come."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path as FilePath
from time import monotonic
from typing import Any
from uuid import uuid4

from experiments.batch import batched, solve_batch
from experiments.grid import Chain, chains, shuffled
from experiments.provenance import machine, now, source, versions
from experiments.spec import Experiment, ExperimentError, Source, read, validated
from experiments.store import (
    compact,
    done,
    open_folder,
    read_rows,
    rows_table,
    write_manifest,
    write_part,
)
from experiments.worker import Row, Run, pin_threads, pinned_threads, solve_chain, solve_whole_chain
from solvers.profiles import tolerances
from solvers.registry import load, settings
from study.path import Path
from study.scenario import Pose
from study.schema import KEY, VERSION, Key, names

# rows are written when this many seconds have passed, so that a killed run loses little
_FLUSH = 1.0

# called with (cells done, cells in all) after every step
Progress = Callable[[int, int], None]


class RunError(RuntimeError):
    """A run that could not go on; what was done is kept."""


def run(
    experiment: str,
    out: str | FilePath | None = None,
    *,
    solvers: list[str] | None = None,
    jobs: int = 1,
    limit: float | None = None,
    repeats: int | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
) -> FilePath:
    """Run an experiment and return its results folder.

    Cells whose row the folder holds are skipped, so that a second run finishes what a first one
    left. One job by default, since times are only comparable then.

    Args:
        experiment: a name (`paper`, `radius-sweep`, ...) or the path of a TOML file.
        out: results folder; `results/<name>` by default.
        solvers: specs to run instead of the experiment's own.
        jobs: processes that solve side by side.
        limit: seconds a solve may take, instead of the experiment's own.
        repeats: how often each cell is attempted, instead of the experiment's own.
        fresh: throw away the rows that the folder holds.
        progress: called with (cells done, cells in all).

    Raises:
        ExperimentError, SolverError, StoreError: if the request or the folder is not valid.
        RunError: if a worker process dies.
    """
    if jobs < 1:
        raise ExperimentError(f"jobs is {jobs}; expected a number of processes above 0")
    found = _changed(read(experiment), solvers, limit, repeats)
    groups = chains(found.experiment)
    folder = FilePath(out) if out is not None else FilePath("results") / found.name
    manifest = _manifest(found, groups, _command(experiment, solvers, jobs, limit, repeats))
    earlier = open_folder(folder, manifest["experiment"], fresh)
    finished = done(folder)
    keys = {cell.key for group in groups for cell in group}
    if earlier is not None:
        # the run that began the folder stays its origin; rows name their own versions
        manifest |= {"created": earlier.get("created"), "finished": earlier.get("finished")}
        manifest["solvers"] = {**earlier.get("solvers", {}), **manifest["solvers"]}
    manifest["cells"] = len(keys | finished)
    shared = Run(uuid4().hex[:12], found.experiment.limit, jobs)
    writer = _Writer(folder, shared.run_id, len(keys), progress)
    if keys <= finished and earlier is not None:
        writer.skip(len(keys))
        return folder
    write_manifest(folder, manifest | {"finished": None})
    try:
        _solve(folder, groups, finished, found.experiment, shared, writer)
    finally:
        writer.flush()
    compact(folder, f"{shared.run_id}-all")
    write_manifest(folder, manifest | {"finished": now()})
    return folder


def _command(
    experiment: str,
    solvers: list[str] | None,
    jobs: int,
    limit: float | None,
    repeats: int | None,
) -> str:
    """The command line that asks for the same rows; where they are put is left out."""
    words = ["dubins-study", "run", experiment]
    words += [word for spec in solvers or () for word in ("--solver", spec)]
    options = {"--jobs": jobs, "--limit": limit, "--repeats": repeats}
    words += [word for key, value in options.items() if value for word in (key, str(value))]
    return shlex.join(words)


def _changed(
    found: Source, solvers: list[str] | None, limit: float | None, repeats: int | None
) -> Source:
    """The experiment with the caller's own solvers, limit and repeats, checked like the file's."""
    given = {"solvers": solvers, "limit": limit, "repeats": repeats}
    changes = {key: value for key, value in given.items() if value is not None}
    if not changes:
        return found
    fields = {name: getattr(found.experiment, name) for name in Experiment.model_fields}
    blocks = found.experiment.scenarios
    if solvers is not None:
        blocks = [block.model_copy(update={"solvers": None}) for block in blocks]
    changed = fields | {"scenarios": blocks} | changes
    return Source(found.name, found.text, validated(found.name, changed))


def _manifest(found: Source, groups: list[Chain], command: str) -> dict[str, Any]:
    specs = dict.fromkeys(cell.solver for group in groups for cell in group)
    loaded = {spec: load(spec, found.experiment.profile) for spec in specs}
    packages = sorted({package for solver in loaded.values() for package in solver.packages})
    return {
        "schema": VERSION,
        "experiment": {
            "name": found.name,
            "title": found.experiment.title,
            "question": found.experiment.question,
            "text": found.text,
        },
        "command": command,
        "seed": found.experiment.seed,
        "limit": found.experiment.limit,
        "profile": found.experiment.profile,
        "gap_tolerance": tolerances(found.experiment.profile).gap,
        "solvers": {spec: settings(solver) for spec, solver in loaded.items()},
        "versions": versions(tuple(packages)),
        "machine": machine(),
        "git": source(),
        "created": now(),
        "finished": None,
    }


class _Writer:
    """Collects rows, writes a part every second, and tells the progress."""

    def __init__(self, folder: FilePath, run_id: str, total: int, progress: Progress | None):
        self.folder, self.run_id, self.total, self.progress = folder, run_id, total, progress
        self.rows: list[Row] = []
        self.parts = 0
        self.done = 0
        self.flushed = monotonic()

    def skip(self, cells: int) -> None:
        self.done += cells
        self._tell()

    def add(self, rows: list[Row]) -> None:
        self.rows += rows
        self.done += len(rows)
        if monotonic() - self.flushed > _FLUSH:
            self.flush()
        self._tell()

    def add_table(self, table: Any) -> None:
        self._write(table)
        self.done += len(table)
        self._tell()

    def flush(self) -> None:
        if self.rows:
            self._write(rows_table(self.rows))
            self.rows = []
        self.flushed = monotonic()

    def _write(self, table: Any) -> None:
        write_part(self.folder, f"{self.run_id}-{self.parts:06d}", table)
        self.parts += 1

    def _tell(self) -> None:
        if self.progress is not None:
            self.progress(self.done, self.total)


def _solve(
    folder: FilePath,
    groups: list[Chain],
    finished: set[Key],
    experiment: Experiment,
    shared: Run,
    writer: _Writer,
) -> None:
    left = [_left(group, finished) for group in groups]
    writer.skip(sum(map(len, groups)) - sum(map(len, left)))
    batches, single = batched([group for group in left if group])
    with pinned_threads():
        for batch in batches:
            writer.add_table(solve_batch(batch, shared))
    before = _paths_before(folder, single, groups)
    ordered = shuffled(single, experiment.seed)
    if shared.jobs == 1:
        with pinned_threads():
            for group in ordered:
                for row in solve_chain(group, shared, before.get(group[0].key)):
                    writer.add([row])
    elif ordered:
        _solve_with_processes(ordered, shared, before, writer)


def _left(group: Chain, finished: set[Key]) -> Chain:
    return tuple(cell for cell in group if cell.key not in finished)


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


def _solve_with_processes(
    groups: list[Chain], shared: Run, before: dict[Key, Path], writer: _Writer
) -> None:
    context = get_context("spawn")  # a fork would carry over threads and solver state
    with ProcessPoolExecutor(shared.jobs, mp_context=context, initializer=pin_threads) as pool:
        futures = [
            pool.submit(solve_whole_chain, group, shared, before.get(group[0].key))
            for group in groups
        ]
        try:
            for future in as_completed(futures):
                writer.add(future.result())
        except BrokenProcessPool:
            raise RunError(
                "a worker process died; the rows written so far are kept, run again to go on"
            ) from None
        finally:
            pool.shutdown(wait=False, cancel_futures=True)

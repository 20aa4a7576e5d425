"""Run an experiment: the cells that are not done yet, recorded as they come."""

from __future__ import annotations

import logging
from collections import Counter
from pathlib import Path as FilePath
from uuid import uuid4

from dubins_study.experiments.definition.experiment import Source
from dubins_study.experiments.engines.engine import Engine, make_engine
from dubins_study.experiments.engines.execution import solve_left
from dubins_study.experiments.engines.stream import (
    Stream,
    solve_streams,
    streamed_totals,
    streams_done,
)
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.sandbox import THREADS, pinned_threads
from dubins_study.experiments.plan.cells import Chain
from dubins_study.experiments.plan.request import Request, accepted
from dubins_study.experiments.plan.solver_description import described
from dubins_study.experiments.provenance import machine, now, source, versions
from dubins_study.experiments.run_settings import BYTES_PER_GIB, RunSettings
from dubins_study.experiments.store.folder import compact, done, open_folder, prepare_folder
from dubins_study.experiments.store.lock import locked
from dubins_study.experiments.store.manifest import count_cells
from dubins_study.experiments.store.part_writer import PartWriter, Progress
from dubins_study.experiments.store.run_entry import recorded
from dubins_study.solvers.profiles import tolerances
from dubins_study.study.rows.manifest import Definition, Manifest, RunEntry, SolverEntry

_LOG = logging.getLogger(__name__)


def run(
    experiment: str | FilePath,
    out: str | FilePath | None = None,
    *,
    solvers: list[str] | None = None,
    jobs: int = 1,
    time_limit: float | None = None,
    memory_limit: float | None = None,
    repeats: int | None = None,
    restart: bool = False,
    trust_plugins: bool = False,
    engine: str = "local",
    scheduler: str | None = None,
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
        time_limit: seconds a solve may take, instead of the experiment's own.
        memory_limit: GiB that a worker process and its children may hold, instead of its own.
        repeats: how often each cell is attempted, instead of the experiment's own.
        restart: throw away the rows that the folder holds.
        trust_plugins: let the experiment's own text name plug-in files and programs on PATH as solvers;
            those among `solvers` are trusted anyway.
        engine: `local`, or `dask`: the same by Dask's workers, on other machines too.
        scheduler: the address of Dask's scheduler; without one, `jobs` workers are started here.
        progress: called with (cells done, cells in all).

    Raises:
        ExperimentError, SolverError, ResultsError: if the request or the folder is not valid.
        RunError: if worker processes end before they have done anything, or Dask cannot go on.
        KeyboardInterrupt: after a SIGINT (Ctrl-C), once the cell being solved is finished and all
            rows are written; a second SIGINT leaves the cell. Only in the main thread, where
            Python handles signals, and with the caller's own handler back in place.
    """
    asked = (
        experiment,
        solvers,
        jobs,
        time_limit,
        memory_limit,
        repeats,
        trust_plugins,
        engine,
        scheduler,
    )
    request = Request(*asked)
    with Interruption() as stop:
        found, groups, wanted = accepted(request, out)
        folder = FilePath(out) if out is not None else FilePath("results") / found.name
        stop.check()
        with make_engine(engine, jobs, scheduler) as entered:
            _record(folder, found, groups, wanted, request, restart, progress, stop, entered)
    return folder


def _record(
    folder: FilePath,
    found: Source,
    groups: list[Chain],
    wanted: list[Stream],
    request: Request,
    restart: bool,
    progress: Progress | None,
    stop: Interruption,
    engine: Engine,
) -> None:
    """Solve the cells that the folder does not hold, and put them there."""
    prepare_folder(folder)
    with locked(folder):
        manifest = _manifest(found, groups, wanted, request.command())
        requested = set(manifest.solvers)
        manifest, repairs = open_folder(folder, manifest, restart)
        for repair in repairs:
            _LOG.warning("dubins-study: %s", repair)
        finished = done(folder)
        keys = {cell.key for group in groups for cell in group}
        cells = Counter((spec, digest) for _, spec, *_, digest in keys | finished)
        rows = cells + streamed_totals(folder, wanted)
        manifest, completes = count_cells(manifest, requested, rows)
        settings = RunSettings(
            run_id=uuid4().hex[:12],
            time_limit_s=found.experiment.time_limit_s,
            memory_limit_bytes=round(found.experiment.memory_limit_gib * BYTES_PER_GIB),
            jobs=engine.jobs,
            engine=request.engine,
            seed=found.experiment.seed,
        )
        total = len(keys) + sum(stream.rows for stream in wanted)
        writer = PartWriter(folder, settings.run_id, total, progress)
        all_done = keys <= finished and streams_done(folder, wanted)
        if all_done and (manifest.finished is not None or not completes):
            writer.skip(total)
            return
        entry = RunEntry(
            run_id=settings.run_id,
            time_limit_s=settings.time_limit_s,
            jobs=settings.jobs,
            engine=settings.engine,
            command=request.command(),
            memory_limit_gib=found.experiment.memory_limit_gib,
            threads=THREADS,
            **engine.run_entry,
        )
        with recorded(folder, manifest, entry, completes) as record:
            writer.after_step = record.write_now_and_then
            try:
                with pinned_threads():
                    solve_streams(folder, wanted, settings, writer, stop)
                solve_left(
                    folder,
                    groups,
                    finished,
                    settings,
                    writer,
                    stop,
                    engine,
                    record.probe,
                )
            finally:
                writer.flush()
            compact(folder, settings.run_id)


def _manifest(found: Source, groups: list[Chain], wanted: list[Stream], command: str) -> Manifest:
    specs = dict.fromkeys(stream.solver for stream in wanted)
    specs |= dict.fromkeys(cell.solver for group in groups for cell in group)
    experiment = found.experiment
    solvers = {spec: described(spec, experiment.profile) for spec in specs}
    packages = sorted({package for solver in solvers.values() for package in solver.packages})
    return Manifest(
        experiment=Definition(
            name=found.name,
            title=experiment.title,
            question=experiment.question,
            section=experiment.section,
            text=found.text,
        ),
        command=command,
        seed=experiment.seed,
        time_limit_s=experiment.time_limit_s,
        memory_limit_gib=experiment.memory_limit_gib,
        profile=experiment.profile,
        gap_tolerance=tolerances(experiment.profile).gap,
        cells=0,
        solvers={
            spec: SolverEntry(
                settings=solver.settings,
                code_digest=solver.code_digest,
                packages=solver.versions,
            )
            for spec, solver in solvers.items()
        },
        versions=versions(tuple(packages)),
        machine=machine(),
        git=source(),
        created=now(),
    )

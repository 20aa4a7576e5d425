"""Run an experiment: solve its cells.

Cells whose rows the results folder holds are not solved again.
"""

from __future__ import annotations

import logging
import warnings
from collections.abc import Iterator
from contextlib import AbstractContextManager, closing
from itertools import chain
from pathlib import Path as FilePath
from uuid import uuid4

from threadpoolctl import threadpool_limits

from dubins_study.experiments.definition.experiment import ExperimentFile
from dubins_study.experiments.executors.executor import Executor, WorkUnit
from dubins_study.experiments.executors.local import local_executor
from dubins_study.experiments.interruption import Interruption
from dubins_study.experiments.isolation.pool import RunError
from dubins_study.experiments.isolation.process_state import THREADS
from dubins_study.experiments.plan.cells import shuffled
from dubins_study.experiments.plan.run_plan import Request, RunPlan, RunSettings, plan_run
from dubins_study.experiments.plan.solver_description import describe_solver
from dubins_study.experiments.provenance import machine, now, source, versions, versions_of
from dubins_study.experiments.stages import not_asked, stages
from dubins_study.experiments.store.folder import compact, done, locked, open_folder, prepare_folder
from dubins_study.experiments.store.manifest_changes import RunRecord, count_by_code, count_cells
from dubins_study.experiments.store.part_writer import PartWriter, Progress
from dubins_study.solvers.matrix import matrix
from dubins_study.study.rows.manifest import Definition, Manifest, RunEntry, SolverEntry
from dubins_study.study.tolerances import tolerances

_LOG = logging.getLogger(__name__)
OLD_WORD = (
    "what runs the cells is the executor, as in run(executor='dask') and --executor dask; the old "
    "word, engine, is taken for this release only"
)


def run(
    experiment: str | FilePath | None = None,
    out: str | FilePath | None = None,
    *,
    solvers: list[str] | None = None,
    jobs: int = 1,
    time_limit: float | None = None,
    memory_limit: float | None = None,
    repeats: int | None = None,
    restart: bool = False,
    trust_plugins: bool = False,
    executor: str = "local",
    scheduler: str | None = None,
    scenarios: str | FilePath | None = None,
    progress: Progress | None = None,
    engine: str | None = None,
) -> FilePath:
    """Run an experiment and return its results folder.

    Cells whose rows the folder holds are skipped, so a second run completes a run that was
    stopped. The default is one job: times are comparable only if cells are solved one by one.

    Args:
        experiment: a name (`paper`, `radius-sweep`, ...) or the path of a TOML file. It may be left
            out if `scenarios` and `solvers` are given.
        out: the results folder; `results/<name>` by default, where the name is that of the
            experiment, or of the file of scenarios.
        solvers: specs that replace those of the experiment.
        jobs: how many processes solve cells at the same time.
        time_limit: seconds that a solve may take, instead of the experiment's limit.
        memory_limit: GiB that a worker process and its children may hold, instead of the
            experiment's limit.
        repeats: how often each question is asked, instead of the experiment's number.
        restart: delete the rows that the folder holds.
        trust_plugins: let the experiment's file name plug-in files and programs on PATH as
            solvers. Those named in `solvers` are always trusted.
        executor: `local`, or `dask` for the workers of a Dask scheduler.
        scheduler: the address of that scheduler.
        scenarios: a .csv or .parquet file of scenarios (`definition.scenario_file`), which replace
            those of the experiment.
        progress: called with the number of cells done and the number of all cells.
        engine: the old word for `executor`, with a warning.

    Raises:
        ExperimentError, SolverError, ScenarioError, ResultsError: if the request or the folder is
            not valid.
        RunError: if worker processes end before their first job, or Dask fails.
        KeyboardInterrupt: after SIGINT (Ctrl-C) or SIGTERM, once the cell that is being solved is
            finished and all rows are written; a second signal abandons that cell. The caller's
            signal handlers are restored. Signals are handled in the main thread only.
    """
    arguments = {name: value for name, value in locals().items() if name in Request._fields}
    if engine is not None:
        warnings.warn(OLD_WORD, FutureWarning, stacklevel=2)
        arguments["executor"] = engine
    request = Request(**arguments)
    with Interruption() as stop:
        plan = plan_run(request)
        stop.check()
        with _executor(request) as opened:
            prepare_folder(plan.folder)
            with locked(plan.folder):
                _solve(plan, request, opened, progress, stop)
    return plan.folder


def _executor(request: Request) -> AbstractContextManager[Executor]:
    if request.scheduler is None:
        return local_executor(request.jobs)
    # Imported only if needed: `distributed` is an extra and takes half a second to import.
    from dubins_study.experiments.executors.dask_executor import dask_executor

    return dask_executor(request.scheduler)


def _solve(
    plan: RunPlan,
    request: Request,
    executor: Executor,
    progress: Progress | None,
    stop: Interruption,
) -> None:
    """Solve the cells, and write their rows.

    Rows are written as they come, then united in one part. The folder is locked by the caller.
    """
    folder = plan.folder
    experiment = plan.experiment_file.experiment
    rising = experiment.rising
    manifest, repairs = open_folder(folder, _new_manifest(plan, request.command()), request.restart)
    for repair in repairs:
        _LOG.warning("dubins-study: %s", repair)
    settings = RunSettings(
        run_id=uuid4().hex[:12],
        jobs=executor.jobs,
        executor=request.executor,
        **experiment.model_dump(include={"time_limit_s", "memory_limit_gib", "seed"}),
    )
    keys = plan.keys
    done_keys = done(folder)
    cells_left = len(keys - done_keys)
    _LOG.info(
        "%s into %s: %d cells, %d of them to solve, with %s",
        plan.experiment_file.name,
        folder,
        len(keys),
        cells_left,
        settings,
    )
    totals = count_by_code(keys | done_keys)
    manifest, completes = count_cells(manifest, set(plan.solver_specs), totals)
    if cells_left < len(keys):
        for sentence in _other_limits(manifest, settings):
            _LOG.warning("dubins-study: %s: %s", folder, sentence)
    writer = PartWriter(folder, settings.run_id, len(keys), progress)
    writer.skip(keys & done_keys)
    # A run that solves no cell is recorded only if it finishes the folder. It cannot if the folder
    # is finished already, nor if cells of another solver are left.
    finishes = completes and manifest.finished is None
    nothing_to_record = not cells_left and not finishes
    if nothing_to_record:
        return
    entry = RunEntry(
        command=request.command(),
        threads=THREADS,
        **{name: value for name, value in settings._asdict().items() if name != "seed"},
        **executor.run_entry,
    )
    with RunRecord(folder, manifest, entry, completes) as record:
        try:
            with threadpool_limits(THREADS):  # of the check, which is made in this process
                for chains in stages(plan.chains, rising):
                    unit = WorkUnit(settings, chains).remaining(done_keys)
                    unit = unit._replace(chains=shuffled(unit.chains, settings.seed))
                    if rising:
                        writer.flush()  # the verdicts so far decide which cells are asked
                        unit, rows = not_asked(folder, unit)
                        writer.add(rows)
                    if not unit.chains:
                        continue
                    with closing(executor.solve(unit, stop, record.probe)) as row_blocks:
                        for rows in row_blocks:
                            writer.add(rows)
                            record.write_now_and_then()
                    stop.check()
        except RunError as error:
            raise RunError(f"{error}; the rows written so far are kept") from None
        finally:
            writer.flush()
        compact(folder, settings.run_id)
        _LOG.info("run %s is done: its rows are one part of %s", settings.run_id, folder)


def _other_limits(manifest: Manifest, settings: RunSettings) -> Iterator[str]:
    """Yield sentences about earlier runs' other limits.

    A sentence names the limits of the earlier runs and the one that is asked for.
    """
    for name, limit, unit in (
        ("time_limit_s", "time limit", "s"),
        ("memory_limit_gib", "memory limit", "GiB"),
    ):
        current = getattr(settings, name)
        earlier = sorted({getattr(entry, name) for entry in manifest.runs} - {current})
        if earlier:
            limits = " and ".join(f"{value:g}" for value in earlier)
            yield (
                f"rows are there of a {limit} of {limits} {unit}, and stay beside {current:g} "
                f"{unit}; --restart solves them again"
            )


def _new_manifest(plan: RunPlan, command: str) -> Manifest:
    """The manifest of a folder with only this experiment.

    The cells are not counted yet.
    """
    profile = plan.experiment_file.experiment.profile
    solvers = {spec: describe_solver(spec, profile) for spec in plan.solver_specs}
    packages = {*chain.from_iterable(solver.packages for solver in solvers.values())}
    entries = {
        spec: SolverEntry(
            settings=solver.settings,
            code_digest=solver.code_digest,
            packages=versions_of(solver.packages),
        )
        for spec, solver in solvers.items()
    }
    return new_manifest(plan.experiment_file, command, entries, tuple(sorted(packages)))


def new_manifest(
    file: ExperimentFile,
    command: str,
    solvers: dict[str, SolverEntry],
    packages: tuple[str, ...] = (),
) -> Manifest:
    """The manifest of a folder about an experiment.

    `solvers` has the entries by spec. The versions of `packages` are recorded. Cells are counted
    later.
    """
    experiment = file.experiment
    pairs = []
    if experiment.matrix:
        pairs = matrix()
    return Manifest(
        experiment=Definition(
            name=file.name,
            text=file.text,
            **experiment.model_dump(include={"title", "question", "section"}),
        ),
        command=command,
        **experiment.model_dump(include={"seed", "time_limit_s", "memory_limit_gib", "profile"}),
        gap_tolerance=tolerances(experiment.profile).gap,
        cells=0,
        matrix=pairs,
        solvers=solvers,
        versions=versions(packages),
        machine=machine(),
        git=source(),
        created=now(),
    )

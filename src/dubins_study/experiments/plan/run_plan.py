"""Check a request, and list the cells of its run."""

from __future__ import annotations

import shlex
from collections import Counter
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from dubins_study.experiments.definition.experiment import (
    ExperimentError,
    ExperimentFile,
    validated,
)
from dubins_study.experiments.definition.scenario_file import listed_experiment
from dubins_study.experiments.plan.cells import Chain, chains
from dubins_study.experiments.plan.file_checks import read_checked, refused
from dubins_study.experiments.plan.solver_description import expand_solvers
from dubins_study.experiments.run_settings import EXECUTOR_NAMES
from dubins_study.solvers.registry import SolverError
from dubins_study.study.rows.schema import Key
from dubins_study.study.values import did_you_mean


class Request(NamedTuple):
    """The arguments of `experiments.run.run`; None means the value in the experiment's file."""

    experiment: str | FilePath | None = None
    out: str | FilePath | None = None
    solvers: list[str] | None = None
    jobs: int = 1
    time_limit_s: float | None = None
    memory_limit_gib: float | None = None
    repeats: int | None = None
    restart: bool = False
    trust_plugins: bool = False
    engine: str = "local"
    scheduler: str | None = None
    scenarios: str | FilePath | None = None

    def command(self) -> str:
        """The command line that asks for the same rows.

        It leaves out the results folder and the address of a scheduler, which is private.
        """
        arguments = ["dubins-study", "run"]
        if self.experiment is not None:
            arguments.append(str(self.experiment))
        if self.scenarios is not None:
            arguments += ["--scenarios", str(self.scenarios)]
        for spec in self.solvers or ():
            arguments += ["--solver", spec]
        options = {
            "--jobs": self.jobs,
            "--time-limit": self.time_limit_s,
            "--memory-limit": self.memory_limit_gib,
            "--repeats": self.repeats,
            "--engine": self.engine if self.engine != "local" else None,
        }
        for option, value in options.items():
            if value:
                arguments += [option, str(value)]
        if self.trust_plugins:
            arguments.append("--trust-plugins")
        return shlex.join(arguments)

    def check(self) -> None:
        """Refuse arguments of the wrong type, and a scheduler for an engine that uses none."""
        name, listed, jobs = self.experiment, self.scenarios, self.jobs
        engine, scheduler = self.engine, self.scheduler
        is_name = isinstance(name, str | FilePath)
        problem = None
        if not isinstance(listed, str | FilePath | None):
            problem = f"scenarios is {listed!r}; expected the path of a .csv or .parquet file"
        elif listed is not None and not is_name and self.solvers is None:
            problem = (
                f"scenarios is {str(listed)!r}, without solvers; expected solvers "
                "(--solver ipopt) or an experiment whose solvers are asked"
            )
        elif not is_name and (listed is None or name is not None):
            problem = f"experiment is {name!r}; expected a name or the path of a .toml file"
        elif not isinstance(self.out, str | FilePath | None):
            problem = f"out is {self.out!r}; expected the path of a folder"
        elif not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1:
            problem = f"jobs is {jobs!r}; expected a whole number of processes above 0"
        elif engine not in EXECUTOR_NAMES:
            near = did_you_mean(engine, EXECUTOR_NAMES)
            problem = f"engine is {engine!r}; {near}expected one of: {', '.join(EXECUTOR_NAMES)}"
        elif scheduler is not None and (not isinstance(scheduler, str) or not scheduler):
            problem = (
                f"scheduler is {scheduler!r}; expected an address such as tcp://127.0.0.1:8786"
            )
        elif scheduler is not None and engine != "dask":
            problem = (
                f"scheduler is {scheduler!r} and engine {engine!r}; only engine 'dask' has a "
                "scheduler"
            )
        elif scheduler is not None and jobs != 1:
            problem = (
                f"jobs is {jobs}; how many cells are solved side by side is for the cluster of "
                f"scheduler {scheduler!r} to say, so leave it out"
            )
        if problem is not None:
            raise ExperimentError(problem)


class RunPlan(NamedTuple):
    """Everything that a run has to solve: an experiment as requested, and all its cells."""

    experiment_file: ExperimentFile
    folder: FilePath
    chains: list[Chain]

    @property
    def keys(self) -> set[Key]:
        """The keys of all cells."""
        return {cell.key for chain in self.chains for cell in chain}

    @property
    def rows(self) -> int:
        """How many rows there will be."""
        return sum(map(len, self.chains))

    @property
    def solver_specs(self) -> list[str]:
        """The canonical specs of all solvers, each once."""
        return list(dict.fromkeys(cell.solver for chain in self.chains for cell in chain))


def cell_counts(keys: set[Key]) -> Counter[tuple[str, str]]:
    """How many cells there are by solver and code digest."""
    return Counter((solver, digest) for _, solver, *_, digest in keys)


def plan_run(request: Request) -> RunPlan:
    """The cells that a request asks for; errors name the argument, or the file and key."""
    request.check()
    own_solvers = request.solvers is None
    name = None if request.experiment is None else str(request.experiment)
    file = None if name is None else read_checked(name, request.trust_plugins, own_solvers)
    if request.scenarios is not None:
        file = listed_experiment(str(request.scenarios), file, request.solvers)
    assert file is not None  # as `Request.check` has seen to
    experiment_file = _changed(file, request)
    experiment = experiment_file.experiment
    if request.solvers is not None:
        # Checked here so that an error message does not name the experiment's file.
        expand_solvers(request.solvers, experiment.profile)
    try:
        cell_chains = chains(experiment)
    except (ExperimentError, SolverError):
        raise refused(experiment_file) from None
    folder = (
        FilePath("results") / experiment_file.name if request.out is None else FilePath(request.out)
    )
    return RunPlan(experiment_file, folder, cell_chains)


def _changed(experiment_file: ExperimentFile, request: Request) -> ExperimentFile:
    """The experiment with the request's solvers, limits and repeats, checked like the file's."""
    requested = {
        "solvers": request.solvers,
        "time_limit_s": request.time_limit_s,
        "memory_limit_gib": request.memory_limit_gib,
        "repeats": request.repeats,
    }
    changes: dict[str, Any] = {key: value for key, value in requested.items() if value is not None}
    if not changes:
        return experiment_file
    experiment = experiment_file.experiment
    blocks = experiment.scenarios
    if request.solvers is not None:
        blocks = [block.model_copy(update={"solvers": None}) for block in blocks]
        changes["first"] = None
    changed = validated(experiment_file.name, dict(experiment) | {"scenarios": blocks} | changes)
    return experiment_file._replace(experiment=changed)

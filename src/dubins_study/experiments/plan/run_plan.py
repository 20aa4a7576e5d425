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
        """Refuse arguments of the wrong type, and a scheduler for an engine that uses none.

        Raises:
            ExperimentError: naming the argument, its value and what was expected.
        """
        out, jobs, engine, scheduler = self.out, self.jobs, self.engine, self.scheduler
        is_number = isinstance(jobs, int) and not isinstance(jobs, bool)
        is_address = isinstance(scheduler, str) and scheduler != ""
        no_scheduler = scheduler is None
        name, is_name = self.experiment, isinstance(self.experiment, str | FilePath)
        listed = self.scenarios is not None
        requirements = (
            (
                self.scenarios is None or isinstance(self.scenarios, str | FilePath),
                f"scenarios is {self.scenarios!r}; expected the path of a .csv or .parquet file",
            ),
            (
                not listed or is_name or self.solvers is not None,
                f"scenarios is {str(self.scenarios)!r}, without solvers; expected solvers "
                "(--solver ipopt) or an experiment whose solvers are asked",
            ),
            (
                is_name or (listed and name is None),
                f"experiment is {name!r}; expected a name or the path of a .toml file",
            ),
            (
                out is None or isinstance(out, str | FilePath),
                f"out is {out!r}; expected the path of a folder",
            ),
            (
                is_number and jobs >= 1,
                f"jobs is {jobs!r}; expected a whole number of processes above 0",
            ),
            (
                engine in EXECUTOR_NAMES,
                f"engine is {engine!r}; {did_you_mean(engine, EXECUTOR_NAMES)}expected one of: "
                f"{', '.join(EXECUTOR_NAMES)}",
            ),
            (
                no_scheduler or is_address,
                f"scheduler is {scheduler!r}; expected an address such as tcp://127.0.0.1:8786",
            ),
            (
                no_scheduler or engine == "dask",
                f"scheduler is {scheduler!r} and engine {engine!r}; only engine 'dask' has a "
                "scheduler",
            ),
            (
                no_scheduler or jobs == 1,
                f"jobs is {jobs}; how many cells are solved side by side is for the cluster of "
                f"scheduler {scheduler!r} to say, so leave it out",
            ),
        )
        for holds, problem in requirements:
            if not holds:
                raise ExperimentError(problem)


class RunPlan(NamedTuple):
    """Everything that a run has to solve.

    Args:
        experiment_file: the experiment with the changes of the request.
        folder: the results folder.
        chains: all cells, solved already or not.
    """

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
    """The cells that a request asks for.

    Raises:
        ExperimentError, SolverError: naming the argument, or the file and key; its value, and what
            was expected.
    """
    request.check()
    experiment_file = _changed(_read(request), request)
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


def _read(request: Request) -> ExperimentFile:
    """The experiment of a request, about the scenarios of a file if the request names one."""
    name = None if request.experiment is None else str(request.experiment)
    own_solvers = request.solvers is None
    file = None if name is None else read_checked(name, request.trust_plugins, own_solvers)
    if request.scenarios is None:
        assert file is not None  # as `Request.check` has seen to
        return file
    return listed_experiment(str(request.scenarios), file, request.solvers)


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

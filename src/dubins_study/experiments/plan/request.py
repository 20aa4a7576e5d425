"""What a caller of `run` asks for: checked, written into the experiment, expanded."""

from __future__ import annotations

import shlex
from pathlib import Path as FilePath
from typing import NamedTuple

from dubins_study.experiments.definition.experiment import (
    Experiment,
    ExperimentError,
    Source,
    read,
    validated,
)
from dubins_study.experiments.engines.engine import ENGINES
from dubins_study.experiments.engines.stream import Stream, streams
from dubins_study.experiments.plan.cells import Chain, chains
from dubins_study.experiments.plan.solver_specs import expand_solvers, foreign
from dubins_study.solvers.registry import SolverError


class Request(NamedTuple):
    """The arguments of `run` that decide which rows there will be."""

    experiment: str | FilePath
    solvers: list[str] | None
    jobs: int
    time_limit_s: float | None
    memory_limit_gib: float | None
    repeats: int | None
    trust: bool = False
    engine: str = "local"
    scheduler: str | None = None

    def command(self) -> str:
        """The command line that asks for the same rows; where they are put is left out.

        So is a scheduler's address, which is nobody else's business.
        """
        words = ["dubins-study", "run", str(self.experiment)]
        words += [word for spec in self.solvers or () for word in ("--solver", spec)]
        options = {
            "--jobs": self.jobs,
            "--time-limit": self.time_limit_s,
            "--memory-limit": self.memory_limit_gib,
            "--repeats": self.repeats,
            "--engine": self.engine if self.engine != "local" else None,
        }
        words += [word for key, value in options.items() if value for word in (key, str(value))]
        words += ["--trust-plugins"] * self.trust
        return shlex.join(words)


def accepted(request: Request, out: object) -> tuple[Source, list[Chain], list[Stream]]:
    """The experiment as the request changes it, all its cells, and what is streamed instead.

    Raises:
        ExperimentError, SolverError: naming the argument or the file and key, its value, and what
            was expected.
    """
    _check_types(request, out)
    found = _changed(read(str(request.experiment)), request)
    if request.solvers is not None:
        # before the file is: it is not to blame for these
        expand_solvers(request.solvers, found.experiment.profile)
    try:
        if request.solvers is None and not request.trust:
            _refuse_foreign(found)
        return found, chains(found.experiment), streams(found.experiment)
    except (ExperimentError, SolverError) as error:
        raise type(error)(f"{found.file}: {error}") from None


def _refuse_foreign(found: Source) -> None:
    """An experiment may come from anyone; what it makes run is for the caller to say."""
    experiment = found.experiment
    lists = {"solvers": experiment.solvers} | {
        f"scenarios.{number}.solvers": block.solvers or []
        for number, block in enumerate(experiment.scenarios)
    }
    for key, specs in lists.items():
        try:
            name = foreign(specs, experiment.profile)
        except SolverError as error:
            raise SolverError(f"{key}: {error}") from None
        if name is not None:
            raise ExperimentError(
                f"{key}: {name} runs a program or file that is not this package's; expected "
                "--trust-plugins, if you know what it is, or your own choice of --solver"
            )


def _check_types(request: Request, out: object) -> None:
    if not isinstance(request.experiment, str | FilePath):
        raise ExperimentError(
            f"experiment is {request.experiment!r}; expected a name or the path of a .toml file"
        )
    if not (out is None or isinstance(out, str | FilePath)):
        raise ExperimentError(f"out is {out!r}; expected the path of a folder")
    jobs = request.jobs
    if isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1:
        raise ExperimentError(f"jobs is {jobs!r}; expected a whole number of processes above 0")
    _check_engine(request)


def _check_engine(request: Request) -> None:
    engine, scheduler, jobs = request.engine, request.scheduler, request.jobs
    if not isinstance(engine, str) or engine not in ENGINES:
        raise ExperimentError(f"engine is {engine!r}; expected one of: {', '.join(ENGINES)}")
    if scheduler is None:
        return
    if not (isinstance(scheduler, str) and scheduler):
        raise ExperimentError(
            f"scheduler is {scheduler!r}; expected an address such as tcp://127.0.0.1:8786"
        )
    if engine != "dask":
        raise ExperimentError(
            f"scheduler is {scheduler!r} and engine {engine!r}; only engine 'dask' has a scheduler"
        )
    if jobs != 1:
        raise ExperimentError(
            f"jobs is {jobs}; how many cells are solved side by side is for the cluster of "
            f"scheduler {scheduler!r} to say, so leave it out"
        )


def _changed(found: Source, request: Request) -> Source:
    """The experiment with the caller's own solvers, limit and repeats, checked like the file's."""
    solvers = request.solvers
    named = ("time_limit_s", "memory_limit_gib", "repeats")
    given = {"solvers": solvers} | {name: getattr(request, name) for name in named}
    changes = {key: value for key, value in given.items() if value is not None}
    if not changes:
        return found
    fields = {name: getattr(found.experiment, name) for name in Experiment.model_fields}
    blocks = found.experiment.scenarios
    if solvers is not None:
        blocks = [block.model_copy(update={"solvers": None}) for block in blocks]
    changed = fields | {"scenarios": blocks} | changes
    return found._replace(experiment=validated(found.name, changed))

"""The arguments of `run`, checked, and the command line that means the same."""

from __future__ import annotations

import shlex
from pathlib import Path as FilePath
from typing import NamedTuple

from dubins_study.experiments.definition.experiment import ExperimentError
from dubins_study.experiments.run_settings import ENGINE_NAMES


class Request(NamedTuple):
    """The arguments of `experiments.run.run`; None where the experiment's own value holds."""

    experiment: str | FilePath
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

    def command(self) -> str:
        """The command line that asks for the same rows.

        It leaves out where the rows are put, and the address of a scheduler, which is private.
        """
        arguments = ["dubins-study", "run", str(self.experiment)]
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
        """Refuse arguments of the wrong type, and engines and schedulers that do not fit together.

        Raises:
            ExperimentError: naming the argument, its value and what was expected.
        """
        if not isinstance(self.experiment, str | FilePath):
            raise ExperimentError(
                f"experiment is {self.experiment!r}; expected a name or the path of a .toml file"
            )
        if not (self.out is None or isinstance(self.out, str | FilePath)):
            raise ExperimentError(f"out is {self.out!r}; expected the path of a folder")
        jobs = self.jobs
        if isinstance(jobs, bool) or not isinstance(jobs, int) or jobs < 1:
            raise ExperimentError(f"jobs is {jobs!r}; expected a whole number of processes above 0")
        self._check_engine()

    def _check_engine(self) -> None:
        engine, scheduler = self.engine, self.scheduler
        if not isinstance(engine, str) or engine not in ENGINE_NAMES:
            raise ExperimentError(
                f"engine is {engine!r}; expected one of: {', '.join(ENGINE_NAMES)}"
            )
        if scheduler is None:
            return
        if not (isinstance(scheduler, str) and scheduler):
            raise ExperimentError(
                f"scheduler is {scheduler!r}; expected an address such as tcp://127.0.0.1:8786"
            )
        if engine != "dask":
            raise ExperimentError(
                f"scheduler is {scheduler!r} and engine {engine!r}; only engine 'dask' has a "
                "scheduler"
            )
        if self.jobs != 1:
            raise ExperimentError(
                f"jobs is {self.jobs}; how many cells are solved side by side is for the cluster "
                f"of scheduler {scheduler!r} to say, so leave it out"
            )

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
        jobs, engine, scheduler = self.jobs, self.engine, self.scheduler
        requirements = (
            (
                isinstance(self.experiment, str | FilePath),
                f"experiment is {self.experiment!r}; expected a name or the path of a .toml file",
            ),
            (
                self.out is None or isinstance(self.out, str | FilePath),
                f"out is {self.out!r}; expected the path of a folder",
            ),
            (
                isinstance(jobs, int) and not isinstance(jobs, bool) and jobs >= 1,
                f"jobs is {jobs!r}; expected a whole number of processes above 0",
            ),
            (
                engine in ENGINE_NAMES,
                f"engine is {engine!r}; expected one of: {', '.join(ENGINE_NAMES)}",
            ),
            (
                scheduler is None or (isinstance(scheduler, str) and scheduler != ""),
                f"scheduler is {scheduler!r}; expected an address such as tcp://127.0.0.1:8786",
            ),
            (
                scheduler is None or engine == "dask",
                f"scheduler is {scheduler!r} and engine {engine!r}; only engine 'dask' has a "
                "scheduler",
            ),
            (
                scheduler is None or jobs == 1,
                f"jobs is {jobs}; how many cells are solved side by side is for the cluster of "
                f"scheduler {scheduler!r} to say, so leave it out",
            ),
        )
        for holds, problem in requirements:
            if not holds:
                raise ExperimentError(problem)

"""Check a request, and list its run's cells."""

from __future__ import annotations

import hashlib
import itertools
import logging
import shlex
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path as FilePath
from typing import Any, NamedTuple

from pydantic import ValidationError

from dubins_study.experiments.definition.experiment import (
    TABLE_KEYS,
    Experiment,
    ExperimentError,
    ExperimentFile,
    fields_of,
    text_of,
)
from dubins_study.experiments.definition.messages import problems_of, refusal
from dubins_study.experiments.definition.scenario_block import HOW_ASKED, ListedBlock
from dubins_study.experiments.definition.scenario_file import read_scenarios, text_about
from dubins_study.experiments.plan.cells import Chain, chains
from dubins_study.experiments.plan.scenarios import scenario_id, scenarios
from dubins_study.experiments.plan.solver_description import (
    check_spec,
    expand_solvers,
    why_unavailable,
)
from dubins_study.solvers.registry import SolverError
from dubins_study.study.rows.schema import Key
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import PROFILES
from dubins_study.study.values import did_you_mean

_LOG = logging.getLogger(__name__)
# The executors that can solve cells: worker processes of this machine, or a Dask cluster.
_EXECUTOR_NAMES = ("local", "dask")
# Key of an experiment that a request may replace -> the argument that replaces it.
_ARGUMENTS = {
    "solvers": "solvers",
    "time_limit_s": "time_limit",
    "memory_limit_gib": "memory_limit",
    "repeats": "repeats",
}


class RunSettings(NamedTuple):
    """The settings of one run.

    All cells and rows of the run share them.
    """

    run_id: str
    time_limit_s: float  # of one solve
    memory_limit_gib: float = 4.0  # of a worker process and its children
    jobs: int = 1  # cells that are solved at the same time
    executor: str = "local"
    seed: int = 0  # of the random order of the cells


class Request(NamedTuple):
    """The arguments of `experiments.run.run`.

    None means the value in the experiment's file.
    """

    experiment: str | FilePath | None = None
    out: str | FilePath | None = None
    solvers: list[str] | None = None
    jobs: int = 1
    time_limit: float | None = None
    memory_limit: float | None = None
    repeats: int | None = None
    restart: bool = False
    trust_plugins: bool = False
    executor: str = "local"
    scheduler: str | None = None
    scenarios: str | FilePath | None = None

    def command(self) -> str:
        """The command line that asks for these rows.

        The results folder, the scheduler's address and `--restart` are left out.
        """
        arguments = ["dubins-study", "run"]
        if self.experiment is not None:
            arguments.append(str(self.experiment))
        for spec in self.solvers or ():
            arguments += ["--solver", spec]
        options = {
            "--scenarios": self.scenarios,
            "--jobs": self.jobs,
            "--time-limit": self.time_limit,
            "--memory-limit": self.memory_limit,
            "--repeats": self.repeats,
        }
        if self.executor != "local":
            options["--executor"] = self.executor
        for option, value in options.items():
            if value:
                arguments += [option, str(value)]
        if self.trust_plugins:
            arguments.append("--trust-plugins")
        return shlex.join(arguments)

    def check(self) -> None:
        """Refuse arguments that are wrong or contradict."""
        name = self.experiment
        listed = self.scenarios
        jobs = self.jobs
        executor = self.executor
        scheduler = self.scheduler
        is_name = isinstance(name, str | FilePath)
        if listed is not None and not is_name and self.solvers is None:
            raise ExperimentError(
                f"scenarios is {str(listed)!r}, without solvers; expected solvers "
                "(--solver ipopt) or an experiment whose solvers are asked"
            )
        if not is_name and (listed is None or name is not None):
            raise ExperimentError(
                f"experiment is {name!r}; expected a name or the path of a .toml file"
            )
        if not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1:
            raise ExperimentError(f"jobs is {jobs!r}; expected a whole number of processes above 0")
        if executor not in _EXECUTOR_NAMES:
            near = did_you_mean(executor, _EXECUTOR_NAMES)
            raise ExperimentError(
                f"executor is {executor!r}; {near}expected one of: {', '.join(_EXECUTOR_NAMES)}"
            )
        if bool(scheduler) != (executor == "dask"):
            raise ExperimentError(
                f"scheduler is {scheduler!r} and executor {executor!r}; expected executor 'dask' "
                "and the address of a scheduler, such as tcp://127.0.0.1:8786, or neither"
            )
        if scheduler is not None and jobs != 1:
            raise ExperimentError(
                f"jobs is {jobs}; how many cells are solved side by side is for the cluster of "
                f"scheduler {scheduler!r} to say, so leave it out"
            )


class RunPlan(NamedTuple):
    """An experiment as requested, and all its cells."""

    experiment_file: ExperimentFile
    folder: FilePath
    chains: list[Chain]

    @property
    def keys(self) -> set[Key]:
        """The keys of all cells."""
        return {cell.key for cell in itertools.chain.from_iterable(self.chains)}

    @property
    def solver_specs(self) -> list[str]:
        """The canonical specs of all solvers, each once."""
        cells = itertools.chain.from_iterable(self.chains)
        return list(dict.fromkeys(cell.solver for cell in cells))


def plan_run(request: Request) -> RunPlan:
    """Check a request, and plan its run.

    Errors name the argument, or the file and key.
    """
    request.check()
    # key of the experiment -> value of the argument that replaces it
    replaced = {key: getattr(request, argument) for key, argument in _ARGUMENTS.items()}
    changes = {key: value for key, value in replaced.items() if value is not None}
    if request.scenarios is None:
        file = _checked(text_of(str(request.experiment)), request.trust_plugins, changes)
    else:
        file = _about_a_file(str(request.scenarios), request, changes)
    cell_chains = chains(file.experiment, file.path, file.text)
    if request.executor == "local":
        _refuse_unavailable(request.solvers or (), file.experiment.profile)
    folder = FilePath("results") / file.name
    if request.out is not None:
        folder = FilePath(request.out)
    return RunPlan(file, folder, cell_chains)


def _refuse_unavailable(specs: Iterable[str], profile: str) -> None:
    """Refuse a named solver that cannot run here.

    A solver of `*` or of the experiment's file is not refused: its rows have the outcome
    `unavailable`.
    """
    single = [spec for spec in specs if spec != "*"]
    for spec in expand_solvers(single, profile):
        if reason := why_unavailable(spec, profile):
            raise SolverError(f"solver {spec!r} is unavailable: {reason}")


def _about_a_file(listed_in: str, request: Request, changes: dict[str, Any]) -> ExperimentFile:
    """The experiment that asks about a file of scenarios.

    The scenarios replace those of the requested experiment. If none is requested, the experiment
    asks the requested solvers. `changes` are keys with new values.
    """
    listed = read_scenarios(listed_in)
    name = FilePath(listed_in).stem
    about = request.experiment
    source = text_about(listed_in)
    if about is not None:
        source = text_of(str(about))
    defaults = {"scenarios": [ListedBlock(listed=listed)]}
    file = _checked(source, request.trust_plugins, changes, defaults)
    title = file.experiment.title
    if about is not None:
        title = f"{title}: scenarios of {name}"
    replaced = {
        "title": title,
        "scenarios": _listed_blocks(listed, file),
        "first": None,
        "section": None,
        "matrix": False,
    }
    experiment = file.experiment.model_copy(update=replaced)
    return ExperimentFile(name, listed_in, _comment_on(listed) + file.text, experiment)


def _comment_on(listed: list[Scenario]) -> str:
    """A TOML comment with a digest of scenarios.

    Put before the experiment's text, it makes experiments about other scenarios differ: their rows
    do not go into the same folder.
    """
    digest = hashlib.sha256(" ".join(map(scenario_id, listed)).encode()).hexdigest()[:16]
    return f"# about {len(listed)} scenarios with the digest {digest}\n"


def _listed_blocks(listed: list[Scenario], file: ExperimentFile) -> list[ListedBlock]:
    """Blocks for the scenarios of a file.

    A scenario that is also in a block of the experiment is asked with that block's settings. A
    sample of a suite thus keeps the time limit and the branches of each question. All others are
    asked with the experiment's settings.
    """
    experiment = file.experiment
    settings = [
        block.model_dump(include=set(HOW_ASKED), exclude_none=True)
        for block in experiment.scenarios
    ]
    if not any(settings):
        return [ListedBlock(listed=listed)]
    blocks = []
    of_experiment: set[Scenario] = set()
    for number, block in enumerate(experiment.scenarios):
        of_block = set(scenarios(block, f"scenarios.{number}"))
        common = [scenario for scenario in listed if scenario in of_block]
        if common:
            blocks.append(ListedBlock(listed=common, **settings[number]))
        of_experiment |= of_block
    unmatched = [scenario for scenario in listed if scenario not in of_experiment]
    if unmatched:
        blocks.append(ListedBlock(listed=unmatched))
        _LOG.warning(
            "dubins-study: %d of %d scenarios are none of %s; they are asked with its general "
            "settings (time_limit_s = %g)",
            len(unmatched),
            len(listed),
            file.name,
            experiment.time_limit_s,
        )
    return blocks


def read_checked(name: str, trust_plugins: bool) -> ExperimentFile:
    """Read an experiment, and check its solvers too.

    See `definition.experiment.read`.
    """
    return _checked(text_of(name), trust_plugins, {})


def _checked(
    source: tuple[str, str, str],
    trust_plugins: bool,
    changes: Mapping[str, Any],
    defaults: Mapping[str, Any] | None = None,
) -> ExperimentFile:
    """The experiment of a file, with some keys changed.

    `source` is the result of `text_of`. `changes` replace keys of the file; `solvers` and
    `time_limit_s` are then removed from its blocks. `defaults` are values of keys that the file
    lacks. Scenarios are not made here.
    """
    _, path, text = source
    fields = {**(defaults or {}), **fields_of(path, text), **changes}
    if "solvers" in changes:  # they replace the solvers of `first` and of all blocks too
        fields.pop("first", None)
    blocks = fields.get("scenarios")
    if not isinstance(blocks, list):
        blocks = []
    for block in blocks:
        for key in {"solvers", "time_limit_s"} & changes.keys():
            if isinstance(block, dict):
                block.pop(key, None)
    profile = fields.get("profile")
    if not isinstance(profile, str) or profile not in PROFILES:
        profile = "default"
    check = None
    if "solvers" not in changes:
        check = partial(check_spec, profile=profile, trust_plugins=trust_plugins)
    try:
        experiment = Experiment.model_validate(fields, context=check)
    except ValidationError as error:
        raise ExperimentError(_mistakes(error, path, text, changes)) from None
    if "solvers" in changes:
        expand_solvers(experiment.solvers, experiment.profile)  # refused without the file's name
    return ExperimentFile(*source, experiment)


def _mistakes(error: ValidationError, path: str, text: str, changes: Mapping[str, Any]) -> str:
    """A message about the mistakes of a request.

    Mistakes of the file are named only if the request's `changes` have none.
    """
    problems = problems_of(error, TABLE_KEYS)
    requested = [each.sentence for each in problems if each.path and each.path[0] in changes]
    return "; ".join(requested) or refusal(path, problems, text)

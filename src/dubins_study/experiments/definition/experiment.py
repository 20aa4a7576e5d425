"""An experiment, checked key by key from its file."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from pydantic import Field, ValidationError, ValidationInfo, field_validator

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.definition.axes import (
    Count,
    Gibibytes,
    Seconds,
    SectionName,
    Seed,
    SolverSpecs,
    StrictModel,
)
from dubins_study.experiments.definition.messages import problems_of, refusal
from dubins_study.experiments.definition.scenario_block import (
    DRAWN,
    Block,
    Branches,
    GuessLengths,
    Route,
    Sample,
    Tour,
)
from dubins_study.study.tolerances import PROFILES
from dubins_study.study.values import did_you_mean

if TYPE_CHECKING:
    ProfileName = str
else:
    ProfileName = Literal[tuple(PROFILES)]


class ExperimentError(DubinsStudyError, ValueError):
    """The experiment does not exist or is not valid.

    The message names file, key and value.
    """


def packaged() -> list[str]:
    """Sorted names of the experiments in the package."""
    return sorted(_packaged_files())


def _packaged_files() -> dict[str, Any]:
    """The package's TOML files by the experiment's name."""
    return {
        file.name.removesuffix(".toml"): file
        for file in files("dubins_study.experiments").iterdir()
        if file.name.endswith(".toml")
    }


def fields_of(path: str, text: str) -> dict[str, Any]:
    """The keys of a TOML file and their values.

    Text that is not TOML is refused at once.
    """
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also: a number too long, or deep nesting
        raise ExperimentError(
            f"{path}: not TOML: {error}; mend this first: nothing behind it can be read"
        ) from None


def text_of(name: str) -> tuple[str, str, str]:
    """Name, path and text of an experiment.

    Returns the first three fields of `ExperimentFile`. `name` is that of an experiment in the
    package, or the path of any TOML file.
    """
    packaged_file = _packaged_files().get(name)
    if packaged_file is not None:
        return name, packaged_file.name, packaged_file.read_text(encoding="utf-8")
    path = FilePath(name)
    # The results folder is named after the stem; "." and ".." cannot name a new folder.
    if path.suffix != ".toml" or path.stem in (".", ".."):
        raise ExperimentError(
            f"no experiment named {name!r}; {did_you_mean(name, packaged())}choose one of: "
            f"{', '.join(packaged())}, or give the path of a .toml file"
        )
    try:
        return path.stem, name, path.read_text(encoding="utf-8-sig")
    except UnicodeError:
        raise ExperimentError(f"experiment {name}: cannot be read: it is not UTF-8 text") from None
    except (OSError, ValueError) as error:  # ValueError: a path that cannot be
        reason = getattr(error, "strerror", None) or error
        raise ExperimentError(f"experiment {name}: cannot be read: {reason}") from None


class First(StrictModel):
    """Solvers that are asked only the first drawn scenarios.

    These are solvers such as slow ones. The first scenarios of a Sobol sample cover its ranges as
    well.
    """

    scenarios: Count
    """How many of the first scenarios of each sample, and of each number of legs or points."""
    solvers: SolverSpecs
    """The solvers that are asked these only."""


class Experiment(StrictModel):
    """The keys of an experiment's TOML file."""

    title: str = Field(min_length=1)
    """Title of the experiment's part of the report."""
    question: str = Field(min_length=1)
    """The question that the experiment answers, in a sentence."""
    section: SectionName | None = None
    """Key of a section of the report about this kind of experiment, such as `benchmark`."""
    scenarios: list[Block] = Field(min_length=1)
    """The scenarios, block by block."""
    solvers: SolverSpecs
    """Specs of the solvers; `*` is every registered one, `{a,b}` one with a and one with b."""
    branches: Branches = Field(default=["best"])
    """Which paths are asked for: `best`, or words, such as `LS`; with a final heading `LSL`."""
    initial_guesses: list[Literal["cold", "warm"]] = Field(default=["cold"], min_length=1)
    """`cold`, or `warm`: each scenario of a block from the path of the one before it."""
    profile: ProfileName = "default"
    """Named settings and tolerances: `default`, `fast` or `accurate`."""
    repeats: Count = 1
    """How often each question is asked."""
    time_limit_s: Seconds = 60.0
    """Seconds after which a solve is ended."""
    memory_limit_gib: Gibibytes = 4.0
    """GiB that a solver's process and its children may hold."""
    seed: Seed = 0
    """Of the order in which cells are solved."""
    rising: bool = False
    """Whether routes and tours are asked by rising number of legs: a solver that finds the shortest
    of none with one number of legs is not asked the longer ones of the same label. These count as
    failures, with the outcome `not_asked`."""
    matrix: bool = False
    """Whether the report lists every pair of formulation and engine, and why some have no row."""
    first: First | None = None
    """Solvers that are asked only a part of each sample."""

    @field_validator("first")
    @classmethod
    def _check_first(cls, first: First | None, info: ValidationInfo) -> First | None:
        blocks: list[Block] = info.data.get("scenarios", [])
        sampled = any(block.drawn is not None and block.solvers is None for block in blocks)
        if first is not None and blocks and not sampled:
            raise ValueError(
                "expected a block with a sample, a route or a tour, without solvers of its own, "
                "and there is none"
            )
        return first

    @property
    def blocks(self) -> list[Block]:
        """All blocks: those of the file, and of `first`.

        For each block that draws scenarios and names no solvers, `first` adds one. It asks the
        solvers of `first` about the first scenarios of the draw.
        """
        first = self.first
        if first is None:
            return self.scenarios
        firsts = []
        for block in self.scenarios:
            table = block.drawn
            if table is not None and block.solvers is None:
                fewer = table.model_copy(update={"count": min(table.count, first.scenarios)})
                name = next(name for name in DRAWN if getattr(block, name) is table)
                firsts.append(block.model_copy(update={name: fewer, "solvers": first.solvers}))
        return [*self.scenarios, *firsts]


# For messages: the keys that each table of the file may have, by the table's name.
TABLE_KEYS = {
    "": tuple(Experiment.model_fields),
    "first": tuple(First.model_fields),
    "scenarios": tuple(Block.model_fields),
    "sample": tuple(Sample.model_fields),
    "route": tuple(Route.model_fields),
    "tour": tuple(Tour.model_fields),
    "guess_lengths": tuple(GuessLengths.model_fields),
}


class ExperimentFile(NamedTuple):
    """An experiment and the file that it comes from."""

    name: str  # of the packaged experiment, or the stem of the file's name
    path: str  # as it appears in messages
    text: str
    experiment: Experiment


def read(name: str) -> ExperimentFile:
    """Read an experiment by its name or its path.

    `plan.run_plan.read_checked` checks its solvers too. The `ExperimentError` names the file and
    every wrong key, its line, value and what was expected.
    """
    return parse(*text_of(name))


def parse(name: str, file: str, text: str) -> ExperimentFile:
    """Read an experiment from the text of its file.

    `file` is named in messages.
    """
    try:
        experiment = Experiment.model_validate(fields_of(file, text))
    except ValidationError as error:
        raise ExperimentError(refusal(file, problems_of(error, TABLE_KEYS), text)) from None
    return ExperimentFile(name, file, text, experiment)

"""An experiment: what its TOML file says, checked key by key."""

from __future__ import annotations

from typing import Any, Literal, NamedTuple, Self

from pydantic import Field, ValidationError, field_validator, model_validator
from pydantic_core import PydanticCustomError

from dubins_study.experiments.definition.axes import (
    Count,
    Gibibytes,
    Seconds,
    SectionName,
    Seed,
    StrictModel,
)
from dubins_study.experiments.definition.experiment_text import (
    ExperimentError as ExperimentError,
)
from dubins_study.experiments.definition.experiment_text import ExperimentText, text_of
from dubins_study.experiments.definition.experiment_text import packaged as packaged
from dubins_study.experiments.definition.key_conflicts import FIRST, key_conflicts
from dubins_study.experiments.definition.messages import (
    NAMED_BY_KEY,
    Problem,
    problems_of,
    refusal,
)
from dubins_study.experiments.definition.scenario_block import (
    FIELDS,
    Block,
    GuessLengths,
    Sample,
    known_branches,
)
from dubins_study.experiments.definition.toml_lines import KeyPath
from dubins_study.solvers.profiles import PROFILES
from dubins_study.study.values import did_you_mean


class First(StrictModel):
    """Solvers that are asked only the first scenarios of every sample, such as slow ones.

    The first scenarios of a Sobol sample cover its ranges as well.
    """

    scenarios: Count
    """How many of the first scenarios of each sample."""
    solvers: list[str] = Field(min_length=1)
    """The solvers that are asked these only."""


class Experiment(StrictModel):
    """The keys of an experiment's TOML file.

    `solvers` are specs: `*` means every registered solver; a spec with `{a,b}` means one solver
    with a and one with b. If `initial_guesses` holds `warm`, the scenarios of each block
    are solved one after another, each from the path of the scenario before it. A solve is stopped
    when it takes longer than `time_limit_s`, or when its process and the children of that process
    hold more than `memory_limit_gib`. `section` names the report's section about this experiment.
    `first` is about solvers that are asked only a part of each sample.
    `matrix` says that the experiment compares every formulation with every engine: the manifest
    then lists all pairs, and why some cannot be asked.
    """

    title: str = Field(min_length=1)
    """Title of the experiment's part of the report."""
    question: str = Field(min_length=1)
    """The question that the experiment answers, in a sentence."""
    section: SectionName | None = None
    """Key of a section of the report about this kind of experiment, such as `benchmark`."""
    scenarios: list[Block] = Field(min_length=1)
    """The scenarios, block by block."""
    solvers: list[str] = Field(min_length=1)
    """Specs of the solvers that are asked; `*` is every registered one."""
    branches: list[str] = Field(default=["best"], min_length=1)
    """Which paths are asked for: `best`, or words: `LS`, `RS`, `LR`, `RL`."""
    initial_guesses: list[Literal["cold", "warm"]] = Field(default=["cold"], min_length=1)
    """`cold`, or `warm`: each scenario of a block from the path of the one before it."""
    profile: str = "default"
    """Named settings and tolerances: `default`, `fast` or `accurate`."""
    repeats: Count = 1
    """How often each question is asked."""
    time_limit_s: Seconds = 60.0
    """Seconds after which a solve is ended."""
    memory_limit_gib: Gibibytes = 4.0
    """GiB that a solver's process and its children may hold."""
    seed: Seed = 0
    """Of the order in which cells are solved."""
    matrix: bool = False
    """Whether the report lists every pair of formulation and engine, and why some have no row."""
    first: First | None = None
    """Solvers that are asked only a part of each sample."""

    @model_validator(mode="after")
    def _check_first(self) -> Self:
        if self.first is not None and len(self.blocks) == len(self.scenarios):
            raise PydanticCustomError(NAMED_BY_KEY, FIRST)
        return self

    @property
    def blocks(self) -> list[Block]:
        """All blocks: those of the file, and the first scenarios of those that `first` is about."""
        first = self.first
        if first is None:
            return self.scenarios
        firsts = []
        for block in self.scenarios:
            if block.sample is not None and block.solvers is None:
                fewer = {"count": min(block.sample.count, first.scenarios)}
                sample = block.sample.model_copy(update=fewer)
                changes = {"sample": sample, "solvers": first.solvers}
                firsts.append(block.model_copy(update=changes))
        return [*self.scenarios, *firsts]

    def solver_lists(self) -> dict[KeyPath, list[str]]:
        """All lists of solvers by the path of their key in the file."""
        lists: dict[KeyPath, list[str]] = {("solvers",): self.solvers}
        if self.first is not None:
            lists["first", "solvers"] = self.first.solvers
        for number, block in enumerate(self.scenarios):
            if block.solvers is not None:
                lists["scenarios", number, "solvers"] = block.solvers
        return lists

    @field_validator("branches")
    @classmethod
    def _check_branches(cls, value: list[str]) -> list[str]:
        return known_branches(value)

    @field_validator("profile")
    @classmethod
    def _check_profile(cls, value: str) -> str:
        if value not in PROFILES:
            near = did_you_mean(value, PROFILES)
            raise ValueError(
                f"no profile named {value!r}; {near}choose one of {', '.join(PROFILES)}"
            )
        return value


# For messages: the keys that each table of the file may have, by the table's name.
TABLE_KEYS = {
    "": tuple(Experiment.model_fields),
    "first": tuple(First.model_fields),
    "scenarios": tuple(Block.model_fields),
    "sample": tuple(Sample.model_fields),
    "ranges": FIELDS,
    "guess_lengths": tuple(GuessLengths.model_fields),
}


class ExperimentFile(NamedTuple):
    """An experiment and the file that it was read from.

    Args:
        name: the name of the packaged experiment, or the stem of the file's name.
        path: the file's path, as it appears in messages.
        text: the text of the file.
        experiment: what the text says.
    """

    name: str
    path: str
    text: str
    experiment: Experiment


def read(name: str) -> ExperimentFile:
    """Read a packaged experiment by its name, or any experiment by the path of its TOML file.

    Solvers are not looked at, nor whether scenarios go together: `plan.file_checks.read_checked`.

    Raises:
        ExperimentError: naming the file, the key, the value and what was expected.
    """
    return parse(*text_of(name))


def parse(name: str, file: str, text: str) -> ExperimentFile:
    """Read an experiment from the text of its file; `file` is named in messages.

    Raises:
        ExperimentError: as `read`.
    """
    fields = ExperimentText(name, file, text).fields()
    return ExperimentFile(name, file, text, validated(file, fields, text))


def validated(file: str, fields: dict[str, Any], text: str = "") -> Experiment:
    """Check the fields of an experiment.

    Args:
        file: named in messages.
        fields: the keys and their values.
        text: the text of the file, for the numbers of lines in messages.

    Raises:
        ExperimentError: naming every wrong key, its line, its value and what was expected.
    """
    try:
        return Experiment.model_validate(fields)
    except ValidationError as error:
        raise ExperimentError(refusal(file, file_problems(error, fields), text)) from None


def file_problems(error: ValidationError, fields: dict[str, Any]) -> list[Problem]:
    """Every mistake of invalid fields: of keys by themselves, and of keys beside each other."""
    return problems_of(error, TABLE_KEYS) + key_conflicts(fields)

"""An experiment as a TOML file says it, validated."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path as FilePath
from typing import Annotated, Any, Literal, NamedTuple, Self

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)

from dubins_study.errors import DubinsStudyError
from dubins_study.experiments.definition.complaint import complaint
from dubins_study.solvers.profiles import PROFILES
from dubins_study.study.angle import parse_angle
from dubins_study.study.closed_form.shortest import BRANCHES


class ExperimentError(DubinsStudyError, ValueError):
    """An experiment that does not exist or is not valid; the message names file, key, value."""


def _no_boolean(value: object) -> object:
    """True is 1 to Python, and never meant so."""
    if isinstance(value, bool):
        raise ValueError("expected a number")
    return value


def _number(value: object) -> object:
    """Angles may be written as texts anywhere a number may stand."""
    return parse_angle(value) if isinstance(value, str) else _no_boolean(value)


Number = Annotated[float, BeforeValidator(_number), Field(allow_inf_nan=False)]
Count = Annotated[int, BeforeValidator(_no_boolean), Field(ge=1, le=10**9)]
Seed = Annotated[int, BeforeValidator(_no_boolean), Field(ge=0, lt=2**63)]
Gibibytes = Annotated[float, BeforeValidator(_no_boolean), Field(ge=0.25, le=2**20)]
# the report's sections are the report's to know; here a name only has to be one
SectionKey = Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]*$", max_length=40)]
Seconds = Annotated[float, BeforeValidator(_no_boolean), Field(gt=0, allow_inf_nan=False)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Linear(_Strict):
    """`count` values from the first to the last, evenly spaced."""

    linear: tuple[Number, Number, Count]


class Log(_Strict):
    """`count` values from the first to the last, evenly spaced in the logarithm."""

    log: tuple[Number, Number, Count]

    @field_validator("log")
    @classmethod
    def _positive(cls, value: tuple[float, float, int]) -> tuple[float, float, int]:
        if not (value[0] > 0 and value[1] > 0):
            raise ValueError("a logarithmic sweep starts and ends above 0")
        return value


class LinearRange(_Strict):
    """Uniform between two numbers."""

    linear: tuple[Number, Number]


class LogRange(_Strict):
    """Uniform in the logarithm between two numbers above 0."""

    log: tuple[Number, Number]

    @field_validator("log")
    @classmethod
    def _positive(cls, value: tuple[float, float]) -> tuple[float, float]:
        if not (value[0] > 0 and value[1] > 0):
            raise ValueError("a logarithmic range starts and ends above 0")
        return value


Axis = Number | Annotated[list[Number], Field(min_length=1)] | Linear | Log
Range = LinearRange | LogRange


class Sample(_Strict):
    """Quasi-random points over ranges of fields (`scipy.stats.qmc`)."""

    method: Literal["sobol", "latin hypercube"]
    count: Count
    seed: Seed
    ranges: dict[str, Range] = Field(min_length=1)


CARTESIAN = ("target_x", "target_y")
POLAR = ("distance", "bearing")
CIRCULAR = ("arc", "margin")
FIELDS = ("x", "y", "heading", *CARTESIAN, "radius", "speed", *POLAR, *CIRCULAR)


class GuessLengths(_Strict):
    """Initial guesses of local solvers: the product of the paper's lengths z1, z2, z3, in radii.

    A left turn, a right turn, a straight, in that order.
    """

    z1: Axis
    z2: Axis
    z3: Axis


class Block(_Strict):
    """Scenarios: the product of the fields' values, or a sample of them.

    The target is `target_x`, `target_y`; or `distance` (in radii) and `bearing` (rad, from the
    heading); or `arc` and `margin`: so far along a turning circle (rad, to the left if positive)
    and so many radii outside it, inside if negative. In a product the fields vary in the order of
    `FIELDS`, the last one fastest. `solvers` and `branches` take the place of the experiment's own
    for this block; `guess_lengths` takes that of its `initial_guesses`.
    """

    label: str = ""
    x: Axis = 0.0
    y: Axis = 0.0
    heading: Axis = 0.0
    target_x: Axis | None = None
    target_y: Axis | None = None
    distance: Axis | None = None
    bearing: Axis | None = None
    arc: Axis | None = None
    margin: Axis | None = None
    radius: Axis = 1.0
    speed: Axis = 1.0
    sample: Sample | None = None
    solvers: list[str] | None = Field(default=None, min_length=1)
    branches: list[str] | None = Field(default=None, min_length=1)
    guess_lengths: GuessLengths | None = None

    @model_validator(mode="after")
    def _one_target(self) -> Self:
        given = {name for name in FIELDS if getattr(self, name) is not None}
        if self.sample is not None:
            if unknown := sorted(set(self.sample.ranges) - set(FIELDS)):
                raise ValueError(
                    f"sample.ranges names {unknown[0]!r}; expected {', '.join(FIELDS)}"
                )
            given |= set(self.sample.ranges)
        kinds = (CARTESIAN, POLAR, CIRCULAR)
        if given & {name for kind in kinds for name in kind} not in map(set, kinds):
            raise ValueError(f"expected {', or '.join(' and '.join(kind) for kind in kinds)}")
        return self

    @field_validator("branches")
    @classmethod
    def _known(cls, value: list[str] | None) -> list[str] | None:
        return None if value is None else _known_branches(value)


def _known_branches(branches: list[str]) -> list[str]:
    for branch in branches:
        if branch not in BRANCHES:
            raise ValueError(f"no branch named {branch!r}; choose from {', '.join(BRANCHES)}")
    return branches


class Experiment(_Strict):
    """Everything that a run needs to know.

    `solvers` are specs; `*` stands for every registered solver, and `{a,b}` in a spec for each of
    a and b. `initial_guesses` may hold `warm`: then each block is also solved in its order, every scenario
    from the path found for the one before. A solve that takes longer than `time_limit_s`, or whose
    process and children hold more than `memory_limit_gib`, is ended.
    `section` names the section of the report that is about this experiment, if one is.
    """

    title: str = Field(min_length=1)
    question: str = Field(min_length=1)
    section: SectionKey | None = None
    scenarios: list[Block] = Field(min_length=1)
    solvers: list[str] = Field(min_length=1)
    branches: list[str] = Field(default=["best"], min_length=1)
    initial_guesses: list[Literal["cold", "warm"]] = Field(default=["cold"], min_length=1)
    profile: str = "default"
    repeats: Count = 1
    time_limit_s: Seconds = 60.0
    memory_limit_gib: Gibibytes = 4.0
    seed: Seed = 0

    @field_validator("branches")
    @classmethod
    def _known(cls, value: list[str]) -> list[str]:
        return _known_branches(value)

    @field_validator("profile")
    @classmethod
    def _profile(cls, value: str) -> str:
        if value not in PROFILES:
            raise ValueError(f"no profile named {value!r}; choose one of {', '.join(PROFILES)}")
        return value


class Source(NamedTuple):
    """An experiment with its name, its file for messages, and the text that it was read from."""

    name: str
    file: str
    text: str
    experiment: Experiment


def packaged() -> list[str]:
    """The names of the experiments that come with the package."""
    return sorted(file.name.removesuffix(".toml") for file in _folder())


def _folder() -> Iterator[Any]:
    return (
        file for file in files("dubins_study.experiments").iterdir() if file.name.endswith(".toml")
    )


def read(name: str) -> Source:
    """An experiment by its name, or from a TOML file by its path.

    Raises:
        ExperimentError: naming the file, the key, the value and what was expected.
    """
    for file in _folder():
        if file.name == f"{name}.toml":
            return parse(name, file.name, file.read_text(encoding="utf-8"))
    path = FilePath(name)
    # of `..toml` and `...toml` no name is left that a results folder could have
    if path.suffix != ".toml" or path.stem in (".", ".."):
        raise ExperimentError(
            f"no experiment named {name!r}; choose one of: {', '.join(packaged())}, "
            "or give the path of a .toml file"
        )
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:  # a path may hold what no file system takes
        unreadable = "it is not UTF-8 text" if isinstance(error, UnicodeError) else str(error)
        reason = error.strerror if isinstance(error, OSError) else unreadable
        raise ExperimentError(f"experiment {name}: cannot be read: {reason}") from None
    return parse(path.stem, name, text)


def parse(name: str, file: str, text: str) -> Source:
    """An experiment from its text; `file` is for messages."""
    try:
        fields = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # too long a number, too many brackets
        raise ExperimentError(f"{file}: not TOML: {error}") from None
    return Source(name, file, text, validated(file, fields))


def validated(file: str, fields: dict[str, Any]) -> Experiment:
    """An experiment from its fields; `file` is for messages."""
    try:
        return Experiment.model_validate(fields)
    except ValidationError as error:
        raise ExperimentError(f"{file}: {complaint(error)}") from None

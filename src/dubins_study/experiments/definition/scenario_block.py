"""One `[[scenarios]]` table of an experiment: its keys, and which of them do not go together."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import (
    AfterValidator,
    Field,
    TypeAdapter,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import PydanticCustomError

from dubins_study.experiments.definition.axes import (
    Axis,
    Count,
    Linear,
    LinearRange,
    Log,
    LogRange,
    Range,
    Seed,
    StrictModel,
)
from dubins_study.experiments.definition.messages import NAMED_BY_KEY, Problem
from dubins_study.study.values import did_you_mean
from dubins_study.study.words import BRANCHES

# The fields of the three ways to write a target.
CARTESIAN = ("target_x", "target_y")
POLAR = ("distance", "bearing")
CIRCULAR = ("arc", "margin")
_WAYS = (CARTESIAN, POLAR, CIRCULAR)
TARGETS = f"expected {', or '.join(' and '.join(way) for way in _WAYS)}"
FIELDS = ("x", "y", "heading", *CARTESIAN, "radius", "speed", *POLAR, *CIRCULAR)
ANGLES = ("heading", "bearing", "arc")  # the fields that may be written as texts: "120deg"


MAX_GUESS_LENGTH = 1e6  # radii; longer than any useful path
# Field -> the rule of its values; a rule about a number by itself, so that a file's lines tell it.
_RULES: dict[str, tuple[Callable[[float], bool], str]] = {
    "radius": (lambda value: value > 0, "above 0"),
    "speed": (lambda value: value > 0, "above 0"),
    "distance": (lambda value: value >= 0, "of at least 0 (a target behind has bearing 180deg)"),
    "margin": (lambda value: value >= -1, "of at least -1, the circle's centre"),
    **dict.fromkeys(
        ("z1", "z2", "z3"),
        (lambda value: 0 <= value <= MAX_GUESS_LENGTH, f"from 0 to {MAX_GUESS_LENGTH:g} radii"),
    ),
}
_SIGNED = [field for field in _RULES if field in FIELDS]
_MOST_VALUES = 5  # that a sentence lists


def values_of(axis: Axis | Range | None) -> list[float]:
    """The values of an axis or a range; of an evenly spaced one, those at its ends."""
    if isinstance(axis, Log | LogRange):
        return list(axis.log[:2])
    if isinstance(axis, Linear):
        first, last, count = axis.linear
        return [first, last] if count > 1 else [first]
    if isinstance(axis, LinearRange):
        return list(axis.linear)
    if isinstance(axis, list):
        return axis
    return [] if axis is None else [axis]


def refused(field: str, values: list[float]) -> str | None:
    """What is wrong with values of a field, all of them in a sentence; None if nothing is."""
    holds, rule = _RULES.get(field, (None, ""))
    wrong = [] if holds is None else [str(value) for value in values if not holds(value)]
    if not wrong:
        return None
    more = len(wrong) - _MOST_VALUES
    listed = ", ".join(wrong[:_MOST_VALUES]) + (f" and {more} more" if more > 0 else "")
    return f"expected a number {rule}; got {listed}"


def _without_texts(axis: object) -> object:
    """An axis or a range as the file has it, if no value of it is a text."""
    values = next(iter(axis.values()), None) if isinstance(axis, dict) else axis
    texts = [v for v in (values if isinstance(values, list) else [values]) if isinstance(v, str)]
    if texts:
        angles = ", ".join(ANGLES)
        raise ValueError(f"expected a number; texts such as '120deg' are for angles: {angles}")
    return axis


def _checked_values(axis: Axis, info: ValidationInfo) -> Axis:
    if sentence := refused(str(info.field_name), values_of(axis)):
        raise ValueError(sentence)
    return axis


def _field_name(name: str) -> str:
    if name not in FIELDS:
        raise ValueError(f"no such field; {did_you_mean(name, FIELDS)}expected {', '.join(FIELDS)}")
    return name


FieldName = Annotated[str, AfterValidator(_field_name)]


class Sample(StrictModel):
    """Quasi-random points over ranges of fields, drawn by `scipy.stats.qmc`."""

    method: Literal["sobol", "latin hypercube"]
    """How points are spread; the first points of a Sobol sample cover its ranges as well."""
    count: Count
    """Number of scenarios."""
    seed: Seed
    """The same seed draws the same points."""
    ranges: dict[FieldName, Range] = Field(min_length=1)
    """Field -> its range; a field of the block that is not named here has the block's value."""

    @field_validator("ranges", mode="before")
    @classmethod
    def _check_texts(cls, ranges: object) -> object:
        for name, over in ranges.items() if isinstance(ranges, dict) else ():
            if name not in ANGLES:
                try:
                    _without_texts(over)
                except ValueError as error:
                    raise ValueError(f"{name}: {error}") from None
        return ranges

    @field_validator("ranges")
    @classmethod
    def _check_ranges(cls, ranges: dict[str, Range]) -> dict[str, Range]:
        if any(refused(name, values_of(over)) for name, over in ranges.items()):
            raise PydanticCustomError(NAMED_BY_KEY, "a range whose values cannot be")
        return ranges


class GuessLengths(StrictModel):
    """The lengths z1, z2, z3 of the paper's path, in radii, from which a local solver starts.

    z1 is the length of the left turn, z2 of the right turn, z3 of the straight. The initial guesses
    are all combinations of the values.
    """

    z1: Axis
    """Length of the left turn."""
    z2: Axis
    """Length of the right turn."""
    z3: Axis
    """Length of the straight."""

    @field_validator("z1", "z2", "z3")
    @classmethod
    def _check_values(cls, axis: Axis, info: ValidationInfo) -> Axis:
        return _checked_values(axis, info)

    @property
    def axes(self) -> tuple[Axis, Axis, Axis]:
        return self.z1, self.z2, self.z3


class Block(StrictModel):
    """Scenarios: all combinations of the fields' values, or a sample.

    The target is written in one of these ways:
    `target_x` and `target_y`;
    `distance` in radii and `bearing` in radians from the start's heading;
    `arc` and `margin`: `arc` radians along a turning circle from the start (positive on the left
    circle, negative on the right one), and `margin` radii outside that circle (negative inside).

    Combinations are numbered in the order of `FIELDS`; the last field varies fastest.
    `solvers` and `branches` replace the experiment's for this block, and `guess_lengths` replaces
    the experiment's `initial_guesses`.
    """

    listed_apart: ClassVar[bool] = False  # in a file of scenarios
    label: str = ""
    """Name of the scenarios; the report calls scenarios of one label a stratum."""
    x: Axis = 0.0
    """Start position."""
    y: Axis = 0.0
    """Start position."""
    heading: Axis = 0.0
    """Start heading, counter-clockwise from +x: radians, or a text such as "120deg" or "2pi/3"."""
    target_x: Axis | None = None
    """Target position."""
    target_y: Axis | None = None
    """Target position."""
    distance: Axis | None = None
    """Distance of the target, in radii; at least 0."""
    bearing: Axis | None = None
    """Direction of the target from the start's heading: radians, or a text."""
    arc: Axis | None = None
    """Radians along a turning circle: positive on the left circle, negative on the right one."""
    margin: Axis | None = None
    """Radii outside that circle; negative inside."""
    radius: Axis = 1.0
    """Minimum turning radius."""
    speed: Axis = 1.0
    """Constant speed; it changes the travel time only."""
    sample: Sample | None = None
    """Scenarios drawn over ranges instead of combined from axes."""
    solvers: list[str] | None = Field(default=None, min_length=1)
    """Replaces the experiment's solvers for this block."""
    branches: list[str] | None = Field(default=None, min_length=1)
    """Replaces the experiment's branches for this block."""
    guess_lengths: GuessLengths | None = None
    """Initial guesses of the local solvers with `initial_guess=given`, instead of cold ones."""

    def axis(self, field: str) -> Axis | None:
        """The values of one of `FIELDS`, or None if the block does not give that field."""
        values: Axis | None = getattr(self, field)
        return values

    @model_validator(mode="after")
    def _check_target(self) -> Self:
        if self.listed_apart:
            return self
        given = {field for field in FIELDS if self.axis(field) is not None}
        if self.sample is not None:
            given |= set(self.sample.ranges)
        if not one_target(given):
            raise PydanticCustomError(NAMED_BY_KEY, TARGETS)
        return self

    _check_texts = field_validator(*sorted({*FIELDS} - {*ANGLES}), mode="before")(_without_texts)

    @field_validator(*_SIGNED)
    @classmethod
    def _check_values(cls, axis: Axis | None, info: ValidationInfo) -> Axis | None:
        return None if axis is None else _checked_values(axis, info)

    @field_validator("branches")
    @classmethod
    def _check_branches(cls, value: list[str] | None) -> list[str] | None:
        return None if value is None else known_branches(value)


class ListedBlock(Block):
    """Scenarios listed one by one in a file of their own; no experiment's file writes this.

    `listed` is a frame with the columns of `study.scenario.COLUMNS`, one row a scenario.
    """

    listed_apart: ClassVar[bool] = True
    listed: Any = Field(exclude=True)


def one_target(given: set[str]) -> bool:
    """Whether fields write a target in one of the ways, and in one only."""
    return given & {field for way in _WAYS for field in way} in map(set, _WAYS)


def known_branches(branches: list[str]) -> list[str]:
    """The branches, unchanged; `ValueError` names those that do not exist."""
    if unknown := [branch for branch in branches if branch not in BRANCHES]:
        names = " or ".join(f"{branch!r:.40}" for branch in unknown[:3])
        near = next(filter(None, (did_you_mean(branch, BRANCHES) for branch in unknown)), "")
        raise ValueError(f"no branch named {names}; {near}choose from {', '.join(BRANCHES)}")
    return branches


_RANGE: TypeAdapter[Range] = TypeAdapter(Range)
FIRST = "first: expected a block with a sample and without solvers of its own, and there is none"


def key_conflicts(fields: dict[str, Any]) -> list[Problem]:
    """Blocks without a target, ranges of values that cannot be, and a `first` about nothing."""
    problems = []
    for number, block in tables(fields):
        problems += _target_problems(number, block)
        problems += _range_problems(number, block)
    blocks = [block for _, block in tables(fields)]
    sampled = any("sample" in block and "solvers" not in block for block in blocks)
    if isinstance(fields.get("first"), dict) and blocks and not sampled:
        problems.append(Problem(("first",), FIRST))
    return problems


def tables(fields: dict[str, Any]) -> Iterator[tuple[int, dict[str, Any]]]:
    """The number and the keys of every block that is a table."""
    blocks = fields.get("scenarios")
    for number, block in enumerate(blocks if isinstance(blocks, list) else ()):
        if isinstance(block, dict):
            yield number, block


def _ranges(block: dict[str, Any]) -> dict[str, Any]:
    sample = block.get("sample")
    ranges = sample.get("ranges") if isinstance(sample, dict) else None
    return ranges if isinstance(ranges, dict) else {}


def _target_problems(number: int, block: dict[str, Any]) -> list[Problem]:
    """No target, or two; not of a block with an unknown key: that may be a part of the target."""
    sampled = set(_ranges(block))
    unknown = (block.keys() - Block.model_fields.keys()) | (sampled - set(FIELDS))
    if unknown or one_target(sampled | block.keys()):
        return []
    return [Problem(("scenarios", number), f"scenarios.{number}: {TARGETS}")]


def _range_problems(number: int, block: dict[str, Any]) -> list[Problem]:
    problems = []
    for name, over in _ranges(block).items():
        try:
            sentence = refused(name, values_of(_RANGE.validate_python(over)))
        except ValidationError:  # no range: the models tell it
            continue
        if sentence:
            path = ("scenarios", number, "sample", "ranges", name)
            problems.append(Problem(path, f"{'.'.join(map(str, path))}: {sentence}"))
    return problems

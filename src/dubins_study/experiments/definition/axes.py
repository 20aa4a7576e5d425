"""How a TOML file writes numbers, and how it gives one field of a scenario several values."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    Tag,
    ValidationInfo,
    WithJsonSchema,
)

from dubins_study.study.angle import parse_angle
from dubins_study.study.values import real_number

Number = Annotated[
    float,
    BeforeValidator(lambda value: parse_angle(value) if isinstance(value, str) else value),
    Field(allow_inf_nan=False, strict=True),
    WithJsonSchema({"type": ["number", "string"]}),  # a text is an angle, such as "120deg"
]
_AboveZero = Annotated[Number, Field(gt=0)]
Count = Annotated[int, Field(ge=1, le=10**9, strict=True)]
# Of the values of an axis, which are written out where it is read: no experiment has more cells.
_AxisCount = Annotated[int, Field(ge=1, le=2_000_000, strict=True)]
# Of a sampled route.
LegCount = Annotated[int, Field(ge=1, le=10**4, strict=True)]
Seed = Annotated[int, Field(ge=0, lt=2**63, strict=True)]
Gibibytes = Annotated[float, Field(ge=0.25, le=2**20, strict=True)]
Seconds = Annotated[float, Field(gt=0, allow_inf_nan=False, strict=True)]
# Name of a section of the report. Only the report knows which sections exist.
SectionName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]*$", max_length=40)]


def _checked_spec(spec: str, info: ValidationInfo) -> str:
    """The spec, if the caller's check (the context of the validation) does not refuse it."""
    if info.context is not None:
        info.context(spec)
    return spec


SolverSpecs = Annotated[list[Annotated[str, AfterValidator(_checked_spec)]], Field(min_length=1)]


class StrictModel(BaseModel):
    """A table of the TOML file; unknown keys are refused. A key's docstring follows it."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, use_attribute_docstrings=True, validate_default=True
    )


class Linear(StrictModel):
    """`[first, last, count]`: `count` evenly spaced values from the first to the last."""

    linear: tuple[Number, Number, _AxisCount]
    """First value, last value, and how many."""


class Log(StrictModel):
    """`[first, last, count]`: `count` values whose logarithms are evenly spaced."""

    log: tuple[_AboveZero, _AboveZero, _AxisCount]
    """First value, last value, and how many; both values are above 0."""


class LinearRange(StrictModel):
    """`[low, high]`: sampled values are spread uniformly between the two."""

    linear: tuple[Number, Number]
    """Least and largest value."""


class LogRange(StrictModel):
    """`[low, high]`: the logarithms of sampled values are spread uniformly; both are above 0."""

    log: tuple[_AboveZero, _AboveZero]
    """Least and largest value, both above 0."""


# A value is written in one of several ways. A step of an error's location with this beginning
# names the way and is no key of the file.
WAY = "way:"


def _way(value: Any) -> str | None:
    """The way in which a value of an axis or a range is written; None if it is none of them."""
    if isinstance(value, dict):
        return next((f"{WAY}{key}" for key in ("linear", "log") if key in value), None)
    if isinstance(value, list):
        return f"{WAY}list"
    return f"{WAY}number" if isinstance(value, bool | int | float | str) else None


def _written_as(expected: str) -> Discriminator:
    return Discriminator(_way, custom_error_type="way", custom_error_message=expected)


def _written_out(axis: Any) -> tuple[Any, ...]:
    """All values of an axis."""
    if isinstance(axis, Linear):
        return tuple(np.linspace(*axis.linear).tolist())
    if isinstance(axis, Log):
        first, last, count = axis.log
        powers = np.linspace(math.log10(first), math.log10(last), count).tolist()
        # not by numpy, whose powers differ in the last bit between processors
        values = [10.0**power for power in powers]
        values[-1], values[0] = last, first
        return tuple(values)
    return tuple(axis) if isinstance(axis, list) else (axis,)


if TYPE_CHECKING:
    Axis = tuple[float, ...]
    LegCounts = tuple[int, ...]
else:
    # The values of one field, written as a number, a list of numbers, or evenly spaced numbers.
    Axis = Annotated[
        Annotated[Number, Tag(f"{WAY}number")]
        | Annotated[list[Number], Field(min_length=1), Tag(f"{WAY}list")]
        | Annotated[Linear, Tag(f"{WAY}linear")]
        | Annotated[Log, Tag(f"{WAY}log")],
        _written_as(
            "expected a number, a list of numbers, { linear = [first, last, count] } "
            "or { log = [first, last, count] }"
        ),
        AfterValidator(_written_out),
    ]
    # Numbers of legs, written as one or several.
    LegCounts = Annotated[
        Annotated[LegCount, Tag(f"{WAY}number")]
        | Annotated[list[LegCount], Field(min_length=1), Tag(f"{WAY}list")],
        _written_as("expected a whole number or a list of whole numbers"),
        AfterValidator(_written_out),
    ]
Range = Annotated[
    Annotated[LinearRange, Tag(f"{WAY}linear")] | Annotated[LogRange, Tag(f"{WAY}log")],
    _written_as("expected { linear = [low, high] } or { log = [low, high] }"),
]


def _via_lists(value: Any) -> Any:
    """The via points of each scenario: one list of points is that of all."""
    expected = "expected points such as [[1, 2], [3, 4]], or a list of such lists"
    if not isinstance(value, list) or not all(isinstance(item, list) for item in value):
        raise ValueError(expected)
    one = all(item and not any(isinstance(part, list) for part in item) for item in value)
    try:
        return [
            [(real_number(x), real_number(y)) for x, y in via]
            for via in ([value] if one else value)
        ]
    except (TypeError, ValueError, OverflowError):
        raise ValueError(expected) from None


_POINTS_SCHEMA = {"type": "array", "items": {"type": "array", "items": {"type": "number"}}}
Points = tuple[tuple[float, float], ...]
# The via points of a scenario, or of several.
ViaLists = Annotated[
    tuple[Points, ...],
    BeforeValidator(_via_lists),
    WithJsonSchema({"anyOf": [_POINTS_SCHEMA, {"type": "array", "items": _POINTS_SCHEMA}]}),
]

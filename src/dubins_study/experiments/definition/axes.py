"""How a TOML file writes numbers, and how it gives one field of a scenario several values."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    WithJsonSchema,
)

from dubins_study.study.angle import parse_angle


def _number(value: object) -> object:
    """Refuse `true` and `false`, which Python would take for 1 and 0, and texts such as "2"."""
    if isinstance(value, bool | str):
        raise ValueError("expected a number")
    return value


def _whole_number(value: object) -> object:
    """The same of a whole number."""
    if isinstance(value, bool | str):
        raise ValueError("expected a whole number")
    return value


def _number_or_angle(value: object) -> object:
    """Read a text such as "120deg" as an angle in radians; refuse booleans."""
    return parse_angle(value) if isinstance(value, str) else _number(value)


Number = Annotated[
    float,
    BeforeValidator(_number_or_angle),
    Field(allow_inf_nan=False),
    WithJsonSchema({"type": ["number", "string"]}),  # a text is an angle, such as "120deg"
]
Count = Annotated[int, BeforeValidator(_whole_number), Field(ge=1, le=10**9)]
Seed = Annotated[int, BeforeValidator(_whole_number), Field(ge=0, lt=2**63)]
Gibibytes = Annotated[float, BeforeValidator(_number), Field(ge=0.25, le=2**20)]
# Name of a section of the report. Only the report knows which sections exist.
SectionName = Annotated[str, Field(pattern=r"^[a-z][a-z0-9-]*$", max_length=40)]
Seconds = Annotated[float, BeforeValidator(_number), Field(gt=0, allow_inf_nan=False)]


def _above_zero(what: str) -> AfterValidator:
    """Refuse a logarithmic sweep or range whose first two numbers are not above 0."""

    def check(value: tuple[Any, ...]) -> tuple[Any, ...]:
        if not (value[0] > 0 and value[1] > 0):
            raise ValueError(f"a logarithmic {what} starts and ends above 0")
        return value

    return AfterValidator(check)


class StrictModel(BaseModel):
    """A table of the TOML file; unknown keys are refused. A key's docstring follows it."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)


class Linear(StrictModel):
    """`[first, last, count]`: `count` evenly spaced values from the first to the last."""

    linear: tuple[Number, Number, Count]
    """First value, last value, and how many."""


class Log(StrictModel):
    """`[first, last, count]`: `count` values whose logarithms are evenly spaced."""

    log: Annotated[tuple[Number, Number, Count], _above_zero("sweep")]
    """First value, last value, and how many; both values are above 0."""


class LinearRange(StrictModel):
    """`[low, high]`: sampled values are spread uniformly between the two."""

    linear: tuple[Number, Number]
    """Least and largest value."""


class LogRange(StrictModel):
    """`[low, high]`: the logarithms of sampled values are spread uniformly; both are above 0."""

    log: Annotated[tuple[Number, Number], _above_zero("range")]
    """Least and largest value, both above 0."""


# The values of one field: a number, a list of numbers, or evenly spaced numbers.
Axis = Number | Annotated[list[Number], Field(min_length=1)] | Linear | Log
Range = LinearRange | LogRange

"""Numbers and axes as a TOML file writes them.

An axis gives one field of a scenario several values.
"""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    ValidationInfo,
    ValidatorFunctionWrapHandler,
    WrapValidator,
    model_validator,
)

from dubins_study.study.angle import parse_angle
from dubins_study.study.scenario import FREE
from dubins_study.study.values import number_of_text


def _number(written: Any) -> Any:
    """The value, with a text read as an angle."""
    if isinstance(written, str):
        return parse_angle(written)
    return written


_Written = float | str  # a text is an angle, such as "120deg"
Number = Annotated[
    float,
    BeforeValidator(_number, json_schema_input_type=_Written),
    Field(allow_inf_nan=False, strict=True),
]
# None is free.
Heading = Annotated[Number | None, BeforeValidator(lambda value: None if value == FREE else value)]
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
    """The spec, unless the caller's check refuses it.

    The check is the context of the validation.
    """
    if info.context is not None:
        info.context(spec)
    return spec


SolverSpecs = Annotated[list[Annotated[str, AfterValidator(_checked_spec)]], Field(min_length=1)]


class StrictModel(BaseModel):
    """A table of the TOML file.

    Unknown keys are refused. A key's docstring follows it.
    """

    model_config = ConfigDict(
        extra="forbid", frozen=True, use_attribute_docstrings=True, validate_default=True
    )


class _Law(StrictModel):
    """Evenly spread values (`linear`), or evenly spread logarithms (`log`)."""

    written: ClassVar[str]  # the list after the name of the law, in messages

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        if len(self.model_fields_set) != 1:
            raise ValueError(
                f"expected {{ linear = {self.written} }} or {{ log = {self.written} }}"
            )
        return self


class Spaced(_Law):
    """`[first, last, count]`: evenly spaced values or logarithms."""

    written = "[first, last, count]"
    linear: tuple[Number, Number, _AxisCount] | None = None
    log: tuple[_AboveZero, _AboveZero, _AxisCount] | None = None

    def values(self) -> list[float]:
        """All values, the first and the last included."""
        if self.log is None:
            assert self.linear is not None
            return list(np.linspace(*self.linear).tolist())
        first, last, count = self.log
        powers = np.linspace(math.log10(first), math.log10(last), count).tolist()
        # not by numpy, whose powers differ in the last bit between processors
        values = [10.0**power for power in powers]
        values[-1] = last
        values[0] = first
        return values


class Range(_Law):
    """Range of a sample: uniform values, or uniform logarithms.

    The first is `linear`, the second `log`.
    """

    written = "[low, high]"
    linear: tuple[Number, Number] | None = None
    """Least and largest value."""
    log: tuple[_AboveZero, _AboveZero] | None = None
    """Least and largest value, both above 0."""

    def value_at(self, share: float) -> float:
        """The value at a share of the range.

        The share goes from 0 (the least value) to 1 (the largest).
        """
        if self.log is not None:
            low, high = self.log
            return float(low * (high / low) ** share)
        assert self.linear is not None
        low, high = self.linear
        return low + share * (high - low)


def as_list(written: Any) -> list[Any]:
    """The list, or a list of one value."""
    if isinstance(written, list):
        return written
    return [written]


def _written_out(written: Any) -> Any:
    """The list of all values of an axis.

    A table such as `{ linear = [0, 1, 3] }` becomes `[0, 0.5, 1]`.
    """
    if isinstance(written, dict):
        return Spaced.model_validate(written).values()
    return as_list(written)


def _radii(written: Any) -> float:
    """The number of radii in a text like `8R`."""
    if isinstance(written, str) and written.endswith("R"):
        with suppress(ValueError):
            return number_of_text(written[:-1])
    raise ValueError("expected a text such as '8R': a number of radii")


_AXIS = BeforeValidator(_written_out, json_schema_input_type=_Written | list[_Written] | Spaced)
_AT_LEAST_ONE = Field(min_length=1)
# The values of one field, written as a number, a list of numbers, or evenly spaced numbers.
Axis = Annotated[list[Number], _AT_LEAST_ONE, _AXIS]
HeadingAxis = Annotated[list[Heading], _AT_LEAST_ONE, _AXIS]
# Numbers of legs, written as one or several.
LegCounts = Annotated[
    list[LegCount],
    _AT_LEAST_ONE,
    BeforeValidator(_written_out, json_schema_input_type=LegCount | list[LegCount]),
]
_Radii = Annotated[float, BeforeValidator(_radii), Field(ge=1e-3, le=1e6)]
# Lengths in radii, written as one or several texts.
RadiiList = Annotated[
    list[_Radii],
    _AT_LEAST_ONE,
    BeforeValidator(_written_out, json_schema_input_type=str | list[str]),
]


def _as_lists(value: Any) -> Any:
    """The axis of `via`: lists of points.

    A single list of points, such as `[[1, 2], [3, 4]]`, becomes an axis of one value.
    """
    points = as_list(value)
    # a point begins with a number or a text, a list of points with a list
    if all(isinstance(point, list) and point and type(point[0]) is not list for point in points):
        return [value]
    return value


_Coordinate = Annotated[float, Field(allow_inf_nan=False, strict=True)]


def _stop(written: Any, validate: ValidatorFunctionWrapHandler) -> tuple[float, ...]:
    """A via point, with its heading if any.

    The result is `(x, y)` or `(x, y, heading)`, the heading in rad. In the file, the heading is an
    angle or "free", or is left out.
    """
    heading = FREE
    if isinstance(written, list) and len(written) == 3:
        *written, heading = written
    point: tuple[float, ...] = validate(written)
    if heading == FREE:
        return point
    return (*point, parse_angle(heading))


_WrittenPoints = list[list[_Written]]
Points = tuple[tuple[float, ...], ...]
_Stop = Annotated[tuple[_Coordinate, _Coordinate], WrapValidator(_stop)]
# The via points of a scenario, or of several.
ViaLists = Annotated[
    tuple[tuple[_Stop, ...], ...],
    BeforeValidator(_as_lists, json_schema_input_type=_WrittenPoints | list[_WrittenPoints]),
]

"""Scenarios: a start pose, a target, a turning radius and a speed; one at a time or as a frame."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dubins_study.errors import DubinsStudyError
from dubins_study.study.angle import AngleError, parse_angle
from dubins_study.study.values import real_number, short

if TYPE_CHECKING:
    import pandas as pd


class Pose(NamedTuple):
    """Position (length unit) and heading (rad, counter-clockwise from +x)."""

    x: float
    y: float
    heading: float


class ScenarioError(DubinsStudyError, ValueError):
    """A scenario or a frame of scenarios that cannot be used; names the field, value and row."""


@dataclass(frozen=True, slots=True, init=False)
class Scenario:
    """One vehicle and one target.

    Args:
        x, y: start position; any length unit, the same for all lengths.
        heading: start heading, counter-clockwise from +x: rad, or a text such as `120deg`.
        target_x, target_y: target position.
        radius: minimum turning radius.
        speed: length units per time unit; travel time = length / speed.
        label: a text of the caller's choice.

    Raises:
        ScenarioError: if the target is missing, a number is none or not finite, `radius` or `speed`
            is not positive, or the label is no text.
    """

    x: float
    y: float
    heading: float
    target_x: float
    target_y: float
    radius: float
    speed: float
    label: str

    def __init__(
        self,
        x: float = 0.0,
        y: float = 0.0,
        heading: float | str = 0.0,
        target_x: float | None = None,
        target_y: float | None = None,
        radius: float = 1.0,
        speed: float = 1.0,
        label: str = "",
    ) -> None:
        given = (x, y, _heading(heading), target_x, target_y, radius, speed)
        for name, value in zip(NUMBERS, given, strict=True):
            object.__setattr__(self, name, _number(name, value))  # floats: 1 and 1.0 are one value
        object.__setattr__(self, "label", _label(label))
        if self.extent > LARGEST_EXTENT * self.radius:
            raise ScenarioError(_lost_in_rounding(self.extent, self.radius))

    @property
    def extent(self) -> float:
        """The size that coordinates are rounded against, `|x| + |y| + |target_x| + |target_y|`."""
        return abs(self.x) + abs(self.y) + abs(self.target_x) + abs(self.target_y)

    @property
    def start(self) -> Pose:
        return Pose(self.x, self.y, self.heading)

    def local(self) -> tuple[float, float]:
        """Target in the vehicle's frame in units of the radius: X forward, Y to the left.

        docs/derivation.md, eq. 1.
        """
        dx, dy = self.target_x - self.x, self.target_y - self.y
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return (dx * cos + dy * sin) / self.radius, (dy * cos - dx * sin) / self.radius


COLUMNS = tuple(field.name for field in fields(Scenario))
NUMBERS = COLUMNS[:-1]
_DEFAULTS: dict[str, Any] = {"speed": 1.0, "label": ""}
_POSITIVE = ("radius", "speed")
LARGEST, SMALLEST = 1e150, 1e-150  # beyond them squares overflow or vanish
LARGEST_EXTENT = 1e13  # radii; a path of ten times as many cannot be driven to within a radius


def _heading(text: float | str) -> float:
    """The heading, in rad where it is a text; anything else stays as it is."""
    if not isinstance(text, str):
        return text
    try:
        return parse_angle(text)
    except AngleError as error:
        expected = "expected a number, in radians, or an angle such as 120deg"
        raise ScenarioError(f"heading is {short(text)}; {expected} ({error})") from None


def _label(text: str) -> str:
    if not isinstance(text, str):
        raise ScenarioError(f"label is {short(text)}; expected a text")
    try:
        return str.encode(text).decode()  # a plain str of any subclass, as a row can hold it
    except UnicodeError:
        raise ScenarioError(f"label is {short(text)}; expected a text without surrogates") from None


def _number(name: str, value: float | None) -> float:
    if value is None:
        raise ScenarioError(f"{name} is missing; expected a number")
    try:
        number = real_number(value)
    except OverflowError:
        raise ScenarioError(
            f"{name} is {short(value)}; expected a number of size up to {LARGEST:g}"
        ) from None
    except Exception:  # of a class of the caller's
        raise ScenarioError(f"{name} is {short(value)}; expected a number") from None
    if problem := _problem(name, number):
        raise ScenarioError(problem)
    return number


def _lost_in_rounding(extent: float, radius: float) -> str:
    return (
        f"radius is {radius}; expected at least {extent / LARGEST_EXTENT:.3g} beside coordinates "
        f"of size {extent:.3g}, or the turning circles are lost in rounding"
    )


def _problem(name: str, value: float) -> str | None:
    if not math.isfinite(value):
        return f"{name} is {value}; expected a finite number"
    if name in _POSITIVE and value <= 0:
        return f"{name} is {value}; expected a number above 0"
    if abs(value) > LARGEST or (name in _POSITIVE and value < SMALLEST):
        least = f"from {SMALLEST:g} to" if name in _POSITIVE else "of size up to"
        return f"{name} is {value}; expected a number {least} {LARGEST:g}"
    return None


def missing_columns(names: Sequence[str]) -> str:
    """The beginning of a sentence about columns that a table of scenarios lacks."""
    return f"missing column{'s' if len(names) > 1 else ''} {', '.join(map(repr, names))}"


def check_frame(frame: pd.DataFrame) -> pd.DataFrame:
    """The frame with the columns of `COLUMNS` in order, float64 where they are numbers.

    `speed` and `label` may be left out, and a label that is missing is empty. The caller's frame
    is not changed; its index is kept. Columns of any type are read if each value is a number as
    `Scenario` takes it (a heading may be a text such as `120deg`) or, of `label`, a text. A
    `ScenarioError` names columns, or the first row that no scenario may have.
    """
    import pandas as pd

    if not isinstance(frame, pd.DataFrame):
        raise ScenarioError(f"expected a DataFrame of scenarios, got {type(frame).__name__}")
    names = list(frame.columns)
    expected = f"expected columns {', '.join(COLUMNS)}"
    if missing := [name for name in COLUMNS if name not in names and name not in _DEFAULTS]:
        raise ScenarioError(f"{missing_columns(missing)}; {expected}")
    if unknown := [name for name in names if name not in COLUMNS]:
        raise ScenarioError(f"unknown column {unknown[0]!r}; {expected}")
    if len(set(names)) < len(names):
        raise ScenarioError(f"a column appears twice; {expected}")
    checked: dict[str, Any] = {}
    for name in NUMBERS:
        checked[name] = (
            _column(frame, name) if name in names else np.full(len(frame), _DEFAULTS[name])
        )
    _check_extent(frame, checked)
    checked["label"] = _labels(frame) if "label" in names else ""
    return pd.DataFrame(checked, index=frame.index, copy=False)


def _column(frame: pd.DataFrame, name: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """One column of numbers as doubles, read-only."""
    if frame[name].dtype.kind in "iuf":
        with np.errstate(over="ignore"):
            values = frame[name].to_numpy(dtype=np.float64, na_value=np.nan)
    else:
        given = _each(frame, frame[name], lambda value: _cell(name, value))
        values = np.fromiter(given, np.float64, len(frame))
    # min and max see NaN and both infinities without a temporary array of the frame's length
    low, high = (values.min(), values.max()) if values.size else (1.0, 1.0)
    values = values.view()
    values.flags.writeable = False  # whoever gets the frame may read it
    least = SMALLEST if name in _POSITIVE else -LARGEST
    if least <= low and high <= LARGEST:  # neither holds for NaN
        return values
    row = int(np.argmin((least <= values) & (values <= LARGEST)))
    raise ScenarioError(f"{_row(frame, row)}: {_problem(name, float(values[row]))}")


def _cell(name: str, value: Any) -> float:
    """A number of a frame's row; NaN, which is refused with the column, where it is missing."""
    if value is None:
        return math.nan
    return _number(name, _heading(value) if name == "heading" else value)


def _labels(frame: pd.DataFrame) -> pd.Series[Any]:
    """The labels, empty where they are missing."""
    import pandas as pd
    from pandas.api.types import infer_dtype

    labels = frame["label"]
    if labels.dtype == "category":
        labels = labels.astype(object)
    missing = labels.isna()
    plain = infer_dtype(labels, skipna=False) in ("string", "empty") and not missing.any()
    if plain and all(map(str.isascii, labels.unique())):
        return frame["label"]
    texts = ["" if none else text for text, none in zip(labels, missing, strict=True)]
    return pd.Series(list(_each(frame, texts, _label)), frame.index, "str")


def _each(
    frame: pd.DataFrame, values: Iterable[Any], convert: Callable[[Any], Any]
) -> Iterator[Any]:
    """The values converted; an error names its row of the frame."""
    for row, value in enumerate(values):
        try:
            yield convert(value)
        except ScenarioError as error:
            raise ScenarioError(f"{_row(frame, row)}: {error}") from None


def _row(frame: pd.DataFrame, row: int) -> str:
    label = frame.index[row]
    return f"row {short(label.item() if isinstance(label, np.generic) else label)}"


def _check_extent(frame: pd.DataFrame, numbers: dict[str, Any]) -> None:
    if not len(frame):
        return
    largest = sum(
        max(abs(numbers[name].min()), abs(numbers[name].max()))
        for name in ("x", "y", "target_x", "target_y")
    )
    if largest <= LARGEST_EXTENT * numbers["radius"].min():
        return  # no row can be worse than the worst of every column together
    extent = sum(np.abs(numbers[name]) for name in ("x", "y", "target_x", "target_y"))
    for row in np.flatnonzero(extent > LARGEST_EXTENT * numbers["radius"])[:1]:
        problem = _lost_in_rounding(float(extent[row]), float(numbers["radius"][row]))
        raise ScenarioError(f"{_row(frame, int(row))}: {problem}")


def scenarios(frame: pd.DataFrame) -> Iterator[Scenario]:
    """The rows of a checked frame, one `Scenario` each."""
    for row in frame[list(COLUMNS)].itertuples(index=False, name=None):
        yield Scenario(*row)

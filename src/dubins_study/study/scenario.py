"""Scenarios: start pose, via points, target, final heading, turning radius and speed.

One at a time, or as a frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dubins_study.errors import DubinsStudyError
from dubins_study.study.angle import AngleError, parse_angle
from dubins_study.study.values import real_number, short
from dubins_study.study.words import (
    BRANCHES,
    FINAL_HEADING,
    FREE_FINAL_HEADING,
    POSE_BRANCHES,
    ROUTE_BRANCHES,
    VIA_POINTS,
)

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike, NDArray

    FloatArray = NDArray[np.float64]


class Pose(NamedTuple):
    """Position (length unit) and heading (rad, counter-clockwise from +x)."""

    x: float
    y: float
    heading: float


class ScenarioError(DubinsStudyError, ValueError):
    """A scenario or a frame of scenarios that cannot be used; names the field, value and row."""


@dataclass(frozen=True, slots=True, init=False)
class Scenario:
    """One vehicle, one target, and points to pass on the way there: none for most.

    Args:
        x, y: start position; any length unit, the same for all lengths.
        heading: start heading, counter-clockwise from +x: rad, or a text such as `120deg`.
        target_x, target_y: target position.
        radius: minimum turning radius.
        speed: length units per time unit; travel time = length / speed.
        label: a text of the caller's choice.
        via: points (x, y) to pass on the way, in this order: pairs of numbers, or an array of shape
            (n, 2). A scenario with via points is a route of n + 1 legs.
        final_heading: heading at the target, given as `heading` is; None is free.

    Raises:
        ScenarioError: if the target is missing, a number is none or not finite, `radius` or `speed`
            is not positive, the label is no text, or a via point is no pair or equal to the point
            before or after it.
    """

    x: float
    y: float
    heading: float
    target_x: float
    target_y: float
    radius: float
    speed: float
    label: str
    via: tuple[tuple[float, float], ...]
    final_heading: float | None

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
        via: ArrayLike | Iterable[Sequence[float]] = (),
        final_heading: float | str | None = None,
    ) -> None:
        given = (x, y, _heading("heading", heading), target_x, target_y, radius, speed)
        for name, value in zip(NUMBERS, given, strict=True):
            object.__setattr__(self, name, _number(name, value))  # floats: 1 and 1.0 are one value
        object.__setattr__(self, "label", _label(label))
        object.__setattr__(self, "via", _via(via))
        if final_heading is not None:
            angle = _heading("final_heading", final_heading)
            final_heading = _number("final_heading", angle)
        object.__setattr__(self, "final_heading", final_heading)
        if self.via:
            _check_neighbours(self._path_points())
        if self.extent > LARGEST_EXTENT * self.radius:
            raise ScenarioError(_lost_in_rounding(self.extent, self.radius))

    @property
    def extent(self) -> float:
        """What coordinates are rounded against, the largest size over the legs.

        Of a leg from (x1, y1) to (x2, y2) it is `|x1| + |y1| + |x2| + |y2|`. A sum over all points
        would grow with their number, and rounding does not.
        """
        if not self.via:
            return abs(self.x) + abs(self.y) + abs(self.target_x) + abs(self.target_y)
        return max(
            abs(x) + abs(y) + abs(u) + abs(v) for (x, y), (u, v) in pairwise(self._path_points())
        )

    @property
    def start(self) -> Pose:
        return Pose(self.x, self.y, self.heading)

    @property
    def legs(self) -> int:
        """How many parts the path has from one point to the next."""
        return len(self.via) + 1

    @property
    def points(self) -> FloatArray:
        """Start, via points and target, shape (legs + 1, 2)."""
        return np.array(self._path_points())

    def _path_points(self) -> list[tuple[float, float]]:
        return [(self.x, self.y), *self.via, (self.target_x, self.target_y)]

    @property
    def via_x(self) -> list[float] | None:
        """x of the via points, as a row holds them; None without."""
        return [x for x, _ in self.via] or None

    @property
    def via_y(self) -> list[float] | None:
        """y of the via points, as a row holds them; None without."""
        return [y for _, y in self.via] or None

    @property
    def one_free_leg(self) -> bool:
        """Whether there are no via points and the final heading is free."""
        return not self.via and self.final_heading is None

    @property
    def branches(self) -> tuple[str, ...]:
        """The branches that can be asked for."""
        if self.via:
            return ROUTE_BRANCHES
        return BRANCHES if self.final_heading is None else POSE_BRANCHES

    @property
    def needs(self) -> tuple[str, ...]:
        """What a solver must take to be asked; of `study.words.NEEDS`."""
        last = FREE_FINAL_HEADING if self.final_heading is None else FINAL_HEADING
        return (VIA_POINTS, last) if self.via else (last,)

    def local(self) -> tuple[float, float]:
        """Target in the vehicle's frame in units of the radius: X forward, Y to the left.

        docs/derivation.md, eq. 1.
        """
        dx, dy = self.target_x - self.x, self.target_y - self.y
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        return (dx * cos + dy * sin) / self.radius, (dy * cos - dx * sin) / self.radius


NUMBERS = ("x", "y", "heading", "target_x", "target_y", "radius", "speed")  # every scenario has
VIA = ("via_x", "via_y")
COLUMNS = (*NUMBERS, "label", *VIA, "final_heading")  # of frames, files and rows
# of the columns that a frame or a file may leave out
DEFAULTS: dict[str, Any] = {
    **{"speed": 1.0, "label": ""},
    **dict.fromkeys((*VIA, "final_heading")),
}
_POSITIVE = ("radius", "speed")
LARGEST, SMALLEST = 1e150, 1e-150  # beyond them squares overflow or vanish
LARGEST_EXTENT = 1e13  # radii; a path of ten times as many cannot be driven to within a radius


def _heading(name: str, text: float | str) -> float:
    """A heading, in rad where it is a text; anything else stays as it is."""
    if not isinstance(text, str):
        return text
    try:
        return parse_angle(text)
    except AngleError as error:
        expected = "expected a number, in radians, or an angle such as 120deg"
        raise ScenarioError(f"{name} is {short(text)}; {expected} ({error})") from None


_PAIRS = "expected pairs of numbers, such as [(4, 1), (6, -2)]"


def _via(points: Any) -> tuple[tuple[float, float], ...]:
    """The via points as pairs of floats."""
    if type(points) is tuple and not points:
        return ()
    if isinstance(points, str | bytes | Mapping | Set):  # which no order or no pairs are in
        raise ScenarioError(f"via is {short(points)}; {_PAIRS}")
    try:
        pairs = [tuple(point) for point in points]
    except Exception:  # of a class of the caller's
        raise ScenarioError(f"via is {short(points)}; {_PAIRS}") from None
    via = []
    for place, pair in enumerate(pairs, 1):
        if len(pair) != 2:
            raise ScenarioError(f"via point {place} is {short(pair)}; expected x and y")
        name = f"of via point {place}"
        via.append((_number(f"x {name}", pair[0]), _number(f"y {name}", pair[1])))
    return tuple(via)


def _check_neighbours(points: list[tuple[float, float]]) -> None:
    """Refuse a route with a leg between equal points, which has no length to be driven."""
    for place, (point, following) in enumerate(pairwise(points)):
        if point == following:
            if place == len(points) - 2:
                number, via, other = place, point, "the target"
            else:
                number, via = place + 1, following
                other = f"via point {place}" if place else "the start"
            expected = "expected a point apart from the points before and after it"
            raise ScenarioError(
                f"via point {number} is {short(via)}, the same point as {other}; {expected}"
            )


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

    Columns of `DEFAULTS` may be left out or lack values: a label is then empty, there are no via
    points, and the final heading is free. The caller's frame is not changed; its index is kept.
    Columns of any type are read if each value is a number as `Scenario` takes it (a heading may be
    a text such as `120deg`), of `label` a text, or of `via_x` and `via_y` a list of numbers or a
    text of numbers and spaces, such as `4 6`; a column `via` of lists of pairs stands for both. A
    `ScenarioError` names columns, or the first row that no scenario may have.
    """
    import pandas as pd

    if not isinstance(frame, pd.DataFrame):
        raise ScenarioError(f"expected a DataFrame of scenarios, got {type(frame).__name__}")
    if "via" in frame and not {*VIA} & {*frame}:  # as of a list of Scenarios
        frame = _with_via_columns(frame)
    names = list(frame.columns)
    expected = f"expected columns {', '.join(COLUMNS)}"
    if missing := [name for name in COLUMNS if name not in names and name not in DEFAULTS]:
        raise ScenarioError(f"{missing_columns(missing)}; {expected}")
    if unknown := [name for name in names if name not in COLUMNS]:
        raise ScenarioError(f"unknown column {unknown[0]!r}; {expected}")
    if len(set(names)) < len(names):
        raise ScenarioError(f"a column appears twice; {expected}")
    checked: dict[str, Any] = {}
    for name in NUMBERS:
        checked[name] = (
            _column(frame, name) if name in names else np.full(len(frame), DEFAULTS[name])
        )
    via = _via_lists(frame)
    _check_extent(frame, checked, via)
    checked["label"] = _labels(frame) if "label" in names else ""
    for row, lists in via.items():
        try:
            Scenario(**{name: checked[name][row] for name in NUMBERS}, via=_pairs(*lists))
        except ScenarioError as error:
            raise ScenarioError(f"{row_name(frame, row)}: {error}") from None
    for place, name in enumerate(VIA):
        checked[name] = list_column(len(frame), {row: lists[place] for row, lists in via.items()})
    checked["final_heading"] = (
        _column(frame, "final_heading", optional=True)
        if "final_heading" in names
        else np.broadcast_to(np.nan, len(frame))  # takes no memory
    )
    return pd.DataFrame(checked, index=frame.index, copy=False)


def list_column(n: int, lists: Mapping[int, list[float] | None]) -> Any:
    """A column of n lists of doubles, by row; null where there is none."""
    import pandas as pd
    import pyarrow as pa

    kind = pa.large_list(pa.float64())
    values: Any = (
        pa.array([lists.get(row) for row in range(n)], kind) if lists else pa.nulls(n, kind)
    )
    return pd.arrays.ArrowExtensionArray(values)  # nulls alone take no memory to speak of


def _with_via_columns(frame: pd.DataFrame) -> pd.DataFrame:
    """The frame with its column `via` written as `via_x` and `via_y`."""
    points = [*_each(frame, frame["via"], lambda via: () if is_missing(via) else _via(via))]
    via = {
        name: list_column(
            len(frame), {row: [p[axis] for p in via] for row, via in enumerate(points)}
        )
        for axis, name in enumerate(VIA)
    }
    return frame.drop(columns="via").assign(**via)


def _via_lists(frame: pd.DataFrame) -> dict[int, list[list[float] | None]]:
    """x and y of the via points by row, of the rows that have any."""
    columns = [frame.get(name) for name in VIA]
    if all(column is None or column.isna().all() for column in columns):
        return {}
    cells = [
        [None] * len(frame)
        if column is None
        else [*_each(frame, column, partial(numbers_of, name))]
        for name, column in zip(VIA, columns, strict=True)
    ]
    return {row: [*lists] for row, lists in enumerate(zip(*cells, strict=True)) if any(lists)}


def numbers_of(name: str, value: Any) -> list[float] | None:
    """A cell of `via_x` or `via_y`: a list of numbers, or a text of numbers and spaces.

    None for a cell without any. One number is a list of itself, since readers of CSV make numbers
    of such cells.
    """
    if is_missing(value):
        return None
    if isinstance(value, str):
        try:
            # Python takes an underscore within a number
            items: list[Any] = [float(text.replace("_", "?")) for text in value.split()]
        except ValueError:
            expected = "expected numbers separated by spaces, such as 4 6"
            raise ScenarioError(f"{name} is {short(value)}; {expected}") from None
    elif isinstance(value, list | tuple) or (isinstance(value, np.ndarray) and value.ndim == 1):
        items = list(value)
    else:
        items = [value]
    return [_number(name, item) for item in items] or None


def is_missing(value: Any) -> bool:
    """Whether a cell is empty: None, NaN, or pandas' NA."""
    return value is None or (isinstance(value, float) and math.isnan(value)) or _is_na(value)


def _is_na(value: Any) -> bool:
    return type(value).__name__ in ("NAType", "NaTType")


def _pairs(xs: list[float] | None, ys: list[float] | None) -> list[tuple[float, float]]:
    """Via points from the cells of both columns."""
    xs, ys = xs or [], ys or []
    if len(xs) != len(ys):
        counts = f"via_x has {len(xs)} numbers and via_y has {len(ys)}"
        raise ScenarioError(f"{counts}; expected as many")
    return list(zip(xs, ys, strict=True))


def scenario_of(row: Mapping[Any, Any]) -> Scenario:
    """The scenario of a row that has the columns of `COLUMNS`, or some of them."""
    fields = {name: row[name] for name in (*NUMBERS, "label") if name in row}
    via = _pairs(*(numbers_of(name, row.get(name)) for name in VIA))
    final = row.get("final_heading")
    return Scenario(**fields, via=via, final_heading=None if is_missing(final) else final)


def _column(
    frame: pd.DataFrame, name: str, *, optional: bool = False
) -> np.ndarray[Any, np.dtype[np.float64]]:
    """One column of numbers as doubles, read-only; NaN is a number of an optional one."""
    if frame[name].dtype.kind in "iuf":
        with np.errstate(over="ignore"):
            values = frame[name].to_numpy(dtype=np.float64, na_value=np.nan)
    else:
        given = _each(frame, frame[name], lambda value: _cell(name, value))
        values = np.fromiter(given, np.float64, len(frame))
    # min and max see NaN and both infinities without a temporary array of the frame's length
    low, high = (values.min(), values.max()) if values.size else (1.0, 1.0)
    if optional:
        low, high = np.fmin.reduce(values, initial=1.0), np.fmax.reduce(values, initial=1.0)
    values = values.view()
    values.flags.writeable = False  # whoever gets the frame may read it
    least = SMALLEST if name in _POSITIVE else -LARGEST
    if least <= low and high <= LARGEST:  # neither holds for NaN
        return values
    fits = (least <= values) & (values <= LARGEST)
    row = int(np.argmin(fits | np.isnan(values) if optional else fits))
    raise ScenarioError(f"{row_name(frame, row)}: {_problem(name, float(values[row]))}")


def _cell(name: str, value: Any) -> float:
    """A number of a frame's row; NaN, which is refused with the column, where it is missing."""
    if value is None or (name == "final_heading" and is_missing(value)):
        return math.nan
    return _number(name, _heading(name, value) if name.endswith("heading") else value)


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
            raise ScenarioError(f"{row_name(frame, row)}: {error}") from None


def row_name(frame: pd.DataFrame, row: int) -> str:
    """A row of a frame in messages, by its label."""
    label = frame.index[row]
    return f"row {short(label.item() if isinstance(label, np.generic) else label)}"


def _check_extent(frame: pd.DataFrame, numbers: dict[str, Any], routes: Iterable[int]) -> None:
    """Refuse a row of one leg whose turning circles are lost in rounding."""
    if not len(frame):
        return
    largest = sum(
        max(abs(numbers[name].min()), abs(numbers[name].max()))
        for name in ("x", "y", "target_x", "target_y")
    )
    if largest <= LARGEST_EXTENT * numbers["radius"].min():
        return  # no row can be worse than the worst of every column together
    extent = sum(np.abs(numbers[name]) for name in ("x", "y", "target_x", "target_y"))
    lost = extent > LARGEST_EXTENT * numbers["radius"]
    lost[list(routes)] = False
    for row in np.flatnonzero(lost)[:1]:
        problem = _lost_in_rounding(float(extent[row]), float(numbers["radius"][row]))
        raise ScenarioError(f"{row_name(frame, int(row))}: {problem}")


def scenarios(frame: pd.DataFrame) -> Iterator[Scenario]:
    """The rows of a checked frame, one `Scenario` each."""
    for row in frame[list(COLUMNS)].itertuples(index=False, name=None):
        yield scenario_of(dict(zip(COLUMNS, row, strict=True)))

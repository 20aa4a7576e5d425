"""Scenarios: start pose, via points, target, final heading, turning radius and speed.

One at a time, or as a frame.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dubins_study.errors import DubinsStudyError
from dubins_study.study.angle import FULL_TURN, AngleError, parse_angle
from dubins_study.study.values import did_you_mean, real_number, short
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
        heading: start heading, counter-clockwise from +x: rad, or a text such as `120deg`. A number
            beyond a full turn gives a warning, since it may be one of degrees.
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
        angle = None
        if final_heading is not None:
            angle = _number("final_heading", _heading("final_heading", final_heading))
        object.__setattr__(self, "final_heading", angle)
        # within the package, and of a scenario with `replace`d fields, numbers are in radians
        caller = sys._getframe(1).f_globals.get("__name__", "")
        if not caller.startswith(("dubins_study.", "dataclasses")):
            for name, written in (("heading", heading), ("final_heading", final_heading)):
                if not isinstance(written, str) and abs(getattr(self, name) or 0.0) > FULL_TURN:
                    warnings.warn(f"{name} {_DEGREES}", stacklevel=2)
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
_HEADINGS = ("heading", "final_heading")
# the same for all numbers, so that Python shows it once a line, of a heading that is integrated too
_DEGREES = (
    "is a number of more than a full turn, taken as radians; of degrees write the unit, such as "
    "'90deg'"
)
LARGEST, SMALLEST = 1e150, 1e-150  # beyond them squares overflow or vanish
LARGEST_EXTENT = 1e13  # radii; a path of ten times as many cannot be driven to within a radius


def _heading(name: str, text: float | str) -> float:
    """A heading, in rad where it is a text; anything else stays as it is."""
    if not isinstance(text, str):
        return text
    try:
        return parse_angle(text)
    except AngleError as error:
        raise ScenarioError(f"{name}: {error}") from None


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
            vias = [f"via point {number}" for number in range(1, len(points) - 1)]
            before, this = ["the start", *vias, "the target"][place : place + 2]
            raise ScenarioError(
                f"{this} is {short(following)}, the same point as {before}; "
                "expected a point apart from the points before and after it"
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


def column_problems(names: Sequence[Any]) -> list[str]:
    """What is wrong with the names of the columns of a table of scenarios, a sentence each."""
    required = [name for name in COLUMNS if name not in DEFAULTS]
    expected = f"expected the columns {', '.join(required)} and, if wanted, {', '.join(DEFAULTS)}"
    problems = []
    if missing := [name for name in required if name not in names]:
        several = "s" if len(missing) > 1 else ""
        problems.append(f"missing column{several} {', '.join(map(repr, missing))}; {expected}")
    for name in dict.fromkeys(names):
        if name not in COLUMNS:
            near = did_you_mean(name, [known for known in COLUMNS if known not in names])
            problems.append(f"unknown column {short(name)}; {near}{expected}")
        elif names.count(name) > 1:
            problems.append(f"column {name!r} appears twice")
    return problems


def check_frame(frame: pd.DataFrame) -> pd.DataFrame:
    """The frame with the columns of `COLUMNS` in order, float64 where they are numbers.

    Columns of `DEFAULTS` may be left out; a cell without a label, via points or a final heading may
    be empty. The caller's frame is not changed; its index is kept. Each value is read as `Scenario`
    takes it, or in `via_x` and `via_y` as `numbers_of` does; a column `via` of lists of pairs
    stands for both. A `ScenarioError` names columns, or the first row that no scenario may have. A
    heading beyond a full turn that is no text gives a warning, as a scenario's does.
    """
    import pandas as pd

    if not isinstance(frame, pd.DataFrame):
        raise ScenarioError(f"expected a DataFrame of scenarios, got {type(frame).__name__}")
    names = list(frame.columns)
    if problems := column_problems([name for name in names if name != "via"]):
        raise ScenarioError(problems[0])
    if "via" in names and {*VIA} & {*names}:
        raise ScenarioError("via points are given twice; expected via, or via_x and via_y")
    columns = _columns_of_numbers(frame) or _columns_row_by_row(frame)
    for name in {*_HEADINGS} & {*names}:
        beyond = np.abs(columns[name]) > FULL_TURN
        if beyond.any() and not all(isinstance(angle, str) for angle in frame[name][beyond]):
            warnings.warn(f"{name} {_DEGREES}", stacklevel=4)  # at the call of `solve_frame`
    return pd.DataFrame(columns, index=frame.index, copy=False)


def _columns_of_numbers(frame: pd.DataFrame) -> dict[str, Any] | None:
    """The columns of one leg a row, each checked as a whole; None if rows are to be looked at."""
    n = len(frame)
    if not n or any(name in frame and not frame[name].isna().all() for name in ("via", *VIA)):
        return None
    columns: dict[str, Any] = {}
    for name in NUMBERS:
        columns[name] = _doubles(frame, name) if name in frame else np.full(n, DEFAULTS[name])
    columns["label"] = _labels(frame) if "label" in frame else ""
    columns |= dict.fromkeys(VIA, list_column(n, {}))
    columns["final_heading"] = (
        _doubles(frame, "final_heading")
        if "final_heading" in frame
        else np.broadcast_to(np.nan, n)  # takes no memory
    )
    if any(column is None for column in columns.values()):
        return None
    places = [columns[name] for name in ("x", "y", "target_x", "target_y")]
    largest = LARGEST_EXTENT * columns["radius"]
    # no row can be worse than the worst of every column together
    worst = sum(max(abs(place.min()), abs(place.max())) for place in places)
    if worst > largest.min() and np.any(sum(map(np.abs, places)) > largest):
        return None
    return columns


def _doubles(frame: pd.DataFrame, name: str) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    """A column of numbers as doubles, read-only; None if one of them is refused, or is a text."""
    if frame[name].dtype.kind not in "iuf":
        return None
    with np.errstate(over="ignore"):
        values = frame[name].to_numpy(dtype=np.float64, na_value=np.nan).view()
    values.flags.writeable = False  # whoever gets the frame may read it
    # min and max see NaN and both infinities without a temporary array of the frame's length
    low, high = values.min(), values.max()
    if name == "final_heading":  # free where it is NaN
        low, high = np.fmin.reduce(values, initial=1.0), np.fmax.reduce(values, initial=1.0)
    least = SMALLEST if name in _POSITIVE else -LARGEST
    return values if least <= low and high <= LARGEST else None  # neither holds for NaN


def _labels(frame: pd.DataFrame) -> pd.Series[Any] | None:
    """The labels, if each is a text that a row can hold."""
    from pandas.api.types import infer_dtype

    labels = frame["label"]
    if infer_dtype(labels, skipna=False) != "string" or labels.isna().any():
        return None
    storable = (text == text.encode("utf-8", "ignore").decode() for text in labels.unique())
    return labels if all(storable) else None


def _columns_row_by_row(frame: pd.DataFrame) -> dict[str, Any]:
    """The columns of any frame; the first row that no scenario may have is refused."""
    import pandas as pd

    n, names = len(frame), (*NUMBERS, "final_heading")
    numbers, labels = np.empty((len(names), n)), []
    via: dict[str, dict[int, list[float] | None]] = {name: {} for name in VIA}
    for row, values in enumerate(frame.itertuples(index=False, name=None)):
        try:
            scenario = scenario_of(dict(zip(frame.columns, values, strict=True)))
        except ScenarioError as error:
            raise ScenarioError(f"{row_name(frame, row)}: {error}") from None
        numbers[:, row] = [getattr(scenario, name) for name in names]  # NaN for None
        labels.append(scenario.label)
        if scenario.via:
            via["via_x"][row], via["via_y"][row] = scenario.via_x, scenario.via_y
    columns: dict[str, Any] = dict(zip(names, numbers, strict=True))
    columns["label"] = pd.array(labels, "str")
    columns |= {name: list_column(n, lists) for name, lists in via.items()}
    return {name: columns[name] for name in COLUMNS}


def list_column(n: int, lists: Mapping[int, list[float] | None]) -> Any:
    """A column of n lists of doubles, by row; null where there is none."""
    import pandas as pd
    import pyarrow as pa

    kind = pa.large_list(pa.float64())
    values: Any = (
        pa.array([lists.get(row) for row in range(n)], kind) if lists else pa.nulls(n, kind)
    )
    return pd.arrays.ArrowExtensionArray(values)  # nulls alone take no memory to speak of


def row_name(frame: pd.DataFrame, row: int) -> str:
    """A row of a frame in messages, by its label."""
    label = frame.index[row]
    return f"row {short(label.item() if isinstance(label, np.generic) else label)}"


def scenarios(frame: pd.DataFrame) -> Iterator[Scenario]:
    """The rows of a checked frame, one `Scenario` each."""
    for row in frame[list(COLUMNS)].itertuples(index=False, name=None):
        yield scenario_of(dict(zip(COLUMNS, row, strict=True)))


def scenario_of(row: Mapping[Any, Any]) -> Scenario:
    """The scenario of a row that has the columns of `COLUMNS`, or some of them."""
    fields = {name: row[name] for name in NUMBERS if name in row}
    for name in ("label", "final_heading"):
        if not is_missing(row.get(name)):
            fields[name] = row[name]
    via: Any = row.get("via")
    if is_missing(via):
        xs, ys = (numbers_of(name, row.get(name)) or [] for name in VIA)
        if len(xs) != len(ys):
            counts = f"via_x has {len(xs)} numbers and via_y has {len(ys)}"
            raise ScenarioError(f"{counts}; expected as many")
        via = zip(xs, ys, strict=True)
    return Scenario(**fields, via=via)


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
    return (
        value is None
        or (isinstance(value, float) and math.isnan(value))
        or type(value).__name__ in ("NAType", "NaTType")
    )

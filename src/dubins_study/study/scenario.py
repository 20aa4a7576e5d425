"""Scenarios: start pose, via points, target, final heading, turning radius and speed."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence, Set
from dataclasses import InitVar, dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from dubins_study.errors import DubinsStudyError
from dubins_study.study.angle import LARGEST_BARE, AngleError, parse_angle
from dubins_study.study.values import real_number, short
from dubins_study.study.words import NEEDS

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from dubins_study.study.arrays import FloatArray


class Pose(NamedTuple):
    """Position (length unit) and heading (rad, counter-clockwise from +x)."""

    x: float
    y: float
    heading: float


class Stop(NamedTuple):
    """A point that a path passes or ends at, and the heading there (rad); None is free."""

    x: float
    y: float
    heading: float | None


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
    # Whether numbers beyond a full turn are known to be radians, and so give no warning. Those of a
    # scenario are: `replace` passes this default on.
    _radians: InitVar[bool] = True

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
        *,
        _radians: bool = False,
    ) -> None:
        numbers = (x, y, heading, target_x, target_y, radius, speed, final_heading)
        for name, value in zip((*NUMBERS, "final_heading"), numbers, strict=True):
            number = None
            if name != "final_heading" or value is not None:
                number = checked_number(name, value)
            object.__setattr__(self, name, number)
            known = _radians or isinstance(value, str)
            if name in HEADINGS and not known and abs(number or 0.0) > LARGEST_BARE:
                warnings.warn(f"{name} {DEGREES}", stacklevel=2)
        object.__setattr__(self, "label", _label(label))
        object.__setattr__(self, "via", _via(via))
        if self.via:
            _check_neighbours(self._path_points())
        if self.extent > LARGEST_EXTENT * self.radius:
            least = f"at least {self.extent / LARGEST_EXTENT:.3g}"
            raise ScenarioError(
                f"radius is {self.radius}; expected {least} beside coordinates of size "
                f"{self.extent:.3g}, or the turning circles are lost in rounding"
            )

    @property
    def extent(self) -> float:
        """What coordinates are rounded against, the largest size over the legs.

        Of a leg from (x1, y1) to (x2, y2) it is `|x1| + |y1| + |x2| + |y2|`. A sum over all points
        would grow with their number, and rounding does not.
        """
        return max(
            abs(x) + abs(y) + abs(u) + abs(v) for (x, y), (u, v) in pairwise(self._path_points())
        )

    @property
    def start(self) -> Pose:
        return Pose(self.x, self.y, self.heading)

    @property
    def stops(self) -> tuple[Stop, ...]:
        """The via points, then the target."""
        last = Stop(self.target_x, self.target_y, self.final_heading)
        return (*(Stop(x, y, None) for x, y in self.via), last)

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
        """Whether this is the paper's problem; for solvers, which may not know the kinds' answers.

        Everything else asks `study.kinds.table`.
        """
        return not any(self.given)

    @property
    def given(self) -> tuple[bool, ...]:
        """Whether each of the fields of `OPTIONAL` has a value."""
        return bool(self.via), self.final_heading is not None

    @property
    def needs(self) -> tuple[str, ...]:
        """What a solver must take to be asked; of `study.words.NEEDS`."""
        has = dict(zip(OPTIONAL, self.given, strict=True))
        return tuple(need for need, (name, given) in NEEDS.items() if has[name] == given)

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
# of the columns that a frame or a file may leave out: all but the target's
DEFAULTS: dict[str, Any] = {
    **{"x": 0.0, "y": 0.0, "heading": 0.0, "radius": 1.0, "speed": 1.0, "label": ""},
    **dict.fromkeys((*VIA, "final_heading")),
}
OPTIONAL = ("via", "final_heading")  # fields that tell the kinds of questions apart
POSITIVE = ("radius", "speed")
HEADINGS = ("heading", "final_heading")
# the same for all numbers, so that Python shows it once a line, of a heading that is integrated too
DEGREES = (
    "is a number of more than a full turn, taken as radians; if it is in degrees, write the "
    "unit, such as '90deg'"
)
LARGEST, SMALLEST = 1e150, 1e-150  # beyond them squares overflow or vanish
LARGEST_EXTENT = 1e13  # radii; a path of ten times as many cannot be driven to within a radius


_CONVENTION = "counterclockwise from +x (east), so north is 90deg"
_PAIRS = "expected pairs of numbers, such as [(4, 1), (6, -2)], or a frame with columns x and y"


def _via(points: Any) -> tuple[tuple[float, float], ...]:
    """The via points as pairs of floats."""
    try:
        if hasattr(points, "columns"):  # a frame that is iterated gives the names of its columns
            points = points[["x", "y"]].to_numpy()
        pairs = [(x, y) for x, y in points]
        if isinstance(points, Set):
            raise TypeError("a set has no order")
    except Exception:  # of a class of the caller's
        raise ScenarioError(f"via is {short(points)}; {_PAIRS}") from None
    via = []
    for place, (x, y) in enumerate(pairs, 1):
        name = f"of via point {place}"
        via.append((checked_number(f"x {name}", x), checked_number(f"y {name}", y)))
    return tuple(via)


def _check_neighbours(points: list[tuple[float, float]]) -> None:
    """Refuse a route with a leg between equal points, which has no length to be driven."""
    for place, (point, following) in enumerate(pairwise(points), 1):
        if point == following:
            this = f"via point {place}" if place < len(points) - 1 else "the target"
            raise ScenarioError(
                f"{this} is {short(following)}, the same point as the one before it; "
                "expected a point apart from the points before and after it"
            )


def _label(text: str) -> str:
    try:
        return str.encode(text).decode()  # a plain str of any subclass, as a row can hold it
    except (TypeError, UnicodeError):
        raise ScenarioError(f"label is {short(text)}; expected a text") from None


def checked_number(name: str, value: float | str | None) -> float:
    """The value as a float, if the field of this name may have it: a text is one of a heading."""
    if value is None:
        raise ScenarioError(f"{name} is missing; expected a number")
    try:
        if isinstance(value, str) and name in HEADINGS:
            value = parse_angle(value)
        number = real_number(value)
    except AngleError as error:
        raise ScenarioError(f"{name}: {error}, {_CONVENTION}") from None
    except Exception:  # of a class of the caller's
        raise ScenarioError(f"{name} is {short(value)}; expected a number") from None
    least = SMALLEST if name in POSITIVE else -LARGEST
    if not least <= number <= LARGEST:  # nor is NaN
        expected = f"a finite number of size up to {LARGEST:g}"
        if name in POSITIVE:
            expected = f"a number above 0, from {SMALLEST:g} to {LARGEST:g}"
        raise ScenarioError(f"{name} is {number}; expected {expected}")
    return number

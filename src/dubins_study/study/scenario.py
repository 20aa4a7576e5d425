"""Scenarios: the questions that solvers are asked.

A scenario has a start pose, via points, a target, a final heading, a turning radius and a speed.
"""

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
from dubins_study.study.tangent_plane import check_place, middle_of, plane_at
from dubins_study.study.values import real_number, short
from dubins_study.study.words import NEEDS, Order

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from dubins_study.study.arrays import FloatArray


class Pose(NamedTuple):
    """Position (length unit) and heading (rad).

    The heading is counter-clockwise from +x.
    """

    x: float
    y: float
    heading: float


class Stop(NamedTuple):
    """A point to pass or to end at.

    The heading there (rad) is None where it is free.
    """

    x: float
    y: float
    heading: float | None = None


class ScenarioError(DubinsStudyError, ValueError):
    """A scenario, or a frame of them, is unusable.

    The message names the field, the value and the row.
    """


@dataclass(frozen=True, slots=True, init=False)
class Scenario:
    """One vehicle and the points it must reach.

    Most scenarios have a target and no via points.

    Args:
        x, y: start position; any length unit, the same for all lengths.
        heading: start heading, counter-clockwise from +x: rad, or a text such as `120deg`. A number
            beyond a full turn gives a warning, since it may be one of degrees. None, or the text
            `free`, leaves it free.
        target_x, target_y: target position; left out of a closed path, and of a tour that may end
            at any of its points.
        radius: minimum turning radius.
        speed: length units per time unit; travel time = length / speed.
        label: a text of the caller's choice.
        via: points (x, y) to pass on the way: pairs of numbers, or an array of shape (n, 2). A
            third value (x, y, heading) is the heading there, given as `heading` is. A scenario with
            via points is a route of n + 1 legs.
        final_heading: heading at the target, given as `heading` is; None is free.
        order: `given` if the via points are passed in their order, `free` if in any (a tour). The
            target stays last. Without via points it is `given`.
        closed: whether the path ends as it starts, in place and heading.

    Raises:
        ScenarioError: if the target is missing or one too many, a number is none or not finite,
            `radius` or `speed` is not positive, the label is no text, or a via point is no pair or
            equal to the point before or after it (of a tour: to any other).
    """

    x: float
    y: float
    heading: float | None
    target_x: float | None
    target_y: float | None
    radius: float
    speed: float
    label: str
    via: tuple[tuple[float, ...], ...]
    final_heading: float | None
    order: Order
    closed: bool
    # Whether headings beyond a full turn are known to be radians, and so give no warning. Those of
    # a scenario are: `dataclasses.replace` passes this default. A caller's `Scenario(...)` has the
    # default of `__init__`, which is False.
    _radians: InitVar[bool] = True

    def __init__(
        self,
        x: float = 0.0,
        y: float = 0.0,
        heading: float | str | None = 0.0,
        target_x: float | None = None,
        target_y: float | None = None,
        radius: float = 1.0,
        speed: float = 1.0,
        label: str = "",
        via: ArrayLike | Iterable[Sequence[Any]] = (),
        final_heading: float | str | None = None,
        order: str = Order.GIVEN,
        closed: bool = False,
        *,
        _radians: bool = False,
    ) -> None:
        object.__setattr__(self, "order", checked_order(order))
        object.__setattr__(self, "closed", _closed(closed))
        object.__setattr__(self, "via", _via(via, _radians))
        no_target = target_x is None and target_y is None
        ends_anywhere = self.closed or (self.order is Order.FREE and no_target)
        if ends_anywhere:
            _refuse_target(
                closed=self.closed,
                target_x=target_x,
                target_y=target_y,
                final_heading=final_heading,
                via=self.via,
            )
        # in the order of `NUMBERS`, then the final heading
        numbers = (x, y, heading, target_x, target_y, radius, speed, final_heading)
        for name, value in zip((*NUMBERS, "final_heading"), numbers, strict=True):
            if name in HEADINGS:
                number = _heading(name, value, _radians, stacklevel=3)
            elif ends_anywhere and name.startswith("target"):
                number = None
            else:
                number = checked_number(name, value)
            object.__setattr__(self, name, number)
        object.__setattr__(self, "label", _label(label))
        if self.via:
            _check_neighbours(self._path_points(), self.order, self.target)
        else:
            object.__setattr__(self, "order", Order.GIVEN)
        if self.extent > LARGEST_EXTENT * self.radius:
            least = f"at least {self.extent / LARGEST_EXTENT:.3g}"
            raise ScenarioError(
                f"radius is {self.radius}; expected {least} beside coordinates of size "
                f"{self.extent:.3g}, or the turning circles are lost in rounding"
            )

    @classmethod
    def from_lonlat(
        cls,
        start: Sequence[float],
        target: Sequence[float] | None = None,
        *,
        via: Iterable[Sequence[Any]] = (),
        origin: tuple[float, float] | None = None,
        **fields: Any,
    ) -> Scenario:
        """Scenario of places on Earth, in metres.

        The coordinates are on the tangent plane at an origin.

        Args:
            start, target: longitude and latitude (degrees, WGS 84); no target as in a scenario.
            via: places to pass, each maybe with a heading, as (longitude, latitude, heading).
            origin: latitude and longitude (degrees), as `Path.to_geojson` takes them, which is the
                inverse; default: the middle of the box around all places.
            fields: the other fields of a scenario. The radius is in metres; headings are
                counterclockwise from the plane's +x, which is east at the origin.

        Raises:
            PlaceError: if a place or the origin is none on Earth.
            ScenarioError: if they are no pairs, and for the same reasons as `Scenario` itself.
        """
        passed = list(via)
        places = [start, *passed]
        if target is not None:
            places.append(target)
        try:
            degrees = [(place[0], place[1]) for place in places]
        except (TypeError, LookupError):
            message = f"expected pairs of longitude and latitude; given is {short(places)}"
            raise ScenarioError(message) from None
        for longitude, latitude in degrees:
            check_place(
                checked_number("longitude", longitude), checked_number("latitude", latitude)
            )
        plane = middle_of(degrees)
        if origin is not None:
            plane = plane_at(origin)
        (x, y), *points = plane.to_plane(degrees).tolist()
        if target is not None:
            fields["target_x"], fields["target_y"] = points.pop()
        stops = [(*point, *place[2:]) for point, place in zip(points, passed, strict=True)]
        return cls(x, y, via=stops, **fields)

    @property
    def extent(self) -> float:
        """Size that coordinates are rounded against.

        It is the largest size over the legs (length unit). The size of a leg from (x1, y1) to (x2,
        y2) is `|x1| + |y1| + |x2| + |y2|`. A sum over all points would grow with their number, and
        rounding does not. In a tour any two points may be a leg.
        """
        points = self._path_points()
        if self.order is Order.FREE:
            first, second, *_ = sorted((abs(x) + abs(y) for x, y in points), reverse=True)
            return first + second
        return max(abs(x) + abs(y) + abs(u) + abs(v) for (x, y), (u, v) in pairwise(points))

    @property
    def start(self) -> Pose:
        """Start pose.

        Raises:
            ScenarioError: if its heading is free.
        """
        if self.heading is None:
            raise ScenarioError(
                "heading is free: only a path has a start pose, `answer.path.start`"
            )
        return Pose(self.x, self.y, self.heading)

    @property
    def target(self) -> tuple[float, float] | None:
        """Position where the path ends.

        It is the start if the path is closed, and None if any point may be the last.
        """
        if self.closed:
            return self.x, self.y
        if self.target_x is None or self.target_y is None:
            return None
        return self.target_x, self.target_y

    @property
    def stops(self) -> tuple[Stop, ...]:
        """Via points, then the target if there is one."""
        via = [Stop(*point) for point in self.via]
        if self.target is None:
            return tuple(via)
        final_heading = self.final_heading
        if self.closed:
            final_heading = self.heading
        return (*via, Stop(*self.target, final_heading))

    @property
    def legs(self) -> int:
        """Number of legs, from one point to the next."""
        return len(self.via) + (self.target is not None)

    @property
    def points(self) -> FloatArray:
        """Positions of start, via points and target.

        Shape (legs + 1, 2).
        """
        return np.array(self._path_points())

    def _path_points(self) -> list[tuple[float, float]]:
        return [(self.x, self.y), *((x, y) for x, y, _ in self.stops)]

    def starts(self, path_start: Pose) -> bool:
        """Whether a path's start pose fits the scenario.

        A free heading fits any.
        """
        return path_start[:2] == (self.x, self.y) and self.heading in (None, path_start.heading)

    @property
    def via_x(self) -> list[float] | None:
        """x of the via points; None without any.

        Rows hold them in this form.
        """
        return [point[0] for point in self.via] or None

    @property
    def via_y(self) -> list[float] | None:
        """y of the via points; None without any.

        Rows hold them in this form.
        """
        return [point[1] for point in self.via] or None

    @property
    def via_heading(self) -> list[float] | None:
        """Headings at the via points.

        A free heading is NaN; None if all are free. Rows hold them in this form.
        """
        if all(len(point) == 2 for point in self.via):
            return None
        return [(*point, math.nan)[2] for point in self.via]

    @property
    def one_free_leg(self) -> bool:
        """Whether this is the paper's problem.

        Solvers ask this property, since they must not import the kinds, which know the answers. All
        other code asks `study.kinds.table`.
        """
        return not any(self.given)

    @property
    def given(self) -> tuple[bool, ...]:
        """Which of the fields of `OPTIONAL` are given.

        A flag for each field, in their order. It is true if the scenario differs there from the
        paper's problem. A closed path ends with its start heading: if that is given, so is the
        final heading.
        """
        free_start = self.heading is None
        return (
            bool(self.via),  # via
            bool(self.via) or free_start,  # searched
            self.final_heading is not None or (self.closed and not free_start),  # final_heading
            self.via_heading is not None,  # via_heading
            free_start,  # free_start
            self.order is Order.FREE,  # order
            self.closed,  # closed
        )

    @property
    def needs(self) -> tuple[str, ...]:
        """Needs that a solver must be able to take.

        They are keys of `study.words.NEEDS`, such as `via points` or `free final heading`.
        """
        has = dict(zip(OPTIONAL, self.given, strict=True))
        return tuple(need for need, (name, given) in NEEDS.items() if has[name] == given)

    def local(self) -> tuple[float, float]:
        """Target in the vehicle's frame, in radii.

        X points forward, Y to the left (docs/derivation.md, eq. 1).
        """
        assert self.target is not None
        dx = self.target[0] - self.x
        dy = self.target[1] - self.y
        cos = math.cos(self.start.heading)
        sin = math.sin(self.start.heading)
        return (dx * cos + dy * sin) / self.radius, (dy * cos - dx * sin) / self.radius


NUMBERS = ("x", "y", "heading", "target_x", "target_y", "radius", "speed")  # every scenario has
VIA = ("via_x", "via_y", "via_heading")
TOUR = ("order", "closed")
COLUMNS = (*NUMBERS, "label", *VIA, "final_heading", *TOUR)  # of frames, files and rows
# for the columns that a frame or a file may leave out: all but the target's
DEFAULTS: dict[str, Any] = {
    **{"x": 0.0, "y": 0.0, "heading": 0.0, "radius": 1.0, "speed": 1.0, "label": ""},
    **dict.fromkeys((*VIA, "final_heading")),
    **{"order": Order.GIVEN, "closed": False},
}
# Fields that distinguish the kinds of questions. A scenario is `searched` if no closed form answers
# it: it has via points, or a free start heading.
OPTIONAL = ("via", "searched", "final_heading", "via_heading", "free_start", "order", "closed")
POSITIVE = ("radius", "speed")
HEADINGS = ("heading", "final_heading")
# The text contains no value: so Python warns once for each line of code, even if a loop there makes
# many headings.
DEGREES = (
    "is a number of more than a full turn, taken as radians; if it is in degrees, write the "
    "unit, such as '90deg'"
)
LARGEST = 1e150  # the square of a larger number overflows
SMALLEST = 1e-150  # the square of a smaller number vanishes
LEAST = dict.fromkeys(POSITIVE, SMALLEST)  # by field; that of any other is -LARGEST
LARGEST_EXTENT = 1e13  # radii; a path of ten times as many cannot be driven to within a radius


CONVENTION = "counterclockwise from +x (east), so north is 90deg"
_PAIRS = (
    "expected pairs of numbers, such as [(4, 1), (6, -2)], or three with a heading, "
    "or a frame with columns x and y"
)
FREE = "free"  # the text of a heading that is not given


def _via(points: Any, radians: bool) -> tuple[tuple[float, ...], ...]:
    """Via points as tuples of floats.

    Each is x, y and, where it is given, the heading.
    """
    try:
        if hasattr(points, "columns"):  # a frame that is iterated gives the names of its columns
            cells = points[["x", "y", *(name for name in points.columns if name == "heading")]]
            points = cells.astype(object).where(cells.notna(), None).to_numpy()
        stops = [(x, y, *heading) for x, y, *heading in points]
        if isinstance(points, Set) or any(len(stop) > 3 for stop in stops):
            raise TypeError
    except Exception:  # of a class of the caller's
        raise ScenarioError(f"via is {short(points)}; {_PAIRS}") from None
    via: list[tuple[float, ...]] = []
    for place, (x, y, *headings) in enumerate(stops, 1):
        name = f"of via point {place}"
        point = [checked_number(f"x {name}", x), checked_number(f"y {name}", y)]
        if headings:
            heading = _heading(f"heading {name}", headings[0], radians, stacklevel=4)
            if heading is not None:
                point.append(heading)
        via.append(tuple(point))
    return tuple(via)


def _heading(name: str, value: float | str | None, radians: bool, stacklevel: int) -> float | None:
    """Heading (rad), or None if it is free.

    A number that seems to be in degrees gives a warning, unless `radians` says that it is not.
    `stacklevel` is that of the warning: the call of `Scenario`.
    """
    if value is None or (isinstance(value, str) and value == FREE):
        return None
    number = checked_number(name, value)
    if not radians and not isinstance(value, str) and abs(number) > LARGEST_BARE:
        warnings.warn(f"{name} {DEGREES}", stacklevel=stacklevel)
    return number


def checked_order(order: str) -> Order:
    """Order as one of `Order`.

    Any other text is a `ScenarioError`.
    """
    try:
        return Order(order)
    except ValueError:
        raise ScenarioError(f"order is {short(order)}; expected {' or '.join(Order)}") from None


def _closed(value: Any) -> bool:
    if not isinstance(value, bool | np.bool_):
        raise ScenarioError(f"closed is {short(value)}; expected true or false")
    return bool(value)


def _refuse_target(
    closed: bool, target_x: Any, target_y: Any, final_heading: Any, via: tuple[Any, ...]
) -> None:
    """Refuse a target where the scenario may have none.

    That is a closed path, or a tour that may end at any point. Both need a via point too, so
    that `via` may not be empty.
    """
    fields = {"target_x": target_x, "target_y": target_y, "final_heading": final_heading}
    for name, value in fields.items():
        if value is not None:
            why = "the tour ends at any point; leave it out"
            if closed:
                why = f"a closed path ends as it starts; leave out {name} or closed"
            message = f"{name} is {short(value)}, but {why} (in a table: an empty cell)"
            raise ScenarioError(message)
    if not via:
        subject = "a tour without a target"
        if closed:
            subject = "a closed path"
        raise ScenarioError(f"via is empty; expected points to pass, which {subject} needs")


def _check_neighbours(
    points: list[tuple[float, float]], order: Order, target: tuple[float, float] | None
) -> None:
    """Refuse a leg between equal points.

    The points go from the start to the target. In a tour any two of them may be a leg, so that all
    have to differ; only the target may be the start.
    """
    back = target == points[0]
    if order is Order.FREE:
        places: dict[tuple[float, float], int] = {}
        different = points
        if back:
            different = points[:-1]
        for place, point in enumerate(different):
            if point in places:
                raise ScenarioError(
                    f"{short(point)} is a point of the tour twice, as points {places[point]} and "
                    f"{place} (the start is 0); expected points apart from each other, but for "
                    "a target at the start"
                )
            places[point] = place
        return
    for place, (point, following) in enumerate(pairwise(points), 1):
        if point == following:
            subject = "the target"
            if back:
                subject = "the start, where the path ends,"
            if place < len(points) - 1:
                subject = f"via point {place}"
            raise ScenarioError(
                f"{subject} is {short(following)}, the same point as the one before it; "
                "expected a point apart from the points before and after it"
            )


def _label(text: str) -> str:
    try:
        return str.encode(text).decode()  # makes a plain str of any subclass, as a row can hold it
    except (TypeError, UnicodeError):
        raise ScenarioError(f"label is {short(text)}; expected a text") from None


def checked_number(name: str, value: float | str | None) -> float:
    """Value of a field as a float.

    A text is allowed only for a heading. A value that the field may not have is a `ScenarioError`.
    """
    if value is None:
        raise ScenarioError(f"{name} is missing; expected a number")
    try:
        if isinstance(value, str) and "heading" in name:
            value = parse_angle(value)
        number = real_number(value)
    except AngleError as error:
        raise ScenarioError(f"{name}: {error}, {CONVENTION}") from None
    except Exception:  # of a class of the caller's
        raise ScenarioError(f"{name} is {short(value)}; expected a number") from None
    if not LEAST.get(name, -LARGEST) <= number <= LARGEST:  # nor is NaN
        expected = f"a finite number of size up to {LARGEST:g}"
        if "heading" in name:
            expected += ", or None where it is free"
        if name in POSITIVE:
            expected = f"a number above 0, from {SMALLEST:g} to {LARGEST:g}"
        raise ScenarioError(f"{name} is {number}; expected {expected}")
    return number

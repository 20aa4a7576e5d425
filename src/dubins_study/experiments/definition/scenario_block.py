"""One `[[scenarios]]` table of an experiment.

Its keys are here, and which of them do not go together.
"""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from dubins_study.experiments.definition.axes import (
    Axis,
    Count,
    HeadingAxis,
    LegCounts,
    RadiiList,
    Range,
    Seconds,
    Seed,
    SolverSpecs,
    StrictModel,
    ViaLists,
    as_list,
)
from dubins_study.study.angle import LARGEST_BARE, parse_angle
from dubins_study.study.kinds.table import EVERY_BRANCH

# The fields of the three ways to write a target.
CARTESIAN = ("target_x", "target_y")
POLAR = ("distance", "bearing")
CIRCULAR = ("arc", "margin")
_WAYS = (CARTESIAN, POLAR, CIRCULAR)
DRAWN = ("sample", "route", "tour")  # the tables that draw scenarios at random
FIELDS = ("x", "y", "heading", *CARTESIAN, "radius", "speed", *POLAR, *CIRCULAR, "final_heading")
# the fields that may be written as texts: "120deg"
_ANGLES = ("heading", "bearing", "arc", "final_heading")
# Keys of a block that say how its scenarios are asked.
HOW_ASKED = ("solvers", "branches", "time_limit_s", "guess_lengths")
# Names of laws of spacing -> the shortest and the longest leg of a sampled route (radii).
SPACINGS = {
    "4R-20R": (4.0, 20.0),
    "5R-30R": (5.0, 30.0),
    "2R-4R": (2.0, 4.0),
    "0.5R-2R": (0.5, 2.0),
    "0.5R-4R": (0.5, 4.0),
}
# The laws of points in a field; `experiments.plan.fields` draws them.
RANDOM = "random"
FIELD_LAWS = ("clusters", "survey rows", "roads", "gps")
if TYPE_CHECKING:
    Branch = str
    FieldName = str
    SpacingName = str
    Law = str
else:
    Law = Literal[RANDOM, *FIELD_LAWS]
    Branch = Literal[EVERY_BRANCH]
    FieldName = Literal[FIELDS]
    SpacingName = Literal[tuple(SPACINGS)]
Branches = Annotated[list[Branch], Field(min_length=1)]
_MOST_LEGS = 10**7  # of all routes or tours of a block: 160 MB


def _numbers(written: Any) -> list[Any]:
    """The numbers in an axis or range as written.

    Of `{ linear = [0, 1, 5] }` they are 0 and 1: the count of evenly spaced values is left out.
    """
    if not isinstance(written, dict):
        return as_list(written)
    ends = next(iter(written.values()), None)
    if not isinstance(ends, list):
        return []
    return ends[:2]


def _check_texts(name: str, written: Any) -> None:
    """Refuse texts for numbers, and unclear angles.

    An angle beyond a full turn is unclear if it is not written as a text.
    """
    for item in _numbers(written):
        if name in _ANGLES:
            if isinstance(item, int | float) and abs(item) > LARGEST_BARE:
                parse_angle(item)  # refuses it, and says what to write
        elif isinstance(item, str):
            angles = ", ".join(_ANGLES)
            raise ValueError(f"expected a number; texts such as '120deg' are for angles: {angles}")


def _check_frozen(patterns: list[str]) -> list[str]:
    """Refuse a pattern that no frozen problem has."""
    from dubins_study.study.convex.problem import matching  # loads sparse matrices

    for pattern in patterns:
        if not matching([pattern]):
            raise ValueError(
                f"no frozen problem is named {pattern!r}; expected one such as qp-50-*"
            )
    return patterns


FrozenNames = Annotated[list[str], Field(min_length=1), AfterValidator(_check_frozen)]


class Drawn(StrictModel):
    """Scenarios that are drawn at random."""

    count: Count
    """Number of scenarios; of routes and tours, for each number of legs or points and density."""
    seed: Seed
    """The same seed draws the same scenarios."""

    @property
    def sizes(self) -> list[int]:
        """Number of legs or points of each kind.

        `count` scenarios of each kind are drawn. A sample has one kind, with the number 0.
        """
        return [0]

    @property
    def size(self) -> int:
        """Number of all scenarios that are drawn."""
        return self.count * len(self.sizes)

    @model_validator(mode="after")
    def _check_size(self) -> Self:
        if (legs := self.count * sum(self.sizes)) > _MOST_LEGS:
            raise ValueError(f"{legs} legs or points in all; expected at most {_MOST_LEGS}")
        return self


class Sample(Drawn):
    """Quasi-random points over ranges of fields, drawn by `scipy.stats.qmc`."""

    method: Literal["sobol", "latin hypercube"]
    """How points are spread; the first points of a Sobol sample cover its ranges as well."""
    ranges: Annotated[dict[FieldName, Range], Field(min_length=1)]
    """Field -> its range; a field of the block that is not named here has the block's value."""

    @field_validator("ranges", mode="before")
    @classmethod
    def _check_ranges(cls, ranges: Any) -> Any:
        if isinstance(ranges, dict):
            for name, written in ranges.items():
                _check_texts(name, written)
        return ranges


class Route(Drawn):
    """Routes drawn at random, leg by leg.

    The way from each point to the next has any direction.

    A route goes from the block's start pose through as many points as it has legs; the last one is
    its target. A route of one leg has no via points. The same seed draws the same routes, whether
    their final headings are free or sampled.
    """

    legs: LegCounts
    """Number of legs, or several numbers."""
    spacing: SpacingName
    """Least and largest length of a leg, in radii; lengths are spread uniformly between the two. In
    a `field` their middle is the unit."""
    field: Law = RANDOM
    """Where the points are: at `random`, or in a field. `clusters`: Gaussian blobs, one after
    another. `survey rows`: rows flown back and forth, points a unit apart. `roads`: one point on
    each block of a drive through streets a unit apart. `gps`: noisy fixes of a smooth track, a unit
    apart."""
    final_heading: Literal["free", "sampled"] = "free"
    """Whether the final heading is `free`, or `sampled` from all headings."""

    @property
    def sizes(self) -> list[int]:
        """Number of legs of each kind of route."""
        return self.legs


class Tour(Drawn):
    """Tours drawn at random: points in any order.

    The points lie in a square.

    The start and n points are spread uniformly over a square. Its side is `density` times sqrt(n),
    so that points are as close to each other in tours of all sizes. The same seed draws the same
    points in squares of all sizes, wherever the tour ends and whether its start heading is free.
    """

    points: LegCounts
    """Number n of points beside the start, or several numbers."""
    density: RadiiList
    """Side of the square over sqrt(n), in radii, such as `"8R"`, or several; more is sparser. In a
    `field` it is the unit."""
    field: Law = RANDOM
    """Where the points are: at `random`, or in a field, as those of a `route`."""
    heading: Literal["sampled", "free"] = "sampled"
    """Whether the start heading is `sampled` from all headings, or `free`."""
    end: Literal["point", "any"] = "point"
    """Where a tour ends: at a `point`, the last that is drawn, or at `any` of them."""
    closed: bool = Field(default=False, strict=True)
    """Whether a tour ends as it starts, with all n points on its way."""

    @model_validator(mode="after")
    def _check_end(self) -> Tour:
        if self.closed and self.end == "any":
            raise ValueError("end is 'any', but a closed tour ends at its start; leave it out")
        return self

    @property
    def sizes(self) -> list[int]:
        """Number of points of each kind of tour."""
        return self.points * len(self.density)

    @property
    def to_target(self) -> bool:
        """Whether the last point is the target."""
        return self.end == "point" and not self.closed


class GuessLengths(StrictModel):
    """Lengths from which a local solver starts, in radii.

    They are the lengths z1, z2, z3 of the paper's path.

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
    def _check_lengths(cls, lengths: Axis) -> Axis:
        if min(lengths) < 0:
            raise ValueError("expected lengths of at least 0")
        return lengths

    @property
    def axes(self) -> list[Axis]:
        return [self.z1, self.z2, self.z3]


_ZERO: Any = 0.0  # as a file writes it
_ONE: Any = 1.0


class Block(StrictModel):
    """Scenarios: combinations of values, or a sample.

    All values of all fields are combined.

    The target is written in one of these ways:
    `target_x` and `target_y`;
    `distance` in radii and `bearing` in radians from the start's heading;
    `arc` and `margin`: `arc` radians along a turning circle from the start (positive on the left
    circle, negative on the right one), and `margin` radii outside that circle (negative inside).
    A sampled `route` or `tour` has targets of its own. A path that is `closed` has none, and one
    whose `order` is free may have none: it then ends at any of its points.

    Combinations are numbered in the order of `FIELDS`, `via` behind them; the last field varies
    fastest.
    `solvers`, `branches` and `time_limit_s` replace the experiment's for this block, and
    `guess_lengths` replaces the experiment's `initial_guesses`.
    """

    label: str = ""
    """Name of the scenarios; the report calls scenarios of one label a stratum."""
    x: Axis = _ZERO
    """Start position."""
    y: Axis = _ZERO
    """Start position."""
    heading: HeadingAxis = _ZERO
    """Start heading, counter-clockwise from +x: radians, a text such as "120deg", or "free"."""
    target_x: Axis | None = None
    """Target position."""
    target_y: Axis | None = None
    """Target position."""
    distance: Axis | None = None
    """Distance of the target, in radii."""
    bearing: Axis | None = None
    """Direction of the target from the start's heading: radians, or a text."""
    arc: Axis | None = None
    """Radians along a turning circle: positive on the left circle, negative on the right one."""
    margin: Axis | None = None
    """Radii outside that circle; negative inside."""
    final_heading: HeadingAxis | None = None
    """Heading at the target: radians, or a text; free where it is not given, or "free"."""
    via: ViaLists | None = None
    """Points to pass on the way, such as `[[1, 2], [3, 4, "90deg"]]`, the third value a heading; a
    list of such lists is an axis."""
    order: Literal["given", "free"] = "given"
    """Whether the points of `via` are passed in the order that is given, or in any: a tour."""
    closed: bool = Field(default=False, strict=True)
    """Whether a path ends as it starts, in place and heading."""
    radius: Axis = _ONE
    """Minimum turning radius."""
    speed: Axis = _ONE
    """Constant speed; it changes the travel time only."""
    frozen: FrozenNames | None = None
    """Frozen convex problems by name, such as `qp-50-*`; a scenario is the route of its problem."""
    sample: Sample | None = None
    """Scenarios drawn over ranges instead of combined from axes."""
    route: Route | None = None
    """Routes drawn at random, instead of targets."""
    tour: Tour | None = None
    """Tours drawn at random, instead of targets."""
    solvers: SolverSpecs | None = None
    """Replaces the experiment's solvers for this block."""
    branches: Branches | None = None
    """Replaces the experiment's branches for this block."""
    time_limit_s: Seconds | None = None
    """Replaces the experiment's time limit for this block."""
    guess_lengths: GuessLengths | None = None
    """Initial guesses of the local solvers with `initial_guess=given`, instead of cold ones."""

    @field_validator(*FIELDS, mode="before")
    @classmethod
    def _check_field(cls, written: Any, info: ValidationInfo) -> Any:
        _check_texts(str(info.field_name), written)
        return written

    @model_validator(mode="after")
    def _check_target(self) -> Block:
        """Refuse a block with no target or several.

        Beside `frozen`, `tour` and `route`, keys are refused that say what these give.
        """
        if isinstance(self, ListedBlock):
            return self
        keys = set(self.model_fields_set)
        if self.sample is not None:
            keys.update(self.sample.ranges)
        if self.frozen is not None:
            _refuse_beside("frozen", keys - {"frozen", *HOW_ASKED})
            return self
        target = keys.intersection(itertools.chain(*_WAYS))
        # keys of what a tour or a route draws itself
        twice = target | keys & {"via", "sample"}
        if self.tour is not None:
            twice |= keys & {"route", "heading", "order", "closed"}
            _refuse_beside("tour", twice)
        elif self.route is not None:
            if self.route.final_heading == "sampled":
                twice |= keys & {"final_heading"}
            _refuse_beside("route", twice)
        elif target or not (self.closed or self.order == "free"):
            self._check_way(target)
        return self

    def _check_way(self, target: set[str]) -> None:
        """Refuse a target that is not written one way.

        From a free heading, only coordinates say where the target is.
        """
        if target not in map(set, _WAYS):
            ways = ", or ".join([*(" and ".join(way) for way in _WAYS), "a route", "a tour"])
            raise ValueError(f"expected {ways}")
        if None in self.heading and target != set(CARTESIAN):
            raise ValueError(
                f"heading is free, and {' and '.join(sorted(target))} begin there; "
                "expected target_x and target_y"
            )

    @property
    def drawn(self) -> Sample | Route | Tour | None:
        """The table that draws at random, or None.

        A block has one of `sample`, `route` and `tour`, or none of them.
        """
        return self.sample or self.route or self.tour

    def axis(self, field: str) -> HeadingAxis | None:
        """The values of one of `FIELDS`, or None.

        None means that the block does not give that field.
        """
        values: HeadingAxis | None = getattr(self, field)
        return values


def _refuse_beside(table: str, keys: set[str]) -> None:
    """Refuse `keys`, if any, beside a table."""
    if keys:
        raise ValueError(f"{', '.join(sorted(keys))}; expected none beside {table}")


class ListedBlock(Block):
    """Scenarios listed one by one in their own file.

    No experiment's file writes this.
    """

    listed: Any = Field(exclude=True)  # a list of `Scenario`, which are valid

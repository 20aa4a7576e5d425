"""One `[[scenarios]]` table of an experiment: many scenarios, written as axes or as a sample."""

from __future__ import annotations

from typing import Any, ClassVar, Self

from pydantic import Field, field_validator, model_validator

from dubins_study.experiments.definition.axes import Axis, Sample, StrictModel
from dubins_study.study.nearest import did_you_mean
from dubins_study.study.words import BRANCHES

# The fields of the three ways to write a target.
CARTESIAN = ("target_x", "target_y")
POLAR = ("distance", "bearing")
CIRCULAR = ("arc", "margin")
FIELDS = ("x", "y", "heading", *CARTESIAN, "radius", "speed", *POLAR, *CIRCULAR)


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
    """Distance of the target, in radii."""
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
            if unknown := sorted(set(self.sample.ranges) - set(FIELDS)):
                near = did_you_mean(unknown[0], FIELDS)
                raise ValueError(
                    f"sample.ranges names {unknown[0]!r}; {near}expected {', '.join(FIELDS)}"
                )
            given |= set(self.sample.ranges)
        ways = (CARTESIAN, POLAR, CIRCULAR)
        if given & {field for way in ways for field in way} not in map(set, ways):
            raise ValueError(f"expected {', or '.join(' and '.join(way) for way in ways)}")
        return self

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


def known_branches(branches: list[str]) -> list[str]:
    """The branches, unchanged.

    Raises:
        ValueError: naming the branches that do not exist.
    """
    if unknown := [branch for branch in branches if branch not in BRANCHES]:
        names = " or ".join(f"{branch!r:.40}" for branch in unknown[:3])
        near = next(filter(None, (did_you_mean(branch, BRANCHES) for branch in unknown)), "")
        raise ValueError(f"no branch named {names}; {near}choose from {', '.join(BRANCHES)}")
    return branches

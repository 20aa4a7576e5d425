"""One `[[scenarios]]` table of an experiment: many scenarios, written as axes or as a sample."""

from __future__ import annotations

from typing import Self

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
    z2: Axis
    z3: Axis

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

    label: str = ""
    x: Axis = 0.0
    y: Axis = 0.0
    heading: Axis = 0.0
    target_x: Axis | None = None
    target_y: Axis | None = None
    distance: Axis | None = None
    bearing: Axis | None = None
    arc: Axis | None = None
    margin: Axis | None = None
    radius: Axis = 1.0
    speed: Axis = 1.0
    sample: Sample | None = None
    solvers: list[str] | None = Field(default=None, min_length=1)
    branches: list[str] | None = Field(default=None, min_length=1)
    guess_lengths: GuessLengths | None = None

    def axis(self, field: str) -> Axis | None:
        """The values of one of `FIELDS`, or None if the block does not give that field."""
        values: Axis | None = getattr(self, field)
        return values

    @model_validator(mode="after")
    def _check_target(self) -> Self:
        given = {field for field in FIELDS if self.axis(field) is not None}
        if self.sample is not None:
            if unknown := sorted(set(self.sample.ranges) - set(FIELDS)):
                raise ValueError(
                    f"sample.ranges names {unknown[0]!r}; expected {', '.join(FIELDS)}"
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


def known_branches(branches: list[str]) -> list[str]:
    """The branches, unchanged.

    Raises:
        ValueError: naming the first branch that does not exist.
    """
    for branch in branches:
        if branch not in BRANCHES:
            near = did_you_mean(branch, BRANCHES)
            raise ValueError(f"no branch named {branch!r}; {near}choose from {', '.join(BRANCHES)}")
    return branches

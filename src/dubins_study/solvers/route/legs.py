"""A scenario as a route in units of the radius: its legs, guessed headings, and its path."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from dubins_study.study.closed_form.pose import WORDS6
from dubins_study.study.path import FloatArray, Path
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import TURN

# the turns of a word's three segments, shape (6, 3)
WORD_TURNS = np.array([[TURN[letter] for letter in word] for word in WORDS6])


class Route(NamedTuple):
    """n legs. The unknown headings are those at the points after the start, shape (k,).

    Methods take one set of headings, or several at once in a further dimension.
    """

    steps: FloatArray  # from each point to the next (radii), shape (n, 2)
    first: float  # heading at the start (rad)
    last: float | None  # heading at the target (rad); None if it is free

    @property
    def unknowns(self) -> int:
        """k: n, or n - 1 if the final heading is given."""
        return len(self.steps) - (self.last is not None)

    def headings(self, unknown: FloatArray) -> FloatArray:
        """The headings at all points; shape (k, ...) -> (n + 1, ...)."""
        given = [self.first] if self.last is None else [self.first, self.last]
        first, *last = (np.full((1, *unknown.shape[1:]), heading) for heading in given)
        return np.concatenate((first, unknown, *last))

    def legs(self, headings: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The shortest legs between headings of shape (n + 1, ...).

        Returns their segments (radii or rad), shape (3, n, ...), and their words, shape (n, ...),
        as indices into `study.closed_form.pose.WORDS6`.
        """
        from dubins_study.study.closed_form.pose_kernel import pose_rows  # loads Numba

        several = headings.shape[1:]
        x, y = np.repeat(self.steps, int(np.prod(several)), axis=0).T
        zeros = np.zeros(x.size)
        ends = headings[:-1].ravel(), x, y, zeros + 1.0, headings[1:].ravel()
        rows = pose_rows(zeros, zeros, *ends)
        shape = (len(self.steps), *several)
        segments = np.array((rows.first, rows.middle, rows.last)).reshape(3, *shape)
        return segments, rows.word.reshape(shape)

    def toward_next(self) -> FloatArray:
        """The guess `bearing`: at each point toward the next one, at a free end as on the last leg.

        Shape (k,).
        """
        bearings = np.arctan2(self.steps[:, 1], self.steps[:, 0])
        return np.append(bearings[1:], bearings[-1])[: self.unknowns]


def route_of(scenario: Scenario) -> Route:
    """The route of a scenario."""
    steps = np.diff(scenario.points, axis=0) / scenario.radius
    return Route(steps, scenario.heading, scenario.final_heading)


def path_of(scenario: Scenario, turns: Iterable[float], lengths: Iterable[float]) -> Path:
    """The path of pieces at unit radius; a length that is not above zero counts as zero."""
    pieces = [
        (turn / scenario.radius, length * scenario.radius)
        for turn, length in zip(turns, lengths, strict=True)
        if not length <= 0  # so that NaN stays and is seen by the check
    ]
    return Path(scenario.start, [k for k, _ in pieces], [length for _, length in pieces])

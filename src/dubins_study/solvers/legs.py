"""The shortest legs of a route between given headings.

They come from the closed form of one leg.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from dubins_study.solvers.course import Course, free_target
from dubins_study.study.arrays import FloatArray
from dubins_study.study.closed_form.pose import WORDS6
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import TURN

# the turns of a word's three segments, shape (6, 3)
WORD_TURNS = np.array([[TURN[letter] for letter in word] for word in WORDS6])


@dataclass(frozen=True, eq=False)
class Route(Course):
    """A course with known shortest legs between any headings."""

    def shortest(self, headings: FloatArray) -> tuple[FloatArray, Any]:
        """The shortest legs between headings.

        `headings` has shape (n + 1, ...).

        Returns their segments (radii or rad), shape (3, n, ...), and their words, shape (n, ...),
        as indices into `study.closed_form.pose.WORDS6`.
        """
        several = headings.shape[1:]
        # each step once for each set of headings, in the order of `ravel`
        x, y = np.repeat(self.steps, int(np.prod(several)), axis=0).T
        segments, words = legs(x, y, headings[:-1].ravel(), headings[1:].ravel())
        shape = (self.legs, *several)
        return segments.reshape(3, *shape), words.reshape(shape)


def legs(
    x: FloatArray, y: FloatArray, first: FloatArray, last: FloatArray
) -> tuple[FloatArray, Any]:
    """The shortest legs over m steps between headings.

    A step is (x, y), in radii. Returns two values: the segments (radii or rad), shape (3, m), and
    the words, shape (m,), as indices into `study.closed_form.pose.WORDS6`.
    """
    from dubins_study.study.closed_form.pose_kernel import pose_rows  # loads Numba

    zeros = np.zeros(x.size)
    rows = pose_rows(zeros, zeros, first, x, y, zeros + 1.0, last)
    return rows.segments, np.asarray(rows.word)


def route_of(scenario: Scenario) -> Route:
    """The route of a scenario, along the scenario's axes."""
    steps = np.diff(scenario.points, axis=0) / scenario.radius
    return Route(steps, scenario.start.heading, scenario.final_heading, free_target(scenario))

"""The closed form against numbers known in advance.

The adversary (`tests/adversary`) compares it with an oracle of 60 digits, `test_pose` with the
least over final headings.
"""

from __future__ import annotations

import math

import pytest

from dubins_study.study.body_coordinates import Local
from dubins_study.study.closed_form.shortest import (
    as_path,
    shortest,
    shortest_local,
)
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import BRANCHES


def unit(X: float, Y: float) -> Scenario:
    """Target (X, Y) in the vehicle's frame, R = 1."""
    return Scenario(0, 0, 0, X, Y, 1)


def test_the_length_jumps_across_the_front_of_a_circle():
    """At arc angle 0.3: 0.300 on the circle and just outside, 6.535 just inside."""
    x, y = math.sin(0.3), math.cos(0.3)
    on = shortest(unit(x, 1 - y))
    outside = shortest(unit(x * (1 + 1e-9), 1 - y * (1 + 1e-9)))
    inside = shortest(unit(x * (1 - 1e-9), 1 - y * (1 - 1e-9)))

    assert (on.word, outside.word, inside.word) == ("L", "LS", "RL")
    assert on.total == pytest.approx(0.3, abs=1e-15)
    assert outside.total == pytest.approx(0.300, abs=5e-4)
    assert inside.total == pytest.approx(6.535, abs=5e-4)  # printed to three digits


def test_centre_of_a_disc_and_straight_behind():
    """Lengths known to six digits; straight behind, the least is at D = 1 exactly."""
    centre = shortest(unit(0, 1))
    assert centre.total == pytest.approx(5.470430, abs=5e-7)
    assert centre.segments == pytest.approx((0.505361, 4.965069), abs=5e-7)
    behind = [shortest(unit(-D, 0)).total for D in (0.9, 1.0, 1.1)]
    assert behind[1] == pytest.approx(5.712389, abs=5e-7)
    assert behind[1] < min(behind[0], behind[2])
    assert shortest(unit(-1, 0)).words == ("LS", "RS")


@pytest.mark.parametrize(
    ("X", "Y"),
    [(0, 3e-16), (1e-16, -8e-16), (-1e-16, 2 + 4e-16), (-1e-16, 2 - 4e-16), (0, 2), (9e-16, 4e-16)],
)
def test_targets_that_rounding_hides_are_met(X, Y):
    """Beside a far origin these are the start or (0, 2); every branch's path still arrives."""
    for branch in BRANCHES:
        for target in (Local(X, Y, 4e-15), Local(X, -Y, 4e-15)):
            found = shortest_local(target, branch)
            if found is not None:
                path = as_path(unit(0, 0), found.word, found.segments)
                off = math.hypot(path.end.x - target.X, path.end.y - target.Y)
                # the root of a rounding of 4e-15 is 6e-8; the verdict allows 1e-6
                assert off < 2e-7, (branch, target)

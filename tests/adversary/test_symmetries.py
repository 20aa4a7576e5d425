"""Symmetries leave the shortest length.

They are tried on legs and routes, with the final heading free or given.

Compared are the proven intervals, which have to overlap, and the lengths of the paths where both
intervals are narrow: a length may jump within the rounding of the data.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from dubins_study.study.check.visits import visits
from dubins_study.study.kinds.table import reference_of
from dubins_study.study.scenario import Scenario
from dubins_study.study.tolerances import Tolerances
from tests.cases import walked

QUICK = Tolerances(search_s=0.1)  # in which nine of ten of these routes close
NARROW = 2e-9  # relative; what a search asks for, twice
ANGLES = st.floats(-3, 3)


@st.composite
def routes(draw: st.DrawFn) -> Scenario:
    """Routes of one leg to four.

    A leg is 0.5 R to 6 R long.
    """
    steps = draw(st.lists(st.tuples(st.floats(0.5, 6), ANGLES), min_size=1, max_size=4))
    _, *via, (x, y) = walked(*np.array(steps).T)
    final = draw(st.none() | ANGLES)
    return Scenario(heading=draw(ANGLES), target_x=x, target_y=y, via=via, final_heading=final)


@st.composite
def images(draw: st.DrawFn) -> tuple[Scenario, Scenario]:
    """A scenario and its image.

    The image is mirrored or not, turned, scaled and shifted.
    """
    scenario = draw(routes())
    turn = draw(ANGLES)
    scale = draw(st.sampled_from([1, 17.0, 1e-3]))
    side = draw(st.sampled_from([1, -1]))
    by = draw(st.sampled_from([(0, 0), (30.0, -70.0)]))
    c, s = scale * math.cos(turn), scale * math.sin(turn)
    points = scenario.points * (1, side) @ np.array([[c, s], [-s, c]]) + np.multiply(by, scale)
    first, last = scenario.heading, scenario.final_heading
    last = None if last is None else side * last + turn
    return scenario, through(points, side * first + turn, last, scale)


def through(points: np.ndarray, first: float, last: float | None, radius: float = 1) -> Scenario:
    start, *via, target = points.tolist()
    return Scenario(*start, first, *target, radius, via=via, final_heading=last)


def compared(one: Scenario, other: Scenario) -> None:
    scale = other.radius / one.radius
    (low, high, *_), path, _ = reference_of(one, tolerances=QUICK)
    (other_low, other_high, *_), other_path, _ = reference_of(other, tolerances=QUICK)

    assert other_low <= scale * high * (1 + 1e-12)
    assert scale * low <= other_high * (1 + 1e-12)
    if max(scale * (high - low), other_high - other_low) < NARROW * other_high:
        assert other_path.length == pytest.approx(scale * path.length, rel=NARROW)


@given(images())
def test_mirror_turn_scale_and_shift_leave_the_length(pair):
    compared(*pair)


@given(routes(), ANGLES)
def test_reversal_in_time_leaves_the_length(scenario, last):
    """Reversal in time leaves the length.

    Both headings are given.
    """
    first = scenario.heading
    back = through(scenario.points[::-1], last + math.pi, first + math.pi)
    compared(replace(scenario, final_heading=last), back)


@given(routes())
def test_a_via_point_on_the_shortest_path_leaves_the_length(scenario):
    """A via point on the shortest path changes nothing.

    It lies in the middle of the longest straight: on an arc, rounding may put it inside the
    circle.
    """
    path = reference_of(scenario, tolerances=QUICK).path
    straights = np.where(path.curvatures == 0, path.lengths, 0)
    longest = int(np.argmax(straights))
    assume(straights[longest] > 1e-3)
    at = path.lengths[:longest].sum() + path.lengths[longest] / 2
    before = sum(at > s for s in visits(path, scenario.stops[:-1], 1, 1e-6).at)
    via = [*scenario.via[:before], path.at(at)[0, :2], *scenario.via[before:]]

    compared(scenario, replace(scenario, via=via))

"""Flights: times of places, bank, speed and radius."""

import math

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from hypothesis import given
from hypothesis import strategies as st

from dubins_study import solve
from dubins_study.missions.flight import FlightError, bank_radius, flight_of, too_tight
from dubins_study.missions.mission import Mission, MissionPoint
from dubins_study.study.tangent_plane import TangentPlane

GRAVITY = 9.80665
POINTS = (
    MissionPoint(900, 100, name="mill", altitude=120),
    MissionPoint(300, 700, altitude=60),
    MissionPoint(-500, 400, name="oak"),
)
MISSION = Mission(POINTS, MissionPoint(0, 0), TangentPlane(52.0, 10.0))


@pytest.fixture(scope="module")
def tour():
    scenario = MISSION.scenario(to_last=False, radius=80, speed=16, order="free", closed=True)
    return flight_of(solve(scenario), MISSION)


def test_stops_come_in_the_order_of_the_flight(tour):
    """Stops come in the order of the flight.

    Each is where the mission has it, at the length over the speed; the last is home.
    """
    stops = tour.stops

    assert [stop.place for stop in stops[:-1]] == [place + 1 for place in tour.answer.order]
    names = {1: "mill", 2: "2", 3: "oak", 4: "home"}
    assert [stop.name for stop in stops] == [names[stop.place] for stop in stops]
    for stop in stops:
        point = (*POINTS, MISSION.home)[stop.place - 1]
        assert math.dist((stop.x, stop.y), point[:2]) < 1e-4
        assert stop.time == stop.length / 16
    assert [stop.length for stop in stops] == sorted(stop.length for stop in stops)
    assert stops[-1].length == tour.path.length


def test_waypoints_lie_a_step_apart_and_at_every_stop(tour):
    """Waypoints lie a step apart and at stops.

    They go from the start to the end; a stop between two of them is one more.
    """
    points = tour.waypoints(50)
    lengths = [point.length for point in points]

    assert (lengths[0], lengths[-1]) == (0.0, tour.path.length)
    assert max(np.diff(lengths)) <= 50 * (1 + 1e-12)
    assert min(np.diff(lengths)) > 0
    assert [point for point in points if point.place] == tour.stops


def test_the_compass_shows_where_the_next_waypoint_lies(tour):
    """The compass shows where the next waypoint lies.

    It is the azimuth of a geodesic to a point a metre on; curvature turns it by no more.
    """
    points = tour.waypoints(1)
    for one, other in zip(points[:-2:40], points[1:-1:40], strict=True):
        line = Geodesic.WGS84.Inverse(one.lat, one.lon, other.lat, other.lon)
        turned = math.remainder(one.compass - line["azi1"], 360.0)
        assert abs(turned) <= math.degrees(0.5 * line["s12"] / 80) + 1e-3


def test_altitude_rises_evenly_between_points_that_have_one(tour):
    """Altitude rises evenly between points with altitudes.

    It rises by length; before the first and after the last it stays.
    """
    known = {stop.length: stop.altitude for stop in tour.stops if stop.place in (1, 2)}
    (first, high), (second, low) = sorted(known.items())

    assert {high, low} == {120, 60}
    for point in tour.waypoints(50):
        share = min(max((point.length - first) / (second - first), 0.0), 1.0)
        assert point.altitude == pytest.approx(high + share * (low - high))


@given(st.floats(1.0, 300.0), st.floats(0.01, 1.5))
def test_a_level_turn_is_held_by_the_bank(speed, bank):
    """A level turn is held by the bank.

    Lift, of which the vertical part carries the weight, pulls inward by v**2 / R.
    """
    radius = bank_radius(speed, bank)
    lift = GRAVITY / math.cos(bank)

    assert speed**2 / radius == pytest.approx(lift * math.sin(bank))
    assert too_tight(radius * (1 + 1e-9), speed, bank) is None
    assert too_tight(radius * (1 - 1e-9), speed, bank)


@pytest.mark.parametrize(
    ("speed", "bank", "message"),
    [
        (0.0, 0.5, "speed is 0.0; expected m/s above 0"),
        (math.inf, 0.5, "speed is inf"),
        (20.0, 0.0, "bank is 0deg; expected an angle between 0 and 90deg"),
        (20.0, 1.6, "bank is 91.67deg"),
        (20.0, math.nan, "bank is nandeg"),
    ],
)
def test_no_turn_of_such_a_speed_or_bank(speed, bank, message):
    with pytest.raises(FlightError, match=message):
        bank_radius(speed, bank)


@pytest.mark.parametrize("step", [0.0, -1.0, math.nan, 1e-6])
def test_a_step_that_makes_no_waypoints_is_refused(tour, step):
    with pytest.raises(FlightError, match=r"step is .*; expected a length above 0"):
        tour.waypoints(step)


def test_a_start_at_the_first_point_has_its_altitude():
    """A start at the first point has its altitude.

    A home position of a plan has none: its altitude is above the sea.
    """
    points = [MissionPoint(x, 0.0, altitude=height) for x, height in [(0, 100), (900, 200)]]
    for source, heights in [("GPX", (100, 200)), ("QGroundControl plan", (200, 200))]:
        mission = Mission(tuple(points[1:]), points[0], TangentPlane(52.0, 10.0), source=source)
        flight = flight_of(solve(mission.scenario(radius=80)), mission)
        start, *_, end = flight.waypoints(100)
        assert (start.altitude, end.altitude) == heights

"""The tangent plane.

It is compared with geodesics of GeographicLib, and by its symmetries.
"""

import math

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from hypothesis import given
from hypothesis import strategies as st

from dubins_study import DubinsStudyError, Path, Scenario, solve
from dubins_study.study.tangent_plane import TangentPlane, middle_of, plane_at

latitudes, longitudes = st.floats(-89, 89), st.floats(-180, 180)
planes = st.builds(TangentPlane, latitudes, longitudes)
metres = st.tuples(st.floats(-2e5, 2e5), st.floats(-2e5, 2e5))


def _turned(one, other):
    """The difference of two longitudes, degrees."""
    return math.remainder(one - other, 360)


@given(planes, metres)
def test_there_and_back(plane, point):
    """There and back is the same place.

    That holds to a millionth of a metre, near the poles and on both sides of the date line too.
    """
    back = plane.to_plane(plane.to_earth([point]))

    np.testing.assert_allclose(back, [point], atol=1e-6)


@given(planes, metres)
def test_distance_and_direction_from_the_middle_are_kept(plane, point):
    """Distance and direction from the middle are kept.

    They define the projection: those of the geodesic from the middle, by another of its ways.

    The length is found from the point to the middle, the direction by a line of points.
    """
    ((lon, lat),) = plane.to_earth([point])
    far = math.hypot(*point)
    back = Geodesic.WGS84.Inverse(lat, lon, plane.latitude, plane.longitude)
    azimuth = math.degrees(math.atan2(*point))
    end = Geodesic.WGS84.Line(plane.latitude, plane.longitude, azimuth).Position(far)

    assert back["s12"] == pytest.approx(far, abs=1e-6)
    assert end["lat2"] == pytest.approx(lat, abs=1e-9)
    assert _turned(end["lon2"], lon) * math.cos(math.radians(lat)) == pytest.approx(0, abs=1e-9)


@given(planes, metres)
def test_mirror_images(plane, point):
    """Mirror images are alike.

    East and west, and north and south, are alike; another longitude changes nothing.
    """
    ((lon, lat),) = plane.to_earth([point])
    x, y = point
    mirrored = TangentPlane(-plane.latitude, plane.longitude)
    moved = TangentPlane(plane.latitude, math.remainder(plane.longitude + 77, 360))

    for image, (east, north), sign, turn in (
        (plane, (-x, y), 1, -_turned(lon, plane.longitude)),
        (mirrored, (x, -y), -1, _turned(lon, plane.longitude)),
        (moved, (x, y), 1, _turned(lon, plane.longitude)),
    ):
        ((other_lon, other_lat),) = image.to_earth([(east, north)])
        assert other_lat == pytest.approx(sign * lat, abs=1e-9)
        wide = _turned(other_lon - image.longitude, turn) * math.cos(math.radians(lat))
        assert wide == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("latitude", [0.0, 48.0, -75.0])
@pytest.mark.parametrize("far", [2e4, 2e5])
def test_the_distortion_is_that_of_a_short_length(latitude, far):
    """The distortion is that of a short length.

    It is measured on the ellipsoid beside a step across, where it is largest; along there is none.
    """
    plane = TangentPlane(latitude, 10.0)
    for azimuth in (0.3, 2.0):
        away = np.array([math.sin(azimuth), math.cos(azimuth)])
        across = np.array([away[1], -away[0]])
        for step, expected in ((across, plane.distortion([far * away])), (away, 0.0)):
            ends = plane.to_earth([far * away - 5 * step, far * away + 5 * step])
            (lon1, lat1), (lon2, lat2) = ends.tolist()
            length = Geodesic.WGS84.Inverse(lat1, lon1, lat2, lon2)["s12"]
            assert 10 / length - 1 == pytest.approx(expected, rel=0.02, abs=1e-9)


def test_the_middle_of_places():
    """Middle of a box of places.

    The box may lie across the date line.
    """
    assert middle_of([(11, 48), (12, 50), (11.2, 49)]) == TangentPlane(49.0, 11.5)
    across = middle_of([(179, 10), (-179.5, 12)])
    assert (across.latitude, across.longitude) == pytest.approx((11, 179.75))
    plane = middle_of([(179.9, 0), (-179.9, 0)])
    np.testing.assert_allclose(
        plane.to_plane([(179.9, 0), (-179.9, 0)]), [(-11132, 0), (11132, 0)], atol=1
    )


@pytest.mark.parametrize("longitude", [0.0, 90.0, -179.0])
def test_beside_a_pole(longitude):
    """Beside a pole places are right.

    The pole itself is a point; beyond it lies the other side, with north turned around.
    """
    plane = TangentPlane(89.9, longitude)
    (pole,) = plane.to_plane([(longitude + 33, 90)])
    beyond = [(0, 2 * pole[1])]
    ((lon, lat),) = plane.to_earth(beyond)

    assert pole == pytest.approx((0, 11169.4), abs=1)
    assert lat == pytest.approx(89.9, abs=1e-9)
    assert abs(_turned(lon, longitude)) == pytest.approx(180)
    assert abs(plane.convergence(beyond)[0]) == pytest.approx(math.pi)


def test_a_scenario_of_places_is_the_inverse_of_geojson():
    """A scenario of places is the inverse of GeoJSON.

    Its path begins and ends where it was asked to, in degrees.
    """
    start = (11.5, 48.1)
    via = (11.51, 48.103, "90deg")
    target = (11.52, 48.1)
    scenario = Scenario.from_lonlat(start, target, via=[via], radius=60, heading=None)
    middle = middle_of([start, via[:2], target])
    origin = middle.latitude, middle.longitude
    path = solve(scenario).path
    line = path.to_geojson(origin=origin)["geometry"]["coordinates"]

    assert scenario == Scenario.from_lonlat(
        start, target, via=[via], origin=origin, radius=60, heading=None
    )
    assert scenario.via[0][2] == math.pi / 2
    np.testing.assert_allclose([line[0], line[-1]], [start, target], atol=1e-9)
    assert Scenario.from_lonlat(start, via=[via, target], closed=True).closed


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Scenario.from_lonlat((48.1, 111), (48.2, 11)), "are the two swapped, or metres"),
        (lambda: Scenario.from_lonlat((11,), (12, 48)), "expected pairs of longitude and latitude"),
        (lambda: Scenario.from_lonlat(11, 48), "expected pairs of longitude and latitude"),
        (lambda: Scenario.from_lonlat(("a", 1), (12, 48)), "longitude is 'a'; expected a number"),
        (lambda: Scenario.from_lonlat((11, math.nan), (12, 48)), "latitude is nan; expected"),
        (lambda: Scenario.from_lonlat((11, 48), (12, 48), origin=(90, 0)), "origin is "),
        (lambda: plane_at("ab"), "origin is 'ab'; expected latitude between"),
        (lambda: Path((0, 0, 0), [0], [1]).to_geojson(origin=(0, 181)), "longitude up to 180"),
    ],
)
def test_no_places(call, message):
    with pytest.raises(DubinsStudyError, match=message):
        call()

"""Tangent plane of a point on Earth.

It turns longitude and latitude into metres east and north.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from dubins_study.errors import DubinsStudyError
from dubins_study.study.arrays import FloatArray
from dubins_study.study.values import real_number, short

if TYPE_CHECKING:
    from collections.abc import Iterable


class PlaceError(DubinsStudyError, ValueError):
    """Longitude and latitude that are no place on Earth."""


@dataclass(frozen=True)
class TangentPlane:
    """Azimuthal equidistant projection around one point.

    The ellipsoid is WGS 84. A point keeps its distance and its direction from the middle. Across
    that direction, lengths are too long by about r**2 / (6 a**2) at the distance r, with a = 6378
    km (Snyder 1987, Map Projections: A Working Manual, section 25). Geodesics are those of
    GeographicLib (Karney 2013).

    Args:
        latitude, longitude: of the middle, degrees; latitude between -90 and 90, both excluded.
    """

    latitude: float
    longitude: float

    def to_plane(self, degrees: ArrayLike) -> FloatArray:
        """Plane points of longitudes and latitudes (degrees).

        Both have the shape (n, 2). A plane point is metres east and north of the middle.
        """
        east_north = []
        for longitude, latitude in np.asarray(degrees, dtype=float).reshape(-1, 2).tolist():
            line = _geodesic().Inverse(self.latitude, self.longitude, latitude, longitude)
            azimuth = math.radians(line["azi1"])
            east_north.append((line["s12"] * math.sin(azimuth), line["s12"] * math.cos(azimuth)))
        return np.array(east_north).reshape(-1, 2)

    def to_earth(self, points: ArrayLike) -> FloatArray:
        """Longitudes and latitudes (degrees) of plane points.

        The points are metres east and north of the middle; shape (n, 2).
        """
        return np.array([line[:2] for line in self.on_earth(points)]).reshape(-1, 2)

    def convergence(self, points: ArrayLike) -> FloatArray:
        """Angle of +y clockwise from true north (rad).

        One for each point, shape (n,).
        """
        return np.array([line[2] for line in self.on_earth(points)])

    def distortion(self, points: ArrayLike) -> float:
        """Largest relative error of a length near the points."""
        away = np.hypot(*np.asarray(points, dtype=float).reshape(-1, 2).T)
        angle: float = float(away.max(initial=0.0)) / _geodesic().a
        if not 0 < angle < math.pi:
            return 0.0
        return angle / math.sin(angle) - 1

    def on_earth(self, points: ArrayLike) -> Iterable[tuple[float, float, float]]:
        """Longitude, latitude (degrees) and convergence (rad).

        One triple for each plane point; `convergence` has the meaning of the third.
        """
        for x, y in np.asarray(points, dtype=float).reshape(-1, 2).tolist():
            azimuth = math.degrees(math.atan2(x, y))
            line = _geodesic().Direct(self.latitude, self.longitude, azimuth, math.hypot(x, y))
            # along the geodesic the plane's direction stays, the true one turns from azi1 to azi2
            turned = math.radians(line["azi2"] - line["azi1"])
            yield line["lon2"], line["lat2"], math.remainder(turned, math.tau)


def plane_at(origin: Any) -> TangentPlane:
    """Tangent plane at a latitude and longitude (degrees).

    Raises:
        PlaceError: if it is no such pair, or a pole.
    """
    try:
        latitude, longitude = map(real_number, origin)
    except (TypeError, ValueError, OverflowError):  # no pair, or no numbers
        latitude = longitude = math.nan
    if not (abs(latitude) < 90 and abs(longitude) <= 180):
        expected = "latitude between -90 and 90 and longitude up to 180 degrees"
        raise PlaceError(f"origin is {short(origin)}; expected {expected}")
    return TangentPlane(latitude, longitude)


def check_place(longitude: float, latitude: float) -> None:
    """Refuse degrees that are no place on Earth.

    Raises:
        PlaceError: if one of them is out of its range, or no number.
    """
    if not (abs(longitude) <= 180 and abs(latitude) <= 90):
        expected = "expected up to 180 and up to 90 degrees; are the two swapped, or metres?"
        raise PlaceError(f"longitude is {longitude}, latitude is {latitude}; {expected}")


def middle_of(degrees: ArrayLike) -> TangentPlane:
    """Tangent plane at the middle of some places.

    The middle is that of the box around their longitudes and latitudes, shape (n, 2).

    Points on both sides of the meridian of 180 degrees have a middle between them.
    """
    longitude, latitude = np.asarray(degrees, dtype=float).reshape(-1, 2).T
    # each longitude within half a turn of the first one
    turned = longitude[0] + (longitude - longitude[0] + 180) % 360 - 180
    east = 0.5 * (turned.min() + turned.max())
    return TangentPlane(0.5 * (latitude.min() + latitude.max()), math.remainder(east, 360))


def _geodesic() -> Any:
    from geographiclib.geodesic import Geodesic  # only scenarios on Earth need it

    return Geodesic.WGS84

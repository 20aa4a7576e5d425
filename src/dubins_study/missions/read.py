"""Mission files of any format, read to a plane.

The content tells the format.
"""

from __future__ import annotations

import json
import logging
import math
import re
from collections.abc import Sequence
from pathlib import Path as FilePath

import numpy as np

from dubins_study.missions.maps import read_geojson, read_xml
from dubins_study.missions.mission import Mission, MissionError, MissionPoint
from dubins_study.missions.qgroundcontrol import read_plan, read_wpl
from dubins_study.missions.reading import Points, Reading, at, number_of, text_of
from dubins_study.missions.table import read_table, read_tsplib
from dubins_study.study.tangent_plane import TangentPlane, check_place, middle_of
from dubins_study.study.values import plain, short

_LOG = logging.getLogger(__name__)
_MOST_POINTS = 10_000  # the search for a path takes minutes for a thousand
_MOST_DISTORTION = 1e-4  # of lengths on the plane, relative; 156 km from its middle
# A micrometre: less than any file of places means, and more than degrees lose by being written.
_SAME = 1e-6


def read_mission(
    file: str | FilePath,
    *,
    columns: Sequence[str] | None = None,
    compass: bool = False,
    drop_repeats: bool = False,
    closed: bool = False,
    plane: TangentPlane | None = None,
) -> Mission:
    """The mission of a file.

    The content of the file tells its format.

    Formats are tables (comma, semicolon or tab), GPX, KML, GeoJSON, plans of QGroundControl,
    QGC WPL 110 and TSPLIB, in UTF-8, or in UTF-16 with a byte order mark. Longitudes and latitudes
    become metres on a tangent plane; a heading in such a file counts from the true east or north.

    Args:
        file: a path.
        columns: names of a table's columns in their order, such as `("lon", "lat", "-", "name")`;
            `-` for one to pass over. Default: those of its header.
        compass: whether headings are degrees (or text with a unit) clockwise from north; default:
            radians (or text with a unit) counterclockwise from east.
        drop_repeats: whether to leave out points that equal the one before them, and a last point
            that equals the first.
        closed: whether the path ends at its start: a last point that equals the first is left out.
        plane: the plane of the points; default: the one at the middle of the points and the home
            position. A file of x and y is taken to have metres on it.

    Returns:
        The mission. Its notes say what was understood and passed over, its warnings what is
        doubtful; warnings are logged too.

    Raises:
        MissionError: if the file cannot be read or has no points, if a number, a heading or a place
            on Earth is not valid, or if points repeat. It names the file and the line or item.
    """
    with at(str(file)):
        reading = _reading(text_of(file), columns, compass)
        mission = _mission(reading, compass, drop_repeats, closed, plane)
    for warning in mission.warnings:
        _LOG.warning("dubins-study: %s", plain(f"{file}: {warning}"))
    return mission


def _read_json(text: str, compass: bool) -> Reading:
    """Read the points of a plan or of GeoJSON.

    The members of the object tell which of them it is.
    """
    content = json.loads(text)
    if "mission" in content:
        return read_plan(content)
    if "type" in content:
        return read_geojson(content, compass)
    raise MissionError("it is neither a plan, with a member mission, nor GeoJSON, with a type")


# pattern in the text of each format, and its reader; a table has none of the patterns
_FORMATS = (
    (r"\AQGC WPL\b", read_wpl),
    (r"\A\s*<", read_xml),
    (r"\A\s*[{\[]", _read_json),
    (r"^\s*NODE_COORD_SECTION", read_tsplib),
)


def _reading(text: str, columns: Sequence[str] | None, compass: bool) -> Reading:
    """Read a text in the format that it shows."""
    if not text.strip():
        raise MissionError("the file is empty; expected points")
    for mark, read in _FORMATS:
        if re.search(mark, text, re.MULTILINE):
            if columns is not None:
                raise MissionError("--columns is given; the file has none, it is no table")
            return read(text, compass)
    return read_table(text, columns, compass)


def _mission(
    reading: Reading, compass: bool, drop_repeats: bool, closed: bool, plane: TangentPlane | None
) -> Mission:
    """The mission of a reading.

    The points are moved to a plane. Repeated points are refused, or left out with `drop_repeats`.
    Notes and warnings are added.
    """
    points = list(reading.points)
    # the home position goes through the same steps as the first point, and is taken out at the end
    if reading.home is not None:
        points.insert(0, reading.home._replace(where="the home position"))
    if len(points) > _MOST_POINTS:
        raise MissionError(f"there are {len(points)} points; expected at most {_MOST_POINTS}")
    if reading.degrees:
        points, plane = _on_plane(points, plane)
    if closed and len(points) > 2 and _same(points[0], points[-1]):
        points.pop()
    points, repeats = _without_repeats(points)
    if repeats and not drop_repeats:
        expected = "--drop-repeats (in Python drop_repeats=True) takes each point once"
        raise MissionError(f"{repeats}; {expected}")
    extent, distortion = _extent(points, plane)
    notes = [extent, reading.passed, repeats and f"dropped: {repeats}"]
    if reading.home is not None:
        notes.append("the home position is where the flight starts, but for --from")
    if headings := sum(point.heading is not None for point in points):
        convention = "radians counterclockwise from east"
        if compass:
            convention = "degrees clockwise from north"
        notes.append(f"{headings} headings, numbers in {convention}")
    warnings = []
    if distortion > _MOST_DISTORTION:
        warnings.append(f"{extent}; are longitude and latitude right?")
    home = None
    if reading.home is not None:
        home = points.pop(0)
    return Mission(
        points=tuple(points),
        home=home,
        plane=plane,
        source=reading.source,
        speed=_speed(reading),
        notes=tuple(map(plain, filter(None, notes))),
        warnings=tuple(warnings),
    )


def _speed(reading: Reading) -> float | None:
    if reading.speed is None:
        return None
    speed = number_of(reading.speed)
    if not speed > 0:
        raise MissionError(f"cruiseSpeed is {short(reading.speed)}; expected m/s above 0")
    return speed


def _on_plane(points: Points, plane: TangentPlane | None) -> tuple[Points, TangentPlane]:
    """The points in metres, and their plane.

    Without `plane`, it is the one at the middle of the points. Headings count from the plane's +x
    then, no longer from the true east.
    """
    for point in points:
        with at(point.where):
            check_place(point.x, point.y)
    degrees = [point[:2] for point in points]
    plane = plane or middle_of(degrees)
    metres = plane.to_plane(degrees)
    moved = []
    for point, (x, y), turn in zip(points, metres, plane.convergence(metres), strict=True):
        heading = point.heading
        if heading is not None:
            heading = float(heading + turn)
        moved.append(point._replace(x=float(x), y=float(y), heading=heading))
    return moved, plane


def _without_repeats(points: Points) -> tuple[Points, str]:
    """The points without repeats, and a sentence about repeats.

    The sentence is empty if no point equals the one before it and the last is not the first.
    """
    distinct = points[:1]
    repeats: Points = []
    for point in points[1:]:
        if _same(point, distinct[-1]):
            repeats.append(point)
        else:
            distinct.append(point)
    notes = []
    if repeats:
        notes.append(f"{repeats[0].where} equals the point before it; such points: {len(repeats)}")
    if len(distinct) > 2 and _same(distinct[0], distinct[-1]):
        notes.append(f"{distinct.pop().where} equals the first point; --closed flies back to it")
    return distinct, "; ".join(notes)


def _same(one: MissionPoint, other: MissionPoint) -> bool:
    return math.dist(one[:2], other[:2]) <= _SAME


def _extent(points: Points, plane: TangentPlane | None) -> tuple[str, float]:
    """A sentence about the points, and the distortion.

    The sentence tells how many points there are, how far they reach, and where. The distortion is
    the largest relative error of lengths on the plane, 0 without a plane.
    """
    xy = np.array([point[:2] for point in points])
    width, height = np.ptp(xy, axis=0)
    extent = f"{len(points)} points, {width:.4g} by {height:.4g}"
    if plane is None:
        return f"{extent} in the radius's unit", 0.0
    where = f"latitude {plane.latitude:.5f}, longitude {plane.longitude:.5f}"
    distortion = plane.distortion(xy)
    error = f"lengths on the plane are up to {distortion:.1g} too long, relatively"
    return f"{extent} m around {where}; {error}", distortion

"""Flights as files for ground stations, maps and tables."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable, Sequence
from pathlib import Path as FilePath
from typing import NamedTuple
from xml.etree import ElementTree

from dubins_study.missions.flight import Flight, FlightError, Waypoint
from dubins_study.missions.mission import Mission

_GPX = "http://www.topografix.com/GPX/1/1"
_KML = "http://www.opengis.net/kml/2.2"
# Properties of the path in GeoJSON, beside those of `Path.to_geojson`: of the answer.
_PROPERTIES = (
    *("word", "travel_time", "solver", "claim", "verdict", "proof", "gap", "miss"),
    *("reference_low", "reference_high"),
)


def _geojson(flight: Flight, waypoints: Sequence[Waypoint]) -> str:
    """The path, then the points, as GeoJSON.

    The path is drawn by short chords, not by the waypoints. The points have the question's order.
    """
    answer = flight.answer
    plane = flight.mission.plane
    scenario = answer.scenario
    of_path = {name: getattr(answer, name) for name in _PROPERTIES}
    origin = None
    places = scenario.points[1:]
    if plane is not None:
        origin = (plane.latitude, plane.longitude)
        places = plane.to_earth(places)
    path = flight.path.to_geojson(origin=origin, kind="path", radius=scenario.radius, **of_path)
    features = [path]
    # place in the question -> place in the order of passing, and the stop
    visits = {stop.place: (visit, stop) for visit, stop in enumerate(flight.stops, 1)}
    for place, coordinates in enumerate(places.tolist(), 1):
        kind = "via"
        visit, stop = visits.get(place, (None, None))
        if place > len(scenario.via):
            kind = "target"
            visit = None
        properties = {
            "kind": kind,
            "index": place,
            "name": flight.given_name(place) or None,
            "heading_rad": stop and stop.heading,
            "time": stop and stop.time,
        }
        if answer.order is not None:
            properties["visit"] = visit
        geometry = {"type": "Point", "coordinates": coordinates}
        features.append({"type": "Feature", "geometry": geometry, "properties": properties})
    return json.dumps({"type": "FeatureCollection", "features": features}, allow_nan=False) + "\n"


def _csv(flight: Flight, waypoints: Sequence[Waypoint]) -> str:
    text = io.StringIO()
    rows = [point._replace(altitude=_above_sea(flight, point)) for point in waypoints]
    csv.writer(text, lineterminator="\n").writerows([Waypoint._fields, *rows])
    return text.getvalue()


def _above_sea(flight: Flight, point: Waypoint) -> float | None:
    """The altitude of a waypoint above the sea.

    None if the waypoint has no altitude, or if it counts from a home whose own is unknown.
    """
    if point.altitude is None or not flight.mission.above_home:
        return point.altitude
    home = flight.mission.home
    if home is None or home.altitude is None:
        return None
    return point.altitude + home.altitude


def _gpx(flight: Flight, waypoints: Sequence[Waypoint]) -> str:
    """The stops as waypoints, the path as track."""

    def place(parent: ElementTree.Element, name: str, point: Waypoint) -> ElementTree.Element:
        element = _under(parent, name, lat=f"{point.lat:.9f}", lon=f"{point.lon:.9f}")
        altitude = _above_sea(flight, point)
        if altitude is not None:
            _under(element, "ele", repr(altitude))
        return element

    root = ElementTree.Element("gpx", xmlns=_GPX, version="1.1", creator="dubins-study")
    for stop in flight.stops:
        mark = place(root, "wpt", stop)
        _under(mark, "name", stop.name)
        _under(mark, "desc", f"after {stop.time:.1f} s, heading {stop.compass:.1f} degrees")
    track = _under(root, "trk")
    _under(track, "name", flight.title)
    segment = _under(track, "trkseg")
    for point in waypoints:
        place(segment, "trkpt", point)
    return _xml(root)


def _kml(flight: Flight, waypoints: Sequence[Waypoint]) -> str:
    """A placemark for each stop and the path."""
    root = ElementTree.Element("kml", xmlns=_KML)
    document = _under(root, "Document")
    _under(document, "name", flight.title)
    placemark = _under(document, "Placemark")
    _under(placemark, "name", "path")
    line = _under(placemark, "LineString")
    _under(line, "tessellate", "1")
    if _above_sea(flight, waypoints[0]) is not None:
        _under(line, "altitudeMode", "absolute")
    _under(line, "coordinates", " ".join(_on_map(flight, point) for point in waypoints))
    for stop in flight.stops:
        placemark = _under(document, "Placemark")
        _under(placemark, "name", stop.name)
        _under(placemark, "description", f"after {stop.time:.1f} s")
        _under(_under(placemark, "Point"), "coordinates", _on_map(flight, stop))
    return _xml(root)


def _under(
    parent: ElementTree.Element, name: str, text: str = "", **attributes: str
) -> ElementTree.Element:
    """Append a new element with a text; return it."""
    element = ElementTree.SubElement(parent, name, attributes)
    element.text = text
    return element


def _xml(root: ElementTree.Element) -> str:
    ElementTree.indent(root)
    return ElementTree.tostring(root, "unicode", xml_declaration=True) + "\n"


def _on_map(flight: Flight, point: Waypoint) -> str:
    altitude = _above_sea(flight, point)
    text = f"{point.lon:.9f},{point.lat:.9f}"
    if altitude is not None:
        text += f",{altitude}"
    return text


_WAYPOINT = 16  # the command of MAVLink
_ABOVE_HOME = 3  # the frame of MAVLink whose altitudes are above home


def _home_altitude(flight: Flight) -> float:
    """The altitude of home above the sea.

    0 if it is not known.
    """
    home = flight.mission.home
    if home and home.altitude:
        return home.altitude
    return 0.0


def _plan(flight: Flight, waypoints: Sequence[Waypoint]) -> str:
    """Waypoints as a plan file of QGroundControl.

    QGroundControl documents the shape of the file. The first waypoint is the home position.
    """
    items = []
    home, *following = waypoints
    for number, point in enumerate(following, 1):
        item = {
            "type": "SimpleItem",
            "doJumpId": number,
            "command": _WAYPOINT,
            "frame": _ABOVE_HOME,
            "autoContinue": True,
            "params": [0, 0, 0, None, point.lat, point.lon, point.altitude],
        }
        if point.name:
            item["stop"] = point.name  # a key that QGroundControl passes over
        items.append(item)
    speed = flight.answer.scenario.speed
    cruise = {}
    if speed != 1:  # 1 if no speed was given
        cruise["cruiseSpeed"] = speed
    mission = {
        "version": 2,
        "firmwareType": 0,
        "vehicleType": 1,  # fixed wing
        **cruise,
        "plannedHomePosition": [home.lat, home.lon, _home_altitude(flight)],
        "items": items,
    }
    plan = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": mission,
        "geoFence": {"version": 2, "circles": [], "polygons": []},
        "rallyPoints": {"version": 2, "points": []},
    }
    return json.dumps(plan, indent=4, allow_nan=False) + "\n"


def _wpl(flight: Flight, waypoints: Sequence[Waypoint]) -> str:
    """Lines of QGC WPL 110: home, then the waypoints.

    `missions.qgroundcontrol.read_wpl` names the cells of a line.
    """
    home, *following = waypoints
    place = f"{home.lat:.9f}\t{home.lon:.9f}\t{_home_altitude(flight)!r}"
    lines = ["QGC WPL 110", f"0\t1\t0\t{_WAYPOINT}\t0\t0\t0\t0\t{place}\t1"]
    for number, point in enumerate(following, 1):
        place = f"{point.lat:.9f}\t{point.lon:.9f}\t{point.altitude!r}"
        lines.append(f"{number}\t0\t{_ABOVE_HOME}\t{_WAYPOINT}\t0\t0\t0\t0\t{place}\t1")
    return "\n".join(lines) + "\n"


class Format(NamedTuple):
    """A format of flights, and its limits."""

    text: Callable[[Flight, Sequence[Waypoint]], str]
    on_earth: bool = True  # whether it needs longitude and latitude
    needs_altitude: bool = False
    lacks: str = ""


_AUTOPILOT = (
    "takeoff, landing, camera and altitudes above the sea are not in it; turns become waypoints"
)
_FORMATS = {
    ".geojson": Format(_geojson, on_earth=False),
    ".json": Format(_geojson, on_earth=False),
    ".csv": Format(_csv, on_earth=False),
    ".gpx": Format(_gpx, lacks="turns become points of a track"),
    ".kml": Format(_kml, lacks="turns become points of a line"),
    ".plan": Format(_plan, needs_altitude=True, lacks=_AUTOPILOT),
    ".waypoints": Format(_wpl, needs_altitude=True, lacks=_AUTOPILOT),
    ".txt": Format(_wpl, needs_altitude=True, lacks=_AUTOPILOT),
}


def format_of(file: FilePath, mission: Mission) -> Format:
    """The format that a file's ending names.

    Raises:
        FlightError: if there is none, or it needs longitudes and latitudes that the mission lacks.
    """
    file_format = _FORMATS.get(file.suffix.lower())
    if file_format is None:
        raise FlightError(f"{file}: unknown ending; expected one of {' '.join(_FORMATS)}")
    if file_format.on_earth and mission.plane is None:
        others = " ".join(ending for ending, each in _FORMATS.items() if not each.on_earth)
        raise FlightError(
            f"{file}: {file.suffix} needs longitude and latitude, and the points have x and y; "
            f"expected one of {others}"
        )
    return file_format


def write_flight(
    flight: Flight, file: FilePath, step: float | None = None, altitude: float = 50.0
) -> str:
    """Write a flight in a file's format.

    The file's ending names the format. A sentence about what it cannot say is returned.

    Args:
        step: from waypoint to waypoint along the path (m, or the points' unit); without one a
            quarter of the radius.
        altitude: m above home, where the format needs one and the mission has none that is.

    Raises:
        FlightError: as `format_of`, and as `Flight.waypoints`.
        OSError: if the file cannot be written.
    """
    chosen = format_of(file, flight.mission)
    size = step
    if size is None:
        size = 0.25 * flight.answer.scenario.radius
    waypoints = []
    if chosen.text is not _geojson:
        waypoints = flight.waypoints(size)
    if chosen.needs_altitude:  # above home: altitudes above the sea are replaced
        for number, point in enumerate(waypoints):
            if not flight.mission.above_home or point.altitude is None:
                waypoints[number] = point._replace(altitude=altitude)
    content = chosen.text(flight, waypoints).encode()
    file.write_bytes(content)  # nothing is written if the text cannot be made
    if chosen.text is _geojson and flight.mission.plane is None:
        return "its coordinates are x and y of the points, no longitude and latitude"
    if not chosen.lacks:
        return ""
    return f"{chosen.lacks}, {size:g} apart"

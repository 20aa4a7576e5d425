"""Points of GPX, KML and GeoJSON files.

Of several kinds of points in a file, one is taken.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import chain
from typing import Any
from xml.etree import ElementTree

from dubins_study.missions.mission import MissionError, MissionPoint
from dubins_study.missions.reading import Reading, each, point_of, reading_of


def read_xml(text: str, compass: bool) -> Reading:
    """Read the points of GPX or KML.

    The first element tells which format it is.
    """
    if re.search(r"<!(DOCTYPE|ENTITY)", text):
        raise MissionError("it declares a document type or entities, which are not read")
    root = ElementTree.fromstring(text)
    element = _tag(root)
    if element == "gpx":
        return _read_gpx(root)
    if element == "kml":
        return _read_kml(root)
    raise MissionError(f"its first element is {element}; expected gpx or kml")


def _tag(element: Any) -> str:
    return str(element.tag).rpartition("}")[2]


def _read_gpx(root: Any) -> Reading:
    """Read the points of routes, waypoints or tracks.

    Only the first of these three that the file has are read.
    """
    # points become features of GeoJSON, which `_read_features` reads
    kinds = ("rtept", "wpt", "trkpt")
    features = []
    for kind in kinds:
        for point in root.iterfind(f".//{{*}}{kind}"):
            position = [point.get("lon"), point.get("lat"), point.findtext("{*}ele")]
            geometry = {"type": kind, "coordinates": position}
            properties = {"name": point.findtext("{*}name")}
            features.append({"geometry": geometry, "properties": properties})
    return _read_features("GPX", features, kinds=kinds)


def _read_kml(root: Any) -> Reading:
    """Read the points of placemarks.

    If there are none, the points of the placemarks' lines and tracks are read.
    """
    # placemarks become features of GeoJSON, which `_read_features` reads
    features = []
    for placemark in root.iterfind(".//{*}Placemark"):
        properties = {"name": placemark.findtext("{*}name")}
        for shape in placemark.iter():
            texts = (shape.findtext("{*}coordinates") or "").split()
            positions = [text.split(",") for text in texts]
            positions += [str(coord.text).split() for coord in shape.iterfind("{*}coord")]
            if positions:
                kind = _tag(shape).replace("Track", "LineString")
                geometry = {"type": kind, "coordinates": positions}
                features.append({"geometry": geometry, "properties": properties})
    return _read_features("KML", features)


def read_geojson(content: Any, compass: bool) -> Reading:
    """Read the points of features, else of their lines.

    The numbers are longitudes and latitudes. If a member `crs` names another system than WGS 84, or
    if a number is too large for degrees, they are lengths on a plane.
    """
    reading = _read_features("GeoJSON", content.get("features", [content]), compass)
    crs = content.get("crs")
    on_earth = crs is None or re.search("CRS84|4326", str(crs))
    if on_earth and all(abs(point.x) <= 180 and abs(point.y) <= 90 for point in reading.points):
        return reading
    note = "no degrees of WGS 84, by crs or by size: x and y on a plane, in the radius's unit"
    notes = filter(None, (note, reading.passed))
    return reading._replace(degrees=False, passed="; ".join(notes))


def _read_features(
    source: str,
    features: Any,
    compass: bool = False,
    kinds: Sequence[str] = ("Point", "LineString"),
) -> Reading:
    """Read the points of GeoJSON's features.

    Only geometries of one kind are read: the first of `kinds` that any feature has. Features of
    other kinds are counted as passed over.
    """
    counts = Counter(map(_kind, features))
    kind = next((name for name in kinds if name in counts), kinds[0])

    def read(feature: Any) -> Iterator[MissionPoint]:
        properties = feature.get("properties") or {}
        if kind == "LineString":  # its name is not that of its points
            properties = {}
        for position in _positions(_geometry(feature)["coordinates"]):
            # a position may have a third number, its own altitude, which counts first
            x, y, altitude = [*position, properties.get("altitude")][:3]
            yield point_of({**properties, "x": x, "y": y, "altitude": altitude}, compass)

    points = each(kind, [feature for feature in features if _kind(feature) == kind], read)
    del counts[kind]  # the others are passed over
    return reading_of(source, points, counts)


def _geometry(feature: Any) -> Any:
    """The geometry of a feature.

    A geometry that stands without a feature is returned as it is.
    """
    return feature.get("geometry", feature) or {"type": "without geometry"}


def _kind(feature: Any) -> str:
    return str(_geometry(feature)["type"]).removeprefix("Multi")


def _positions(coordinates: Any) -> list[Any]:
    """The positions in lists of any depth."""
    if isinstance(coordinates[0], list):
        return list(chain.from_iterable(map(_positions, coordinates)))
    return [coordinates]

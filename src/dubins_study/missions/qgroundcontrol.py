"""Points of mission files of ground stations.

They are plans in JSON, and lines of QGC WPL 110.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

from dubins_study.missions.mission import MissionPoint
from dubins_study.missions.reading import Reading, each, point_of, reading_of

# Commands of MAVLink by number. The vehicle passes the place of these; a yaw that they may have is
# where a copter looks, and no course.
_PLACES = {
    16: "waypoint",
    17: "loiter without end",
    18: "loiter turns",
    19: "loiter time",
    21: "land",
    22: "takeoff",
    31: "loiter to altitude",
    82: "spline waypoint",
    84: "VTOL takeoff",
    85: "VTOL land",
}
_NAMES = _PLACES | {
    20: "return to launch",
    93: "delay",
    177: "jump",
    178: "change speed",
    195: "region of interest",
    201: "region of interest",
    206: "camera trigger distance",
    530: "camera mode",
    2000: "take pictures",
    2001: "stop pictures",
    2500: "record video",
}
_AT_HOME = (21, 22, 84, 85)  # takeoffs and landings, often at the home position
_ON_EARTH = (0, 3, 5, 6, 10, 11)  # frames of coordinates in degrees
_ABOVE_SEA = (0, 5)  # frames whose altitudes are above the sea
_ABOVE_HOME = (3, 6)  # frames whose altitudes are above home


def read_plan(content: Any, source: str = "QGroundControl plan") -> Reading:
    """Read the points of a plan, and its home.

    The points are those of its items, surveys included. Home is the planned home position.
    """
    passed: Counter[str] = Counter()
    mission = content["mission"]
    position = mission.get("plannedHomePosition") or (0, 0)
    # read like a waypoint (16) with an altitude above home (3): what is passed over is not counted
    home = _places({"command": 16, "frame": 3, "coordinate": position}, Counter(), [])
    points = each("item", mission["items"], lambda item: _places(item, passed, home))
    for shape in ("polygons", "circles"):
        passed[f"fence {shape}"] = len(content.get("geoFence", {}).get(shape, ()))
    speed = mission.get("cruiseSpeed")
    return reading_of(source, points, passed, home=next(iter(home), None), speed=speed)


def read_wpl(text: str, compass: bool) -> Reading:
    """Read the points of QGC WPL 110.

    The first line is the format's name, the second the home position. A line's cells are: number,
    current, frame, command, four parameters, latitude, longitude, altitude, autocontinue.
    """
    _, home, *rows = [line.split() for line in text.splitlines() if line.strip()]
    items = [{"frame": row[2], "command": row[3], "params": row[4:11]} for row in rows]
    plan = {"items": items, "plannedHomePosition": home[8:11]}
    return read_plan({"mission": plan}, "QGC WPL 110")


def _places(item: Any, passed: Counter[str], home: list[MissionPoint]) -> list[MissionPoint]:
    """The points of an item of a plan.

    A survey has several points. The list is empty for an item without a place, and for a takeoff or
    landing at the home position: `passed` counts these by name, and is changed in place. `home` has
    the home position, above which altitudes are returned, or is empty.
    """
    transects = item.get("TransectStyleComplexItem") or {}
    if corners := transects.get("VisualTransectPoints"):
        height = (transects.get("CameraCalc") or {}).get("DistanceToSurface")
        return [
            point_of({"x": corner[1], "y": corner[0], "altitude": height}) for corner in corners
        ]
    if "command" not in item:
        passed[str(item["complexItemType"])] += 1
        return []
    command = int(item["command"])
    name = _NAMES.get(command, f"command {command}")
    # the first version of plans has the place beside four parameters
    parameters = [*item.get("params", [0] * 4), *item.get("coordinate", ()), None]
    latitude, longitude, altitude = parameters[4:7]
    frame = int(item.get("frame", 0))
    # at 0 0, or null, it is where the vehicle is
    has_place = frame in _ON_EARTH and any(map(float, (latitude or 0, longitude or 0)))
    if command in _PLACES and has_place:
        above = None
        if home:
            above = home[0].altitude
        if altitude is not None and frame in _ABOVE_SEA and above is not None:
            altitude = float(altitude) - above
        elif altitude is not None and frame not in _ABOVE_HOME:
            passed["altitude that is not above home"] += 1
            altitude = None
        point = point_of({"x": longitude, "y": latitude, "altitude": altitude})
        if command not in _AT_HOME or point[:2] not in [place[:2] for place in home]:
            return [point]
        name = f"{name} at home"
    elif command in _PLACES:
        name = f"{name} without a place"
    passed[name] += 1
    return []

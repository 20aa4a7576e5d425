"""Flights as files, read back by others' parsers."""

import csv
import json
import math
from xml.etree import ElementTree

import gpxpy
import numpy as np
import pytest

from dubins_study import read_mission, solve
from dubins_study.missions.flight import FlightError, flight_of
from dubins_study.missions.mission import Mission, MissionPoint
from dubins_study.missions.write import format_of, write_flight
from dubins_study.study.tangent_plane import TangentPlane
from tests.unit.missions.test_read import FILES

GPX = "{http://www.topografix.com/GPX/1/1}"
KML = "{http://www.opengis.net/kml/2.2}"
NAMES = ["mill & <oak>", "ford", "gate"]
POINTS = tuple(
    MissionPoint(x, y, name=name)
    for (x, y), name in zip([(900, 100), (300, 700), (-500, 400)], NAMES, strict=True)
)
ON_EARTH = Mission(POINTS, MissionPoint(0, 0), TangentPlane(-33.0, 151.0))
ON_A_PLANE = Mission(POINTS, MissionPoint(0, 0))


@pytest.fixture(scope="module")
def flight():
    return flight_of(solve(ON_EARTH.scenario(radius=80, speed=16)), ON_EARTH)


def places_of(flight, step):
    return [(point.lon, point.lat) for point in flight.waypoints(step)]


def test_gpx_has_its_elements_in_order(flight, tmp_path):
    """GPX has its elements in order.

    GPX 1.1: waypoints, then tracks; of a waypoint ele, name, desc.
    """
    file = tmp_path / "flight.gpx"
    lacks = write_flight(flight, file, step=20)
    root = ElementTree.parse(file).getroot()

    assert lacks == "turns become points of a track, 20 apart"
    assert [child.tag for child in root] == [f"{GPX}wpt"] * 3 + [f"{GPX}trk"]
    assert [mark.find(f"{GPX}name").text for mark in root.iter(f"{GPX}wpt")] == NAMES
    for mark in root.iter(f"{GPX}wpt"):
        tags = [child.tag for child in mark]
        assert tags == [f"{GPX}name", f"{GPX}desc"]
    track = [(float(p.get("lon")), float(p.get("lat"))) for p in root.iter(f"{GPX}trkpt")]
    np.testing.assert_allclose(track, places_of(flight, 20), atol=1e-9)


def test_gpx_is_what_another_program_reads(flight, tmp_path):
    """gpxpy finds the stops, their names, and the track."""
    file = tmp_path / "flight.gpx"
    write_flight(flight, file, step=20)
    gpx = gpxpy.parse(file.read_text())

    assert [mark.name for mark in gpx.waypoints] == NAMES
    track = [(point.longitude, point.latitude) for point in gpx.walk(only_points=True)]
    np.testing.assert_allclose(track, places_of(flight, 20), atol=1e-9)


def test_kml_has_a_line_and_a_placemark_for_each_stop(flight, tmp_path):
    """KML has a line and placemarks for stops.

    KML 2.2: of a placemark the name, the description, then the geometry.
    """
    file = tmp_path / "flight.kml"
    write_flight(flight, file, step=20)
    root = ElementTree.parse(file).getroot()
    path, *stops = root.iter(f"{KML}Placemark")

    assert root.tag == f"{KML}kml"
    line = path.find(f"{KML}LineString/{KML}coordinates").text.split()
    written = [tuple(map(float, text.split(","))) for text in line]
    np.testing.assert_allclose(written, places_of(flight, 20), atol=1e-9)
    assert [stop.find(f"{KML}name").text for stop in stops] == NAMES
    for stop in stops:
        tags = [child.tag.removeprefix(KML) for child in stop]
        assert tags == ["name", "description", "Point"]


def test_a_plan_has_what_its_documentation_asks_for(flight, tmp_path):
    """The keys of QGroundControl's plan files, with their types."""
    file = tmp_path / "flight.plan"
    write_flight(flight, file, step=20, altitude=77)
    plan = json.loads(file.read_text())
    mission = plan["mission"]

    assert (plan["fileType"], plan["version"]) == ("Plan", 1)
    assert (plan["geoFence"]["version"], plan["rallyPoints"]["version"]) == (2, 2)
    assert mission["version"] == 2
    assert mission["cruiseSpeed"] == 16
    assert len(mission["plannedHomePosition"]) == 3
    for number, item in enumerate(mission["items"], 1):
        assert (item["type"], item["command"], item["frame"]) == ("SimpleItem", 16, 3)
        assert item["doJumpId"] == number
        assert item["autoContinue"] is True
        assert len(item["params"]) == 7
        assert item["params"][6] == 77
    stops = [item["stop"] for item in mission["items"] if "stop" in item]
    assert stops == NAMES


def test_waypoint_lines_have_twelve_cells(flight, tmp_path):
    """Waypoint lines have twelve cells.

    QGC WPL 110: home is line 0, in the global frame; the others are above home.
    """
    file = tmp_path / "flight.waypoints"
    write_flight(flight, file, step=20, altitude=77)
    first, *lines = file.read_text().splitlines()
    rows = [line.split("\t") for line in lines]

    assert first == "QGC WPL 110"
    assert {len(row) for row in rows} == {12}
    assert [int(row[0]) for row in rows] == list(range(len(rows)))
    assert [row[2] for row in rows] == ["0"] + ["3"] * (len(rows) - 1)
    written = [(float(row[9]), float(row[8])) for row in rows]
    np.testing.assert_allclose(written, places_of(flight, 20), atol=1e-9)


@pytest.mark.parametrize("mission", [ON_EARTH, ON_A_PLANE], ids=["on Earth", "on a plane"])
def test_a_table_has_the_path_as_it_is_sampled(mission, tmp_path):
    """A table has the path as it is sampled.

    It has the poses and curvatures of `Path.at`; degrees are empty on a plane.
    """
    file = tmp_path / "flight.csv"
    flown = flight_of(solve(mission.scenario(radius=80, speed=16)), mission)
    assert not write_flight(flown, file, step=20)
    with file.open(newline="") as opened:
        rows = list(csv.DictReader(opened))

    lengths = [float(row["length"]) for row in rows]
    poses = [[float(row[name]) for name in ("x", "y")] for row in rows]
    np.testing.assert_allclose(poses, flown.path.at(lengths)[:, :2], atol=1e-9)
    assert [float(row["time"]) * 16 for row in rows] == pytest.approx(lengths)
    assert [row["name"] for row in rows if row["name"]] == NAMES
    assert {bool(row["lon"]) for row in rows} == {mission is ON_EARTH}
    turned = [math.radians(float(row["compass"])) + float(row["heading"]) for row in rows]
    # north of the plane and true north are a meridian's convergence apart: 100 m at 33 degrees
    assert max(abs(math.remainder(angle - math.pi / 2, math.tau)) for angle in turned) < 2e-4


@pytest.mark.parametrize("name", FILES)
def test_every_file_of_a_mission_becomes_a_flight(name, tmp_path):
    """Every file of a mission becomes a flight.

    It is written in each format that its coordinates allow; the stops lie where the file has them.
    """
    text, places, _ = FILES[name]
    source = tmp_path / "mission.dat"
    source.write_bytes(text if isinstance(text, bytes) else text.encode())
    mission = read_mission(source)
    flown = flight_of(solve(mission.scenario(radius=10)), mission)
    endings = ["geojson", "csv"]
    if mission.plane is not None:
        endings += ["plan", "waypoints", "gpx", "kml"]
    for ending in endings:
        write_flight(flown, tmp_path / f"flight.{ending}")
        assert (tmp_path / f"flight.{ending}").stat().st_size > 0
    features = json.loads((tmp_path / "flight.geojson").read_text())["features"]
    points = [feature["geometry"]["coordinates"] for feature in features[1:]]

    np.testing.assert_allclose(points, places[1:], atol=1e-6)
    assert len(flown.stops) == len(places) - 1


def test_what_is_written_is_read_back(flight, tmp_path):
    """Written files are read back.

    The reader of missions takes the stops of a map, and else every waypoint.
    """
    waypoints = np.array(places_of(flight, 20))
    stops = np.array([(stop.lon, stop.lat) for stop in flight.stops])
    for ending in ("plan", "waypoints", "kml", "gpx", "csv"):
        places = stops if ending in ("kml", "gpx") else waypoints
        file = tmp_path / f"flight.{ending}"
        write_flight(flight, file, step=20)
        mission = read_mission(file).started()
        flown = (mission.home, *mission.points)
        points = mission.plane.to_earth([point[:2] for point in flown])
        for place in places:
            away = np.hypot(*(points - place).T)
            assert away.min() < 1e-8, ending


def test_an_ending_says_what_it_needs(tmp_path):
    """Before anything is solved or written."""
    with pytest.raises(FlightError, match=r"flight.doc: unknown ending; expected one of .geojson"):
        format_of(tmp_path / "flight.doc", ON_EARTH)
    for ending in ("plan", "waypoints", "txt", "gpx", "kml"):
        with pytest.raises(FlightError, match="needs longitude and latitude"):
            format_of(tmp_path / f"flight.{ending}", ON_A_PLANE)


PLAN = "QGroundControl plan"


@pytest.mark.parametrize(
    ("altitude", "source", "written"),
    [(None, "GPX", 50), (300.0, "GPX", 50), (300.0, PLAN, 300), (None, PLAN, 50)],
)
def test_altitudes_of_a_plan_are_above_home(altitude, source, written, tmp_path):
    """Altitudes of a plan are above home.

    Those above the sea are not written: ground under a map's point is no height to fly at.
    """
    file = tmp_path / "flight.plan"
    write_flight(_flight_with(altitude, source, home=520.0), file)
    mission = json.loads(file.read_text())["mission"]

    assert {item["frame"] for item in mission["items"]} == {3}
    assert {item["params"][6] for item in mission["items"]} == {written}
    assert mission["plannedHomePosition"][2] == 520.0


@pytest.mark.parametrize(
    ("source", "home", "written"),
    [(PLAN, 520.0, 820.0), (PLAN, None, None), ("GPX", 520.0, 300.0)],
)
def test_altitudes_of_a_map_are_above_the_sea(source, home, written, tmp_path):
    """Altitudes of a map are above the sea.

    Of a plan's points they are the sum with home's, or none where nobody knows that.
    """
    flight = _flight_with(300.0, source, home)
    for ending in ("gpx", "kml", "csv"):
        write_flight(flight, tmp_path / f"flight.{ending}", step=100)
    gpx = gpxpy.parse((tmp_path / "flight.gpx").read_text())
    kml = ElementTree.parse(tmp_path / "flight.kml").getroot()
    with (tmp_path / "flight.csv").open(newline="") as opened:
        row = list(csv.DictReader(opened))[-1]

    assert gpx.waypoints[-1].elevation == written
    *_, last = kml.find(f".//{KML}LineString/{KML}coordinates").text.split()
    assert last.split(",")[2:] == ([] if written is None else [str(written)])
    modes = [mode.text for mode in kml.iter(f"{KML}altitudeMode")]
    assert modes == ([] if written is None else ["absolute"])
    assert row["altitude"] == ("" if written is None else str(written))


def _flight_with(altitude, source, home):
    """A flight whose points all have one altitude."""
    points = tuple(point._replace(altitude=altitude) for point in POINTS)
    start = ON_EARTH.home._replace(altitude=home)
    mission = Mission(points, start, ON_EARTH.plane, source=source)
    return flight_of(solve(mission.scenario(radius=80)), mission)

"""Mission files of every format.

They are read as they are, and refused with one clear line.
"""

import csv
import io
import json
import math

import gpxpy.gpx
import numpy as np
import pytest
from geographiclib.geodesic import Geodesic
from hypothesis import given
from hypothesis import strategies as st

from dubins_study import DubinsStudyError, read_mission
from dubins_study.missions.table import read_points
from dubins_study.study.tangent_plane import TangentPlane

LONLAT = [(11.5, 48.1), (11.51, 48.1), (11.51, 48.11)]
XY = [(0, 0), (100, 0), (100, 50.5)]
GPX = '<?xml version="1.0"?>\n<gpx version="1.1" creator="t" xmlns="http://www.topografix.com/GPX/1/1">'
KML = '<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2"><Document>'


def gpx_points(tag):
    return "".join(f'<{tag} lat="{lat}" lon="{lon}"><ele>5</ele></{tag}>' for lon, lat in LONLAT)


def item(lon, lat, command=16, frame=3, **others):
    params = [0, 0, 0, None, lat, lon, 50]
    fields = {"type": "SimpleItem", "command": command, "frame": frame, "params": params}
    return {**fields, **others}


def plan(*items, home=(0, 0, 0), **others):
    mission = {"items": items, "plannedHomePosition": home, "version": 2}
    return json.dumps({"fileType": "Plan", "mission": mission, "version": 1, **others})


def survey(**transect):
    fields = {"type": "ComplexItem", "complexItemType": "survey"}
    return {**fields, "TransectStyleComplexItem": transect, "polygon": [[1, 2]]}


CORNERS = [[lat, lon] for lon, lat in LONLAT]
LANDING = {"type": "ComplexItem", "complexItemType": "fwLandingPattern"}


def wpl(*rows):
    return "QGC WPL 110\r\n" + "".join("\t".join(map(str, row)) + "\r\n" for row in rows)


def row(number, lon, lat, command=16, frame=3):
    return (number, 0, frame, command, 0, 0, 0, 0, lat, lon, 100.0, 1)


ROWS = [row(number, *place) for number, place in enumerate(LONLAT, 1)]


def features(*geometries, **members):
    found = [{"type": "Feature", "geometry": each, "properties": None} for each in geometries]
    return json.dumps({"type": "FeatureCollection", "features": found, **members})


def shape(kind, coordinates):
    return {"type": kind, "coordinates": coordinates}


POINTS = [shape("Point", place) for place in LONLAT]
LINE = shape("LineString", LONLAT)

# text -> the points of the file, degrees or metres, and what a note says
FILES = {
    "x and y": ("x,y\n0,0\n100,0\n100,50.5\n", XY, "3 points, 100 by 50.5"),
    "metres in the names": ("X_m;Y [m]\n0,0;0,0\n100,0;0\n1e2;50,5\n", XY, "3 points"),
    "header behind a sign": ("# made by hand\n# x_m,y_m\n0,0\n100,0\n100,50.5\n", XY, "3 points"),
    "comments above a header": ("# one, two, three, four\nx,y\n0,0\n100,0\n100,50.5\n", XY, ""),
    "easting": (
        "Easting\tNorthing\tzone\n0\t0\t32U\n100\t0\t32U\n100\t50.5\t32U\n",
        XY,
        "columns that are passed over: zone",
    ),
    "longitude": (
        "id,Latitude,Longitude,alt\n1,48.1,11.5,3\n\n2,48.1,11.51,\n3,48.11,11.51,4\n",
        LONLAT,
        "around latitude 48.10500, longitude 11.50500",
    ),
    "lng": ("\ufefflng;lat\r\n11,5;48,1\r\n11,51;48,1\r\n11,51;48,11\r\n", LONLAT, ""),
    "a byte order mark of UTF-16": ("x,y\n0,0\n100,0\n100,50.5\n".encode("utf-16"), XY, ""),
    "gpx waypoints": (GPX + gpx_points("wpt") + "</gpx>", LONLAT, "3 points"),
    "gpx route": (
        f"{GPX}<wpt lat='1' lon='2'/><rte>{gpx_points('rtept')}</rte></gpx>",
        LONLAT,
        "passed over: 1 wpt",
    ),
    "gpx track": (
        f"{GPX}<trk><trkseg>{gpx_points('trkpt')}</trkseg><trkseg/></trk></gpx>",
        LONLAT,
        "3 points",
    ),
    "kml points": (
        KML
        + "".join(
            f"<Placemark><name>P</name><Point><coordinates>\n{lon},{lat},5\n</coordinates></Point></Placemark>"
            for lon, lat in LONLAT
        )
        + "<Placemark><Polygon><outerBoundaryIs><LinearRing><coordinates>0,0 1,0 1,1 0,0"
        "</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>",
        LONLAT,
        "passed over: 1 LinearRing",
    ),
    "kml line": (
        f"{KML}<Placemark><LineString><coordinates>11.5,48.1 11.51,48.1,0\n"
        "11.51,48.11</coordinates></LineString></Placemark></Document></kml>",
        LONLAT,
        "3 points",
    ),
    "kml track": (
        f"{KML}<Placemark><gx:Track><gx:coord>11.5 48.1 9</gx:coord><gx:coord>11.51 48.1 9"
        "</gx:coord><gx:coord>11.51 48.11 9</gx:coord></gx:Track></Placemark></Document></kml>",
        LONLAT,
        "3 points",
    ),
    "geojson points": (features(*POINTS, LINE, None), LONLAT, "1 LineString, 1 without geometry"),
    "geojson lines": (json.dumps(shape("MultiLineString", [LONLAT])), LONLAT, ""),
    "geojson on a plane": (
        features(shape("LineString", [(0, 0), (100, 0), (100, 50.5)]), crs={"name": "EPSG:32632"}),
        XY,
        "no degrees of WGS 84, by crs or by size: x and y on a plane",
    ),
    "geojson in metres": (
        features(shape("LineString", [(500, 0), (600, 0), (600, 50.5)])),
        [(500, 0), (600, 0), (600, 50.5)],
        "no degrees of WGS 84, by crs or by size",
    ),
    "a plan": (
        plan(
            item(0, 0, 22),
            item(0, 0, 178, 2),
            *(item(*place, command) for place, command in zip(LONLAT, (16, 82, 21), strict=True)),
            item(None, None, 20, 2),
            item(None, None, 206, 2),
            item(1, 2, 1234),
        ),
        LONLAT,
        "passed over: 1 takeoff without a place, 1 change speed, 1 return to launch, "
        "1 camera trigger distance, 1 command 1234",
    ),
    "a plan's survey": (
        plan(
            survey(VisualTransectPoints=CORNERS),
            LANDING,
            geoFence={"circles": [], "polygons": [{}, {}], "version": 2},
        ),
        LONLAT,
        "passed over: 1 fwLandingPattern, 2 fence polygons",
    ),
    "an old plan": (
        plan(
            *(
                item(0, 0, params=[0] * 4, coordinate=[lat, lon, 5], complexItemType=None)
                for lon, lat in LONLAT
            )
        ),
        LONLAT,
        "3 points",
    ),
    "waypoints": (
        wpl(row(0, 0, 0), *ROWS[:1], row(9, 0, 0, 177), *ROWS[1:]),
        LONLAT,
        "passed over: 1 jump",
    ),
    "tsplib": (
        "NAME : t\nEDGE_WEIGHT_TYPE : EUC_2D\nNODE_COORD_SECTION\n"
        " 1 0 0\n2 100.0 0\n3   1e2 50.5\nEOF\n",
        XY,
        "3 points",
    ),
}


@pytest.fixture
def mission_of(tmp_path):
    """Reads a text, or bytes, as a mission.

    The file's ending says nothing.
    """

    def read(text, **options):
        file = tmp_path / "mission.dat"
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_mission(file, **options)

    return read


@pytest.mark.parametrize("name", FILES)
def test_a_file_is_read_as_it_is(name, mission_of):
    """A file is read as it is.

    Its points are where geodesics from the middle end; what is passed over is named.
    """
    text, expected, note = FILES[name]
    mission = mission_of(text)

    points = [(point.x, point.y) for point in mission.points]
    if mission.plane is not None:
        middle = mission.plane.latitude, mission.plane.longitude
        lines = [Geodesic.WGS84.Inverse(*middle, lat, lon) for lon, lat in expected]
        ends = [(line["s12"], math.radians(line["azi1"])) for line in lines]
        expected = [(far * math.sin(azimuth), far * math.cos(azimuth)) for far, azimuth in ends]
    np.testing.assert_allclose(points, expected, atol=1e-6)
    assert note in "\n".join(mission.notes)
    assert mission.home is None
    assert mission.warnings == ()
    scenario = mission.scenario(radius=10)
    assert scenario.legs == 2
    np.testing.assert_allclose(scenario.points, expected, atol=1e-6)


# text -> what its refusal says after the file's name
WRONG = {
    "empty": ("", "the file is empty"),
    "blank": (" \r\n\t\n", "the file is empty"),
    "binary": (bytes(range(256)), "it is not UTF-8 text"),
    "zeros": (b"x,y\n1,2\n\0\0\0", "it is not UTF-8 text"),
    "Latin-1": ("x,y,name\n1,2,Höhe\n".encode("latin-1"), "it is not UTF-8 text"),
    "UTF-16 unmarked": ("x,y\n1,2\n".encode("utf-16-le"), "it is not UTF-8 text"),
    "KMZ": (b"PK\x03\x04\xff\xff", "save a table as UTF-8; unpack a KMZ archive"),
    "swapped": ("lon,lat\n48.1,111.5\n", "line 2: longitude is 48.1, latitude is 111.5; expected"),
    "metres as degrees": ("lon,lat\n692000,5330000\n", "are the two swapped, or metres?"),
    "mixed units": ("lon,lat\n11.5,48.1\n11500,48100\n", "line 3: longitude is 11500.0"),
    "swapped GPX": (f"{GPX}<wpt lat='111' lon='48'/></gpx>", "wpt 1: longitude is 48.0"),
    "compass": ("x,y,heading\n0,0,\n1,1,270\n", "line 3: heading: 270 is more than a full turn"),
    "no header": (
        "1,2\n3,4\n",
        "line 1 is '1,2'; expected the column names x and y, once each, or lon and lat; or name",
    ),
    "half a pair": ("x,lat\n1,2\n", "line 1 is 'x,lat'; expected the column names x and y"),
    "no columns": ("a;b\n1;2\n", "line 1 is 'a,b'; expected the column names"),
    "duplicates": ("x,y,Y\n1,2,3\n", "line 1 is 'x,y,Y'; expected the column names x and y, once"),
    "two altitudes": ("x,y,alt,ele\n1,2,3,4\n", "column 'altitude': expected one column"),
    "a number as a name": ("x,y,2024\n1,a,3\n", "line 2: x,y is '1,a'; expected two numbers"),
    "two headings": ("x,y,heading,heading\n1,2,3,4\n", "expected one column heading"),
    "a unit in the name": ("x,y,heading_deg\n1,2,3\n", "column 'heading_deg': expected one column"),
    "NaN": ("x,y\n1,nan\n", "line 2: x,y is '1,nan'; expected two numbers"),
    "infinity": ("x,y\n1,2\ninf,3\n", "line 3: x,y is 'inf,3'; expected two numbers"),
    "a text": ("lon;lat\n11,5;north\n", "line 2: x,y is '11.5,north'; expected two numbers"),
    "too many cells": ("x,y\n1,2,3\n", "line 2: 3 cells; expected 2, as in line 1"),
    "too few cells": ("x,y\n1,2\n3\n", "line 3: x,y is '3,'; expected two numbers"),
    "a decimal comma": ("x,y\n1,5,2,5\n", "line 2: 4 cells; expected 2, as in line 1"),
    "an open quote": ('x,y,name\n1,2,"a\n3,4,b\n', "line 2: unexpected end of data"),
    "bad altitude": ("x,y,alt\n1,2,high\n", "line 2: altitude is 'high'; expected a number"),
    "header alone": ("lon,lat\n", "no points; expected a line each"),
    "cut JSON": (plan(item(1, 2))[:-9], "cut, or not as its format has it (JSONDecodeError"),
    "deep JSON": ("[" * 100_000, "cut, or not as its format has it (RecursionError"),
    "a JSON list": ("[1, 2]", "it is neither a plan, with a member mission, nor GeoJSON"),
    "another object": ('{"a": 1}', "it is neither a plan, with a member mission, nor GeoJSON"),
    "no items": (plan(), "there are no points; it has nothing"),
    "unknown commands": (plan(item(1, 2, 999)), "there are no points; it has 1 command 999"),
    "landing alone": (plan(LANDING), "there are no points; it has 1 fwLandingPattern"),
    "local frame": (plan(item(1, 2, 16, 1)), "it has 1 waypoint without a place"),
    "a plan of texts": (plan("x"), "item 1: cut, or not as its format has it"),
    "a survey of another program": (
        plan(survey(VisualTransectPoints=[], Items=[])),
        "there are no points; it has 1 survey",
    ),
    "a plan of nothing": ('{"mission": 3}', "cut, or not as its format has it"),
    "NaN in a plan": (plan(item(math.nan, 48)), "item 1: x,y is 'nan,48'; expected two numbers"),
    "polygons": (features(shape("Polygon", [LONLAT])), "there are no points; it has 1 Polygon"),
    "no coordinates": (features({"type": "Point"}), "Point 1: cut, or not as its format has it"),
    "text in GeoJSON": (
        features(shape("Point", ["a", 1])),
        "Point 1: x,y is 'a,1'; expected two",
    ),
    "a number as GeoJSON": ('{"type": 3}', "there are no points; it has 1 3"),
    "cut GPX": (f"{GPX}<wpt lat='1'", "cut, or not as its format has it (ParseError"),
    "GPX without points": (f"{GPX}</gpx>", "there are no points"),
    "text in GPX": (
        f"{GPX}<wpt lat='a' lon='1'/></gpx>",
        "wpt 1: x,y is '1,a'; expected two numbers",
    ),
    "NaN in GPX": (f"{GPX}<wpt lat='nan' lon='1'/></gpx>", "wpt 1: x,y is '1,nan'; expected"),
    "entities": (
        '<?xml version="1.0"?><!DOCTYPE kml [<!ENTITY a "b">]><kml>&a;</kml>',
        "it declares a document type or entities",
    ),
    "cut KML": (f"{KML}<Placemark>", "cut, or not as its format has it (ParseError"),
    "KML without points": (f"{KML}</Document></kml>", "there are no points"),
    "text in KML": (
        f"{KML}<Placemark><Point><coordinates>a,b</coordinates></Point></Placemark></Document></kml>",
        "Point 1: x,y is 'a,b'; expected two numbers",
    ),
    "HTML": ("<html><body/></html>", "its first element is html; expected gpx or kml"),
    "an endless number": (plan(item(11, 10**400)), "item 1: cut, or not as its format has it"),
    "rows cut": (wpl(row(0, 1, 2), row(1, 1, 2)[:9]), "item 1: cut, or not as its format has it"),
    "no rows": ("QGC WPL 110\n", "cut, or not as its format has it"),
    "a TSPLIB node": (
        "EDGE_WEIGHT_TYPE: EUC_2D\r\nNODE_COORD_SECTION\r\n1 2 3\r\n2 4\r\nEOF\r\n",
        "line 4: x,y is '4,'; expected two numbers",
    ),
    "explicit TSPLIB": (
        "EDGE_WEIGHT_TYPE: EXPLICIT\nNODE_COORD_SECTION\n1 2 3\n",
        "expected EDGE_WEIGHT_TYPE EUC_2D",
    ),
    "neighbours": ("x,y\n0,0\n1,1\n1,1\n1,1\n2,2\n", "line 4 equals the point before it; such"),
    "home": (
        plan(item(*LONLAT[0]), home=[*LONLAT[0][::-1], 1]),
        "item 1 equals the point before it",
    ),
    "closed": ("x,y\n0,0\n1,1\n2,0\n0,0\n", "line 5 equals the first point; --closed flies back"),
    "huge": ("x,y\n" + "1,2\n3,4\n" * 50_000, "there are 100000 points; expected at most 10000"),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_file_meets_one_line(name, mission_of, tmp_path):
    """A wrong file gives one line.

    It names the file and what is wrong there.
    """
    text, message = WRONG[name]
    with pytest.raises(DubinsStudyError) as refusal:
        mission_of(text)

    assert str(refusal.value).startswith(f"{tmp_path / 'mission.dat'}: ")
    assert message in str(refusal.value)
    assert str(refusal.value).isprintable()
    assert len(str(refusal.value)) < 400


def test_a_file_that_is_not_there(tmp_path):
    for file, reason in (
        (tmp_path / "no", "cannot be read: No such file"),
        (tmp_path, "cannot be read: Is a directory"),
        (3, "^3: "),
    ):
        with pytest.raises(DubinsStudyError, match=reason):
            read_mission(file)


def test_columns_are_named_by_place(mission_of):
    """Columns may have a header or none.

    A header is passed over where columns are named by place.
    """
    rows = "A,11.5,9,48.1\nB,11.51,9,48.1\n"
    for text in (rows, f"p,q,r,s\n{rows}"):
        mission = mission_of(text, columns=("name", "lon", "-", "lat"))

        assert [point.name for point in mission.points] == ["A", "B"]
        assert [point.x for point in mission.points] == pytest.approx([-372.2, 372.2], abs=1)
        assert not any("passed over" in note for note in mission.notes)
    for columns, message in (
        (("lon", "lat"), r"line 1 has 4 cells; expected 2"),
        (("x", "-", "-", "-"), r"--columns is 'x,-,-,-'; expected the column names x and y"),
    ):
        with pytest.raises(DubinsStudyError, match=message):
            mission_of(rows, columns=columns)
    with pytest.raises(DubinsStudyError, match="--columns is given; the file has none"):
        mission_of(plan(item(1, 2)), columns=("x", "y"))


@pytest.mark.parametrize(
    ("text", "compass", "heading"),
    [
        ("90deg", False, math.pi / 2),
        ("pi/3", False, math.pi / 3),
        ("1,5", False, 1.5),
        ("free", False, None),
        ("", True, None),
        ("0", True, math.pi / 2),
        ("90", True, 0.0),
        ("270", True, -math.pi),
        ("0,5rad", True, math.pi / 2 - 0.5),
        ("100deg", True, math.radians(-10)),
    ],
)
def test_headings(text, compass, heading, mission_of):
    """Headings are counterclockwise from east, or clockwise from north.

    A note says which.
    """
    mission = mission_of(f"x;y;heading\n0;0;\n5;5;{text}\n", compass=compass)

    assert mission.points[0].heading is None
    assert mission.points[1].heading == (None if heading is None else pytest.approx(heading))
    assert ("clockwise from north" in mission.notes[-1]) == (compass and heading is not None)


@pytest.mark.parametrize("place", [(11.4, 48.3), (11.9, 47.9), (-170.0, -60.0), (179.9, 70.0)])
@pytest.mark.parametrize("course", [0.0, 77.0, 255.0])
def test_a_compass_heading_is_true(place, course, mission_of):
    """A compass heading is true.

    A step along the geodesic with that azimuth goes along the heading on the plane.
    """
    lon, lat = place
    other = (lon - 0.5, lat + 0.2)
    rows = f"lon,lat,heading\n{other[0]},{other[1]},\n{lon},{lat},{course}\n"
    mission = mission_of(rows, compass=True)
    step = Geodesic.WGS84.Direct(lat, lon, course, 1.0)

    x, y = mission.plane.to_plane([(step["lon2"], step["lat2"])])[0]
    point = mission.points[1]
    angle = math.atan2(y - point.y, x - point.x)
    # across, lengths on the plane are longer, which turns a slanted step a little
    distortion = mission.plane.distortion([point[:2]])
    assert math.remainder(point.heading - angle, math.tau) == pytest.approx(
        0, abs=distortion + 1e-6
    )


def test_home_and_what_is_carried_along(mission_of):
    """Home and other values are those of the file.

    They are the home position, altitudes, names and speeds.
    """
    mission = mission_of(plan(*(item(*place) for place in LONLAT), home=[48.2, 11.5, 400]))

    assert mission.home.altitude == 400
    assert "the home position is where the flight starts, but for --from" in mission.notes
    assert {point.altitude for point in mission.points} == {50}
    assert [point.where for point in mission.points] == ["item 1", "item 2", "item 3"]
    assert mission.source == "QGroundControl plan"
    short = json.dumps({"mission": {"items": [item(*LONLAT[0])], "plannedHomePosition": [48, 11]}})
    assert mission_of(short).home is not None
    assert mission_of(short.replace("plannedHome", "")).home is None
    scenario = mission.scenario(radius=10)
    assert (scenario.x, scenario.y) == mission.home[:2]
    assert scenario.heading is None
    assert scenario.legs == 3
    by_lines = mission_of(wpl(row(0, 11.5, 48.2, frame=0), *ROWS))
    np.testing.assert_allclose(by_lines.home[:2], mission.home[:2])
    table = mission_of("x,y,name,alt,speed\n0,0,Höhe,,7.5\n1,1,,-3,\n")
    assert [point[3:6] for point in table.points] == [("Höhe", None, 7.5), ("", -3.0, None)]


def test_repeats_are_dropped_and_counted(mission_of):
    text = "x,y,name\n0,0,a\n0,0,b\n1,1,c\n1,1.0000000001,d\n2,0,e\n0,0,f\n"
    with pytest.raises(DubinsStudyError, match=r"line 3 equals .* line 7 equals .*--drop-repeats"):
        mission_of(text)
    mission = mission_of(text, drop_repeats=True)

    assert [point.name for point in mission.points] == ["a", "c", "e"]
    assert mission.notes[1] == (
        "dropped: line 3 equals the point before it; such points: 2; "
        "line 7 equals the first point; --closed flies back to it"
    )
    with pytest.raises(DubinsStudyError, match="the mission has one point"):
        mission_of("x,y\n1,1\n1,1\n", drop_repeats=True).scenario()


def test_a_field_too_large_for_a_plane_is_warned_of(mission_of, caplog):
    """A field too large for planes gives a warning.

    The limit is 1e-4, 156 km from the middle; points of which some are swapped are warned of, too.
    """
    assert mission_of("lon,lat\n11,48\n14,48\n").warnings == ()
    large = mission_of("lon,lat\n11,48\n16,48\n")
    swapped = mission_of("lon,lat\n11.5,48.1\n48.1,11.5\n")

    assert "lengths on the plane are up to 0.0001 too long, relatively" in large.warnings[0]
    assert "are longitude and latitude right?" in swapped.warnings[0]
    assert swapped.warnings[0] in caplog.text


def test_a_plane_of_ones_own(mission_of):
    """A plane of one's own is taken.

    It replaces the middle of degrees; of metres it says where they are.
    """
    plane = TangentPlane(48.1, 11.5)
    mission = mission_of("lon,lat\n11.5,48.1\n11.6,48.1\n", plane=plane)

    assert mission.points[0][:2] == pytest.approx((0, 0), abs=1e-9)
    assert mission.plane == mission_of("x,y\n1,2\n3,4\n", plane=plane).plane == plane


@pytest.mark.parametrize("text", ["lon,lat\n11.5,48.1\n", "x;y\n1;2\n"])
def test_points_of_a_route(text, tmp_path, caplog):
    """Points of a route.

    A file of via points is on a plane, and fields that a route has not are named.
    """
    file = tmp_path / "points.csv"
    file.write_text(text)
    if "lat" in text:
        with pytest.raises(DubinsStudyError, match="in degrees; give the file as the argument"):
            read_points(file)
        return
    assert [point[:2] for point in read_points(file)] == [(1, 2)]
    file.write_text("x,y,alt,speed\n1,2,3,4\n")
    read_points(file)
    assert "columns that are passed over: alt, speed" in caplog.text


@pytest.mark.parametrize("name", FILES)
@given(data=st.data())
def test_a_damaged_file_is_read_or_refused(name, data, tmp_path_factory):
    """A damaged file is read or refused.

    It is cut anywhere, or has a piece put elsewhere: the result is a mission of finite numbers, or
    one line.
    """
    text = FILES[name][0]
    text = text if isinstance(text, bytes) else text.encode()
    begin, end, at = sorted(data.draw(st.tuples(*[st.integers(0, len(text))] * 3)))
    damaged = data.draw(
        st.sampled_from([text[:end], text[:begin] + text[end:], text[:at] + text[begin:]])
    )
    file = tmp_path_factory.getbasetemp() / "damaged"
    file.write_bytes(damaged)
    message = ""
    try:
        mission = read_mission(file, drop_repeats=True)
    except DubinsStudyError as error:
        message = str(error)
    if message:
        assert message.startswith(f"{file}: ")
        assert message.isprintable()
    else:
        assert np.isfinite([point[:2] for point in mission.points]).all()


places = st.lists(
    st.tuples(st.integers(-1790, 1790), st.integers(-890, 890)), min_size=1, max_size=6, unique=True
)
names = st.text(st.characters(codec="utf-8", categories=["L", "N", "P"]), max_size=5)


def _as_gpx(points, names):
    gpx = gpxpy.gpx.GPX()
    for (lon, lat), name in zip(points, names, strict=True):
        gpx.waypoints.append(gpxpy.gpx.GPXWaypoint(lat, lon, 7.5, name=name))
    return gpx.to_xml()


def _as_csv(points, names):
    text = io.StringIO()
    writer = csv.writer(text, delimiter=";")
    writer.writerow(("lat", "name", "lon", "alt"))
    for (lon, lat), name in zip(points, names, strict=True):
        writer.writerow((str(lat).replace(".", ","), name, lon, 7.5))
    return text.getvalue()


def _as_geojson(points, names):
    found = [
        {"type": "Feature", "geometry": shape("Point", [*place, 7.5]), "properties": {"name": name}}
        for place, name in zip(points, names, strict=True)
    ]
    return json.dumps({"type": "FeatureCollection", "features": found})


@pytest.mark.parametrize("written", [_as_gpx, _as_csv, _as_geojson])
@given(places=places, data=st.data())
def test_what_another_writer_writes_is_read_back(written, places, data, tmp_path_factory):
    """Files of another writer are read back.

    Places, names and altitudes come back; the places by way of the plane and back.
    """
    points = [(lon / 10, lat / 10) for lon, lat in places]
    wanted = [data.draw(names) for _ in points]
    file = tmp_path_factory.getbasetemp() / "written"
    file.write_text(written(points, wanted), encoding="utf-8", newline="")
    mission = read_mission(file)

    back = mission.plane.to_earth([point[:2] for point in mission.points])
    np.testing.assert_allclose(back, points, atol=1e-9)
    assert [point.name for point in mission.points] == wanted
    assert {point.altitude for point in mission.points} == {7.5}


def test_a_takeoff_and_a_landing_at_home_are_no_points_to_pass(mission_of):
    """Takeoffs and landings at home are no points.

    Planners write them; elsewhere they are places.
    """
    home = [52.0, 10.0, 0]
    places = [(22, 52.0, 10.0), (16, 52.01, 10.0), (21, 52.0, 10.0), (21, 52.02, 10.0)]
    items = [
        {"type": "SimpleItem", "command": command, "frame": 3, "params": [0, 0, 0, None, x, y, 50]}
        for command, x, y in places
    ]
    plan = {"fileType": "Plan", "mission": {"items": items, "plannedHomePosition": home}}

    mission = mission_of(json.dumps(plan))

    assert len(mission.points) == 2
    assert "1 takeoff at home, 1 land at home" in " ".join(mission.notes)


def test_a_survey_has_its_height_and_a_plan_its_speed(mission_of):
    """A survey has its height, a plan its speed.

    The height is above home, as those of items are in frame 3; in frame 0 it is passed over.
    """
    corners = [[52.0, 10.0], [52.0, 10.01]]
    survey = {"VisualTransectPoints": corners, "CameraCalc": {"DistanceToSurface": 80}}
    items = [
        {"type": "ComplexItem", "complexItemType": "survey", "TransectStyleComplexItem": survey},
        {"command": 16, "frame": 3, "params": [0, 0, 0, None, 52.01, 10.0, 60]},
        {"command": 16, "frame": 0, "params": [0, 0, 0, None, 52.02, 10.0, 700]},
    ]
    plan = {"items": items, "cruiseSpeed": 17}
    mission = mission_of(json.dumps({"mission": plan}))
    known = mission_of(json.dumps({"mission": plan | {"plannedHomePosition": [52, 10.1, 600]}}))

    assert [point.altitude for point in mission.points] == [80, 80, 60, None]
    assert [point.altitude for point in known.points] == [80, 80, 60, 100]
    assert mission.speed == 17
    assert "1 altitude that is not above home" in " ".join(mission.notes)
    with pytest.raises(DubinsStudyError, match="cruiseSpeed is '18 m/s'; expected m/s above 0"):
        mission_of(json.dumps({"mission": plan | {"cruiseSpeed": "18 m/s"}}))


def test_a_closed_list_is_no_repeat_of_a_closed_path(tmp_path):
    """A closed list is no repeat of closed paths.

    Its last point is the start; otherwise the message says what to do.
    """
    file = tmp_path / "loop.csv"
    file.write_text("x,y\n0,0\n100,0\n100,100\n0,0\n")

    assert len(read_mission(file, closed=True).points) == 3
    with pytest.raises(DubinsStudyError, match="line 5 equals the first point; --closed"):
        read_mission(file)


def test_a_name_is_a_name(mission_of):
    """A name is a name.

    It may be a word of ours, or have characters that no file of a map may have.
    """
    collection = {
        "type": "FeatureCollection",
        "features": [
            {
                "type": "Feature",
                "geometry": {"type": "Point", "coordinates": [10 + i, 50]},
                "properties": {"name": name},
            }
            for i, name in enumerate(["free", "a\u0001b", "c\ud800"])
        ],
    }
    names = [point.name for point in mission_of(json.dumps(collection)).points]

    assert names[0] == "free"
    assert all(name.isprintable() for name in names)
    assert [name.encode() for name in names]

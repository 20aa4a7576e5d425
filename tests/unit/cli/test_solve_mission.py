"""`dubins-study solve FILE`, from mission to flight."""

import csv
import itertools
import json
import math
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from geographiclib.geodesic import Geodesic

from dubins_study.errors import DubinsStudyError
from tests.unit.cli.conftest import asked, line_of

MEADOW = str(Path(__file__).parents[3] / "examples" / "flights" / "meadow.plan")
TOUR = ("solve", MEADOW, "--closed", "--order", "free", "--radius", "60")
FORMATS = ("plan", "waypoints", "gpx", "kml", "geojson", "csv")
GPX = "{http://www.topografix.com/GPX/1/1}"
KML = "{http://www.opengis.net/kml/2.2}"


def _plan_places(file):
    mission = json.loads(file.read_text())["mission"]
    home = mission["plannedHomePosition"][1::-1]
    return [home, *(item["params"][5:3:-1] for item in mission["items"])]


def _waypoint_places(file):
    rows = [line.split("\t") for line in file.read_text().splitlines()[1:]]
    return [(float(row[9]), float(row[8])) for row in rows]


def _gpx_places(file):
    points = ElementTree.parse(file).iter(f"{GPX}trkpt")
    return [(float(point.get("lon")), float(point.get("lat"))) for point in points]


def _kml_places(file):
    line = next(ElementTree.parse(file).iter(f"{KML}LineString"))
    texts = line.find(f"{KML}coordinates").text.split()
    return [tuple(map(float, text.split(",")[:2])) for text in texts]


def _geojson_places(file):
    return json.loads(file.read_text())["features"][0]["geometry"]["coordinates"]


def _csv_places(file):
    with file.open(newline="") as rows:
        return [(float(row["lon"]), float(row["lat"])) for row in csv.DictReader(rows)]


PLACES = dict(
    zip(
        FORMATS,
        (_plan_places, _waypoint_places, _gpx_places, _kml_places, _geojson_places, _csv_places),
        strict=True,
    )
)


def _length(places):
    """Metres along longitudes and latitudes, by geodesics."""
    legs = itertools.pairwise(places)
    return sum(Geodesic.WGS84.Inverse(a[1], a[0], b[1], b[0])["s12"] for a, b in legs)


def test_a_plan_becomes_a_proved_closed_tour_in_every_format(tmp_path):
    """A plan becomes a closed tour in every format.

    The tour is proved. The flight is as long on Earth as the answer says, and passes each point of
    the plan.
    """
    files = {ending: tmp_path / f"flight.{ending}" for ending in FORMATS}
    options = [word for file in files.values() for word in ("--out", str(file))]
    answer = json.loads(asked(*TOUR, "--json", "--step", "5", *options).stdout)

    assert (answer["verdict"], answer["proof"]) == ("optimal", "proved")
    items = json.loads(Path(MEADOW).read_text())["mission"]["items"]
    points = [item["params"][5:3:-1] for item in items if item["command"] in (16, 22)]
    assert len(answer["order"]) == len(points)
    for ending, file in files.items():
        places = PLACES[ending](file)
        # chords over arcs of 60 m that are 5 m long are shorter by 0.03 %
        assert _length(places) == pytest.approx(answer["length"], rel=1e-3), ending
        for longitude, latitude in points:
            away = [Geodesic.WGS84.Inverse(latitude, longitude, y, x)["s12"] for x, y, *_ in places]
            assert min(away) < (0.01 if ending != "geojson" else 0.2), ending


def test_the_table_of_stops_tells_when_and_where_to(tmp_path):
    """The table of stops tells times and headings.

    Times are lengths by speed; a heading of 0 rad is 90 degrees of a compass.
    """
    file = tmp_path / "points.csv"
    file.write_text("x,y,name\n0,0,base\n100,0,east\n200,0,far\n")
    answer = json.loads(
        asked("solve", str(file), "--radius", "10", "--speed", "5", "--json").stdout
    )
    text = asked("solve", str(file), "--radius", "10", "--speed", "5").stdout

    stops = answer["stops"]
    assert [stop["name"] for stop in stops] == ["east", "far"]
    assert [stop["time"] for stop in stops] == pytest.approx([20.0, 40.0])
    assert [stop["compass"] for stop in stops] == pytest.approx([90.0, 90.0])
    assert "east" in text
    assert line_of("travel time", text) == "40"


def test_bank_and_speed_give_the_radius(tmp_path):
    """Bank and speed give the radius.

    It is v squared over g tan bank; a smaller radius is warned of.
    """
    radius = 20.0**2 / (9.80665 * math.tan(math.radians(30)))
    words = ("solve", MEADOW, "--speed", "20", "--bank", "30deg")
    answer = json.loads(asked(*words, "--json").stdout)

    turns = [abs(piece["curvature"]) for piece in answer["segments"] if piece["curvature"]]
    assert max(turns) == pytest.approx(1 / radius)
    assert f"the radius is {radius:.6g}: a bank of 30deg at 20 m/s" in asked(*words).stderr
    tight = asked(*words, "--radius", "40")
    assert "below" in tight.stderr
    of_the_plan = json.loads(asked("solve", MEADOW, "--bank", "30deg", "--json").stdout)
    assert of_the_plan["length"] / of_the_plan["travel_time"] == pytest.approx(15.0)
    file = tmp_path / "points.csv"
    file.write_text("lon,lat\n10,52\n10.01,52\n")
    with pytest.raises(DubinsStudyError, match="--bank is given without --speed"):
        asked("solve", str(file), "--bank", "30deg")


REFUSED = {
    ("solve", MEADOW, "--radius", "9", "--out", MEADOW): "is read, or is written twice",
    ("solve", MEADOW, "--radius", "9", "--out", "a.gpx", "--step", "0"): "--step is 0.0",
    ("solve", MEADOW, "--radius", "9", "--altitude", "nan"): "--altitude is nan",
    ("solve", MEADOW, "--radius", "9", "--from", "10", "100", "free"): "latitude is 100",
    ("solve", "3", "4", "--drop-repeats"): "--drop-repeats is given without a mission file",
    ("solve", "3", "4", "--columns", "x,y"): "--columns is given without a mission file",
    ("solve", MEADOW): "the radius is missing: the points lie on Earth",
    ("solve", MEADOW, "5", "--radius", "9"): "expected the file alone",
    (*TOUR, "--out", "flight.doc"): "flight.doc",
    (*TOUR, "--out", "no/such/flight.plan"): "cannot write",
}


@pytest.mark.parametrize("words", REFUSED)
def test_a_bad_request_is_one_message(words):
    with pytest.raises(Exception, match=REFUSED[words]) as refusal:
        asked(*words)
    assert "\n" not in str(refusal.value)


def test_a_file_that_is_not_there_is_named():
    """A missing file is named.

    The word is neither a number nor a file.
    """
    done = asked("solve", "no-such-file.plan", "--radius", "9", raises=False)

    assert done.exit_code != 0
    assert "no-such-file.plan" in str(done.exception) + done.output


def test_a_compass_heading_runs_clockwise_from_north(tmp_path):
    file = tmp_path / "points.csv"
    file.write_text("x,y\n300,0\n")
    east = asked("solve", str(file), "--from", "0", "0", "90", "--compass", "--json").stdout

    assert json.loads(east)["length"] == pytest.approx(300.0)


def test_a_start_on_earth_is_longitude_and_latitude(tmp_path):
    """A start on Earth is longitude and latitude.

    The path is the geodesic to the only point, where the vehicle heads for it.
    """
    file = tmp_path / "points.csv"
    file.write_text("lon,lat\n10.3,52.0\n")
    answer = json.loads(
        asked(
            "solve", str(file), "--from", "10.3", "51.99", "free", "--radius", "5", "--json"
        ).stdout
    )

    assert answer["length"] == pytest.approx(
        Geodesic.WGS84.Inverse(51.99, 10.3, 52.0, 10.3)["s12"], rel=1e-9
    )
    assert np.isclose(answer["start_heading"], math.pi / 2)

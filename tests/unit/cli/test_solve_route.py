"""`dubins-study solve` of routes.

Tested are the text, points from a file, the drawing, and GeoJSON.
"""

import json
import math
import re
from dataclasses import replace
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from dubins_study import Path, Scenario, plot_path, solve
from dubins_study.errors import DubinsStudyError
from dubins_study.missions.flight import flight_of
from dubins_study.missions.mission import Mission, MissionPoint
from dubins_study.missions.write import write_flight
from tests.unit.cli.conftest import asked, line_of

START = ("solve", "--from", "0", "0", "30deg", "--final-heading", "90deg")
ROUTE = (*START, "10", "5", "--via", "4", "1", "--via", "6", "-2")


@pytest.fixture
def points(tmp_path):
    """A file whose last point is the target.

    It has a column and a line that are passed over.
    """
    file = tmp_path / "points.csv"
    file.write_text("more,y, x\nfirst,1,4\n\nsecond,-2,6\nlast,5,10\n")
    return file


def test_the_text_of_a_route():
    """The text of a route.

    It has the words of legs, the length and, to the last digit, the interval that is proven.
    """
    text = asked(*ROUTE).stdout
    answer = json.loads(asked(*ROUTE, "--json").stdout)

    assert line_of("word", text) == "RSR RSL LSL"
    assert line_of("length", text) == f"{answer['length']:.12g}" == "16.3229767512"
    low, high = answer["reference_low"], answer["reference_high"]
    width = (high - low) / high
    assert line_of("optimum", text) == f"in [{low!r}, {high!r}], relative width {width:.2g}"
    assert 0 <= width <= 1e-9
    assert (line_of("verdict", text), line_of("proof", text)) == ("optimal", "proved")
    assert "optimum" not in asked("solve", "10", "5").stdout


def test_points_of_a_file(points, tmp_path):
    """Points of a file are the route's.

    The last point is the target; where a target is given, all points are on the way.
    """
    options = [
        json.loads(asked(*q, "--json").stdout) for q in (ROUTE, (*START, "--via-file", str(points)))
    ]
    same = ("word", "length", "via", "final_heading")
    assert [options[0][name] for name in same] == [options[1][name] for name in same]

    points.write_text("X, Y\n4,1\n6,-2\n")
    with_target = json.loads(asked(*START, "10", "5", "--via-file", str(points), "--json").stdout)
    assert with_target["length"] == options[0]["length"]


REFUSED = {
    "x|y\n": "line 1 is 'x|y'; expected the column names x and y, once each",
    "": "line 1 is ''; expected the column names x and y",
    "x,y,x\n1,2,3\n": "line 1 is 'x,y,x'; expected the column names x and y",
    "lon,lat\n8,47\n": "its points are in degrees; give the file as the argument: solve ",
    "x,y\n": "no points; expected a line each",
    "x,y\n1,2\n3,four\n": "line 3: x,y is '3,four'; expected two numbers",
    "x,y\n1\n": "line 2: x,y is '1,'; expected two numbers",
    "x,y\n4,5,2\n": "line 2: 3 cells; expected 2, as in line 1",
    'x,y,name\n3,4,"a\n6,-2,b\n7,7,"\n': "line 2: a text goes on to line 4; expected each row",
    'x,y,name\n3,4,"a\n6,-2,b\n': "line 2: unexpected end of data; expected each row on a line",
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_file_of_points_that_cannot_be_read(text, points):
    points.write_text(text)
    with pytest.raises(DubinsStudyError) as refusal:
        asked("solve", "--via-file", str(points))
    assert str(refusal.value).startswith(f"{points}: {REFUSED[text]}")


@pytest.mark.parametrize("option", ["--plot", "--geojson"])
@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ("no/a.svg", "No such file"),
        (".", "Is a directory"),
        ("a" * 300 + ".svg", "File name too long"),
        ("/proc/a.svg", ""),  # the folder's mode lets root write
    ],
)
def test_a_file_that_cannot_be_written_is_refused_before_the_solve(option, file, reason):
    """An unwritable file is refused before the solve.

    The refusal is about the file: the solver, which does not exist, is not looked for.
    """
    with pytest.raises(
        DubinsStudyError, match=re.escape(f"{option}: cannot write {file}: {reason}")
    ):
        asked("solve", "3", "4", option, file, "--solver", "nonesuch")


def test_a_route_as_geojson(points, tmp_path):
    """A route as GeoJSON.

    It has a line past every point, with what is proven of it, and the points with the names of the
    file.
    """
    file = tmp_path / "route.json"
    points.write_text(points.read_text().replace("more", "name"))
    asking = (*START, "--via-file", str(points), "--json", "--geojson", str(file))
    answer = json.loads(asked(*asking).stdout)
    path, *marks = json.loads(file.read_text())["features"]
    line = np.array(path["geometry"]["coordinates"])
    properties = path["properties"]

    for point in [(0, 0), (4, 1), (6, -2), (10, 5)]:
        assert np.hypot(*(line - point).T).min() < 0.1  # arcs have a point every 5 degrees
    np.testing.assert_allclose(line[-1], (10, 5), atol=1e-9)
    same = ("word", "length", "verdict", "proof", "reference_low", "reference_high", "miss")
    assert {name: properties[name] for name in same} == {name: answer[name] for name in same}
    assert (properties["kind"], properties["radius"]) == ("path", 1.0)
    assert properties["start_heading_rad"] == math.radians(30)
    places = [(mark["geometry"]["type"], *mark["geometry"]["coordinates"]) for mark in marks]
    assert places == [("Point", 4, 1), ("Point", 6, -2), ("Point", 10, 5)]
    shown = [[mark["properties"][key] for key in ("kind", "index", "name")] for mark in marks]
    assert shown == [["via", 1, "first"], ["via", 2, "second"], ["target", 3, "last"]]
    for mark in marks:  # the heading is that of the chord that ends at the point, or nearly
        chord = np.hypot(*(line - mark["geometry"]["coordinates"]).T)[1:].argmin() + 1
        dx, dy = line[chord] - line[chord - 1]
        turned = mark["properties"]["heading_rad"] - math.atan2(dy, dx)
        assert abs(math.remainder(turned, 2 * math.pi)) < 0.1


def test_points_without_names_as_geojson(tmp_path):
    """Points without names as GeoJSON.

    Names are null; so are headings at points that a path is not known to pass in order.
    """
    file = tmp_path / "route.json"
    asked(*ROUTE, "--geojson", str(file))
    marks = json.loads(file.read_text())["features"][1:]
    answer = solve(Scenario(target_x=3, target_y=0, via=[(2, 0)]))
    mission = Mission((MissionPoint(2, 0), MissionPoint(3, 0)), home=MissionPoint(0, 0))
    missed = flight_of(replace(answer, visits=None, gap=None), mission)
    write_flight(missed, file)
    unseen = json.loads(file.read_text())["features"][1:]

    assert [mark["properties"]["name"] for mark in marks] == [None] * 3
    assert [mark["properties"]["heading_rad"] for mark in unseen] == [None] * 2


def test_a_drawn_route():
    """A drawn route.

    Each kind of piece is once in the legend. There are the points by their numbers, two arrows,
    and circles.
    """
    scenario = Scenario(
        heading="30deg", target_x=10, target_y=5, via=[(4, 1), (6, -2)], final_heading="90deg"
    )
    answer = solve(scenario)
    ax = plot_path(answer).axes[0]
    legend = ax.get_legend()

    assert [text.get_text() for text in legend.get_texts()] == ["left", "straight", "right"]
    assert legend.get_title().get_text() == "analytic: length 16.3230, proved"
    looks = {
        (line.get_color(), line.get_linestyle(), line.get_linewidth())
        for line in legend.get_lines()
    }
    assert len(looks) == 3
    assert [text.get_text() for text in ax.texts if text.get_text()] == ["start", "1", "2"]
    assert sum(text.arrow_patch is not None for text in ax.texts) == 2
    assert {round(patch.radius, 12) for patch in ax.patches} == {1.0}
    # the lines are the path: they pass its poses
    drawn = np.vstack([line.get_xydata() for line in ax.lines if len(line.get_xydata()) > 1])
    for x, y, _ in answer.path.poses:
        assert np.nanmin(np.hypot(*(drawn - (x, y)).T)) < 1e-9  # a NaN parts two pieces


def test_a_drawn_route_with_a_free_final_heading():
    """A drawn route with a free final heading.

    It has one arrow. A path of another solver, in many pieces of different curvature, is drawn
    too.
    """
    scenario = Scenario(target_x=3, target_y=0, via=[(2, 0)])
    steps = 0.3 * np.sin(np.arange(40))
    answer = SimpleNamespace(
        scenario=scenario, solver="some", path=Path(scenario.start, steps, np.full(40, 0.1))
    )
    ax = plot_path(answer).axes[0]

    assert sum(text.arrow_patch is not None for text in ax.texts) == 1
    assert not ax.patches
    straight = SimpleNamespace(
        scenario=scenario, solver="some", path=Path(scenario.start, [0.0], [math.pi])
    )
    assert plot_path(straight).axes[0].get_legend() is not None
    pose = solve(Scenario(target_x=3, target_y=0, final_heading=1.0))
    assert len(plot_path(pose).axes[0].texts) == 3  # its arrows and its start


def route_through(points):
    """An answer of straight legs through points.

    It has only what the drawing needs.
    """
    turns = []
    lengths = []
    chords = np.diff(points, axis=0)
    headings = np.arctan2(chords[:, 1], chords[:, 0])
    for turn, chord in zip(np.diff(headings, prepend=headings[0]), chords, strict=True):
        turns += [math.copysign(1e9, turn), 0.0]  # on the spot
        lengths += [abs(turn) / 1e9, math.hypot(*chord)]
    scenario = Scenario(*points[0], headings[0], *points[-1], radius=1, via=points[1:-1])
    path = Path(scenario.start, turns, lengths)
    return SimpleNamespace(scenario=scenario, solver="some", path=path)


around = np.linspace(0, 2 * np.pi, 201)
DENSE = {
    "walk of 30": np.random.default_rng(1).uniform(-5, 5, (31, 2)).cumsum(axis=0),
    "circle of 200": 5 * np.column_stack((np.cos(around), np.sin(around))),
    "700 anywhere": np.random.default_rng(1).uniform(0, 60, (701, 2)),
    "700 in line": np.column_stack((np.arange(701), np.zeros(701))),
}


@pytest.mark.parametrize("points", DENSE.values(), ids=DENSE)
@pytest.mark.parametrize("inches", [None, 2])
def test_numbers_of_points_do_not_overlap(points, inches):
    """Numbers of points do not overlap.

    Nor do many points get many numbers, or large dots; few points have one each.
    """
    ax = inches and Figure((inches, inches)).add_subplot()
    figure = plot_path(route_through(points), ax=ax)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    texts = [text for text in figure.axes[0].texts if text.get_text()]
    boxes = [text.get_window_extent(canvas.get_renderer()) for text in texts]

    assert 2 <= len(texts) <= 60
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
    dots = next(line for line in figure.axes[0].lines if len(line.get_xydata()) == len(points) - 2)
    step = np.hypot(*np.diff(figure.axes[0].transData.transform(points), axis=0).T)
    assert dots.get_markersize() * figure.dpi / 72 < max(np.median(step), 1)


def test_a_long_word_is_broken_where_the_terminal_ends(monkeypatch):
    """A long word is broken at the terminal's end.

    It is broken on a terminal alone; its continuation begins below the value.
    """
    many = [word for i in range(1, 13) for word in ("--via", str(5 * i), "1")]
    unbroken = asked("solve", "70", "0", *many).stdout
    monkeypatch.setenv("COLUMNS", "60")
    broken = asked("solve", "70", "0", *many).stdout

    assert len(line_of("word", unbroken).split()) == 13
    assert max(map(len, broken.splitlines())) <= 60
    assert broken.replace("\n" + " " * 12, " ").splitlines()[0] == unbroken.splitlines()[0]


def test_a_word_of_many_legs_is_shortened_in_the_text():
    """A word of many legs is shortened.

    The text has the first legs and how many there are; the JSON object has all.
    """
    many = [word for i in range(1, 40) for word in ("--via", str(5 * i), "1")]
    asking = ("solve", "200", "0", *many)
    shown = line_of("word", asked(*asking).stdout)
    word = json.loads(asked(*asking, "--json").stdout)["word"]

    assert len(word.split()) == 40
    begun, count = shown.split(" ... ")
    assert count == "(40 legs)"
    assert word.startswith(f"{begun} ")
    assert 50 < len(begun) <= 60


def test_the_check_s_shorter_path_can_be_taken(tmp_path):
    """The check's shorter path can be taken.

    Where an answer is found longer, the text has the shorter length, and files have its path.
    """
    solver = "heading-milp[headings=5]"
    question = ("solve", "--from", "0", "0", "0", "-2", "-1", "--via", "3", "0", "--solver", solver)
    files = [tmp_path / name for name in ("answer.json", "shortest.json")]

    text = asked(*question, "--geojson", str(files[0])).stdout
    asked(*question, "--geojson", str(files[1]), "--shortest")

    answer, shortest = (json.loads(file.read_text())["features"][0]["properties"] for file in files)
    assert (answer["verdict"], shortest["verdict"]) == ("longer", "optimal")
    assert answer["length"] > shortest["length"]
    assert line_of("shorter", text).startswith(f"{shortest['length']:.12g}, found by the check")


def test_columns_that_are_passed_over_are_named(tmp_path, caplog):
    """Columns that are passed over are named.

    A heading whose column says more, such as a unit, is refused: it would be read wrongly.
    """
    file = tmp_path / "points.csv"
    file.write_text("x,y,alt,heading,z\n4,1,120,,0\n6,-2,120,,0\n")

    asked("solve", "--via-file", str(file), "--radius", "0.5")

    assert "columns that are passed over: alt, z" in caplog.text
    file.write_text("x,y,heading\n4,1,90\n6,-2,\n")
    with pytest.raises(DubinsStudyError, match="line 2: heading: 90 is more than a full turn; wri"):
        asked("solve", "--via-file", str(file))
    file.write_text("x,y,heading_deg\n4,1,90\n6,-2,\n")
    with pytest.raises(DubinsStudyError, match="column 'heading_deg': expected one column heading"):
        asked("solve", "--via-file", str(file))


@pytest.mark.parametrize(
    ("points", "radius", "odd"),
    [
        ("8.541,47.372\n8.545,47.374\n8.551,47.371\n", 40, True),  # degrees
        ("0.2,0.1\n0.5,0.3\n1.9,1.1\n", 60, True),  # kilometres, the radius in metres
        ("200.2,100.1\n200.3,100.1\n", 60, True),  # hardly a path
        ("10,5\n-80,20\n", 25, False),
        ("0.1,0\n0.2,0.1\n0.3,0.3\n", 1, False),
        ("412,96\n430,99\n441,110\n", 40, False),
    ],
)
def test_units_that_do_not_fit_are_said(points, radius, odd, tmp_path, caplog):
    file = tmp_path / "points.csv"
    file.write_text(f"x,y\n{points}")

    asked("solve", "--via-file", str(file), "--radius", str(radius), "--time-limit", "1")

    assert ("x, y and radius are taken to be in one unit" in caplog.text) == odd


@pytest.mark.parametrize("text", ["1_000", "1_0.5"])
def test_a_number_has_no_underscores(text, tmp_path):
    """Python's `float` takes some of these."""
    file = tmp_path / "points.csv"
    file.write_text(f"x,y\n{text},2\n")

    with pytest.raises(DubinsStudyError, match=f"line 2: x,y is '{text},2'; expected two"):
        asked("solve", "--via-file", str(file))
    for words in ((text, "2"), ("1", "2", "--radius", text), ("1", "2", "--via", text, "3")):
        refused = asked("solve", *words)
        assert refused.exit_code == 2
        assert repr(text) in refused.stderr

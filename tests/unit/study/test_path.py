"""Paths against an ODE integrator, geometry and symmetry."""

import json
import math
from xml.etree.ElementTree import fromstring

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.study.path import Path, outline
from dubins_study.study.scenario import Pose, Scenario
from tests.brute_force import integrated

MIRRORED = str.maketrans("LR", "RL")
arcs = st.lists(st.tuples(st.floats(-3, 3), st.floats(0, 5)), max_size=8)


def path_of(pieces: list[tuple[float, float]]) -> Path:
    return Path(Pose(1.0, -2.0, 0.7), [k for k, _ in pieces], [length for _, length in pieces])


@given(arcs, st.integers(2, 50))
def test_end_pose_is_what_an_ode_integrator_finds(pieces, n):
    """The end pose is that of an ODE integrator.

    The exact arcs agree with DOP853 at 1e-12, whose error over 40 lengths stays below 1e-9.

    Samples begin and end where the path does and are nowhere further apart than along it.
    """
    path = path_of(pieces)
    poses = path.sample(n)

    np.testing.assert_allclose(path.end, integrated(path), atol=1e-9)
    np.testing.assert_allclose(poses[[0, -1]], [path.start, path.end], atol=1e-9)
    steps = np.hypot(*np.diff(poses[:, :2], axis=0).T)
    assert (steps <= path.length / (n - 1) + 1e-9).all()


@given(arcs, st.integers(2, 40))
def test_a_path_cut_into_many_arcs_is_the_same(pieces, parts):
    """A path cut into many arcs is unchanged.

    Its poses at the old cuts are those of the few arcs, and all are what an integrator finds.
    """
    few = path_of(pieces)
    many = path_of([(k, length / parts) for k, length in pieces for _ in range(parts)])

    np.testing.assert_allclose(many.poses[::parts], few.poses, atol=1e-11)
    np.testing.assert_allclose(many.end, many.poses[-1], rtol=1e-15, atol=0)
    np.testing.assert_allclose(many.end, integrated(few), atol=1e-9)


@pytest.mark.parametrize("count", [3, 60])
def test_after_a_heading_that_is_not_finite_nothing_is(count):
    """After an infinite heading nothing is finite.

    The heading may be NaN, too. The path has few arcs, which a loop drives, or many.
    """
    curvatures = np.full(count, 0.5)
    curvatures[1] = math.inf

    poses = Path(Pose(0, 0, 0), curvatures, np.ones(count)).poses

    assert np.isfinite(poses[:2]).all()
    assert not np.isfinite(poses[2:]).any()


def test_an_almost_straight_arc_keeps_its_digits():
    """An almost straight arc keeps its digits.

    Curvature 1e-12 is a straight line to rounding; 1/k would lose four digits here.
    """
    path = Path(Pose(0, 0, 0), [1e-12], [10.0])

    np.testing.assert_allclose(path.end, (10.0, 5e-11, 1e-11), rtol=1e-12)


@given(arcs, st.floats(0.05, 3))
def test_a_frame_of_samples(pieces, step):
    """A frame of samples.

    Every pose is where `at` has it, a step from the last; the curvature is that of its arc.
    """
    path = path_of(pieces)
    frame = path.sample(step=step)

    assert list(frame) == ["s", "x", "y", "heading", "curvature"]
    np.testing.assert_array_equal(frame[["x", "y", "heading"]], path.at(frame["s"]))
    assert (frame["s"].iloc[0], frame["s"].iloc[-1]) == (0.0, path.length)
    steps = np.diff(frame["s"])
    np.testing.assert_allclose(steps[:-1], step, rtol=1e-9)
    assert (steps[-1:] <= step * (1 + 1e-9)).all()
    # the heading a little later, by the curvature: the samples are not at the ends of arcs
    ends = np.concatenate(([0.0], np.cumsum(path.lengths)))
    inside = [np.abs(ends - s).min() > 1e-3 for s in frame["s"]]
    turned = path.at(frame["s"] + 1e-4)[:, 2] - frame["heading"]
    np.testing.assert_allclose(
        turned[inside], 1e-4 * frame["curvature"][inside], rtol=1e-6, atol=1e-12
    )


def test_a_step_that_divides_the_path_adds_no_pose():
    """A step that divides the path adds no pose.

    Three tenths make a path of 0.3: rounding makes no fourth step.
    """
    assert len(Path(Pose(0, 0, 0), [0.0], [0.1 + 0.2]).sample(step=0.1)) == 4
    assert len(Path(Pose(0, 0, 0), [0.0], [0.3]).sample(step=1e300)) == 2
    assert len(Path(Pose(0, 0, 0), [], []).sample(step=0.1)) == 1


@given(arcs, st.floats(1e-3, 1))
def test_chords_of_geojson_are_near_their_arcs(pieces, share):
    """Chords of GeoJSON are near their arcs.

    No pose of the path is further from the line than the chord error; ends and length agree.
    """
    path = path_of(pieces)
    feature = json.loads(json.dumps(path.to_geojson(share, verdict="optimal"), allow_nan=False))
    line = np.array(feature["geometry"]["coordinates"]).reshape(-1, 2)
    properties = feature["properties"]

    kind = "LineString" if path.lengths.any() else "Point"
    assert (feature["type"], feature["geometry"]["type"]) == ("Feature", kind)
    assert (properties["length"], properties["verdict"]) == (path.length, "optimal")
    np.testing.assert_allclose(line[0], path.start[:2])
    np.testing.assert_allclose(line[-1], path.end[:2], atol=1e-12)
    allowed = properties["chord_error"] + 1e-9
    for point in path.sample(300)[:, :2]:
        assert _distance(point, line if len(line) > 1 else [*line, *line]) <= allowed


def _distance(point, line):
    """Distance from a point to a chain of segments."""
    line = np.asarray(line)
    begin = line[:-1]
    along = np.diff(line, axis=0)
    share = np.sum((point - begin) * along, axis=1) / np.maximum(np.sum(along**2, axis=1), 1e-300)
    return np.hypot(*(begin + np.clip(share, 0, 1)[:, None] * along - point).T).min()


def test_a_circle_has_as_few_chords_as_its_error_allows():
    """A circle has few chords for its error.

    Chords over the angle a are R (1 - cos(a / 2)) from their arc: 71 of a circle at R / 1000.
    """
    circle = Path(Pose(0, 0, 0), [0.5], [4 * math.pi])

    coordinates = circle.to_geojson()["geometry"]["coordinates"]
    assert len(coordinates) - 1 == math.ceil(2 * math.pi / (2 * math.acos(1 - 1e-3)))
    assert circle.to_geojson()["properties"]["radius"] == 2.0
    for path in (Path(Pose(1, 2, 0), [], []), Path(Pose(1, 2, 0), [9], [0])):  # of no length
        assert path.to_geojson()["geometry"] == {"type": "Point", "coordinates": [1, 2]}


ARC = Path(Pose(0, 0, 0), [1], [1])
STEPS = (0, -1, math.nan, math.inf, 1e-9, None, "1", True)
SHARES = (0, -1, 1.5, math.nan)


@pytest.mark.parametrize(
    ("path", "asked", "message"),
    [
        *((ARC, {"step": step}, r"step is .*; expected") for step in STEPS),
        (ARC, {"n": 10**9}, "at most 10000000 poses"),
        *((ARC, share, r"chord_error is .*; expected a share up to 1") for share in SHARES),
        (Path(Pose(0, 0, 0), [math.nan], [1]), 1e-3, "not finite"),
        (Path(Pose(0, 0, 0), [1], [1e12]), 1e-3, r"the path has .* points; expected at most"),
    ],
)
def test_what_is_neither_sampled_nor_handed_on(path, asked, message):
    with pytest.raises(ValueError, match=message):
        path.sample(**asked) if isinstance(asked, dict) else path.to_geojson(asked)


def test_what_is_no_path_and_what_a_path_does_not_allow():
    with pytest.raises(ValueError, match=r"shape \(2,\) and lengths \(1,\)"):
        Path(Pose(0, 0, 0), [1, 2], [1])
    with pytest.raises(ValueError, match="read-only"):
        ARC.lengths[0] = 2


@pytest.mark.parametrize(
    ("pieces", "word"),
    [
        ([], ""),
        ([(1, 0), (-1, 0)], ""),
        ([(1, 1), (0, 2)], "LS"),
        ([(-1, 1), (1, 4)], "RL"),
        ([(0, 5)], "S"),
        ([(1, 1), (1, 1), (0.3, 1), (0, 2), (1e-9, 1), (-1e-9, 1)], "LS"),
        ([(1, 1e-9), (-1, 2)], "R"),
        ([(1, 1), (-1, 2), (0, 3)], "LRS"),
        ([(math.nan, 1)], ""),
    ],
)
def test_words(pieces, word):
    """Words of a path and its images.

    The mirror image has L and R exchanged; scale and cuts change nothing.
    """
    assert path_of(pieces).word() == word
    assert path_of([(-k, s) for k, s in pieces]).word() == word.translate(MIRRORED)
    assert path_of([(k / 9, s * 9) for k, s in pieces]).word() == word
    assert path_of([(k, s / 3) for k, s in pieces for _ in range(3)]).word() == word


def test_an_origin_turns_metres_into_degrees():
    """An origin turns metres into degrees.

    The length of the meridian from 45 to 46 degrees comes from the usual series of WGS 84 at its
    middle (111 132.954 - 559.822 cos 2 phi + 1.175 cos 4 phi); `Scenario.from_lonlat` undoes it.
    """
    path = Path(Pose(0, 0, math.pi / 2), [0.0], [111_141.55])
    (lon, lat), (end_lon, end_lat) = path.to_geojson(origin=(45, 8))["geometry"]["coordinates"]

    assert (lon, lat) == pytest.approx((8, 45), abs=1e-12)
    assert end_lon == pytest.approx(8, abs=1e-12)
    assert end_lat == pytest.approx(46, abs=1e-6)
    slanted = Path(Pose(-3000, 200, 1), [0.0], [9000])
    ends = slanted.to_geojson(origin=(45, 8))["geometry"]["coordinates"]
    scenario = Scenario.from_lonlat(ends[0], ends[1], origin=(45, 8))
    assert (scenario.x, scenario.y) == pytest.approx((-3000, 200), abs=1e-6)
    assert scenario.target == pytest.approx(tuple(slanted.end[:2]), abs=1e-6)
    for origin in ((91, 0), (90, 0), (0, 181), (math.nan, 0), 5, (45,), ("45", 8), (10**400, 8)):
        with pytest.raises(ValueError, match="expected latitude between"):
            path.to_geojson(origin=origin)


def test_csv_is_the_sample(tmp_path):
    path = Path(Pose(1, 2, 0.3), [1.0, 0.0], [1.0, 2.0])
    path.to_csv(tmp_path / "path.csv", step=0.25)

    written = pd.read_csv(tmp_path / "path.csv", float_precision="round_trip")
    pd.testing.assert_frame_equal(written, path.sample(step=0.25), check_exact=True)
    assert path.to_csv(step=0.25) == (tmp_path / "path.csv").read_text()


def test_a_notebook_shows_a_drawing():
    """A notebook shows a drawing.

    It is a half circle, as wide as its radius, begun at the bottom; y points up.
    """
    path = Path(Pose(0, 0, 0), [1.0], [math.pi])
    tree = fromstring(path._repr_svg_())
    line = np.array([pair.split(",") for pair in tree[1].get("points").split()], float)

    assert tree[0].text == tree[3].text == "L, length 3.14159"
    assert (tree[2].get("cx"), tree[2].get("cy")) == ("10.00", "310.00")
    assert line[[0, -1]].tolist() == [[10.0, 310.0], [10.0, 10.0]]
    assert np.hypot(*(line - (10, 160)).T) == pytest.approx(150, abs=0.02)
    assert Path(Pose(0, 0, 0), [], [])._repr_svg_() is None
    assert Path(Pose(0, 0, 0), [math.nan], [1])._repr_svg_() is None


@pytest.mark.parametrize(("turn", "parts"), [(0.2, 2), (5.0, 50), (1e3, 10_000), (1e9, 100_000)])
def test_an_outline_has_few_points_however_often_a_circle_is_driven(turn, parts):
    """The straight behind the circle is one part."""
    points, curvatures = outline(Path(Pose(0, 0, 0), [0.5, 0], [2 * turn, 7]), 0.1)

    assert len(points) == len(curvatures) + 1 == parts + 2
    assert np.hypot(points[:-1, 0], points[:-1, 1] - 2) == pytest.approx(2, abs=1e-6)
    assert np.diff(points[:-1, 2]) == pytest.approx(turn / parts, abs=1e-6)


@given(arcs, arcs)
def test_two_paths_in_one_are_driven_one_after_the_other(first, second):
    """Two joined paths are driven in turn.

    Times are lengths by the speed; the second begins where the first ends.
    """
    one = path_of(first)
    other = path_of(second)
    moved = Path(one.end, other.curvatures, other.lengths)
    both = one + moved

    assert both.length == pytest.approx(one.length + moved.length, abs=1e-12)
    late = one.length + 0.5 * moved.length
    scale = 1 + np.abs(both.poses).max()
    np.testing.assert_allclose(
        both.at_time(late / 7.0, speed=7.0), moved.at(0.5 * moved.length), atol=1e-9 * scale
    )


def test_paths_that_do_not_meet_are_not_joined():
    """Paths that do not meet are not joined.

    Full turns apart are the same heading; a millionth of a radius is near enough.
    """
    one = Path((0.0, 0.0, 0.0), [0.5], [1.0])
    x, y, heading = one.end
    near = Path((x + 1e-6, y, heading + 2 * math.pi), [0.5], [1.0])

    assert Path.join([one, near]).length == 2.0
    beside = Path((x + 1e-5, y, heading), [0.5], [1.0])
    turned = Path((x, y, heading + 1e-5), [0.5], [1.0])
    straight = Path((0.0, 0.0, 0.0), [0.0], [1.0])
    away = Path((1.1, 0.0, 0.0), [0.0], [1.0])
    for first, wrong in ((one, beside), (one, turned), (straight, away)):
        with pytest.raises(ValueError, match=r"path 2 begins .* from the end of path 1"):
            Path.join([first, wrong])
    with pytest.raises(ValueError, match="there is no path to join"):
        Path.join([])

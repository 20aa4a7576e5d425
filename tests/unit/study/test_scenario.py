"""Scenarios, frames and rows: accepted or refused.

They have via points and final headings too; a refusal says why.
"""

import math
import pickle
import re
import warnings
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise, product

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study import Path, plot_path, solve_frame
from dubins_study.asking.reply import ask
from dubins_study.experiments.isolation.messages import decode_question, encode_question
from dubins_study.solvers.protocol import Question, Solver
from dubins_study.study.angle import AngleError, parse_angle
from dubins_study.study.rows.parts import rows_table
from dubins_study.study.rows.schema import ROW, names
from dubins_study.study.scenario import (
    COLUMNS,
    NUMBERS,
    Pose,
    Scenario,
    ScenarioError,
)
from dubins_study.study.scenario_frame import check_frame, scenario_of, scenarios
from dubins_study.study.words import (
    BRANCHES,
    FINAL_HEADING,
    FREE_FINAL_HEADING,
    NEEDS,
    POSE_BRANCHES,
    VIA_POINTS,
    Outcome,
)
from tests.cases import placed, scenario_row

GOOD = {"x": 0, "y": 0, "heading": 0, "target_x": 1, "target_y": 2, "radius": 1}


def refused(message, **values):
    """Check that a scenario is refused in few words.

    A frame is refused as well, and the message names its row.
    """
    with pytest.raises(ScenarioError, match=f"^{message}") as one:
        Scenario(**(GOOD | values))
    assert len(str(one.value)) < 200
    refused_in_a_frame(message, **values)


def refused_in_a_frame(message, **values):
    """Check that a frame of values is refused.

    Its columns are of objects, and of doubles if the values are.
    """
    doubles = all(type(value) is float for value in values.values())
    for dtype in (object, float) if doubles else (object,):
        frame = pd.DataFrame([GOOD | {"speed": 1.0}] * 3)
        for field, value in values.items():
            column = frame[field].astype(object)
            column[1] = value
            frame[field] = column.astype(dtype)
        with pytest.raises(ScenarioError, match=f"^row 'b': {message}"):
            check_frame(frame.set_axis(["a", "b", "c"]))


# a number, and what is expected instead
REFUSED = [
    *product(NUMBERS, (math.nan, math.inf, -math.inf, "one", None), ["a (finite )?number"]),
    *product(["radius", "speed"], (0.0, -1.0), ["a number above 0"]),
    # whose squares overflow or vanish
    *(("x", 1e308, ""), ("target_y", -1e200, ""), ("radius", 1e308, "")),
    *(("radius", 1e-320, ""), ("speed", 1e-320, "")),
]


@pytest.mark.parametrize(("field", "value", "expected"), REFUSED)
def test_numbers_that_are_refused(field, value, expected):
    """Numbers that are refused.

    The message names the field, the value and what is expected.
    """
    shown = "(missing|None|nan)" if value is None else re.escape(repr(value))
    if (field, value) == ("heading", None):
        assert Scenario(**(GOOD | {"heading": None})).heading is None  # free
    elif (field, value) == ("heading", "one"):
        refused("heading: 'one' is not an angle; expected e.g.", heading="one")
    else:
        refused(f"{field} is {shown}.*expected {expected}", **{field: value})


def test_a_circle_smaller_than_the_last_digit_of_the_coordinates():
    refused("radius is 1e-06; expected at least 0", target_x=1e10, radius=1e-6)


NO_NUMBERS = [
    ("1", "'1'"),
    ("1_0", "'1_0'"),
    (b"1", "b'1'"),
    (True, "True"),
    (1j, "1j"),
    (1 + 0j, r"\(1\+0j\)"),
    (np.True_, r"np\.True_"),
    (np.complex64(2), r"np\.complex64\(2\+0j\)"),
    (np.timedelta64(1, "s"), "np.timedelta64"),
    (pd.Timedelta(1), "Timedelta"),
    (pd.Timestamp(0), "Timestamp"),
    ((1,), r"\(1,\)"),
    (10**400, r"1000\d{0,60}\.\.\."),
    (10**5000, "a value of type int"),  # Python refuses to print as many digits
    (Decimal("sNaN"), r"Decimal\('sNaN'\)"),
]


@pytest.mark.parametrize(("value", "shown"), NO_NUMBERS, ids=[shown for _, shown in NO_NUMBERS])
@pytest.mark.parametrize("field", ["x", "heading", "radius"])
def test_what_is_no_number(field, value, shown):
    """Values that are no numbers are refused.

    Only the heading may be a text.
    """
    if field != "heading" or not isinstance(value, str):
        refused(rf"{field} is {shown}.*; expected a number", **{field: value})


@pytest.mark.parametrize("dtype", [object, "str", "category"])
def test_a_heading_of_a_frame_may_be_a_text_as_of_a_scenario(dtype):
    texts = ["30deg", "-pi/2", "1"]
    frame = pd.DataFrame([GOOD] * 3).assign(heading=pd.Series(texts, dtype=dtype))
    expected = [Scenario(**(GOOD | {"heading": text})) for text in texts]

    assert list(scenarios(check_frame(frame))) == expected


@pytest.mark.parametrize(
    "value",
    [2, np.float32(2), np.int8(2), Decimal(2), Fraction(2), np.array(2.0), np.longdouble(2)],
)
def test_what_is_a_number(value):
    assert Scenario(**(GOOD | {"x": value})) == Scenario(**(GOOD | {"x": 2.0}))
    frame = pd.DataFrame([GOOD | {"x": 2.0}]).assign(x=pd.Series([value], dtype=object))
    assert list(scenarios(check_frame(frame))) == [Scenario(**(GOOD | {"x": 2.0}))]


COLUMNS_OF_NUMBERS = [
    *(np.array([1, 2], dtype) for dtype in (">f8", ">i2", np.float16, object)),
    *(pd.array([1, 2], dtype="Int64"), pd.Categorical([1.0, 2.0])),
    pd.arrays.SparseArray([1.0, 2.0]),
]
OTHER_COLUMNS = [
    (np.array([1 + 2j, 2]), r"\(1\+2j\)"),
    (np.array(["1_0", "2"]), "'1_0'"),
    (pd.array(["1", "2"], dtype="string"), "'1'"),
    (pd.Categorical(["1", "2"]), "'1'"),
    (pd.to_timedelta([1, 2]), "Timedelta"),
    (pd.to_datetime([1, 2]), "Timestamp"),
    (np.array([True, False]), "True"),
    (pd.array([True, None], dtype="boolean"), ".*True"),
    (pd.array([None, 2], dtype="Int64"), "<NA>"),
    (pd.Series(np.ma.masked_array([1.0, 2.0], [True, False])), "nan"),
]


@pytest.mark.parametrize("column", COLUMNS_OF_NUMBERS)
def test_columns_of_every_type_of_number(column):
    """Read for what they hold, whatever the index."""
    checked = check_frame(pd.DataFrame([GOOD] * 2).assign(target_x=column).set_axis([7, 7]))

    assert checked["target_x"].tolist() == [1.0, 2.0]
    assert checked["target_x"].dtype == np.float64
    assert checked.index.tolist() == [7, 7]


@pytest.mark.parametrize(("column", "shown"), OTHER_COLUMNS)
def test_columns_of_something_else(column, shown):
    frame = pd.DataFrame([GOOD] * 2).assign(radius=column)
    with pytest.raises(ScenarioError, match=rf"^row 'a': radius is {shown}.*; expected a "):
        check_frame(frame.set_axis(["a", "b"]))


@pytest.mark.parametrize("label", [[1], {}, None, 3, b"a", "\ud800"])
def test_a_label_is_a_text(label):
    """A label is a text.

    In a frame a missing one is empty, as CSV files read; anything else is named and its row.
    """
    with pytest.raises(ScenarioError, match=r"^label is .*; expected a text"):
        Scenario(**(GOOD | {"label": label}))
    frame = pd.DataFrame([GOOD] * 2).assign(label=pd.Series(["a", None], dtype=object))
    assert check_frame(frame)["label"].tolist() == ["a", ""]
    if label not in (None, "\ud800"):
        frame.at[1, "label"] = label
        with pytest.raises(ScenarioError, match=r"^row 1: label is .*; expected a text"):
            check_frame(frame)


@pytest.mark.parametrize(
    ("frame", "message"),
    [
        (lambda good: good.drop(columns="target_x"), "missing column 'target_x'; expected the col"),
        (lambda good: good[["x"]], "missing columns 'target_x', 'target_y'; expected the"),
        (lambda good: good.assign(lable="a"), "unknown column 'lable'; did you mean 'label'"),
        (lambda _: [GOOD], "expected a DataFrame"),
    ],
)
def test_columns(frame, message):
    with pytest.raises(ScenarioError, match=message):
        check_frame(frame(pd.DataFrame([GOOD])))


@pytest.mark.parametrize("more", [{}, {"via": [(1, 2)]}, {"final_heading": "90deg"}])
def test_columns_that_are_left_out(more):
    """Columns that are left out have defaults.

    Each has that of `Scenario`, in columns of numbers and in rows of texts and lists.
    """
    frame = pd.DataFrame([{"target_x": 3, "target_y": 4, **more}] * 2)

    assert list(scenarios(check_frame(frame))) == [Scenario(target_x=3, target_y=4, **more)] * 2


def test_local_coordinates():
    """Local coordinates of a target.

    It lies two radii ahead and one to the left, whatever the pose.
    """
    scenario = placed(2, 1, x=5, y=-3, heading=2.0, radius=2)

    np.testing.assert_allclose(scenario.local(), (2, 1), rtol=1e-14)


@pytest.mark.parametrize(
    ("text", "radians"),
    [
        ("120deg", 2 * math.pi / 3),
        ("-45 deg", -math.pi / 4),
        ("90°", math.pi / 2),
        ("2.0944", 2.0944),
        ("-1e-3", -1e-3),
        ("pi", math.pi),
        ("-pi/2", -math.pi / 2),
        ("2pi/3", 2 * math.pi / 3),
        ("0.5*pi", math.pi / 2),
        ("7rad", 7.0),
        ("-120 rad", -120.0),
        ("720deg", 4 * math.pi),
        ("6.2832", 6.2832),
        (1, 1.0),
    ],
)
def test_angles(text, radians):
    assert parse_angle(text) == pytest.approx(radians, rel=1e-15)


@pytest.mark.parametrize("text", ["", "1_0", "nan", "inf", "pi/0", "1e999", "2pi/", "deg", "__"])
def test_not_an_angle(text):
    with pytest.raises(AngleError, match="is not an angle; expected"):
        parse_angle(text)


@pytest.mark.parametrize("text", ["120", "-90", "6.3", "1e3"])
def test_a_text_beyond_a_full_turn_needs_a_unit(text):
    """A text beyond a full turn needs a unit.

    Neither a text nor a number is an angle; of a `Scenario` only the text is refused.
    """
    message = f"{text} is more than a full turn; write {text}deg, or"
    for written in (text, float(text)):
        with pytest.raises(AngleError, match="is more than a full turn; write "):
            parse_angle(written)
    with pytest.raises(ScenarioError, match=f"^heading: {message}"):
        Scenario(heading=text, target_x=1, target_y=0)
    refused_in_a_frame(f"heading: {message}", heading=text)


DEGREES = "if it is in degrees, write the unit, such as '90deg'"


@pytest.mark.parametrize("name", ["heading", "final_heading"])
def test_a_number_beyond_a_full_turn_gives_a_warning(name):
    """A number beyond a full turn gives a warning.

    It is at the caller's line, and so once for all numbers there; radians beyond it may be a text.
    """
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("default")
        for number in (90, -400.0, np.float64(7), 6.2832, "7rad", "-720deg"):
            scenario = Scenario(**(GOOD | {name: number}))
        scenario_of({name: getattr(scenario, name) for name in COLUMNS})
        replace(scenario, x=1)
    assert [DEGREES in str(warning.message) for warning in found] == [True]
    assert found[0].filename == __file__

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert decode_question(encode_question(Question(scenario, "best"))).scenario == scenario
        plot_path(Path(Pose(0, 0, 400.0), [1.0], [2.0]))
    theirs = {"Scenario": Scenario, "__name__": "dubins_study.plugin_of_another"}
    with pytest.warns(UserWarning, match="full turn"):
        exec("Scenario(target_x=1, target_y=0, heading=90)", theirs)

    frame = pd.DataFrame([GOOD | {"final_heading": 1.0}] * 3)
    for column in ([1, 90, 7.0], ["7rad", 90, 1], ["90deg", "7rad", "-720deg"]):
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            check_frame(frame.assign(**{name: column}))
        assert [DEGREES in str(warning.message) for warning in found] == [True] * (90 in column)
    with pytest.warns(UserWarning, match="full turn") as found:
        solve_frame(frame.assign(**{name: 90}))
    assert found[0].filename == __file__


def test_a_scenario_has_the_defaults_of_the_command():
    """A scenario has the defaults of the command.

    Only the target must be given; the heading may be a text, and is stored in radians.
    """
    assert Scenario(target_x=3, target_y=2) == Scenario(0, 0, 0, 3, 2, 1, 1, "")
    assert Scenario(0, 0, "120deg", 3, 2).heading == math.radians(120)
    assert Scenario(heading="2pi/3", target_x=3, target_y=2).heading == 2 * math.pi / 3
    for missing, other in (("target_x", {"target_y": 1}), ("target_y", {"target_x": 1})):
        with pytest.raises(ScenarioError, match=f"^{missing} is missing; expected a number$"):
            Scenario(**other)


ROUTE = Scenario(
    heading="30deg", target_x=10, target_y=5, via=[(4, 1), (6, -2)], final_heading="90deg"
)
PLAIN = Scenario(target_x=10, target_y=5)
POSE = Scenario(target_x=10, target_y=5, final_heading=-1)
CASES = [PLAIN, POSE, ROUTE, replace(ROUTE, final_heading=None, label="free")]
ROW_OF = {"x": 0, "y": 0, "heading": 0, "target_x": 10, "target_y": 5, "radius": 1}
coordinates = st.floats(-100, 100).map(lambda value: value + 0.0)


def test_points_and_legs_of_a_route():
    assert ROUTE.legs == 3
    np.testing.assert_array_equal(ROUTE.points, [[0, 0], [4, 1], [6, -2], [10, 5]])
    assert ROUTE.final_heading == math.pi / 2
    assert PLAIN.legs == Scenario(target_x=0, target_y=0, final_heading=1).legs == 1
    np.testing.assert_array_equal(PLAIN.points, [[0, 0], [10, 5]])
    assert (PLAIN.via, PLAIN.final_heading) == ((), None)


@pytest.mark.parametrize(
    "via",
    [
        [[4, 1], [6, -2]],
        ((4.0, 1.0), (6.0, -2.0)),
        np.array([[4, 1], [6, -2]]),
        np.array([[4, 1], [6, -2]], dtype=np.float32),
        zip([4, 6], [1, -2], strict=True),
        pd.DataFrame({"x": [4, 6], "y": [1, -2]}),
    ],
)
def test_via_points_of_every_kind_are_one_value(via):
    """Equal scenarios have equal hashes, and hold plain floats."""
    scenario = replace(ROUTE, via=via)

    assert scenario == ROUTE
    assert hash(scenario) == hash(ROUTE)
    assert {type(c) for point in scenario.via for c in point} == {float}


@pytest.mark.parametrize("scenario", CASES)
def test_a_scenario_comes_back_from_its_pickle_its_repr_and_its_copy(scenario):
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    assert eval(repr(scenario)) == scenario  # a repr of ours
    assert replace(scenario) == scenario


@pytest.mark.parametrize(
    ("via", "message"),
    [
        ([(0, -0.0)], r"via point 1 is \(0.0, -0.0\), the same point as the one before"),
        ([(1, 2), (1, 2)], r"via point 2 is \(1.0, 2.0\), the same point as the one before"),
        ([(1, 2), (10, 5)], r"the target is \(10.0, 5.0\), the same point as the one before"),
        ("12", "via is '12'; expected pairs of numbers, such as"),
        ({(1, 2)}, "via is .*; expected pairs of numbers"),
        ([1, 2], r"via is \[1, 2\]; expected pairs of numbers"),
        (7, "via is 7; expected pairs of numbers"),
        (None, "via is None; expected pairs of numbers"),
        ([(1, 2, 3, 4)], r"via is \[\(1, 2, 3, 4\)\]; expected pairs of numbers"),
        ([(1, 2), ("a", 2)], "x of via point 2 is 'a'; expected a number"),
        ([(1, True)], "y of via point 1 is True; expected a number"),
        ([(math.nan, 2)], "x of via point 1 is nan; expected a finite number"),
        ([(1, -1e200)], "y of via point 1 is -1e.200; expected a finite number of size up to"),
        ([(1, None)], "y of via point 1 is missing; expected a number"),
        ([(1, 1e14)], "radius is 1.0; expected at least 10 beside coordinates of size 1e.14"),
    ],
)
def test_via_points_that_are_refused(via, message):
    with pytest.raises(ScenarioError, match=f"^{message}") as error:
        replace(PLAIN, via=via)
    assert len(str(error.value)) < 200


@pytest.mark.parametrize("value", [math.nan, math.inf, "7", "east", True, [1], 1e200])
def test_final_headings_that_are_refused(value):
    with pytest.raises(ScenarioError, match=r"^final_heading(:| is) .*; (expected|write)"):
        replace(PLAIN, final_heading=value)


@given(st.lists(st.tuples(coordinates, coordinates), min_size=2, max_size=8))
def test_extent_is_the_largest_over_legs(points):
    """The extent is the largest over legs.

    Each leg alone is a scenario, whose extent has no via points; a long route is not refused.
    """
    if any(one == other for one, other in pairwise(points)):
        return
    (x, y), *via, (u, v) = points
    route = Scenario(x, y, 0, u, v, via=via)
    legs = [Scenario(*one, 0, *other) for one, other in pairwise(points)]

    assert route.extent == max(leg.extent for leg in legs)


def test_points_of_a_frame_are_its_columns_x_and_y():
    """Points of a frame are its columns x, y.

    Their order does not matter; a frame without them is refused, since it could be anything.
    """
    frame = pd.DataFrame({"name": ["a", "b"], "y": [1, -2], "x": [4, 6]})

    assert Scenario(target_x=9, target_y=0, via=frame).via == ((4.0, 1.0), (6.0, -2.0))
    with pytest.raises(ScenarioError, match="or a frame with columns x and y"):
        Scenario(target_x=9, target_y=0, via=frame.rename(columns={"x": "lon", "y": "lat"}))


def test_stops_are_the_points_after_the_start():
    """Stops are the points after the start.

    Only the last one may have a heading.
    """
    route = Scenario(target_x=9, target_y=0, via=[(4, 1), (6, -2)], final_heading=0.5)

    assert route.stops == ((4.0, 1.0, None), (6.0, -2.0, None), (9.0, 0.0, 0.5))
    assert [stop[:2] for stop in route.stops] == [tuple(point) for point in route.points[1:]]


def test_a_scenario_names_its_needs():
    assert PLAIN.needs == (FREE_FINAL_HEADING,)
    assert POSE.needs == (FINAL_HEADING,)
    assert ROUTE.needs == (VIA_POINTS, FINAL_HEADING)
    assert CASES[3].needs == (VIA_POINTS, FREE_FINAL_HEADING)


@pytest.mark.parametrize("scenario", CASES)
def test_a_row_is_the_scenario(scenario):
    """A row is the scenario.

    It goes by way of the Parquet table and pandas, whose lists are arrays and whose nulls are
    many.
    """
    table = rows_table([dict.fromkeys(names(ROW)) | scenario_row(scenario)])
    [from_arrow] = table.to_pylist()
    [from_pandas] = table.to_pandas().to_dict("records")

    assert from_arrow["via_x"] == ([x for x, _ in scenario.via] or None)
    for read in (scenario_row(scenario), from_arrow, from_pandas):
        assert scenario_of(read) == scenario
    old = {name: from_pandas[name] for name in COLUMNS[:8]}
    assert scenario_of(old) == replace(scenario, via=(), final_heading=None)


def test_frames_and_scenarios_go_round():
    """Frames and scenarios go round.

    They come from columns of rows, and from what pandas makes of a list of scenarios.
    """
    expected = [PLAIN, POSE, ROUTE, replace(ROUTE, via=[(1, 2)])]
    for frame in (pd.DataFrame([scenario_row(s) for s in expected]), pd.DataFrame(expected)):
        checked = check_frame(frame)
        assert list(checked.columns) == list(COLUMNS)
        assert list(scenarios(checked)) == expected
        assert list(scenarios(check_frame(checked))) == expected


TWO, ONE = ((4, 1), (6, -2)), ((4, 1),)
CELLS = [
    *(("4 6", "1 -2", TWO), ([4, 6], (1, -2), TWO), (np.array([4, 6]), " 1  -2.0 ", TWO)),
    (4.0, 1.0, ONE),  # a column of numbers, as pandas reads it
    *((empty, empty, ()) for empty in (None, math.nan, pd.NA, "", [], ())),
]


@pytest.mark.parametrize(("via_x", "via_y", "via"), CELLS)
def test_cells_of_via_points(via_x, via_y, via):
    """Cells of via points.

    A row without any, whose final heading is missing too, stands beside them.
    """
    frame = pd.DataFrame([ROW_OF] * 2)
    for name, cell in (("via_x", via_x), ("via_y", via_y)):
        frame[name] = pd.Series([cell, math.nan], dtype=float if via == ONE else object)
    frame["final_heading"] = pd.Series([pd.NA if via_x is pd.NA else None] * 2, dtype=object)
    route, plain = scenarios(check_frame(frame))

    assert route == replace(PLAIN, via=via)
    assert plain == PLAIN


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"via_x": "4 6", "via_y": "1"}, "via_x has 2 numbers and via_y has 1; expected as many"),
        ({"via_x": "4 6"}, "via_x has 2 numbers and via_y has 0; expected as many"),
        ({"via_x": "[4, 6]"}, r"via_x is '\[4, 6\]'; expected numbers separated by spaces, such"),
        ({"via_y": "1_0"}, "via_y is '1_0'; expected numbers separated by spaces"),
        ({"via_x": [4, "6"]}, "via_x is '6'; expected a number"),
        ({"via_x": [0], "via_y": [0]}, r"via point 1 is \(0.0, 0.0\), the same point as the one"),
        ({"via_x": [0], "via_y": [1e15]}, "radius is 1.0; expected at least 100 beside"),
        ({"via": [(1,)]}, r"via is \[\(1,\)\]; expected pairs of numbers"),
        ({"via_heading": "1"}, "via_x has 0 numbers and via_heading has 1; expected as many"),
        ({"final_heading": "120"}, "final_heading: 120 is more than a full turn; write 120deg"),
        ({"final_heading": math.inf}, "final_heading is inf; expected a finite number"),
    ],
)
def test_rows_of_a_frame_that_are_refused(change, message):
    frame = pd.DataFrame([ROW_OF, ROW_OF | change], index=["a", "b"])

    with pytest.raises(ScenarioError, match=f"^row 'b': {message}"):
        check_frame(frame)


def test_a_route_beyond_the_extent_of_one_leg_is_accepted():
    """A route beyond one leg's extent is accepted.

    The sum of start and target is no leg of it.
    """
    frame = pd.DataFrame([ROW_OF | {"x": -6e12, "target_x": 6e12}])
    with pytest.raises(ScenarioError, match="lost in rounding"):
        check_frame(frame)
    [route] = scenarios(check_frame(frame.assign(via_x="0", via_y="0")))

    assert route.legs == 2


class Asked(Solver):
    """Notes that it is asked."""

    name = "asked"
    branches = (*BRANCHES, *POSE_BRANCHES)

    def solve(self, model: Question, limit: float):
        raise AssertionError("asked")


@pytest.mark.parametrize("taken", [(), *((need,) for need in NEEDS), NEEDS])
@pytest.mark.parametrize("scenario", CASES)
def test_a_solver_is_asked_only_what_it_takes(scenario, taken, monkeypatch):
    """A solver is asked only what it takes.

    A question that needs more is unsupported, with a message that says what is not taken.
    """
    monkeypatch.setattr(Asked, "takes", frozenset(taken))
    reply = ask(Asked(), Question(scenario))

    if lacking := [need for need in scenario.needs if need not in taken]:
        assert reply.outcome is Outcome.UNSUPPORTED
        assert f"asked does not take: {', '.join(lacking)}; it takes: " in reply.solution.message
    else:
        assert reply.outcome is Outcome.RAISED

"""Scenarios and frames: what is accepted, and what is said of the rest."""

from __future__ import annotations

import math
import re
import warnings
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from itertools import product

import numpy as np
import pandas as pd
import pytest
from cases import placed

from dubins_study.study.angle import AngleError, parse_angle
from dubins_study.study.scenario import (
    COLUMNS,
    NUMBERS,
    Scenario,
    ScenarioError,
)
from dubins_study.study.scenario_frame import check_frame, scenario_of, scenarios

GOOD = {"x": 0, "y": 0, "heading": 0, "target_x": 1, "target_y": 2, "radius": 1}


def refused(message, **values):
    """A scenario of these values is refused in few words; so is a frame, which names its row."""
    with pytest.raises(ScenarioError, match=f"^{message}") as one:
        Scenario(**(GOOD | values))
    assert len(str(one.value)) < 200
    refused_in_a_frame(message, **values)


def refused_in_a_frame(message, **values):
    """Of columns of objects, and of doubles if the values are."""
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
    """The message names the field, the value and what is expected."""
    shown = "(missing|None|nan)" if value is None else re.escape(repr(value))
    if (field, value) == ("heading", "one"):
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
    """Only the heading may be a text."""
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
    """In a frame a missing one is empty, as CSV files read; anything else is named and its row."""
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


def test_defaults_and_index_are_kept():
    frame = pd.DataFrame([GOOD, GOOD], index=[7, 3])
    checked = check_frame(frame)

    assert list(checked.columns) == list(COLUMNS)
    assert list(checked.index) == [7, 3]
    assert (checked["speed"] == 1).all()
    assert list(frame.columns) == list(GOOD)
    assert len(check_frame(pd.DataFrame(columns=list(COLUMNS)))) == 0


@pytest.mark.parametrize("more", [{}, {"via": [(1, 2)]}, {"final_heading": "90deg"}])
def test_columns_that_are_left_out(more):
    """Each has the default of `Scenario`, in columns of numbers and in rows of texts and lists."""
    frame = pd.DataFrame([{"target_x": 3, "target_y": 4, **more}] * 2)

    assert list(scenarios(check_frame(frame))) == [Scenario(target_x=3, target_y=4, **more)] * 2


def test_local_coordinates():
    """A target two radii ahead and one to the left, whatever the pose."""
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
    """Neither a text nor a number is an angle; of a `Scenario` only the text is refused."""
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
    """At the caller's line, and so once for all numbers there; radians beyond it may be a text."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("default")
        for number in (90, -400.0, np.float64(7), 6.2832, "7rad", "-720deg"):
            scenario = Scenario(**(GOOD | {name: number}))
        scenario_of({name: getattr(scenario, name) for name in COLUMNS})
        replace(scenario, x=1)
    assert [DEGREES in str(warning.message) for warning in found] == [True]
    assert found[0].filename == __file__

    frame = pd.DataFrame([GOOD | {"final_heading": 1.0}] * 3)
    for column in ([1, 90, 7.0], ["7rad", 90, 1], ["90deg", "7rad", "-720deg"]):
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            check_frame(frame.assign(**{name: column}))
        assert [DEGREES in str(warning.message) for warning in found] == [True] * (90 in column)


def test_a_scenario_has_the_defaults_of_the_command():
    """Only the target must be given; the heading may be a text, and is stored in radians."""
    assert Scenario(target_x=3, target_y=2) == Scenario(0, 0, 0, 3, 2, 1, 1, "")
    assert Scenario(0, 0, "120deg", 3, 2).heading == math.radians(120)
    assert Scenario(heading="2pi/3", target_x=3, target_y=2).heading == 2 * math.pi / 3
    for missing, given in (("target_x", {"target_y": 1}), ("target_y", {"target_x": 1})):
        with pytest.raises(ScenarioError, match=f"^{missing} is missing; expected a number$"):
            Scenario(**given)

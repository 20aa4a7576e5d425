"""Via points and final headings: in scenarios, frames and rows, and what is said of wrong ones."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.solvers.protocol import Question, Solver
from dubins_study.solvers.reply import ask
from dubins_study.study.rows.parts import rows_table
from dubins_study.study.rows.schema import ROW, SCENARIO, names
from dubins_study.study.scenario import COLUMNS, Scenario, ScenarioError
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
        pd.DataFrame({"x": [4, 6], "y": [1, -2]}).to_numpy(),
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
        ([(0, -0.0)], r"via point 1 is \(0.0, -0.0\), the same point as the start; expected a po"),
        ([(1, 2), (1, 2)], r"via point 2 is \(1.0, 2.0\), the same point as via point 1; expected"),
        ([(1, 2), (10, 5)], r"the target is \(10.0, 5.0\), the same point as via point 2; expect"),
        ("12", "via is '12'; expected pairs of numbers, such as"),
        ({(1, 2)}, "via is .*; expected pairs of numbers"),
        ([1, 2], r"via is \[1, 2\]; expected pairs of numbers"),
        (7, "via is 7; expected pairs of numbers"),
        (None, "via is None; expected pairs of numbers"),
        ([(1, 2, 3)], r"via point 1 is \(1, 2, 3\); expected x and y"),
        ([(1, 2), ("a", 2)], "x of via point 2 is 'a'; expected a number"),
        ([(1, True)], "y of via point 1 is True; expected a number"),
        ([(math.nan, 2)], "x of via point 1 is nan; expected a finite number"),
        ([(1, -1e200)], "y of via point 1 is -1e.200; expected a number of size up to"),
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
    """Each leg alone is a scenario, whose extent has no via points; a long route is not refused."""
    if any(one == other for one, other in pairwise(points)):
        return
    (x, y), *via, (u, v) = points
    route = Scenario(x, y, 0, u, v, via=via)
    legs = [Scenario(*one, 0, *other) for one, other in pairwise(points)]

    assert route.extent == max(leg.extent for leg in legs)


def test_a_scenario_names_its_branches_and_needs():
    assert [s.branches for s in CASES] == [BRANCHES, POSE_BRANCHES, *[("best", "frozen")] * 2]
    assert PLAIN.needs == (FREE_FINAL_HEADING,)
    assert POSE.needs == (FINAL_HEADING,)
    assert ROUTE.needs == (VIA_POINTS, FINAL_HEADING)
    assert CASES[3].needs == (VIA_POINTS, FREE_FINAL_HEADING)


def row(scenario):
    return {name: getattr(scenario, name) for name in names(SCENARIO)}


@pytest.mark.parametrize("scenario", CASES)
def test_a_row_is_the_scenario(scenario):
    """By way of the Parquet table and pandas, whose lists are arrays and whose nulls are many."""
    table = rows_table([dict.fromkeys(names(ROW)) | row(scenario)])
    [from_arrow] = table.to_pylist()
    [from_pandas] = table.to_pandas().to_dict("records")

    assert from_arrow["via_x"] == ([x for x, _ in scenario.via] or None)
    for read in (row(scenario), from_arrow, from_pandas):
        assert scenario_of(read) == scenario
    old = {name: from_pandas[name] for name in COLUMNS[:8]}
    assert scenario_of(old) == replace(scenario, via=(), final_heading=None)


def test_frames_and_scenarios_go_round():
    """From columns of rows, and from what pandas makes of a list of scenarios."""
    expected = [PLAIN, POSE, ROUTE, replace(ROUTE, via=[(1, 2)])]
    for frame in (pd.DataFrame([row(s) for s in expected]), pd.DataFrame(expected)):
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
    """Beside a row without any, whose final heading is missing too."""
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
        ({"via_x": [0], "via_y": [0]}, r"via point 1 is \(0.0, 0.0\), the same point as the start"),
        ({"via_x": [0], "via_y": [1e15]}, "radius is 1.0; expected at least 100 beside"),
        ({"via": [(1, 2, 3)]}, r"via point 1 is \(1, 2, 3\); expected x and y"),
        ({"final_heading": "120"}, "final_heading: 120 is more than a full turn; write 120deg"),
        ({"final_heading": math.inf}, "final_heading is inf; expected a finite number"),
    ],
)
def test_rows_of_a_frame_that_are_refused(change, message):
    frame = pd.DataFrame([ROW_OF, ROW_OF | change], index=["a", "b"])

    with pytest.raises(ScenarioError, match=f"^row 'b': {message}"):
        check_frame(frame)


def test_a_route_beyond_the_extent_of_one_leg_is_accepted():
    """The sum of start and target is no leg of it."""
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
    """A question that needs more is unsupported, with a message that says what is not taken."""
    monkeypatch.setattr(Asked, "takes", frozenset(taken))
    reply = ask(Asked(), Question(scenario))

    if lacking := [need for need in scenario.needs if need not in taken]:
        assert reply.outcome is Outcome.UNSUPPORTED
        assert f"asked does not take: {', '.join(lacking)}; it takes: " in reply.solution.message
    else:
        assert reply.outcome is Outcome.RAISED

"""Tours as scenarios, frames and rows.

There are given headings at via points, free starts and closed paths.
"""

import math
import pickle
import shlex
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from dubins_study import solve, solve_frame
from dubins_study.experiments.plan.scenarios import scenario_id
from dubins_study.study.kinds.table import KINDS, kind_of, rows_of
from dubins_study.study.path import Path
from dubins_study.study.rows.parts import rows_table, start_of
from dubins_study.study.rows.schema import ROW, names
from dubins_study.study.scenario import COLUMNS, Scenario, ScenarioError
from dubins_study.study.scenario_frame import check_frame, scenario_of, scenarios, solve_command
from dubins_study.study.words import NEEDS, Order
from tests.cases import scenario_row

VIA = [(4, 1), (6, -2)]
TARGET = {"target_x": 10, "target_y": 5}
HEADED = [(4, 1, "90deg"), (6, -2, "free")]
SCENARIOS = {
    "tour": Scenario(**TARGET, via=VIA, order="free"),
    "tour to a heading": Scenario(**TARGET, via=VIA, order="free", final_heading=1),
    "tour, the end at any": Scenario(via=VIA, order="free", label="anywhere"),
    "closed tour": Scenario(heading=2, via=VIA, order="free", closed=True, radius=0.5),
    "closed route": Scenario(-1, 2, "90deg", via=[*VIA, (-1, 2), (3, 3)], closed=True),
    "headings at via points": Scenario(**TARGET, via=HEADED),
    "tour with headings": Scenario(via=HEADED, order="free"),
    "free start": Scenario(heading="free", **TARGET),
    "free start to a heading": Scenario(heading=None, **TARGET, final_heading=-3),
    "free start of a route": Scenario(heading=None, **TARGET, via=VIA),
}
every = pytest.mark.parametrize("scenario", SCENARIOS.values(), ids=SCENARIOS)


REFUSED = [
    ({"order": "free"}, "via is empty; expected points to pass, which a tour without a target"),
    ({"closed": True}, "via is empty; expected points to pass, which a closed path needs"),
    ({"closed": True, "via": VIA, "target_x": 0}, "target_x is 0, but a closed path ends as it"),
    ({"closed": True, "via": VIA, "final_heading": 1}, "final_heading is 1, but a closed path"),
    ({"order": "free", "via": VIA, "final_heading": 1}, "final_heading is 1, but the tour ends at"),
    ({"order": "free", "via": VIA, "target_x": 1}, "target_y is missing; expected a number"),
    ({"order": "FREE", "via": VIA, **TARGET}, "order is 'FREE'; expected given or free"),
    ({"order": None, "via": VIA, **TARGET}, "order is None; expected given or free"),
    ({"order": ["free"], "via": VIA}, r"order is \['free'\]; expected given or free"),
    *(({"closed": flag, "via": VIA}, "closed is .*; expected true") for flag in (1, "yes", None)),
    ({"via": VIA}, "target_x is missing; expected a number"),
    ({"heading": "Free", **TARGET}, "heading: 'Free' is not an angle; expected e.g."),
    ({"heading": math.nan, **TARGET}, "heading is nan; expected a finite number"),
    ({"heading": np.array([1.0, 2.0]), **TARGET}, "heading is array.*; expected a number"),
    ({"via": [(1, 2, math.inf)], **TARGET}, "heading of via point 1 is inf; expected a finite"),
    ({"via": [(1, 2), (3, 4, "91")], **TARGET}, "heading of via point 2: 91 is more than a full"),
    ({"via": [(1, 2, True)], **TARGET}, "heading of via point 1 is True; expected a number"),
    ({"via": [(1, 2, 3, 4)], **TARGET}, r"via is \[\(1, 2, 3, 4\)\]; expected pairs of numbers"),
    ({"via": [*VIA, (4, 1)], "order": "free"}, r"\(4.0, 1.0\) is a point of the tour twice, as po"),
    ({"via": [(4, 1), (0, 0)], "order": "free"}, r"\(0.0, 0.0\) is a point of the tour twice, as"),
    ({"via": [(10, 5)], "order": "free", **TARGET}, r"\(10.0, 5.0\) is a point of the tour twice"),
    ({"via": [(4, 1), (0, 0)], "closed": True}, "the start, where the path ends, is .* the same"),
    ({"via": [(1e13, 0), (0, 1e13)], "order": "free"}, "radius is 1.0; expected at least 2 beside"),
]


@pytest.mark.parametrize(("values", "message"), REFUSED)
def test_what_is_refused(values, message):
    """Refusals name the field in one sentence."""
    with pytest.raises(ScenarioError, match=f"^{message}") as error:
        Scenario(**values)
    assert len(str(error.value)) < 200
    assert "\n" not in str(error.value)


def test_a_free_start_has_no_pose():
    with pytest.raises(ScenarioError, match="heading is free: only a path has a start pose"):
        _ = Scenario(heading=None, target_x=4, target_y=1).start


def test_stops_and_needs():
    """Stops, and needs of a solver.

    The fields that are given tell where a path ends, and what a solver must take.
    """
    stops = {name: scenario.stops for name, scenario in SCENARIOS.items()}
    needs = {name: set(scenario.needs) for name, scenario in SCENARIOS.items()}

    assert stops["tour"][-1] == (10.0, 5.0, None)
    assert stops["tour, the end at any"] == ((4.0, 1.0, None), (6.0, -2.0, None))
    assert stops["closed tour"][-1] == (0.0, 0.0, 2.0)
    assert stops["closed route"][-1] == (-1.0, 2.0, math.pi / 2)
    assert stops["headings at via points"][:2] == ((4.0, 1.0, math.pi / 2), (6.0, -2.0, None))
    assert [SCENARIOS[name].legs for name in ("tour", "tour, the end at any")] == [3, 2]
    assert needs["closed tour"] == {"via points", "final heading", "free order", "closed"}
    assert needs["free start"] == {"free start heading", "free final heading"}
    assert needs["tour with headings"] >= {"headings at stops", "free order"}
    assert set().union(*needs.values()) == {*NEEDS}
    assert Scenario(**TARGET, order="free") == Scenario(
        **TARGET
    )  # there is nothing to put in order


@every
def test_a_scenario_is_a_value(scenario):
    copied = pickle.loads(pickle.dumps(scenario))

    assert copied == scenario
    assert hash(copied) == hash(scenario)
    assert eval(repr(scenario)) == scenario  # a repr of ours
    assert replace(scenario) == scenario
    assert type(scenario.order) is Order
    assert type(scenario.closed) is bool


def test_points_of_a_frame_have_headings():
    """An empty cell of the column is free."""
    points = pd.DataFrame({"heading": [1.5, None], "name": ["a", "b"], "x": [4, 6], "y": [1, -2]})

    assert Scenario(**TARGET, via=points).via == ((4.0, 1.0, 1.5), (6.0, -2.0))
    assert Scenario(**TARGET, via=points.assign(heading=["90deg", "free"])).via == (
        *((4.0, 1.0, math.pi / 2), (6.0, -2.0)),
    )


def test_ids_of_older_scenarios_are_what_they_were():
    """Ids of older scenarios are what they were.

    They stand in results folders; what is new has ids of its own.
    """
    old = {
        "1d3d82903d2a36ff": Scenario(**TARGET),
        "b6eb7f75f16cbec6": Scenario(1, 2, "30deg", -3, 4, 2, 0.5, "a"),
        "5e9b7eb505849f13": Scenario(**TARGET, final_heading=-1),
        "2f00f3b733d297d1": Scenario(**TARGET, via=VIA),
        "e6db74c1221f291c": Scenario(**TARGET, via=VIA, final_heading="90deg", label="x"),
    }
    assert [scenario_id(scenario) for scenario in old.values()] == [*old]
    alike = [
        *(*old.values(), *SCENARIOS.values()),
        Scenario(**TARGET, via=[(4, 1), (6, -2, 0)]),
        Scenario(**TARGET, via=[(4, 1, 0), (6, -2)]),
        Scenario(**TARGET, via=[(4, 1, 0), (6, -2)], order="free"),
        Scenario(via=VIA, closed=True),
        Scenario(via=VIA, closed=True, order="free"),
        Scenario(via=VIA, order="free"),
        Scenario(heading=None, via=VIA, order="free"),
    ]
    assert len({scenario_id(scenario) for scenario in alike}) == len(alike)


CELLS = [
    *(("90deg free", [1.5707963267948966, None]), (["free", "90deg"], [None, math.pi / 2])),
    *(([1.0, None], [1.0, None]), ([1.0, math.nan], [1.0, None]), ([pd.NA, 1], [None, 1.0])),
    *((np.array([1.0, np.nan]), [1.0, None]), ([math.nan, math.nan], [None, None])),
    *((empty, [None, None]) for empty in (None, math.nan, pd.NA, "", [])),
]


@pytest.mark.parametrize(("cell", "headings"), CELLS)
def test_cells_of_headings_at_via_points(cell, headings):
    """Cells of headings at via points.

    A row without via points stands beside them.
    """
    frame = pd.DataFrame([TARGET] * 2)
    for name, cells in {"via_x": "4 6", "via_y": "1 -2", "via_heading": cell}.items():
        frame[name] = pd.Series([cells, None], dtype=object)
    points = [(x, y, heading) for (x, y), heading in zip(VIA, headings, strict=True)]

    headed, plain = scenarios(check_frame(frame))

    assert headed == Scenario(**TARGET, via=points)
    assert plain == Scenario(**TARGET)


CLOSED = (
    "target_x is 10, but a closed path ends as it starts; "
    r"leave out target_x or closed \(in a table: an empty cell\)"
)
ROWS = [
    ({"heading": None}, "heading is .*; expected a number, or 'free'"),
    ({"heading": math.nan}, "heading is nan; expected a number, or 'free'"),
    ({"via_heading": "91", "via_x": "4", "via_y": "1"}, "via_heading: 91 is more than a full turn"),
    ({"via_heading": "1", "via_x": "4 6", "via_y": "1 2"}, "via_x has 2 numbers and via_heading"),
    ({"closed": "True", "via_x": "4", "via_y": "1"}, "closed is 'True'; expected true or false"),
    ({"closed": True, "via_x": "4", "via_y": "1"}, CLOSED),
    ({"order": "any"}, "order is 'any'; expected given or free"),
]


@pytest.mark.parametrize(("change", "message"), ROWS)
def test_rows_of_a_frame_that_are_refused(change, message):
    frame = pd.DataFrame([TARGET, TARGET | change], index=["a", "b"]).astype(object)
    for name in {"closed", "order", "heading"} & {*change}:
        frame.loc["a", name] = {"closed": False, "order": "given", "heading": 0.0}[name]

    with pytest.raises(ScenarioError, match=f"^row 'b': {message}"):
        check_frame(frame)


def test_frames_go_round():
    """Frames go round.

    Rows come from columns and from a list of scenarios; they are checked once and twice, and
    solved.
    """
    expected = list(SCENARIOS.values())
    listed = pd.DataFrame(expected)
    listed["heading"] = ["free" if one.heading is None else one.heading for one in expected]

    for frame in (pd.DataFrame(map(scenario_row, expected)), listed):
        checked = check_frame(frame)
        assert list(checked.columns) == list(COLUMNS)
        assert list(scenarios(checked)) == expected
        assert list(scenarios(check_frame(checked))) == expected

    solved = solve_frame(listed)
    assert set(solved["verdict"]) == {"optimal"}
    assert list(scenarios(check_frame(solved[list(COLUMNS)]))) == expected
    assert [scenario_of(each) for each in solved.to_dict("records")] == expected


@every
def test_a_row_keeps_the_scenario_and_the_path(scenario):
    """A row keeps the scenario and the path.

    It goes by way of Arrow, which older readers of a part see as well.
    """
    answer = solve(scenario)
    table = rows_table([dict.fromkeys(names(ROW)) | answer.row()])
    [from_arrow] = table.to_pylist()
    [from_pandas] = table.to_pandas().to_dict("records")

    assert scenario_of(from_arrow) == scenario_of(from_pandas) == scenario
    path = Path(start_of(from_arrow), from_arrow["curvatures"], from_arrow["lengths"])
    assert path.start == answer.path.start
    assert path.end == answer.path.end
    assert from_arrow["visit_order"] == (answer.order if scenario.order is Order.FREE else None)
    given = None if scenario.heading is not None else answer.path.start.heading
    assert from_arrow["start_heading"] == given


def random_scenario(rng):
    """A scenario with or without each optional field."""
    via = rng.uniform(-9, 9, (int(rng.integers(0, 3)), 2)).tolist()
    if rng.random() < 0.3:
        via = [(*point, rng.uniform(-3, 3)) for point in via]
    order = rng.choice(["given", "free"])
    closed = bool(via) and rng.random() < 0.3
    ends = {} if closed or (via and order == "free" and rng.random() < 0.5) else TARGET
    final_heading = 1.0 if ends and rng.random() < 0.5 else None
    heading = None if rng.random() < 0.3 else 0.3
    return Scenario(
        **ends, heading=heading, via=via, order=order, closed=closed, final_heading=final_heading
    )


def test_each_scenario_and_its_row_are_of_one_kind():
    rng = np.random.default_rng(34)
    some = [random_scenario(rng) for _ in range(400)]
    frame = check_frame(pd.DataFrame(map(scenario_row, some)))

    assert list(scenarios(frame)) == some
    kinds = [kind_of(scenario).name for scenario in some]
    assert {*kinds} == {kind.name for kind in KINDS}
    for kind in KINDS:
        assert rows_of(frame, kind).tolist() == [name == kind.name for name in kinds]


def options_of(command):
    """Words of a command by option.

    Those before any are those of the program.
    """
    options: dict[str, list[list[str]]] = {}
    values: list[str] = []
    for word in shlex.split(command):
        if word.startswith("--"):
            values = []
            options.setdefault(word, []).append(values)
        else:
            values.append(word)
    return options


def test_a_command_states_the_question():
    """Text of the command that asks the question.

    `tests/unit/cli` runs commands.
    """
    tour = Scenario(1, 2, "free", 9, -3, via=[(4, 1, 2), (6, -2), (7, 8, "90rad")], order="free")
    command = solve_command(scenario_row(tour) | {"solver": "analytic"})
    closed = solve_command(scenario_row(SCENARIOS["closed tour"]) | {"solver": "analytic"})

    options = options_of(command)
    assert options["--from"] == [["1", "2", "free"]]
    assert options["--via"] == [["4", "1"], ["6", "-2"], ["7", "8"]]
    assert options["--via-heading"] == [["1", "2"], ["3", "90rad"]]
    assert options["--order"] == [["free"]]
    assert "--closed" not in options
    assert command.endswith(" -- 9 -3")
    assert "--closed" in options_of(closed)
    assert " -- " not in closed

"""Scenarios of a file.

They are the same from CSV and Parquet, and every wrong row is named at once.
"""

from collections import defaultdict
from dataclasses import replace

import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.definition.scenario_file import read_scenarios
from dubins_study.experiments.definition.table_file import TableFileError
from dubins_study.experiments.plan import run_plan
from dubins_study.experiments.plan.cells import block_plans
from dubins_study.experiments.plan.run_plan import Request, plan_run
from dubins_study.experiments.plan.scenarios import scenario_id, scenarios
from dubins_study.study.scenario import COLUMNS, Scenario

HEAD = "target_x,target_y,x,y,heading,radius,label,speed\n"
GOOD = (
    HEAD + '10,5,0,0,120deg,1,ahead,\n\n-3,-2,1,1,-pi/3,2,"behind, left",4\n1e0,4,1,1,-0.5,1,,1\n'
)
EXPECTED = [
    Scenario(0, 0, "120deg", 10, 5, 1, 1, "ahead"),
    Scenario(1, 1, "-pi/3", -3, -2, 2, 4, "behind, left"),
    Scenario(1, 1, -0.5, 1, 4, 1, 1, ""),
]


def frame_of(rows):
    return pd.DataFrame([{name: getattr(row, name) for name in COLUMNS} for row in rows])


def written(tmp_path, text, name="drive.csv"):
    file = tmp_path / name
    file.write_bytes(text if isinstance(text, bytes) else text.encode())
    return file


def refusal_of(file):
    with pytest.raises(TableFileError) as error:
        read_scenarios(file)
    return str(error.value).removeprefix(f"{file}: ")


def test_rows_that_repeat_are_counted(tmp_path, caplog):
    """Rows that repeat are asked once, and counted."""
    file = written(tmp_path, f"{HEAD}1,2,0,0,0,1,,1\n1,2,0,0,0,1,,1\n1,3,0,0,0,1,,1\n")

    assert len(read_scenarios(file)) == 3
    assert "of 3 rows 1 repeat an earlier one; each scenario is asked once" in caplog.text


@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_csv_file(tmp_path, mark, end):
    """A CSV file in many forms.

    It has columns in any order, empty lines, quoted labels, Windows' line ends, a byte order mark.
    """
    assert read_scenarios(written(tmp_path, mark + GOOD.replace("\n", end))) == EXPECTED


def test_a_parquet_file(tmp_path):
    """A Parquet file.

    Headings are numbers or texts; a missing speed or label has its default.
    """
    file = tmp_path / "drive.parquet"
    frame = frame_of(EXPECTED)
    frame.drop(columns=["speed"]).assign(label=["ahead", None, ""]).to_parquet(file)

    expected = [(*s.start, s.target_x, s.target_y, s.radius) for s in EXPECTED]
    read = read_scenarios(file)
    assert [(*s.start, s.target_x, s.target_y, s.radius) for s in read] == expected
    assert [(s.speed, s.label) for s in read] == [(1, "ahead"), (1, ""), (1, "")]


WRONG = (
    HEAD
    + '10,5,0,0,120,1,a,\n3,nan,,0,pi/3,-2,"b\n c",0\n1_0,2,3,3,five,1e200,,1\n'
    + "1e20,2,0,0,0,1,,\n1,2,3,east,0,1,,\n"
)
MISTAKES = [
    "line 3: a text goes on to line 4; expected each row on a line of its own: is a quotation",
    "line 2: heading: 120 is more than a full turn; write 120deg, or 120rad, "
    "counterclockwise from +x (east), so north is 90deg",
    "line 5: target_x is '1_0'; expected a number",
    "line 6: radius is 1.0; expected at least 1e+07 beside coordinates of size 1e+20, or the",
    "line 7: y is 'east'; expected a number",
]


def test_every_wrong_row_is_named(tmp_path):
    """Every wrong row is named.

    Its first mistake is told, with line, column, value and rule; a text of two lines is no row.
    """
    head, *lines = refusal_of(written(tmp_path, WRONG)).splitlines()

    assert head == f"{len(MISTAKES)} mistakes"
    for line, expected in zip(lines, MISTAKES, strict=True):
        assert line.startswith(f"  {expected}")


def test_columns_may_be_left_out(tmp_path):
    """Columns may be left out.

    Then a scenario has its defaults, and a frame; an empty cell of such a column is refused.
    """
    pd.DataFrame({"target_y": [5], "target_x": [10.5]}).to_parquet(tmp_path / "a.parquet")
    files = tmp_path / "a.parquet", written(tmp_path, "target_x,target_y\n10.5,5\n")

    for file in files:
        assert read_scenarios(file) == [Scenario(target_x=10.5, target_y=5)]
    for name in ("x", "y", "heading", "radius"):
        text = f"target_x,{name},target_y\n3,,4\n"
        assert f"line 2: {name} is empty; expected a number" in refusal_of(written(tmp_path, text))


def test_other_columns_are_passed_over(tmp_path, caplog):
    """Other columns are passed over and named.

    A row has no place for them; a name that is near a missing one is a slip.
    """
    text = "name,target_x,target_y,height\nfirst,10.5,5,30\n"

    assert read_scenarios(written(tmp_path, text)) == [Scenario(target_x=10.5, target_y=5)]
    assert "columns that are passed over: name, height" in caplog.text
    assert "did you mean 'radius'" in refusal_of(written(tmp_path, text.replace("name", "radus")))


def test_the_rows_of_parquet_are_counted_from_one(tmp_path):
    """The rows of Parquet are counted from one.

    A heading that is a number is read as a text would be.
    """
    frame = frame_of(EXPECTED).assign(radius=[1, 1, None], heading=[6.28, 90, 1])
    frame.to_parquet(tmp_path / "a.parquet")

    assert refusal_of(tmp_path / "a.parquet").splitlines()[1:] == [
        "  row 2: heading: 90.0 is more than a full turn; write 90.0deg, or 90.0rad, "
        "counterclockwise from +x (east), so north is 90deg",
        "  row 3: radius is empty; expected a number",
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "missing columns 'target_x', 'target_y'; expected"),
        ("x,y\n", "missing columns 'target_x', 'target_y'; expected"),
        ("x,y,target_x,radius\n", "missing column 'target_y'; expected"),
        (HEAD, "no scenarios; expected a row each"),
        (HEAD.replace(",", ";"), "the columns are separated by semicolons; expected commas"),
        (HEAD.replace("heading", "headng"), "unknown column 'headng'; did you mean 'headi"),
        (HEAD.replace("speed", "x"), "column 'x' appears twice"),
        (HEAD + "1,2,3\n", "line 2: y is empty; expected a number"),
        (HEAD + "1,2,3,4,5,6,7,8,9\n", "line 2: 9 cells; expected 8, as in line 1"),
        (
            HEAD + '1,2,"3',
            "line 2: unexpected end of data; expected each row on a line of its own: ",
        ),
        (HEAD + '1,2,0,0,0,1,"a\n3,4,0,0,0,1,b"\n', "line 2: a text goes on to line 3; expected"),
        (HEAD.encode() + b"\xff", "cannot be read: it is not UTF-8 text"),
    ],
)
def test_a_file_that_is_no_table(tmp_path, text, message):
    assert message in refusal_of(written(tmp_path, text))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a.txt", "expected a name ending in .csv or .parquet"),
        ("none.csv", "cannot be read: No such file"),
        ("folder.csv", "cannot be read: Is a directory"),
        ("text.parquet", "cannot be read"),
    ],
)
def test_a_file_that_cannot_be_read(tmp_path, name, message):
    (tmp_path / "folder.csv").mkdir()
    written(tmp_path, "no Parquet", "text.parquet")

    assert message in refusal_of(tmp_path / name)


@given(
    content=st.binary(max_size=200),
    head=st.booleans(),
    suffix=st.sampled_from([".csv", ".parquet"]),
)
def test_any_bytes_are_read_or_refused(content, head, suffix, tmp_path_factory):
    """Any bytes are read or refused.

    One refusal names the file, with no control character of the file's.
    """
    file = tmp_path_factory.getbasetemp() / f"any{suffix}"
    file.write_bytes(HEAD.encode() + content if head else content)
    try:
        assert len(read_scenarios(file))
        return
    except TableFileError as error:
        message = str(error)
    assert message.startswith(str(file))
    assert all(line.isprintable() for line in message.splitlines())


def test_the_cells_of_a_file(tmp_path):
    """The cells of a file.

    Chosen solvers, or those of an experiment, are asked about exactly these scenarios.
    """
    file = written(tmp_path, GOOD)
    alone = plan_run(Request(scenarios=file, solvers=["slsqp", "analytic"]))
    paper = plan_run(Request("paper", scenarios=file))

    for plan in (alone, paper):
        cells = [cell for chain in plan.chains for cell in chain]
        assert {cell.scenario for cell in cells} == set(EXPECTED)
        assert str(plan.folder) == "results/drive"
    assert len(alone.keys) == 6
    assert set(paper.solver_specs) <= set(plan_run(Request("paper")).solver_specs)
    assert "--scenarios" in Request(scenarios=file, solvers=["slsqp"]).command()


def test_other_scenarios_are_another_experiment(tmp_path):
    """Other scenarios are another experiment.

    The text that a results folder keeps tells the scenarios apart.
    """
    file = written(tmp_path, GOOD)
    texts = [
        plan_run(Request(scenarios=file, solvers=[s])).experiment_file.text
        for s in ("slsqp", "nlp")
    ]
    written(tmp_path, GOOD.replace("10,5", "10,6"))
    texts.append(plan_run(Request(scenarios=file, solvers=["nlp"])).experiment_file.text)

    assert texts[0] == texts[1] != texts[2]


def asked_of(plan):
    """Time limit (s) of each id and branch.

    They are those of a plan's scenarios.
    """
    cells = [cell for chain in plan.chains for cell in chain]
    return {(cell.scenario_id, cell.branch): cell.time_limit_s for cell in cells}


def sample_of(suite, tmp_path, every):
    """A suite's sample in a file, and its limits.

    It says how the suite asks these scenarios.
    """
    suite_cells = plan_run(Request(suite, solvers=["analytic"])).chains
    chosen = {cell.scenario_id: cell.scenario for chain in suite_cells for cell in chain}
    ids = [*chosen][::every]
    file = tmp_path / "sample.parquet"
    frame_of([chosen[each] for each in ids]).to_parquet(file)
    asked = asked_of(plan_run(Request(suite, solvers=["analytic"])))
    return file, {key: limit for key, limit in asked.items() if key[0] in ids}


@pytest.mark.parametrize(
    ("suite", "different"),
    [("benchmark-route", {1.0, 3.0, 10.0}), ("benchmark-leg", {"best", "LS", "RS", "LR", "RL"})],
)
def test_a_sample_of_a_suite_is_asked_as_the_suite_asks(tmp_path, caplog, suite, different):
    """A suite's sample is asked as in the suite.

    It has the time limit and the branches of each question; a limit that is given replaces all.
    """
    file, expected = sample_of(suite, tmp_path, 3)
    asked = asked_of(plan_run(Request(suite, scenarios=file, solvers=["analytic"])))
    given = asked_of(plan_run(Request(suite, scenarios=file, solvers=["analytic"], time_limit=7.0)))

    assert asked == expected
    assert different <= {*expected.values(), *(branch for _, branch in expected)}
    assert given == dict.fromkeys(expected, 7.0)
    assert not caplog.records


@pytest.mark.parametrize("suite", ["benchmark-route", "benchmark-tour", "benchmark-leg"])
def test_no_question_of_a_suite_has_two_limits(suite):
    """No question of a suite has two limits.

    The key of a row has no limit: of one solver and scenario only one row would be kept.
    """
    limits = defaultdict(set)
    for plan in block_plans(read(suite).experiment):
        ids = [scenario_id(each) for each in scenarios(plan.block, plan.key)]
        for solver in plan.solvers:
            for each in ids:
                limits[each, solver.spec, plan.branches].add(plan.time_limit_s)

    assert len(limits) > 500
    assert {len(each) for each in limits.values()} == {1}


def test_scenarios_that_are_none_of_a_suite_have_its_general_limit(tmp_path, caplog):
    """Scenarios of no suite have the general limit.

    The message says how many there are; the others keep theirs.
    """
    file, expected = sample_of("benchmark-route", tmp_path, 3)
    frame = pd.concat([pd.read_parquet(file), frame_of(EXPECTED_ROUTES[:2])])
    frame.to_parquet(file)
    asked = asked_of(plan_run(Request("benchmark-route", scenarios=file, solvers=["analytic"])))

    assert expected.items() <= asked.items()
    assert [asked[key] for key in asked.keys() - expected.keys()] == [10.0, 10.0]
    message = f"2 of {len(frame)} scenarios are none of benchmark-route; they are asked with its"
    assert message in caplog.text


ROUTES = (
    "x,y,heading,target_x,target_y,radius,via_x,via_y,final_heading\n"
    "0,0,30deg,10,5,1,4 6,1 -2,90deg\n0,0,0,10,5,1,4,1,\n0,0,0,10,5,1,,,\n"
)
EXPECTED_ROUTES = [
    Scenario(
        heading="30deg", target_x=10, target_y=5, via=[(4, 1), (6, -2)], final_heading="90deg"
    ),
    Scenario(target_x=10, target_y=5, via=[(4, 1)]),
    Scenario(target_x=10, target_y=5),
]


def test_routes_of_a_file(tmp_path):
    """Routes of a file.

    They are the same from CSV, and from lists of Parquet; a row that repeats is counted.
    """
    frame_of(EXPECTED_ROUTES).to_parquet(tmp_path / "a.parquet")

    assert read_scenarios(written(tmp_path, ROUTES)) == EXPECTED_ROUTES
    assert read_scenarios(tmp_path / "a.parquet") == EXPECTED_ROUTES


def test_routes_that_repeat_are_counted(tmp_path, caplog):
    read_scenarios(written(tmp_path, ROUTES + "0,0,0,10,5,1,4.0,1,\n0,0,0,10,5,1,4,2,\n"))
    assert "of 5 rows 1 repeat an earlier one" in caplog.text


def test_every_wrong_route_is_named(tmp_path):
    head, *_ = ROUTES.splitlines()
    rows = ["4 x,1 -2,", "4 6,1,", '"[4, 6]",1 2,', "4,1,120", "0,0,", "4,nan,east"]
    text = "\n".join([head, *(f"0,0,0,10,5,1,{row}" for row in rows)])

    assert refusal_of(written(tmp_path, text)).splitlines()[1:] == [
        "  line 2: via_x is '4 x'; expected numbers separated by spaces, such as 4 6",
        "  line 3: via_x has 2 numbers and via_y has 1; expected as many",
        "  line 4: via_x is '[4, 6]'; expected numbers separated by spaces, such as 4 6",
        "  line 5: final_heading: 120 is more than a full turn; write 120deg, or 120rad, "
        "counterclockwise from +x (east), so north is 90deg",
        "  line 6: via point 1 is (0.0, 0.0), the same point as the one before it; expected a "
        "point apart from the points before and after it",
        "  line 7: via_y is nan; expected a finite number of size up to 1e+150",
    ]


def test_files_with_other_routes_have_another_comment(tmp_path):
    """Files with other routes have another comment.

    A results folder knows its scenarios by it; without routes it is what it was.
    """
    plain = EXPECTED_ROUTES[2]
    via = replace(plain, via=[(4, 1)])
    posed = replace(plain, final_heading=1)
    files = ([plain, plain], [via, plain], [plain, via], [posed, plain])

    assert len({run_plan._comment_on(file) for file in files}) == 4


def test_an_experiment_without_scenarios_is_asked_about_a_file(tmp_path):
    """An experiment may lack scenarios.

    A file has them then.
    """
    (tmp_path / "mine.toml").write_text('title = "t"\nquestion = "q"\nsolvers = ["analytic"]\n')
    plan = plan_run(Request(tmp_path / "mine.toml", scenarios=written(tmp_path, GOOD)))

    assert {cell.scenario for chain in plan.chains for cell in chain} == set(EXPECTED)
    assert plan.experiment_file.experiment.title == "t: scenarios of drive"

"""A suite as files, and other programs' judged answers."""

import csv
import json
import shutil
import subprocess
from pathlib import Path

import casadi
import numpy as np
import pyscipopt
import pytest

from dubins_study.experiments.definition.experiment import read
from dubins_study.experiments.judge import COLUMNS, AnswersError, judge_answers
from dubins_study.experiments.plan.questions import questions
from dubins_study.experiments.reference_set import export_suite
from dubins_study.report.data.results import load_results
from dubins_study.solvers.export import ExportError
from dubins_study.solvers.protocol import Question
from dubins_study.solvers.registry import load
from dubins_study.study.closed_form.shortest import shortest

SOURCE = Path(__file__).parents[3] / "examples" / "judge" / "turn_straight.cpp"
HEAD = 'title = "T"\nquestion = "Q?"\nsolvers = ["analytic"]\ntime_limit_s = 5\n'
LEGS = """
[[scenarios]]
target_x = [3, 6.5]
target_y = 2
branches = ["best", "LR", "RS"]
"""
ROUTES = """
[[scenarios]]
label = "far apart"
[scenarios.route]
legs = [1, 2]
spacing = "4R-20R"
count = 2
seed = 5
"""
FREE_START = """
[[scenarios]]
heading = "free"
via = [[4, 1]]
target_x = 9
target_y = 2
"""
TOUR = """
[[scenarios]]
label = "tour"
[scenarios.tour]
points = 4
density = "3R"
count = 1
seed = 3
"""


def suite(folder, *blocks):
    """The path of an experiment with these scenarios."""
    file = folder / "small.toml"
    file.write_text(HEAD + "".join(blocks))
    return str(file)


def instances(folder):
    with (folder / "instances.csv").open(newline="") as text:
        return list(csv.DictReader(text))


def write_answers(file, rows):
    """Write a file of answers as another program might.

    It has only the columns that the rows have.
    """
    with file.open("w", newline="") as text:
        writer = csv.DictWriter(text, list(dict.fromkeys(name for row in rows for name in row)))
        writer.writeheader()
        writer.writerows(rows)
    return file


def known(row, **more):
    """The best path of an instance as an answer."""
    return {name: row[name] for name in ("id", "curvatures", "lengths", "start_heading")} | more


def test_ids_follow_from_the_question_and_not_from_its_place(tmp_path):
    """Ids follow from the question, not its place.

    Other blocks before and after leave the ids as they are; each branch has one of its own.
    """
    alone = questions(read(suite(tmp_path, LEGS)).experiment)
    among = questions(read(suite(tmp_path, ROUTES, LEGS, TOUR)).experiment)

    assert len(alone) == 2 * 3
    assert alone.items() <= among.items()
    assert {id_.rpartition("-")[2] for id_ in alone} == {"best", "LR", "RS"}


def test_the_best_paths_of_a_suite_are_judged_optimal(tmp_path):
    """The best paths of a suite are judged optimal.

    They are written to a table and read back, as text: legs, routes, a free start, a tour.
    """
    file = suite(tmp_path, LEGS, ROUTES, FREE_START, TOUR)
    export_suite(file, "disjunctive", tmp_path / "set")
    rows = instances(tmp_path / "set")
    reached = [row for row in rows if row["lengths"]]
    answers = [known(row, claim="optimal", bound=row["reference_low"]) for row in reached]
    answers += [{"id": row["id"], "claim": "infeasible"} for row in rows if not row["lengths"]]

    judgements = judge_answers(write_answers(tmp_path / "copy.csv", answers), file)

    verdicts = dict(zip(judgements["id"], judgements["verdict"], strict=True))
    assert {verdicts[row["id"]] for row in reached} == {"optimal"}
    assert {verdicts[row["id"]] for row in rows if not row["lengths"]} == {"none exists"}
    assert not judgements["false_claim"].any()
    assert not judgements["false_bound"].any()
    assert {row["open"] for row in rows} == {"false"}
    for row in reached:
        assert float(row["reference_low"]) <= float(row["length"]) * (1 + 1e-12)
        assert sum(map(float, row["lengths"].split())) == pytest.approx(float(row["length"]))


def test_the_table_of_legs_has_the_closed_form(tmp_path):
    """The table of legs has the closed form.

    The length of each word that exists is checked by formulas that know nothing of the table.
    """
    file = suite(tmp_path, LEGS)
    export_suite(file, "disjunctive", tmp_path / "set")
    asked = questions(read(file).experiment)

    for row in instances(tmp_path / "set"):
        optimum = shortest(asked[row["id"]].scenario, row["branch"])
        length = float(row["length"]) if row["length"] else None
        expected = None if optimum is None else pytest.approx(optimum.total, rel=1e-12)
        assert length == expected


def test_nl_files_of_routes_are_solved_to_lengths_in_the_interval(tmp_path):
    """NL files of routes lead into the interval.

    casadi's reader of NL files and Ipopt solve them, from the file's own first point.
    """
    export_suite(suite(tmp_path, ROUTES), "route-nlp", tmp_path / "set")
    for row in instances(tmp_path / "set"):
        file = casadi.NlpBuilder()
        file.import_nl(str(tmp_path / "set" / row["files"]))
        problem = {"x": casadi.vertcat(*file.x), "f": file.f, "g": casadi.vertcat(*file.g)}
        quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes"}}
        solver = casadi.nlpsol("solver", "ipopt", problem, quiet)
        solution = solver(
            x0=file.x_init, lbx=file.x_lb, ubx=file.x_ub, lbg=file.g_lb, ubg=file.g_ub
        )

        assert solver.stats()["success"]
        assert float(solution["f"]) == pytest.approx(float(row["reference_high"]), rel=1e-6)


def test_scip_proves_the_disjunctions_file_within_the_interval(tmp_path):
    """SCIP's own reader of the file that Pyomo wrote."""
    one = "\n[[scenarios]]\ntarget_x = 3\ntarget_y = 2\nradius = 2\n"
    export_suite(suite(tmp_path, one), "disjunctive", tmp_path / "set")
    [row] = instances(tmp_path / "set")
    scip = pyscipopt.Model()
    scip.hideOutput()
    scip.readProblem(str(tmp_path / "set" / row["files"]))

    scip.optimize()

    assert scip.getStatus() == "optimal"
    assert 2 * scip.getDualbound() == pytest.approx(float(row["reference_low"]), rel=1e-4)


@pytest.mark.parametrize("spec", ["tour-milp[headings=4]", "heading-milp[headings=8]"])
def test_mps_files_have_the_optimum_of_their_grid(spec, tmp_path):
    """MPS files have the optimum of their grid.

    SCIP's reader and search find it; HiGHS, by the solver, has the same; no grid beats the
    interval.
    """
    file = suite(tmp_path, TOUR if "tour" in spec else ROUTES)
    export_suite(file, spec, tmp_path / "set")
    asked = questions(read(file).experiment)
    row = instances(tmp_path / "set")[-1]
    scip = pyscipopt.Model()
    scip.hideOutput()
    scip.readProblem(str(tmp_path / "set" / row["files"]))

    scip.optimize()

    solver = load(spec)
    answer = solver.solve(solver.build(Question(asked[row["id"]].scenario)), 20)
    assert scip.getStatus() == "optimal"
    assert scip.getObjVal() == pytest.approx(answer.claimed_length, rel=1e-6)
    assert scip.getObjVal() >= float(row["reference_low"]) * (1 - 1e-9)


def test_instances_that_a_formulation_does_not_take_stay_in_the_table(tmp_path):
    exported = export_suite(suite(tmp_path, LEGS, ROUTES), "paper", tmp_path / "set")

    without = [row for row in instances(tmp_path / "set") if not row["files"]]
    assert exported.instances == 10
    assert {row["id"] for row in without} == set(exported.left_out)
    assert exported.files == 2 * (exported.instances - len(without))


@pytest.mark.parametrize(
    ("formulation", "message"),
    [
        ("joint", "formulation is 'joint'; expected one of: paper, route-nlp"),
        ("route-nlq", "did you mean 'route-nlp'"),
        ("tour-milp[model=cuts]", "adds rows while it runs; expected flow or mtz"),
        ("paper", "has no question for paper"),
    ],
)
def test_formulations_that_cannot_be_written_are_refused(formulation, message, tmp_path):
    with pytest.raises(ExportError, match=message.replace("[", r"\[")):
        export_suite(suite(tmp_path, TOUR), formulation, tmp_path / "set")


@pytest.fixture(scope="module")
def legs(tmp_path_factory):
    """A suite of legs and its table's rows."""
    folder = tmp_path_factory.mktemp("legs")
    file = suite(folder, LEGS)
    export_suite(file, "disjunctive", folder / "set")
    return file, instances(folder / "set")


def test_false_claims_and_bounds_are_counted_by_method(legs, tmp_path):
    """False claims and bounds are counted by method.

    One program overstates what it knows, the other does not; questions left out are rows.
    """
    file, rows = legs
    best = next(row for row in rows if row["branch"] == "best")
    turn = f"{2 * np.pi!r} {best['lengths']}"
    detour = {"id": best["id"], "curvatures": f"1 {best['curvatures']}", "lengths": turn}
    high = float(best["reference_high"])
    answers = [
        detour | {"method": "proud", "claim": "optimal", "bound": 1.01 * high},
        detour | {"method": "modest", "claim": "feasible", "bound": 0.9 * high},
    ]

    judgements = judge_answers(
        write_answers(tmp_path / "a.csv", answers), file, out=tmp_path / "out"
    )

    proud, modest = (judgements[judgements["solver"] == name] for name in ("proud", "modest"))
    assert (proud["false_claim"].sum(), proud["false_bound"].sum()) == (1, 1)
    assert (modest["false_claim"].sum(), modest["false_bound"].sum()) == (0, 0)
    for rows in (proud, modest):
        assert rows["verdict"].value_counts().to_dict() == {"none": 5, "longer": 1}
    stored = load_results(tmp_path / "out")
    assert stored["outcome"].value_counts().to_dict() == {"not_asked": 10, "returned": 2}
    assert set(stored["solver"]) == {"proud", "modest"}
    assert stored["false_bound"].sum() == 1


def test_the_same_answers_are_kept_once_and_other_ones_replace_them(legs, tmp_path):
    file, rows = legs
    [first, *_] = (row for row in rows if row["lengths"])
    answers = write_answers(tmp_path / "mine.csv", [known(first)])
    for _ in range(2):
        judge_answers(answers, file, out=tmp_path / "out")
    assert len(load_results(tmp_path / "out")) == len(rows)

    nothing = dict.fromkeys(("curvatures", "lengths"), "")
    write_answers(answers, [{"id": first["id"], "claim": "failed"} | nothing])
    judge_answers(answers, file, out=tmp_path / "out")

    stored = load_results(tmp_path / "out")
    assert len(stored) == len(rows)
    assert "failed" in set(stored["claim"])
    assert "optimal" not in set(stored["verdict"])


def test_json_and_csv_are_judged_alike(legs, tmp_path):
    """JSON and CSV are judged alike.

    Lists are numbers in one, texts in the other; what is told as seconds is the time.
    """
    file, rows = legs
    answers = [known(row, seconds=0.25) for row in rows if row["lengths"]]
    listed = [
        {name: answer[name] for name in ("id", "seconds")}
        | {name: list(map(float, answer[name].split())) for name in ("curvatures", "lengths")}
        for answer in answers
    ]
    (tmp_path / "same.json").write_text(json.dumps(listed))

    of_csv = judge_answers(write_answers(tmp_path / "same.csv", answers), file)
    of_json = judge_answers(tmp_path / "same.json", file)

    columns = ["id", "solver", "verdict", "length", "gap", "wall_s"]
    assert of_csv[columns].equals(of_json[columns])
    assert of_csv["wall_s"].dropna().unique().tolist() == [0.25]


GOOD = {"curvatures": "1 0", "lengths": "1 2"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"id": "0123-best"}, "line 2: id is '0123-best'; expected an id of the suite's instances"),
        ({"curvatures": "1"}, "line 2: curvatures has 1 numbers and lengths 2; expected as many"),
        ({"lengths": ""}, "line 2: curvatures has 2 numbers and lengths 0"),
        ({"lengths": "1 inf"}, "line 2: lengths.1 is 'inf': expected a finite number"),
        ({"curvatures": "1 nan"}, "line 2: curvatures.1 is 'nan': expected a finite number"),
        ({"lengths": "1;2"}, "line 2: lengths.0 is '1;2': expected a valid number"),
        ({"claim": "proved"}, "line 2: claim is 'proved': expected 'optimal', 'local'"),
        ({"bound": "nan"}, "line 2: bound is 'nan': expected a finite number"),
        ({"seconds": "-1"}, "line 2: seconds is '-1': expected greater than or equal to 0"),
        ({"start_heading": "1"}, "line 2: start_heading is 1.0; expected it empty"),
        ({"method": "nlp[engine=x]"}, "line 2: method is 'nlp.*': String should match"),
        (
            {"method": "analytic"},
            "line 2: method is 'analytic', a solver of ours; expected another",
        ),
        ({"claims": "local"}, "unknown column 'claims'; did you mean 'claim'"),
    ],
)
def test_what_is_wrong_in_a_line_is_named(change, message, legs, tmp_path):
    file, rows = legs
    answers = write_answers(tmp_path / "bad.csv", [{"id": rows[0]["id"]} | GOOD | change])

    with pytest.raises(AnswersError, match=f"bad.csv: {message}"):
        judge_answers(answers, file, out=tmp_path / "out")

    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", "", "missing columns 'id', 'curvatures', 'lengths'"),
        ("a.csv", "id,curvatures,lengths\n", "no answers; expected a row each"),
        ("a.csv", "id,curvatures\nx,1\n", "missing column 'lengths'"),
        ("a.json", "{", "Invalid JSON: .* line 1 column 1"),
        ("a.json", "[1]", "0 is 1: expected a table; expected a list of objects"),
        ("a.json", '[{"id": 3}]', "answer 1: id is 3: expected a valid string"),
        ("a.json", '[{"id": "x", "lengths": {}}]', r"lengths: expected a valid list"),
    ],
)
def test_files_that_hold_no_answers_are_refused(name, text, message, legs, tmp_path):
    (tmp_path / name).write_text(text)

    with pytest.raises(AnswersError, match=message):
        judge_answers(tmp_path / name, legs[0])


def test_a_second_answer_to_a_question_is_refused(legs, tmp_path):
    file, rows = legs
    same = {"id": rows[0]["id"]} | GOOD
    answers = write_answers(tmp_path / "twice.csv", [same, same])

    with pytest.raises(AnswersError, match=r"line 3: id .* of method twice is in line 2 already"):
        judge_answers(answers, file)


def test_a_suite_of_convex_problems_has_no_paths_to_judge(tmp_path):
    with pytest.raises(AnswersError, match="points of convex problems; expected one of paths"):
        judge_answers(tmp_path / "none.csv", "convex")


@pytest.mark.skipif(shutil.which("g++") is None, reason="no C++ compiler")
def test_a_program_in_another_language_takes_part(tmp_path):
    """A program in another language takes part.

    Far from the start its turn and straight line are the shortest path of one leg.

    Past a via point they may be longer, but pass every point; it leaves other questions out.
    """
    file = suite(tmp_path, LEGS, ROUTES, FREE_START, TOUR)
    export_suite(file, "disjunctive", tmp_path / "set")
    program = tmp_path / "turn_straight"
    subprocess.run(["g++", "-std=c++17", "-o", program, SOURCE], check=True)
    table = (tmp_path / "set" / "instances.csv").read_text()
    done = subprocess.run([program], input=table, capture_output=True, text=True, check=True)
    (tmp_path / "cpp.csv").write_text(done.stdout)

    judgements = judge_answers(tmp_path / "cpp.csv", file)

    best = judgements[judgements["branch"] == "best"]
    one_leg = best["via_x"].isna()
    assert set(best["verdict"][one_leg]) == {"optimal"}
    assert set(best["verdict"][~one_leg]) <= {"optimal", "longer"}
    assert set(judgements["verdict"][judgements["branch"] != "best"]) == {"none"}
    assert not judgements["false_claim"].any()


def test_the_columns_are_those_that_the_documentation_names():
    """The documentation names the columns of answers.

    The page for other programs has each column of a file of answers.
    """
    page = (SOURCE.parents[2] / "docs" / "reference-set.md").read_text()

    assert [name for name in COLUMNS if f"| `{name}` |" not in page] == []


def test_a_folder_with_other_files_is_not_written_to(tmp_path):
    """An export replaces an earlier one, and nothing else."""
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "instances.csv").write_text("precious\n")
    file = suite(tmp_path, LEGS)

    with pytest.raises(ExportError, match=r"holds 'instances.csv', no export"):
        export_suite(file, "paper", folder)
    assert (folder / "instances.csv").read_text() == "precious\n"
    for _ in range(2):
        assert export_suite(file, "paper", tmp_path / "new").files


def test_a_label_of_two_lines_is_read_back(tmp_path):
    """So is an answer of ten thousand arcs."""
    file = suite(
        tmp_path,
        'label = "of\\ntwo lines"'.join(("\n[[scenarios]]\n", "\ntarget_x = 4\ntarget_y = 1\n")),
    )
    folder = export_suite(file, "paper", tmp_path / "set").folder
    text = (folder / "instances.csv").read_text().splitlines()
    arcs = " ".join(["0.25"] * 30_000)
    longer = tmp_path / "longer.csv"
    id_ = text[1].partition(",")[0]
    longer.write_text(f"id,curvatures,lengths\n{id_},{arcs},{arcs}\n")

    assert len(judge_answers(folder / "instances.csv", file)) == 1
    assert judge_answers(longer, file)["verdict"].tolist() == ["misses"]

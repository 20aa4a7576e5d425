"""The section on tours, by hand.

It shows which tours close, and proved tours against others.
"""

import math

import pandas as pd
import pytest

from dubins_study import solve
from dubins_study.report.data.results import load
from dubins_study.report.topics.single_attempts import sample
from dubins_study.report.topics.tours import (
    against_proof,
    asked_of_most,
    by_engine,
    by_kind,
    by_points,
    closed_within,
    tours_section,
    with_points,
)
from dubins_study.solvers.statuses import STATUSES
from dubins_study.study.kinds.shortest import shortest_route
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, lost
from tests.unit.report.test_single_attempts import unpacked
from tests.unit.report.topic_page import topic_page

DENSE, SPARSE = "1.5 R sqrt(n)", "8 R sqrt(n)"
EXACT, GRID, BOUNDS = "analytic", "tour-milp", "tour-milp[costs=bounds]"
METHODS = {
    EXACT: ("closed form", "closed form"),
    GRID: ("tour MILP", "HiGHS"),
    "tour-milp[engine=scip]": ("tour MILP", "SCIP"),
    BOUNDS: ("tour MILP", "HiGHS"),
    "tour-order": ("order then headings", "dynamic programming"),
    "tour-order[order=alternating]": ("order then headings", "dynamic programming"),
}
SETTINGS = {
    GRID: {"costs": "lengths", "headings": 8, "polish": False},
    "tour-milp[engine=scip]": {"costs": "lengths", "headings": 8, "polish": False},
    BOUNDS: {"costs": "bounds", "headings": 8, "polish": False},
    "tour-order": {"order": "euclidean"},
    "tour-order[order=alternating]": {"order": "alternating"},
}


def tour(n=2, **changes):
    """Points on a line, then the target."""
    via = [(2.0 + i, 5.0 - i) for i in range(n)]
    return Scenario(**{"target_x": 9, "target_y": 1, "via": via, "order": "free", **changes})


def row(name, solver, scenario=None, *, gap=0.0, order=(0, 1), solved=False, **changes):
    """A judged attempt at a tour of 3 points."""
    formulation, engine = METHODS[solver]
    exact = solver == EXACT
    status = "kOptimal" if solved else "kTimeLimit"
    given = {
        "scenario_id": name,
        "claim": Claim.OPTIMAL if exact and solved else Claim.FEASIBLE,
        "verdict": "optimal" if gap < 1e-6 else "longer",
        "native_status": "" if exact else status,
        "label": DENSE,
        "visit_order": list(map(float, order)),
        **{"gap": gap, "formulation": formulation, "engine": engine, "wall_s": 0.5},
        **{"reference_low": 10.0, "reference_high": 10.0, "false_bound": False},
    }
    line = attempt(scenario or tour(), solver, path=None, claim=Claim.NONE)
    return line | given | changes


def rows():
    """Rows of three tours.

    Of tour a the search has a proof, of b none; of c, closed, it has one.
    """
    back = tour(3, closed=True, target_x=None, target_y=None)
    return [
        row("a", EXACT, solved=True, lower_bound=10.0),
        row("b", EXACT, gap=0.2, lower_bound=5.0),
        row("c", EXACT, back, order=(2, 0, 1), solved=True, lower_bound=10.0),
        row("a", GRID, gap=0.04, solved=True),
        row("b", GRID, gap=0.5, solved=True),
        row("c", GRID, back, gap=0.1, order=(1, 0, 2), solved=True),
        row("a", "tour-milp[engine=scip]", gap=0.04, solved=True),
        row("b", "tour-milp[engine=scip]", gap=0.4),
        row("a", BOUNDS, gap=0.3, order=(1, 0), solved=True, lower_bound=8.0),
        lost(tour(), BOUNDS, scenario_id="b", label=DENSE, formulation="tour MILP"),
        row("a", "tour-order", gap=0.0),
        row("c", "tour-order", back, gap=0.3, order=(0, 1, 2)),
        row("a", "tour-order[order=alternating]", gap=0.6),
    ]


def test_what_closes_by_hand(load_rows):
    """Closed tours by hand.

    A tour closes by a proof of the search, or by an optimum of an engine's own program, each in
    time.
    """
    table = with_points(load_rows("benchmark-tour", rows()).rows)
    cells = by_points(table).set_index(["solver", "label", "points"])

    assert cells.loc[(EXACT, DENSE, 3), ["successes", "trials"]].tolist() == [2, 3]
    assert cells.loc[(EXACT, DENSE, 3), "gap"] == 0.0
    assert cells.loc[(GRID, DENSE, 3), ["successes", "trials"]].tolist() == [3, 3]
    assert cells.loc[(BOUNDS, DENSE, 3), ["successes", "trials"]].tolist() == [1, 2]
    assert cells.loc[(BOUNDS, DENSE, 3), "gap"] == 0.3  # the other attempt has none: infinite
    assert cells.loc[("tour-order", DENSE, 3), ["successes", "trials"]].tolist() == [0, 0]


def test_every_engine_closes_in_its_own_words():
    """Every engine closes in its own words.

    They are those that the table of statuses calls an optimum, and no others.
    """
    for engine in ("highs", "scip", "glpk", "cbc", "cp-sat"):
        for meaning, statuses in STATUSES[engine].items():
            for status in statuses:
                frame = pd.DataFrame([row("a", GRID, native_status=status)]).assign(late=False)
                assert with_points(frame)["closes"].tolist() == [meaning == "optimal"], status


def test_points_do_not_count_the_start():
    """Points do not count the start.

    A tour ends at a target, at any point or at its start.
    """
    three = [
        tour(),
        tour(3, target_x=None, target_y=None),
        tour(3, target_x=None, target_y=None, closed=True),
    ]
    frame = pd.DataFrame([row(str(n), EXACT, each) for n, each in enumerate(three)])

    assert with_points(frame.assign(late=False))["points"].tolist() == [3, 3, 3]


def test_gaps_of_answers_and_bounds(load_rows):
    """Gaps of answers and bounds.

    A missing answer has an infinite gap, and no bound is the bound 0.
    """
    table = by_engine(with_points(load_rows("benchmark-tour", rows()).rows)).set_index("solver")

    assert table.loc[GRID, "gap"] == 0.1
    assert table.loc[BOUNDS, "bound_gap"] == pytest.approx(0.2)  # of 20 % and 100 % the lower
    assert math.isnan(table.loc[GRID, "bound_gap"])
    assert table.loc[EXACT, "closes_text"].startswith("66.7 % of 3")
    assert table.loc["tour-order", "closes_text"] == "–"


def test_what_an_engine_leaves_open_of_its_own_program(load_rows):
    """Gap of an engine's own program.

    Its message tells, in the words of the solver; a lost attempt left all open.
    """
    attempts = rows()
    text = "bound 8, gap 0.25, of bounds over 8 intervals a point"
    attempts[8] |= {"message": text, "memory_mib": 5.0, "false_bound": True}
    table = by_engine(with_points(load_rows("benchmark-tour", attempts).rows)).set_index("solver")

    assert table.loc[BOUNDS, "own_gap"] == pytest.approx(0.25)  # of 25 % and 100 % the lower
    assert math.isnan(table.loc[EXACT, "own_gap"])
    assert table.loc[BOUNDS, "false_bounds"] == 1
    assert table.loc[EXACT, "false_bounds"] == 0


def test_the_words_of_a_solver_tell_its_own_gap():
    """A solver's words tell its own gap.

    The message that `tour-milp` writes is the one that the report reads.
    """
    answer = solve(tour(n=1), "tour-milp[engine=highs,gap=0.5]")
    frame = pd.DataFrame([row("a", GRID, message=answer.message)]).assign(late=False)

    assert 0.0 <= with_points(frame)["own_gap"].item() <= 0.5


def test_what_closes_within_a_second():
    """Tours that close within a second.

    Questions with as long a limit count: a run of 10 s tells of 1 s too, and not of 100 s.
    """
    lines = [
        row("a", GRID, solved=True, wall_s=0.5, limit_s=10.0),
        row("b", GRID, solved=True, wall_s=5.0, limit_s=10.0),
        row("c", GRID, wall_s=100.0, limit_s=100.0),
        row("a", EXACT, solved=True, wall_s=0.2, limit_s=1.0),
    ]
    table = closed_within(with_points(pd.DataFrame(lines).assign(late=False)))

    assert table.loc[GRID].tolist() == ["1/3", "2/3", "0/1"]
    assert table.loc[EXACT, "in_1_s"] == "1/1"
    assert table.loc[EXACT, ["in_10_s", "in_100_s"]].isna().all()


def test_refuted_optima_by_hand(load_rows):
    """Refuted optima by hand.

    Of the grid's two proved optima both are longer than the proved tours, by 4 and 10 %.
    """
    results = load_rows("benchmark-tour", rows())
    table = by_kind(against_proof(with_points(results.rows), SETTINGS)).set_index("kind")
    grid = table.loc["best tour of 8 headings"]

    assert grid["refuted_text"].startswith("100 % of 2")
    assert grid["other_order_text"].startswith("0 % of 2")
    assert (grid["excess"], grid["most"]) == (pytest.approx(0.07), 0.1)
    straight = table.loc["order by straight lines, best headings"]
    assert straight["refuted_text"].startswith("50.0 % of 2")


def test_engines_are_compared_on_the_same_questions(load_rows):
    """Engines are compared on the same questions.

    Tour a is the only one that all six solvers were asked.
    """
    table = asked_of_most(with_points(load_rows("benchmark-tour", rows()).rows))

    assert set(table["scenario_id"]) == {"a"}
    assert table["solver"].nunique() == 6


def test_proved_tours_against_others(load_rows):
    """Proved tours against others.

    Only questions with a proof count; of a grid the optimum; a closed tour may be driven back.
    """
    results = load_rows("benchmark-tour", rows())
    compared = against_proof(with_points(results.rows), SETTINGS)
    gaps = {
        (kind, name): (gap, other)
        for kind, name, gap, other in zip(
            compared["kind"],
            compared["scenario_id"],
            compared["gap"],
            compared["other_order"],
            strict=True,
        )
    }

    assert gaps == {
        ("best tour of 8 headings", "a"): (0.04, False),
        ("best tour of 8 headings", "c"): (0.1, False),  # 1 0 2 is 2 0 1 driven back
        ("order by straight lines, best headings", "a"): (0.0, False),
        ("order by straight lines, best headings", "c"): (0.3, True),
        ("that order, every other leg straight", "a"): (0.6, False),
    }


def test_the_section_says_what_is_proved(load_rows):
    results = load_rows("benchmark-tour", rows())
    section = tours_section(results)

    assert "The search proves 2 of 3 tours" in section.text
    assert "Of 2 proved optima of a grid 2 are longer" in section.text
    assert section.blocks[0].name == "tours"
    written = {text.get_text() for ax in section.blocks[0].figure.axes for text in ax.texts}
    assert {"2/3", "3/3", "1/2"} <= written


def test_a_page_of_tours_of_all_ends(results, tmp_path):
    """A page of tours of all ends.

    There are free starts, closed tours, none arriving: what the page draws and asks again is
    there.
    """
    attempts = []
    for number, changes in enumerate(
        ({}, {"heading": None}, {"target_x": None, "target_y": None, "closed": True})
    ):
        scenario = tour(3, label=SPARSE, **changes)
        path = shortest_route(scenario, limit=1.0).path
        line = attempt(scenario, EXACT, path=path, formulation="closed form")
        attempts.append(line | {"scenario_id": str(number)})
    attempts.append(lost(tour(label=SPARSE), GRID, formulation="tour MILP"))
    folder = results("benchmark-tour", attempts)
    page = topic_page(folder, tmp_path / "out", "tours", "single attempts", "failures")
    loaded = load([folder])
    shown = unpacked(sample(loaded, 10))

    scenarios = shown["scenarios"]
    starts = {row["scenario_id"]: row["start_heading"] for row in attempts}
    order = [scenarios["scenario_id"][place] for place in shown["columns"]["scenario"]]

    assert 'id="tours"' in page.read_text(encoding="utf-8")
    assert scenarios["order"] == ["free"] * 4
    assert scenarios["closed"] == [each == "2" for each in scenarios["scenario_id"]]
    assert sorted(map(str, scenarios["heading"])) == ["0.0", "0.0", "0.0", "None"]
    assert shown["columns"]["start_heading"] == [starts[name] for name in order]
    [free] = loaded.rows.index[loaded.rows["scenario_id"] == "1"]
    assert loaded.path(free).start == (0, 0, starts["1"])

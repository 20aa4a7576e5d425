"""What enters no share: attempts that are undecided, and questions that a solver does not take."""

from __future__ import annotations

import pytest

from dubins_study import load_results
from dubins_study.report.page.render import render
from dubins_study.report.statistics.methods import compared
from dubins_study.report.statistics.metrics import success
from dubins_study.report.topics.existence import existence
from dubins_study.report.topics.failures import failures, failures_section
from dubins_study.report.topics.success import gap_quantiles
from dubins_study.report.topics.summary import solver_summary
from dubins_study.report.two_runs.changes import pairs
from dubins_study.study.words import Claim, Verdict
from tests.unit.report.results_folder import attempt, lost, paper_scenarios


def rows_with(undecided: int) -> list[dict[str, object]]:
    """Three right attempts of a solver, and some that are undecided."""
    scenarios = paper_scenarios()
    rows = [attempt(scenario, "ipopt", claim=Claim.LOCAL) for scenario in scenarios[:3]]
    for scenario in scenarios[3 : 3 + undecided]:
        route = {"via_x": [9.0], "via_y": [9.0], "region": None, "margin": None, "gap": 0.1}
        open_ = {
            "verdict": str(Verdict.UNDECIDED),
            "claim": "optimal",
            "scenario_id": f"{id(route)}",
        }
        rows.append(attempt(scenario, "ipopt", **route | open_))
    return rows


@pytest.mark.parametrize("undecided", [0, 2])
def test_no_share_counts_them(load_rows, undecided):
    results = load_rows("run", rows_with(undecided))
    line = solver_summary(results.attempts).iloc[0]

    assert (line["attempts"], line["questions"], line["right"]) == (3, 3, 3)
    assert line["undecided"] == undecided
    assert line["longer"] == line["false_claims"] == 0
    assert line["right_share"] == 1
    assert failures(results.attempts).empty
    assert existence(results.attempts).empty
    assert success(results.rows).sum() == 3


def test_a_comparison_leaves_them_out(load_rows):
    """A question that was right and is undecided now is not lost."""
    base, new = load_rows("base", rows_with(0)), load_rows("new", rows_with(2)[1:])

    assert len(pairs(base, new)) == 2


def test_they_stand_on_the_page(results):
    folder = results("run", rows_with(2))

    page = render([folder])

    text = page.read_text(encoding="utf-8")
    assert "undecided" in text
    assert (page.parent / "tables" / "summary.csv").exists()


def not_taken(scenario, solver="ipopt"):
    """The row of a solver that was not called."""
    return lost(scenario, solver, outcome="unsupported", label="route", via_x=[9.0], via_y=[9.0])


def test_a_question_that_a_solver_does_not_take_is_no_failure(load_rows, results):
    """All numbers are those of the run in which it was not asked, and a sentence tells them."""
    scenarios = paper_scenarios()
    asked = [attempt(s, "ipopt", claim=Claim.LOCAL) for s in scenarios[:3]]
    asked.append(lost(scenarios[3], "ipopt", outcome="timeout"))
    more = [*asked, *map(not_taken, scenarios[4:])]
    fewer, every = load_rows("fewer", asked), load_rows("every", more)

    for found in (fewer, every):
        line = solver_summary(found.attempts).iloc[0]
        assert (line["attempts"], line["questions"], line["right"]) == (4, 4, 3)
        assert (line["not_returned"], line["right_share"]) == (1, 0.75)
        assert failures(found.attempts)["attempts"].sum() == 1
        assert gap_quantiles(found.attempts)["attempts"].max() == 4
        assert success(found.rows).mean() == compared(found).rows["right"].mean() == 0.75
        assert existence(found.attempts).empty
    assert "3 more questions" not in failures_section(fewer).text
    assert "3 more questions" in failures_section(every).text
    assert len(load_results(results("read", more))) == 7


def test_a_run_of_which_no_question_was_taken_makes_a_page(results):
    page = render([results("run", [not_taken(s) for s in paper_scenarios()])])

    assert "7 more questions" in page.read_text(encoding="utf-8")

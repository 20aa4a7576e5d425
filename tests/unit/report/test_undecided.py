"""Attempts at routes whose interval is too wide to tell: neither right nor wrong, but shown."""

from __future__ import annotations

import pytest

from dubins_study.report.data import verdicts
from dubins_study.report.data.failures import failures
from dubins_study.report.page.render import render
from dubins_study.report.statistics.metrics import success
from dubins_study.report.topics.existence import engine_times
from dubins_study.report.topics.summary import solver_summary
from dubins_study.report.two_runs.changes import pairs
from dubins_study.study.words import Claim, Verdict
from tests.unit.report.results_folder import attempt, paper_scenarios


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
    found = verdicts.existence(results.attempts).iloc[0]
    assert [found[kind] for kind in verdicts.KINDS] == [0] * len(verdicts.KINDS)
    assert engine_times(results.rows).empty
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

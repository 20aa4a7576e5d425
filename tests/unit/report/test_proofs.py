"""The section on proofs of routes.

It has a row for each limit, with numbers by hand.
"""

import math

import pytest

from dubins_study.report.topics.proofs import by_limit, proofs_section
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import attempt, lost, paper_scenarios

SOLVER = "disjunctive"


def row(number, limit, bound, claim=Claim.LIMIT, verdict="optimal", **changes):
    """A judged attempt at a route of two legs.

    Its shortest length is 10.
    """
    given = {"via_x": [1.0], "via_y": [9.0], "formulation": "disjunction", "verdict": verdict}
    given |= {"scenario_id": str(number), "claim": claim, "limit_s": limit, "lower_bound": bound}
    given |= {"reference_low": 10.0, "reference_high": 10.0, "wall_s": limit / 2, "gap": 0.0}
    return attempt(paper_scenarios()[0], SOLVER, **given | changes)


def test_limits_are_apart(load_rows):
    """Limits are apart.

    An attempt that closes in 100 s is none of the row of 10 s; no bound is the bound 0; a late
    answer and a claim that is false close nothing.
    """
    attempts = [
        row(0, 10.0, 8.0),
        row(1, 10.0, None),
        row(2, 10.0, 9.0, Claim.OPTIMAL, "longer"),
        row(3, 100.0, 10.0, Claim.OPTIMAL),
        row(4, 100.0, 9.5, Claim.OPTIMAL, wall_s=200.0),
        row(5, 100.0, 10.5),
        lost(paper_scenarios()[0], SOLVER, scenario_id="6", formulation="headings"),
    ]
    results = load_rows("benchmark-route", attempts)
    table = by_limit(results.rows[results.rows["formulation"] == "disjunction"])
    lines = table.set_index("limit_s")

    assert table["legs"].tolist() == [2, 2]
    assert lines["closed_share"].tolist() == [0.0, pytest.approx(1 / 3)]
    assert lines["bound_gap"].tolist() == [pytest.approx(0.2), 0.0]
    assert lines["wall_s"].tolist() == [5.0, 50.0]
    assert len(proofs_section(results).blocks[0].frame) == 2
    assert not math.isnan(lines["closed_low"].sum())


def test_no_proofs_no_section(load_rows):
    """Rows of other formulations have none."""
    attempts = [row(0, 10.0, 8.0, formulation="headings")]

    assert proofs_section(load_rows("benchmark-route", attempts)) is None

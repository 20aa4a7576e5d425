"""What a proof costs: numbers by hand, and the section."""

from __future__ import annotations

import math

import pytest

from dubins_study.report.topics.proofs import (
    PAPER,
    prices,
    proofs,
    proofs_section,
    proven_gap,
    provers,
)
from dubins_study.study.scenario import Scenario
from dubins_study.study.words import Claim
from tests.unit.report.results_folder import astray, attempt, paper_scenarios

DISC = [Scenario(0, 0, 0, x, 1, 1, label="in a disc") for x in (0.1, 0.2, 0.3)]


def rows():
    """A global solver of 40 ms, a local one of 2 ms on the paper's problems and 20 ms in the disc,
    a faster one that is right on the paper's problems only."""
    made = []
    for scenario in (*paper_scenarios()[:3], *DISC):
        paper = scenario.label != "in a disc"
        bound = attempt(scenario)["length"] * (1 - 1e-7)
        own = {"lower_bound": bound, "false_bound": False, "wall_s": 0.04}
        local = {"claim": Claim.LOCAL, "wall_s": 0.002 if paper else 0.02}
        fast = {
            "claim": Claim.LOCAL,
            "wall_s": 0.001,
            "path": "exact" if paper else astray(scenario),
        }
        made += [
            attempt(scenario, "disjunctive", proof="proved", **own),
            attempt(scenario, "slsqp", proof="proved", **local),
            attempt(scenario, "shooting", proof="proved" if paper else "none", **fast),
        ]
    return made


def test_numbers_by_hand(load_rows):
    """Own bounds, the certificate's words and times; no bound is no proof of one's own."""
    loaded = load_rows("proofs", rows()).rows
    table = proofs(loaded).set_index("solver")

    assert provers(loaded) == ["disjunctive"]
    assert table["own_bound"].to_dict() == {"disjunctive": 1.0, "slsqp": 0.0, "shooting": 0.0}
    assert table.loc["disjunctive", "gap"] == pytest.approx(1e-7)
    assert math.isnan(table.loc["slsqp", "gap"])
    assert table["proved"].to_dict() == {"disjunctive": 6, "slsqp": 6, "shooting": 3}
    assert table.loc["shooting", ["success", "none"]].tolist() == [0.5, 3]


def test_a_price_is_over_the_fastest_right_answer(load_rows):
    """On the paper's problems that is shooting's 1 ms; in the disc, where it is wrong, slsqp's
    20 ms."""
    loaded = load_rows("proofs", rows()).rows
    found = prices(loaded).set_index(["group", "solver"])["ratio"]

    assert found[PAPER, "disjunctive"] == pytest.approx(40)
    assert found[PAPER, "slsqp"] == pytest.approx(2)
    assert found["in a disc", "disjunctive"] == pytest.approx(2)
    assert found["in a disc", "slsqp"] == 1
    assert ("in a disc", "shooting") not in found.index


def test_a_false_bound_proves_nothing(load_rows):
    """It lies above the shortest length, and so below no gap."""
    made = rows()
    made[0] |= {"lower_bound": 2 * made[0]["length"], "false_bound": True}
    loaded = load_rows("proofs", made).rows

    assert math.isnan(proven_gap(loaded)[0])
    assert proofs(loaded).set_index("solver").loc["disjunctive", "own_bound"] == pytest.approx(
        5 / 6
    )


def test_the_section_says_what_the_rows_say(load_rows):
    section = proofs_section(load_rows("proofs", rows()))

    assert "proves 9 of the 12 answers" in section.text

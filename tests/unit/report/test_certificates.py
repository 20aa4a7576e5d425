"""Certificates in the report: numbers by hand, the section, and real rows."""

from __future__ import annotations

import math

import pytest

from dubins_study.report.topics.certificates import certificates_section, proofs
from tests.unit.report.results_folder import attempt, lost, paper_scenarios

PROVED = {
    "proof": "proved",
    "pmp_residual": 1e-15,
    "cut_margin": 0.5,
    "reference_low": 1.0,
    "reference_high": 1.0 + 4e-16,
    "false_bound": False,
}


def rows():
    """One solver proved, with multipliers; one with a bad bound, an extremal and a lost row."""
    first, second, third = paper_scenarios()[:3]
    extremal = {"proof": "extremal", "false_bound": True}
    return [
        attempt(first, "slsqp", costate_error=1e-9, **PROVED),
        attempt(second, "slsqp", costate_error=1e-7, **(PROVED | {"cut_margin": 0.2})),
        attempt(first, "disjunctive", lower_bound=9.0, **(PROVED | extremal)),
        attempt(second, "disjunctive", lower_bound=1.0, **(PROVED | {"proof": "bounded"})),
        lost(third, "disjunctive"),
    ]


def test_numbers_by_hand(load_rows):
    """Counts of each word, a lost row has no proof; worst and least of what is measured."""
    table = proofs(load_rows("tiny", rows()).attempts).set_index("solver")
    words = ["attempts", "proved", "bounded", "extremal", "none"]

    assert table.loc["slsqp", words].tolist() == [2, 2, 0, 0, 0]
    assert table.loc["disjunctive", words].tolist() == [3, 0, 1, 1, 1]
    assert table.loc["slsqp", "pmp_residual"] == 1e-15
    assert table.loc["slsqp", ["multipliers", "costate_error"]].tolist() == [2, 1e-7]
    assert table.loc["disjunctive", ["bounds", "false_bounds"]].tolist() == [2, 1]
    assert math.isnan(table.loc["disjunctive", "costate_error"])


def test_multipliers_are_compared_with_costates_that_are_there(load_rows):
    """Not of a single arc, which leaves them free, nor of a path that is no extremal or is lost."""
    scenario = paper_scenarios()[0]
    kept = attempt(scenario, "slsqp", costate_error=1e-9, **PROVED)
    made = [
        kept,
        kept | {"repeat": 1, "word": "L"},
        kept | {"repeat": 2, "pmp_residual": 0.1},
        kept | {"repeat": 3, "costate_error": None},
        kept | {"repeat": 4, "gap": None},
    ]

    table = proofs(load_rows("tiny", made).attempts)

    assert table[["attempts", "multipliers", "costate_error"]].to_numpy().tolist() == [[5, 1, 1e-9]]
    for row in made[1:]:
        alone = proofs(load_rows(f"only-{row['repeat']}", [row]).attempts)
        assert alone["multipliers"].tolist() == [0]


def test_width_of_enclosures(load_rows):
    """Of every attempt, and not where no path exists; a jump is counted apart."""
    made = rows()
    made[0] |= {"reference_low": 2.0, "reference_high": 2.001}
    made[2] |= {"reference_low": 2.0, "reference_high": 2.001}
    made.append(made[0] | {"repeat": 1, "reference_low": 0.3, "reference_high": 6.5})
    made.append(made[4] | {"repeat": 1, "reference_low": 0.0, "reference_high": 0.0})
    table = proofs(load_rows("tiny", made).attempts).set_index("solver")

    assert table["enclosed"].to_dict() == {"slsqp": 3, "disjunctive": 2}
    assert table["open"].to_dict() == {"slsqp": 1, "disjunctive": 0}
    assert table["width"].to_dict() == pytest.approx(dict.fromkeys(table.index, 0.001 / 2.001))
    narrow = [row | {"repeat": 1} for row in rows()[:2]]
    alone = proofs(load_rows("narrow", narrow).attempts)
    assert alone["width"].tolist() == pytest.approx([4e-16])


def test_the_section_says_what_the_rows_say(load_rows):
    text = certificates_section(load_rows("tiny", rows())).text

    assert "Of 5 attempts 2 are proved (40.0 %; 1 bounded, 1 extremal, 1 none)." in text
    assert "is 4.4e−16 of it: as much as the rounding of the data leaves open." in text
    assert "both sides of a jump" not in text
    assert "at most 1.0e−7 (slsqp, word NLPs, whose median is 5.0e−8)" in text
    assert "Of 2 lower bounds that solvers report 1 lie above" in text

    wide = [row | {"reference_low": 0.5} for row in rows()[:2]]
    text = certificates_section(load_rows("wide", wide)).text
    assert "2 intervals hold the lengths on both sides of a jump" in text
    assert "lower bounds" not in text
